"""What is 0 at a pose, proved by balls: number fields say the same, and nothing else is."""

from dataclasses import replace
from fractions import Fraction
from functools import cache

import pytest

from rpr_solver import Manipulator, census
from rpr_solver.exact.biform import BiForm, T
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions import isolated_events
from rpr_solver.transitions.event_systems import EventSystems
from rpr_solver.transitions.isolated_events import BallEvent, _located, events
from rpr_solver.transitions.vanishing import level, vanishes
from tests.support.families import family
from tests.support.sampling import long

EQUILATERAL = Manipulator(10, 5, "8.660", "1.732", "1.732", "1.732")
"""An equilateral pair, rounded."""
PRINTED = Manipulator(10, 5, "8.660254037844386", *["1.7320508075688772"] * 3)
"""The same as programs print it."""
RIGHT = family("right angles")
BESIDE = replace(RIGHT, d2=RIGHT.d2 * (1 + Fraction(1, 1000)))
SIDES = "7.211102550927979", "10.19803902718557", "7.211102550927979"
"""Of a platform beside a right isosceles triangle."""
TWO_ANGLES = Manipulator("-44.8", -16, "38.4", "44.7999552", 48, "41.6")
"""Nearly congruent and mirrored; leg 3 has length 0 at two angles."""


def ball_events(m: Manipulator) -> list[BallEvent]:
    return [e for e in events(systems_of(m)) if isinstance(e, BallEvent) and e.pose is not None]


@cache
def systems_of(m: Manipulator, leg: int = 1) -> EventSystems:
    return EventSystems.of(SliceMap.of(m, leg))


def test_an_angle_is_0_where_a_number_field_says_so() -> None:
    events_at_0 = [event for event in ball_events(EQUILATERAL) if event.coordinates(512)[0].is_zero()]
    assert events_at_0
    for event in events_at_0[:1]:
        pose = event.exact().local.pose
        assert pose.sin_alpha.is_zero
        assert pose.cos_alpha.sign > 0


def test_no_angle_is_0_that_is_not() -> None:
    angles = [event.coordinates(4096)[0] for event in ball_events(EQUILATERAL)]
    assert any(alpha.is_zero() for alpha in angles)
    assert any(abs(alpha) < 1 for alpha in angles if not alpha.contains(0))


def test_what_is_tiny_but_not_0_is_told_from_0() -> None:
    alpha, _ = level(SliceMap.of(EQUILATERAL))
    # 0 where tan(α/2) is 10^-400 or -10^400
    tiny = BiForm.of(2 * 10**400 * T - (1 - T**2), alpha.radicand, 2, 0)
    event = next(e for e in ball_events(EQUILATERAL) if e.coordinates(512)[0].is_zero())
    assert vanishes(event.system, event.root, alpha) is True
    assert vanishes(event.system, event.root, tiny) is False


@pytest.mark.parametrize(("m", "leg"), [(BESIDE, 1), (TWO_ANGLES, 3)])
def test_a_root_at_which_the_leg_has_no_length_is_told_from_the_others(m: Manipulator, leg: int) -> None:
    systems = systems_of(m, leg)
    system, found = systems.critical, []
    for root in real_roots(system.eliminant.polynomial):
        closes = vanishes(system, root, systems.permanent.first)
        # no precision shows that a length is 0
        assert closes == (_located(system, root, 4096) is None)
        found.append(closes)
    assert set(found) == {True, False}


def roots(base: list[str], platform: list[str]) -> Manipulator:
    return Manipulator.from_json({"base": {"sides": base}, "platform": {"sides": platform}})


@pytest.mark.parametrize(
    ("m", "leg"),
    [
        # L of a ball equals an exact length
        (roots(["7", "5.9", "7"], ["16.3", "16.300000000163", "16.3"]), 1),
        # a leg has length 0 where the triangles are nearly congruent
        long(roots(["9.7", "16.53", "17.5"], ["9.7", "16.5299999999998347", "17.5"]), 3),
        # a symmetry's image, close to another root
        (Manipulator("7.071067811865475", 0, "7.071067811865475", *SIDES), 1),
        # L is 0 or infinite above roots whose field is small, while the eliminant is long
        long(roots(["sqrt(48)"] * 3, ["3.000000000000000000000000000003", "3", "3"]), 1),
    ],
)
def test_beside_a_special_shape_no_event_needs_a_number_field(
    m: Manipulator, leg: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(BallEvent, "exact", None)
    monkeypatch.setattr(isolated_events, "exact_counterparts", None)
    assert census(m, fixed_leg=leg, digits=15).transitions


@pytest.mark.parametrize("exponent", [16, long(40)])
def test_beside_an_equilateral_pair_a_census_needs_no_number_field(
    exponent: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(BallEvent, "exact", None)
    m = PRINTED if exponent == 16 else replace(PRINTED, d1=PRINTED.d1 + Fraction(1, 10**exponent))
    table = census(m, digits=15)
    assert len(table.transitions) > 10
    assert max(table.counts) == 6
