"""Followed cusps and the cusps of other slices that they reach, against a predictor-corrector."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise
from typing import Any

import mpmath as mp
import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, Eliminant, Manipulator, Unproved, cusp_curves, solve_slice
from rpr_solver.curves import follower as follower_module
from rpr_solver.curves.follower import Cusp, Follower, Lost, Tracker, expected_work
from rpr_solver.curves.neighbourhood import CuspForms, PoseBox
from rpr_solver.model.jets import HalfTangent
from tests.support.definitions import Point, Slices, distance
from tests.support.places import cusps_in, cusps_of, place
from tests.support.sampling import sample
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

    def start(bits: int) -> PoseBox:
        with ctx.workprec(bits):
            return place(cusp[0], cusp[1], 1e-25)

    scale = eliminant.slice_map.scale
    return Follower(CuspForms(eliminant.slice_map), start, length * scale, upwards=upwards)


def held(box: PoseBox, points: list[Point]) -> list[int]:
    """Which points a box holds, as far as their digits tell."""
    with ctx.workprec(256):
        return [i for i, point in enumerate(points) if not place(point[0], point[1], 1e-25).apart(box)]


def decimal(x: Fraction) -> mp.mpf:
    return mp.mpf(x.numerator) / x.denominator


def with_marks(way: Any, upwards: bool) -> Any:
    """One way, where curves turn back, always; the others with `--long`."""
    marks = [] if way.id == "two are born" and not upwards else [pytest.mark.long]
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
        expected, point = slices.trace(cusp, *map(decimal, ends), upwards=upwards, step=0.02)
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
    ends = Fraction(29), Fraction(900)
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

    def start(bits: int) -> PoseBox:
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

    def start(_: int) -> PoseBox:
        return PoseBox(HalfTangent(arb(0), arb(1)), HalfTangent(arb(1), arb(0)))

    for upwards in (True, False):
        walking = Follower(CuspForms(eliminant.slice_map), start, scale, upwards=upwards)
        with pytest.raises(Lost):
            walking.walk(scale / 2, 2 * scale, TUBES)


PAIRS = [
    pytest.param(FLAT, 1, "34.6", "36.2", id="two die"),
    pytest.param(FLAT, 2, "36", "40.1", id="leg 2, two are born"),
    pytest.param(FLAT, 3, "30.6", "32.1", id="leg 3, one turns twice"),
    pytest.param(FLAT, 1, "26.16", "29", id="over three transitions"),
    pytest.param(INNOCENTI, 1, "28.0", "28.1", id="an irrational platform"),
]


def all_from(tracker: Tracker, start: Fraction, other: Fraction) -> dict[int, Cusp]:
    """Where all cusps of a slice come to on the way to another."""
    upwards = start < other
    followers = {i: tracker.follower((start, i), upwards=upwards) for i in range(tracker.table(start).count)}
    return tracker.destinations(followers, *sorted((start, other)))


def traced(slices: Slices, tracker: Tracker, start: Fraction, other: Fraction) -> dict[int, Cusp]:
    """The same, in floating point."""
    low, high = sorted((start, other))
    ends = {decimal(x): x for x in (low, high)}
    cusps = {x: cusps_in(tracker.table(x)) for x in (low, high)}
    result = {}
    for i, cusp in enumerate(cusps[start]):
        end, point = slices.trace(cusp, decimal(low), decimal(high), upwards=start < other)
        length = ends[end]
        [index] = [k for k, x in enumerate(cusps[length]) if distance(x, point) < 1e-12]
        result[i] = length, index
    return result


@pytest.mark.parametrize(("m", "leg", "low", "high"), sample(PAIRS, 1))
def test_every_cusp_comes_to_where_its_curve_leads(m: Manipulator, leg: int, low: str, high: str) -> None:
    tracker, slices = Tracker(eliminant_of(m, leg), DIGITS), Slices.of(m, leg)
    ends = Fraction(low), Fraction(high)
    ways = {}
    for start, other in (ends, ends[::-1]):
        destinations = all_from(tracker, start, other)
        assert destinations == traced(slices, tracker, start, other)
        ways.update({(start, i): cusp for i, cusp in destinations.items()})
    # every curve has two ends, and each leads to the other
    assert set(ways) == {(end, i) for end in ends for i in range(tracker.table(end).count)}
    assert all(ways[there] == here != there for here, there in ways.items())


def test_where_the_first_two_cusps_are_born_they_meet_each_other() -> None:
    tracker = Tracker(eliminant_of(FLAT), DIGITS)
    below, above = Fraction("0.4"), Fraction(1)
    assert tracker.table(below).count == 0
    assert all_from(tracker, above, below) == {0: (above, 1), 1: (above, 0)}


def test_curves_that_take_too_many_tubes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(follower_module, "_MOST_WORK", 10)
    tracker = Tracker(eliminant_of(FLAT), DIGITS)
    with pytest.raises(Unproved, match="bound of work"):
        all_from(tracker, Fraction("34.6"), Fraction("36.2"))


def test_what_would_take_too_long_is_refused_before_a_cusp_is_followed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Congruent triangles, but for 1e-40 of a side, mirrored."""

    def walk(*_: object) -> None:
        raise AssertionError("a cusp is followed")

    monkeypatch.setattr(follower_module.Follower, "walk", walk)
    sides = {"base": {"sides": ["23", "7", "20"]}, "platform": {"sides": ["23", "7", f"20.{'0' * 39}1"]}}
    near = Manipulator.from_json({**sides, "orientation": "cw"})
    with pytest.raises(Unproved, match="bound of work"):
        cusp_curves(near, digits=15)


