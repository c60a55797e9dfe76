"""The reading of posted questions: a question that was read is known by its body."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest

from service.api.answers import request_body
from service.api.answers.request_body import Asked, Reading
from service.api.threads import Threads
from service.schemas.censuses import CensusRequest
from service.schemas.curves import CuspCurvesRequest
from service.schemas.limits import Limits
from service.schemas.questions import EXAMPLE_GEOMETRY
from service.schemas.tables import CuspTableRequest


def body(**asked: Any) -> bytes:
    return json.dumps({"geometry": EXAMPLE_GEOMETRY, **asked}).encode()


def read_in_turn(*bodies: bytes) -> list[Asked]:
    async def run() -> list[Asked]:
        questions = Reading(Limits(), Threads(1))
        return [await questions.question(CuspTableRequest, each) for each in bodies]

    return asyncio.run(run())


def test_a_body_is_read_once() -> None:
    first, second, again = read_in_turn(body(l1=17), body(l1=17, deadline_s=5), body(l1=17))
    assert again is first
    assert (first.deadline_s, second.deadline_s) == (None, 5)
    assert first.request == second.request


def test_the_same_body_asks_another_question_elsewhere() -> None:
    async def run() -> tuple[Asked, Asked]:
        questions = Reading(Limits(), Threads(1))
        return await questions.question(CensusRequest, body()), await questions.question(
            CuspCurvesRequest, body()
        )

    census, curves = asyncio.run(run())
    assert (census.request.kind.name, curves.request.kind.name) == ("census", "cusp-curves")


@pytest.mark.parametrize("asked", [{"l1": {"from": 1, "to": 51, "step": 1}}, {"l1": ["1" + 1100 * " "]}])
def test_a_large_question_is_read_each_time(asked: dict[str, Any]) -> None:
    first, again = read_in_turn(body(**asked), body(**asked))
    assert again is not first
    assert again == first


def test_the_questions_not_asked_for_the_longest_time_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(request_body, "_KEPT", 2)
    one, two, three = (body(l1=length) for length in (1, 2, 3))
    answers = read_in_turn(one, two, one, three, one, two)
    assert answers[2] is answers[4] is answers[0]
    assert answers[5] is not answers[1]
