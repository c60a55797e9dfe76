"""A follower's boxes along cusp curves, against independently solved slices and a predictor-corrector."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise
from typing import Any

import mpmath as mp
import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, Eliminant, Manipulator
from rpr_solver.curves.follower import Follower, LostError
from rpr_solver.curves.neighbourhood import CuspForms, Place
from rpr_solver.model.half_tangent import HalfTangent
from tests.support.definitions import Point, Slices
from tests.support.places import cusps_of, place
from tests.support.shared import eliminant_of

DIGITS = 30
TUBES = 500
FLAT, INNOCENTI = EXAMPLES["zein-flat"], EXAMPLES["innocenti"]
WAYS = [  # manipulator, fixed leg, two lengths, how many turn back on the way up and down
    pytest.param(FLAT, 1, "26.16", "26.362", (2, 0), id="two die, one is rational"),
    pytest.param(FLAT, 1, "29", "31.86338", (0, 2), id="two are born"),
    pytest.param(FLAT, 3, "30.6", "32.1", (0, 0), id="leg 3, one turns twice"),
    pytest.param(INNOCENTI, 1, "28.0", "28.1", (0, 2), id="an irrational platform"),
]


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    with mp.workdps(DIGITS):
        yield


def follower(eliminant: Eliminant, cusp: Point, length: Fraction, *, upwards: bool) -> Follower:
    """From a cusp known to a few digits more than DIGITS, as a box that is a little wider."""

    def start(bits: int) -> Place:
        with ctx.workprec(bits):
            return place(cusp[0], cusp[1], 1e-25)

    scale = eliminant.slice_map.scale
    return Follower(CuspForms(eliminant.slice_map), start, length * scale, upwards=upwards)


def held(box: Place, points: list[Point]) -> list[int]:
    """Which points a box holds, as far as their digits tell."""
    with ctx.workprec(256):
        return [i for i, point in enumerate(points) if not place(point[0], point[1], 1e-25).apart(box)]


def decimal(x: Fraction) -> mp.mpf:
    return mp.mpf(x.numerator) / x.denominator


def with_marks(way: Any, upwards: bool) -> Any:
    """Downwards where curves turn back; all ways are gone in both directions by `test_destinations` too."""
    marks = [] if upwards or way.id == "two are born" else [pytest.mark.long]
    return pytest.param(*way.values, upwards, id=f"{way.id}, {'up' if upwards else 'down'}", marks=marks)


@pytest.mark.parametrize(
    ("m", "leg", "low", "high", "turning", "upwards"),
    [with_marks(way, upwards) for way in WAYS for upwards in (True, False)],
)
def test_a_walk_ends_where_the_curve_does(
    m: Manipulator, leg: int, low: str, high: str, turning: tuple[int, int], upwards: bool
) -> None:
    """At the other slice, or at another cusp of its own where the curve turns back."""
    eliminant, slices = eliminant_of(m, leg), Slices.of(m, leg)
    scale = eliminant.slice_map.scale
    ends = Fraction(low), Fraction(high)
    tables = {end: cusps_of(eliminant, end, DIGITS) for end in ends}
    start = ends[0] if upwards else ends[1]
    back = 0
    for i, cusp in enumerate(tables[start]):
        met = follower(eliminant, cusp, start, upwards=upwards).walk(ends[0] * scale, ends[1] * scale, TUBES)
        assert met is not None
        length, box = met[0] / scale, met[1]
        expected, point = slices.trace(cusp, *map(decimal, ends), upwards=upwards, step=0.01)
        assert decimal(length) == expected
        [index] = held(box, tables[length])
        assert held(box, [point]) == [0]
        assert (length, index) != (start, i)
        back += length == start
    assert back == turning[not upwards]


def test_one_follower_passes_through_slice_after_slice() -> None:
    eliminant = eliminant_of(FLAT)
    scale = eliminant.slice_map.scale
    lengths = [Fraction(x) for x in ("29", "29.3", "29.9", "30.05", "31")]
    tables = [cusps_of(eliminant, length, DIGITS) for length in lengths]
    followers = [follower(eliminant, cusp, lengths[0], upwards=True) for cusp in tables[0]]
    for (low, high), table in zip(pairwise(lengths), tables[1:], strict=True):
        indices = []
        for walking in followers:
            met = walking.walk(low * scale, high * scale, TUBES)
            assert met is not None
            assert met[0] == high * scale
            [index] = held(met[1], table)
            indices.append(index)
        assert sorted(indices) == list(range(len(table)))


def test_too_few_tubes_lead_nowhere_and_more_go_on() -> None:
    eliminant = eliminant_of(FLAT)
    scale = eliminant.slice_map.scale
    ends = Fraction(29), Fraction(60)
    cusp = cusps_of(eliminant, ends[0], DIGITS)[0]
    walking = follower(eliminant, cusp, ends[0], upwards=True)
    low, high = (x * scale for x in ends)
    assert walking.walk(low, high, 0) is None
    assert walking.walk(low, high, 1) is None
    met = walking.walk(low, high, TUBES)
    assert met is not None
    at_once = follower(eliminant, cusp, ends[0], upwards=True).walk(low, high, TUBES)
    assert at_once is not None
    assert met[0] == at_once[0] == high
    assert not met[1].apart(at_once[1])


def test_there_and_back_again() -> None:
    eliminant = eliminant_of(FLAT)
    scale = eliminant.slice_map.scale
    low, high = Fraction(29) * scale, Fraction(31) * scale
    below, above = (cusps_of(eliminant, x, DIGITS) for x in (Fraction(29), Fraction(31)))
    for i, cusp in enumerate(below):
        up = follower(eliminant, cusp, Fraction(29), upwards=True).walk(low, high, TUBES)
        assert up is not None
        [there] = held(up[1], above)
        down = follower(eliminant, above[there], Fraction(31), upwards=False).walk(low, high, TUBES)
        assert down is not None
        assert down[0] == low
        assert held(down[1], below) == [i]


def test_a_start_that_is_wide_at_first_is_asked_for_more_precisely() -> None:
    eliminant = eliminant_of(FLAT)
    scale = eliminant.slice_map.scale
    cusp = cusps_of(eliminant, Fraction(29), DIGITS)[0]
    asked = []

    def start(bits: int) -> Place:
        asked.append(bits)
        with ctx.workprec(bits):
            return place(cusp[0], cusp[1], 1e-25 if bits > 500 else 0.5)

    walking = Follower(CuspForms(eliminant.slice_map), start, Fraction(29) * scale, upwards=True)
    assert walking.walk(Fraction(29) * scale, Fraction("29.01") * scale, TUBES) is not None
    assert asked[-1] > 500
    assert asked == sorted(asked)


def test_at_a_swallowtail_there_is_no_way_up_or_down() -> None:
    """At θ1 = 180° and α = 0 the curve turns back: L cannot be its parameter, at any precision."""
    m = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
    eliminant = eliminant_of(m)
    scale = eliminant.slice_map.scale

    def start(_: int) -> Place:
        return Place(HalfTangent(arb(0), arb(1)), HalfTangent(arb(1), arb(0)))

    for upwards in (True, False):
        walking = Follower(CuspForms(eliminant.slice_map), start, scale, upwards=upwards)
        with pytest.raises(LostError):
            walking.walk(scale / 2, 2 * scale, TUBES)
