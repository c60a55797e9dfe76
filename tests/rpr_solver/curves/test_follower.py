"""Followed cusps and the cusps of other slices that they reach, against a predictor-corrector."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import mpmath as mp
import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, Eliminant, Manipulator, Unproved, cusp_curves
from rpr_solver.curves import follower as follower_module
from rpr_solver.curves.follower import Cusp, Follower, Lost, Tracker
from rpr_solver.curves.neighbourhood import CuspForms, PoseBox
from rpr_solver.model.jets import HalfTangent
from tests.support.definitions import Point, Slices, distance
from tests.support.places import cusps_in, place
from tests.support.sampling import sample
from tests.support.shared import eliminant_of

DIGITS = 30
TUBES = 500
FLAT, INNOCENTI = EXAMPLES["zein-flat"], EXAMPLES["innocenti"]


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


def decimal(x: Fraction) -> mp.mpf:
    return mp.mpf(x.numerator) / x.denominator


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
