from __future__ import annotations

import pytest

from service.api.answers.forms import negotiate
from service.api.problems import ProblemError
from service.schemas.answers import CSV, JSON, NDJSON

OFFERED = (JSON, CSV, NDJSON)


@pytest.mark.parametrize(
    ("accept", "chosen"),
    [
        ([], JSON),
        ([""], JSON),
        (["*/*"], JSON),
        (["text/*"], CSV),
        (["text/csv"], CSV),
        (["Application/X-NDJSON"], NDJSON),
        (["text/csv;q=0.5, application/json;q=0.4"], CSV),
        (["*/*;q=0.1, text/csv"], CSV),
        (["application/json;q=0, */*"], CSV),
        (["text/html, application/xhtml+xml, */*;q=0.8"], JSON),
        (["image/png", "text/csv"], CSV),
    ],
)
def test_the_form_that_the_client_likes_best(accept: list[str], chosen: str) -> None:
    assert negotiate(accept, OFFERED) == chosen


@pytest.mark.parametrize("accept", ["image/png", "*/*;q=0", "application/json;q=x"])
def test_no_acceptable_form(accept: str) -> None:
    with pytest.raises(ProblemError, match="matches none of application/json, text/csv"):
        negotiate([accept], OFFERED)
