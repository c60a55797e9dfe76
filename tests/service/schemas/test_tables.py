from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.exact.numerals import digit_count
from service.schemas import document
from service.schemas.document import parse_json
from service.schemas.limits import LimitError, Limits
from service.schemas.tables import CuspTableRequest
from tests.support.service_server import GEOMETRY
from worker.answers.kind import JobRequest

SOURCE = document.Source(Limits(max_slices=10))


def read(text: str | Mapping[str, Any]) -> JobRequest:
    body = text if isinstance(text, str) else json.dumps(text)
    return document.read(CuspTableRequest, parse_json(body.encode()), SOURCE).job_request()


def with_slices(slices: str) -> Sequence[str]:
    return read(f'{{"geometry": {json.dumps(GEOMETRY)}, "l1": {slices}}}').parts


@pytest.mark.parametrize(
    ("slices", "expected"),
    [
        ('"1498/100"', ["14.98"]),
        ('["14.98", 27, 14.980, "1/3"]', ["14.98", "27", "1/3"]),
        ('{"from": 0.1, "to": 0.3, "step": 0.1}', ["0.1", "0.2", "0.3"]),
        ('{"from": 1, "to": 2, "step": "1/3"}', ["1", "4/3", "5/3", "2"]),
        ("1e-30", ["0." + "0" * 29 + "1"]),
    ],
)
def test_slices(slices: str, expected: list[str]) -> None:
    assert with_slices(slices) == expected


@pytest.mark.parametrize(
    ("slices", "said"),
    [('{"from": -9, "to": 0, "step": 1}', "l1: is -9, -8, -7, …; a leg length must be > 0")],
)
def test_a_question_without_a_possible_slice_is_refused(slices: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        with_slices(slices)
    assert str(caught.value) == said
    assert with_slices("[-1, 0, 3]") == ["-1", "0", "3"], "among others it has an error in its place"


@given(st.integers(1, 10**6), st.integers(1, 10**6), st.integers(0, 9), st.integers(0, 6))
def test_a_range_is_exact_and_holds_its_stop_only_when_it_is_hit(
    start: int, step: int, count: int, shift: int
) -> None:
    def text(x: int) -> str:
        return f"{x}e-{shift}"

    stop = start + count * step
    hit = with_slices(json.dumps({"from": text(start), "to": text(stop), "step": text(step)}))
    past = with_slices(json.dumps({"from": text(start), "to": text(stop + step - 1), "step": text(step)}))
    assert hit == past
    assert len(hit) == count + 1
    assert hit == with_slices(json.dumps([text(start + i * step) for i in range(count + 1)]))


@pytest.mark.parametrize(
    ("slices", "said"),
    [
        ("null", "is null"),
        ("[[1]]", r"l1\[0\]: is a list"),
        ('["1", "x"]', r"l1\[1\]: 'x' is not a finite number"),
        ('{"from": 1, "to": 2}', "l1.step: is missing"),
        ('{"from": 1, "to": 2, "step": 0}', "must be > 0"),
        ('{"from": 2, "to": 1, "step": 1}', "the range is empty"),
    ],
)
def test_wrong_slices_are_named(slices: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        with_slices(slices)


@pytest.mark.parametrize(
    ("change", "limit", "sent"),
    [
        ({"l1": list(range(1, 12))}, "max_slices", "asks for 11 slices"),
        ({"l1": {"from": 0, "to": "1e300", "step": "1e-99"}}, "max_slices", "more than 10^20 slices"),
        ({"digits": 1001}, "max_digits", "asks for 1001 digits"),
        ({"l1": "1e-999999999"}, "max_number_digits", "a number with 1000000000 digits"),
        ({"l1": "1/" + "7" * 500}, "max_number_digits", "a number with 500 digits"),
    ],
)
def test_a_limit_that_is_exceeded_is_named_with_what_was_sent(
    change: dict[str, Any], limit: str, sent: str
) -> None:
    with pytest.raises(LimitError) as caught:
        read({"geometry": GEOMETRY, "l1": 1, **change})
    assert caught.value.limit == limit
    assert sent in str(caught.value)
    assert str(caught.value.value) in str(caught.value)


@pytest.mark.parametrize(
    ("change", "fields"),
    [
        ({"geometry": {**GEOMETRY, "d1": -1, "d2": -1}}, {"geometry.d1", "geometry.d2"}),
        (
            {"geometry": {**GEOMETRY, "d1": None, "dd": 2}, "digits": "90"},
            {"geometry.d1", "geometry.dd", "digits"},
        ),
        ({"digits": 90.5, "fixed_leg": 4}, {"digits", "fixed_leg"}),
        ({"fixed_leg": True, "l1": "?"}, {"fixed_leg", "l1"}),
    ],
)
def test_every_field_at_fault_is_named_at_once(change: dict[str, Any], fields: set[str]) -> None:
    with pytest.raises(InputError) as caught:
        read({"geometry": GEOMETRY, "l1": 1, **change})
    assert {problem.field for problem in caught.value.problems} == fields


def test_whole_numbers_may_be_written_in_any_way() -> None:
    request = read(f'{{"geometry": {json.dumps(GEOMETRY)}, "l1": 1, "digits": 3.00e1, "fixed_leg": 1.0}}')
    assert (request.digits, request.fixed_leg) == (30, 1)


@pytest.mark.parametrize(
    ("text", "digits"),
    [("17.04", 4), ("0.001", 4), ("1e3", 4), ("1e-3", 4), ("12/345", 3), ("x", 0), ("1e" + "9" * 50, 10**20)],
)
def test_digit_count(text: str, digits: int) -> None:
    assert digit_count(text) == digits
