"""Questions for one document, as they are read."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from rpr_solver import EXAMPLES, InputError, exact_str
from service.schemas import document_requests as read
from service.schemas.document_models import CensusRequest, CheckRequest, CuspCurvesRequest, PosesRequest
from service.schemas.exact_json import JsonNumber
from service.schemas.limits import Limits
from service.schemas.ranges import parse_length_range, read_range
from tests.support.service_server import GEOMETRY
from worker import DocumentRequest
from worker.answers.censuses import census_request

LIMITS = Limits()
BODY: dict[str, Any] = {"geometry": {key: JsonNumber(value) for key, value in GEOMETRY.items()}}
POSITIVE = st.fractions(min_value=Fraction(1, 1000), max_value=1000, max_denominator=1000)


def spellings(x: Fraction) -> st.SearchStrategy[str]:
    """Ways to write one number."""
    plain = exact_str(x)
    return st.sampled_from(
        [
            plain,
            JsonNumber(plain) if "/" not in plain else plain,
            f"{x.numerator}/{x.denominator}",
            f" {plain} ",
        ]
    )


@given(st.data(), POSITIVE, POSITIVE)
def test_every_spelling_is_one_question(data: st.DataObject, start: Fraction, width: Fraction) -> None:
    stop = start + width
    wanted = {"from": data.draw(spellings(start)), "to": data.draw(spellings(stop))}
    found = read.census_request({**BODY, "range": wanted}, LIMITS)
    assert found == census_request(EXAMPLES["innocenti"], start=start, stop=stop)
    legs = {f"l{leg}": data.draw(spellings(start)) for leg in (1, 2, 3)}
    assert read.poses_request({**BODY, **legs}, LIMITS) == read.of_poses(
        EXAMPLES["innocenti"], [start] * 3, LIMITS.default_digits
    )
    requirement = {"range": wanted, "max_cusps": JsonNumber("4")}
    bounds = {"from": exact_str(start), "to": exact_str(stop)}
    checked = read.check_request({**BODY, "requirement": requirement}, LIMITS).content["requirement"]
    assert (checked["range"], checked["max_cusps"], checked["min_cusps"]) == (bounds, 4, None)


@given(st.none() | POSITIVE, st.none() | POSITIVE)
def test_a_range_is_the_same_on_the_command_line(start: Fraction | None, stop: Fraction | None) -> None:
    ends = {"from": start and exact_str(start), "to": stop and exact_str(stop)}
    text = f"{ends['from'] or ''}:{ends['to'] or ''}"
    if stop is not None and stop <= (start or 0):
        with pytest.raises(InputError, match="must exceed"):
            read_range(ends, LIMITS)
        with pytest.raises(InputError, match="must exceed"):
            parse_length_range(text, "--l1-range", LIMITS)
        return
    posted, written = read_range(ends, LIMITS), parse_length_range(text, "--l1-range", LIMITS)
    assert (posted.start, posted.stop) == (written.start, written.stop) == (start or 0, stop)


@pytest.mark.parametrize(
    ("reader", "model"),
    [
        (read.poses_request, PosesRequest),
        (read.census_request, CensusRequest),
        (read.check_request, CheckRequest),
        (read.curves_request, CuspCurvesRequest),
    ],
)
def test_the_documented_model_has_the_fields_that_are_read(
    reader: Callable[[object, Limits], DocumentRequest], model: type[BaseModel]
) -> None:
    documented = model.model_json_schema()
    own = [name for name in documented["properties"] if "oneOf" not in documented or name not in ("l2", "l3")]
    with pytest.raises(InputError) as refused:
        reader(dict.fromkeys((*own, "other")), LIMITS)
    messages = {problem.field: problem.message for problem in refused.value.problems}
    assert [name for name, message in messages.items() if message.startswith("unknown field")] == ["other"]
    with pytest.raises(InputError) as empty:
        reader({}, LIMITS)
    assert {problem.field for problem in empty.value.problems} == set(documented["required"])


@given(st.recursive(st.none() | st.booleans() | st.text() | st.builds(JsonNumber, st.just("1")), st.lists))
def test_anything_else_is_refused_as_input(value: object) -> None:
    for reader in (read.poses_request, read.census_request, read.check_request, read.curves_request):
        for body in (value, {**BODY, "requirement": value, "range": value, "l1": value, "samples": value}):
            with suppress(InputError):
                reader(body, LIMITS)