@pytest.mark.parametrize(
    ("counts", "least", "most"),
    [
        ([(1, 4), (2, 6), (3, 4), (9, 8)], 0, 300),
        # cusps that pass through forty decades, or two transitions as close as that
        ([(Fraction(1, 10**40), 4), (2, 6), (9, 8)], 1000, 4000),
        ([(1, 4), (2, 6), (2 + Fraction(1, 10**40), 4), (9, 8)], 500, 3000),
    ],
)
def test_the_work_that_is_expected_grows_with_decades(
    counts: list[tuple[Fraction, int]], least: float, most: float
) -> None:
    exact = [(Fraction(length), count) for length, count in counts]
    assert least < expected_work(exact) < most


def test_no_more_is_done_once_a_slice_is_full() -> None:
    tracker = Tracker(eliminant_of(FLAT), DIGITS)
    below, above = Fraction("0.4"), Fraction(1)
    followers = {i: tracker.follower((above, i), upwards=False) for i in (0, 1)}
    assert tracker.destinations(followers, below, above, until_full=below) == {}
    low, high = Fraction("34.6"), Fraction("36.2")
    followers = {i: tracker.follower((low, i), upwards=True) for i in range(8)}
    met = tracker.destinations(followers, low, high, until_full=high)
    assert sorted(index for length, index in met.values() if length == high) == list(range(6))
    whole = all_from(tracker, low, high)
    assert met.items() <= whole.items()


def test_a_follower_that_is_lost_is_missing_and_others_are_not() -> None:
    """One starts in the swallowtail at L1 = 1, where no tube leads up."""
    m = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
    tracker = Tracker(eliminant_of(m), DIGITS)
    low, high = Fraction(1), Fraction(2)
    assert tracker.table(low).count > 0
    followers = {i: tracker.follower((low, i), upwards=True) for i in range(tracker.table(low).count)}

    def swallowtail(_: int) -> PoseBox:
        return PoseBox(HalfTangent(arb(0), arb(1)), HalfTangent(arb(1), arb(0)))

    scale = tracker.eliminant.slice_map.scale
    lost = Follower(CuspForms(tracker.eliminant.slice_map), swallowtail, low * scale, upwards=True)
    met = tracker.destinations({-1: lost, **followers}, low, high)
    assert set(met) == set(followers)


def test_nothing_is_decided_by_nearness() -> None:
    """A box that holds two cusps has come to neither; one that holds one cusp has, however wide it is."""
    tracker = Tracker(eliminant_of(FLAT), DIGITS)
    low, high = Fraction(29), Fraction(30)
    alphas = [cusp[0] for cusp in cusps_in(tracker.table(high))]
    thetas = [cusp[1] for cusp in cusps_in(tracker.table(high))]

    class Arrived(Follower):
        box: PoseBox

        def walk(self, low: Fraction, high: Fraction, tubes: int) -> tuple[Fraction, PoseBox]:  # noqa: ARG002
            return high, self.box

    follower = Arrived(CuspForms(tracker.eliminant.slice_map), lambda _: follower.box, high, upwards=True)
    with ctx.workprec(128):
        follower.box = PoseBox(place(alphas[0], thetas[0], 1e-9).alpha, HalfTangent(arb(0, 1), arb(0, 1)))
    assert tracker.destinations({5: follower}, low, high) == {5: (high, 0)}
    with ctx.workprec(128):
        follower.box = PoseBox(HalfTangent(arb(0, 1), arb(0, 1)), HalfTangent(arb(0, 1), arb(0, 1)))
    with pytest.raises(Unproved, match="slice 30 are too close to tell"):
        tracker.destinations({5: follower}, low, high)


def test_tables_are_kept_and_known_ones_taken() -> None:
    eliminant = eliminant_of(FLAT)
    known = solve_slice(eliminant, Fraction(29), DIGITS)
    tracker = Tracker(eliminant, DIGITS, [known])
    assert tracker.table(Fraction(29)) is known
    solved = tracker.table(Fraction(30))
    assert solved is tracker.table(Fraction(30), DIGITS - 5)
    assert (solved.length, solved.digits) == (30, DIGITS)
    precise = tracker.table(Fraction(29), 60)
    assert precise.digits == 60
    assert tracker.table(Fraction(29)) is known
