"""What counts as the same answer of two trees."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from tests.support.same_answers import IGNORED, Answer, same

DOCUMENT = {
    "digits": 15,
    "solver_version": "1",
    "slices": [{"count": 1, "cusps": [{"l2": "3.0"}], "certificate": {"method": "balls"}}],
}
QUESTION = {"l1": "2"}
ANSWER = Answer(200, "ct-1", DOCUMENT, QUESTION)


def compared(after: Answer, *ignored: str, version: str = "1") -> bool:
    return same(ANSWER, after, IGNORED | {*ignored}, versions=("1", version))


def with_slice(**members: Any) -> Answer:
    return replace(ANSWER, document={**DOCUMENT, "slices": [{**DOCUMENT["slices"][0], **members}]})


def test_members_are_ignored_at_any_depth() -> None:
    assert compared(ANSWER)
    assert compared(replace(ANSWER, document={**DOCUMENT, "solver_version": "2"}))
    assert compared(with_slice(certificate={"method": "exact"}))
    assert not compared(with_slice(count=2))
    assert compared(with_slice(count=2), "count")
    assert not compared(with_slice(near=[]))
    assert compared(with_slice(near=[]), "near")


@pytest.mark.parametrize(
    "after",
    [
        replace(ANSWER, status=422),
        with_slice(cusps=[{"l2": "3.1"}]),
        replace(ANSWER, document=dict(reversed(DOCUMENT.items()))),
    ],
    ids=["status", "digit", "order"],
)
def test_all_else_is_compared(after: Answer) -> None:
    assert not compared(after)


def test_job_ids_are_compared_unless_they_depend_on_what_is_ignored() -> None:
    other = replace(ANSWER, job="ct-2")
    assert not compared(other)
    assert compared(other, version="2")
    assert compared(replace(other, question={"document": {"solver_version": "2"}}))
