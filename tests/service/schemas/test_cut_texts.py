"""A text that is too long for a message is cut, and the message shows it."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator
from typing import Any

import pytest

from rpr_solver.errors import InputError
from service.schemas.document import JsonError, JsonNumber, Source, parse_json, read
from service.schemas.limits import Limits
from service.schemas.questions import EXAMPLE_GEOMETRY, Question
from service.schemas.registry import all_questions

LONG = ["7" * 5000, "x" * 5000, "7x" * 2500, JsonNumber("7" * 5000), JsonNumber(f"0.{'7' * 5000}")]
CUT = re.compile(r"[7x]{15,}(?![7x]|…)")


def places(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The places of all members and elements."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, one in inner:
        yield (*at, key)
        yield from places(one, (*at, key))


def with_member(body: Any, place: tuple[Any, ...], value: object) -> Any:
    changed = copy.deepcopy(body)
    *way, last = place
    inner = changed
    for key in way:
        inner = inner[key]
    inner[last] = value
    return changed


@pytest.mark.parametrize("question", all_questions(), ids=lambda question: question.__name__)
def test_in_every_member_of_every_question(question: type[Question]) -> None:
    for example in question.examples.values():
        body = {"geometry": EXAMPLE_GEOMETRY, **example[1]}
        for place in places(body):
            if "document" in place:
                continue  # what is verified is read elsewhere
            for text in LONG:
                for asked in (with_member(body, place, text), {**body, text: 1}):
                    assert not CUT.search(fault(question, asked))


def fault(question: type[Question], body: object) -> str:
    """What is wrong with a body, or nothing."""
    try:
        read(question, body, Source(Limits()))
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("text", [f'{{"{"x" * 500}": NaN}}', f'{{"{"x" * 500}": 1, "{"x" * 500}": 1}}'])
def test_in_names_of_members(text: str) -> None:
    with pytest.raises(JsonError) as caught:
        parse_json(text.encode())
    assert not CUT.search(caught.value.detail)
    assert not CUT.search(caught.value.field)
