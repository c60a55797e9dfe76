"""Every kind with sides of as many digits as may be, and with lengths of any size: the right answer, or a
refusal that names the member."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any

import pytest

from benchmarks.questions import Body, seeds
from rpr_solver import exact_str
from rpr_solver.contract import silent
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.numerals import double
from service.api.batches.rows import read_item
from service.schemas.limits import Limits
from tests.support.sampling import long
from worker.answers.kind import JobRequest, Store

LENGTHS = {
    *("a2x", "a3x", "a3y", "d1", "d2", "d3", "l1", "l2", "l3", "from", "to", "step", "min", "max"),
    *("chord", "speed", "acceleration", "jerk", "ignore_windows"),
}
"""Members in the unit of length, some of them by time; a pose is a whole number, and stays."""
_NO_LENGTHS = {"path": {"from", "to"}, "singular-curves": {"tolerance"}}
KINDS = sorted(name for name in seeds() if name != "verification")
_EXACT = {"cusp-table", "article-table", "poses", "census"}
"""Kinds in whose answers no place is chosen, as samples are, and no double is printed."""
_QUICK = 1.0
"""Seconds that an answer may be expected to take in the usual run."""


def changed(value: Any, change: Callable[[Fraction], Fraction], kept: set[str], name: str = "") -> Any:
    """A question with other lengths."""
    if isinstance(value, dict):
        return {key: changed(item, change, kept, key) for key, item in value.items()}
    if isinstance(value, list):
        return [changed(item, change, kept, name) for item in value]
    is_length = (
        name in LENGTHS | {"tolerance"} and name not in kept and re.fullmatch(r"-?[\d./]+", str(value))
    )
    return exact_str(change(Fraction(str(value)))) if is_length and not isinstance(value, bool) else value


def scaled(kind: str, body: Body, power: int) -> Body:
    """The same question in another unit."""
    result: Body = changed(body, lambda x: x * Fraction(10) ** power, _NO_LENGTHS.get(kind, set()))
    return result


def lengthened(body: Body) -> Body:
    """The same with sides of 400 digits."""
    draw = random.Random(1)
    sides = changed(body["geometry"], lambda x: x and x + Fraction(draw.randrange(10**390), 10**396), set())
    return {**body, "geometry": sides}


def request_of(kind: str, body: Body) -> JobRequest | str:
    """The question as the service reads it, or the names of the members that it refuses."""
    item = read_item(json.dumps({"kind": kind, "request": body}).encode(), 0, Limits())
    if item.request is not None:
        return item.request
    assert item.problem is not None
    names = " ".join(error["field"] for error in item.problem["errors"])
    assert names.startswith("items[0].request.")
    return names


def outcome(request: JobRequest | str) -> Mapping[str, Any] | str:
    """The answer, or why there is none; any other error is a fault."""
    if isinstance(request, str):
        return request
    try:
        return request.kind.compute(request, Store(), silent)
    except InputError as error:
        return " ".join(problem.field for problem in error.problems)
    except SolverError as error:
        return str(error)


def significant(value: Any) -> Any:
    """An answer with the significant digits of its numbers alone, and without what depends on their size."""
    if isinstance(value, Mapping):
        apart = {
            "sensitivity",
            "certificate",
            "geometry_hash",
            "svg",
            "description",
            "reason",
            "summary",
            "audit",
        }
        digits = value.get(
            "sensitivity"
        )  # those that are proved, of which one unit may prove more than another
        found = {name: significant(item) for name, item in value.items() if name not in apart}
        if not digits:
            return found
        return found | {"sensitivity": {k: x and f"{double(Fraction(x)):.9e}" for k, x in digits.items()}}
    if isinstance(value, list | tuple):
        return [significant(item) for item in value]
    if isinstance(value, str) and re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?", value):
        mantissa = value.partition("e")[0].replace(".", "").lstrip("-0").rstrip("0")
        return ("-" if value[0] == "-" else "") + mantissa
    return value


def cases(*, quick: bool) -> Iterator[Any]:
    """Each example of each kind: the first of those that are quick runs each time."""
    for kind in KINDS:
        done = False
        for k, body in enumerate(seeds()[kind]):
            request = request_of(kind, body)
            is_quick = not isinstance(request, str) and request.cost.whole < _QUICK and not done
            done |= is_quick
            case = (kind, body)
            yield (
                pytest.param(*case, id=f"{kind}-{k}") if is_quick and quick else long(*case, id=f"{kind}-{k}")
            )


@pytest.mark.parametrize("power", [390, long(-390), long(140), long(-140)])
@pytest.mark.parametrize(("kind", "body"), list(cases(quick=True)))
def test_another_unit_gives_the_same_digits_or_a_refusal(kind: str, body: Body, power: int) -> None:
    found = outcome(request_of(kind, scaled(kind, body, power)))
    if not isinstance(found, str) and kind in _EXACT:
        assert significant(found) == significant(outcome(request_of(kind, body)))


@pytest.mark.parametrize(("kind", "body"), list(cases(quick=False)))
def test_sides_of_400_digits(kind: str, body: Body) -> None:
    outcome(request_of(kind, lengthened(body)))


def leaves(body: Body) -> Iterator[tuple[Any, str]]:
    for key, value in body.items():
        if isinstance(value, dict):
            yield from leaves(value)
        elif key in LENGTHS and not isinstance(value, list):
            yield body, key


@pytest.mark.parametrize("text", ["1" + "0" * 399, "0." + "0" * 398 + "1"], ids=["1e399", "1e-399"])
@pytest.mark.parametrize(("kind", "body"), list(cases(quick=False)))
def test_one_length_out_of_all_proportion(kind: str, body: Body, text: str) -> None:
    for k in range(len(list(leaves(body)))):
        asked = json.loads(json.dumps(body))
        inner, key = list(leaves(asked))[k]
        inner[key] = text
        outcome(request_of(kind, asked))


G = {"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84"}
_MOTION = {"geometry": G, "l1": 27, "cusp": "B", "samples": 3}
_DESIGN = {"objective": "most-cusps", "requirement": {"range": {"from": 1, "to": 2}, "min_cusps": 2}}


@pytest.mark.parametrize("kind", ["margin", "design"])
@pytest.mark.parametrize("power", [305, 390, -300, -390])
def test_what_doubles_do_not_hold_is_named(kind: str, power: int) -> None:
    more = {"l1": "28.1"} if kind == "margin" else _DESIGN
    found = outcome(request_of(kind, scaled(kind, {"geometry": G, **more}, power)))
    assert isinstance(found, str)
    assert "geometry.a2x" in found


@pytest.mark.parametrize(
    "limits",
    [
        {"speed": "1e-399", "acceleration": 20},
        {"speed": {"l2": "1e399", "l3": 1}, "acceleration": {"l2": "1e-399", "l3": "1e399"}},
        {"speed": 1, "acceleration": 1, "jerk": "1e-399"},
    ],
)
def test_motions_within_limits_of_any_size(limits: Mapping[str, Any]) -> None:
    found = outcome(request_of("path", {**_MOTION, "motion": limits}))
    assert not isinstance(found, str)
    assert len(found["samples"]) == 3


def test_a_chord_of_any_length() -> None:
    for body in ({**_MOTION, "motion": {"speed": 1, "acceleration": 1}}, _MOTION):
        del (asked := dict(body))["samples"]
        found = outcome(request_of("path", {**asked, "sampling": {"chord": "1e-399"}}))
        assert isinstance(found, str)
        assert found.startswith("sampling.chord")


def test_limits_beyond_all_poses_change_nothing() -> None:
    asked = {"range": {"from": 23, "to": 24}, "max_cusps": 6}
    plain, far = (
        outcome(request_of("check", {"geometry": G, "requirement": asked | more}))
        for more in ({}, {"limits": {"l2": {"max": "1e300"}}})
    )
    assert not isinstance(plain, str)
    assert not isinstance(far, str)
    assert (plain["passed"], plain["intervals"]) == (far["passed"], far["intervals"])


def test_a_margin_of_a_requirement_from_a_fraction() -> None:
    """The end of the range is no decimal."""
    asked = {"range": {"from": "64/3", "to": 26}, "max_cusps": 6}
    found = outcome(request_of("margin", {"geometry": G, "requirement": asked, "tolerance": "0.001"}))
    assert not isinstance(found, str)
    assert found["verdict"] == "proved"
