"""Poses that are singular at every L, and events above multiple roots, against the definitions."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from itertools import product

import mpmath as mp
import pytest
from mpmath import mpf

from rpr_solver import EXAMPLES, Manipulator, PoseKind
from rpr_solver.exact.factors import exact_roots, norm_factors
from rpr_solver.exact.number_field import Algebraic
from rpr_solver.model.jets import Pose
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.transitions import exact_events
from rpr_solver.transitions.event_systems import EventSystems, NotGeneric, System
from rpr_solver.transitions.exact_events import (
    _permanent_poses,
    events_above,
    never_degenerate,
    permanent_events,
    permanent_limits,
)
from tests.support.definitions import DIGITS, Point, Slices, number, real, same_place
from tests.support.families import family
from tests.support.sampling import sample

ZEIN = EXAMPLES["zein-flat"]
CASES = [(ZEIN, 1), (family("flat base"), 1), (family("d1 = a2x"), 3), (family("right angles"), 2)]
PERMANENT = [
    ("flat base", 1, ["quadruple"]),
    ("similar, mirrored", 2, ["node", "node"]),
    ("right angles", 2, ["node", "quadruple"]),
    ("isosceles", 3, ["swallowtail", "swallowtail"]),
    ("folded flat platform", 1, ["swallowtail"]),
    ("right angles", 1, []),
]


@cache
def systems_of(m: Manipulator, fixed_leg: int) -> EventSystems:
    return EventSystems.of(SliceMap.of(m, fixed_leg))


def place_of(pose: Pose[Algebraic], length: mpf) -> Point:
    entries = (pose.cos_alpha, pose.sin_alpha, pose.cos_theta, pose.sin_theta)
    cos_a, sin_a, cos_t, sin_t = (number(x.ball(256)) for x in entries)
    return mp.atan2(sin_a, cos_a), mp.atan2(sin_t, cos_t), length


def stretched(leg: Leg) -> list[tuple[mpf, mpf]]:
    """α and θ with the fixed leg and the side of the platform along the base line: ∇f = 0 at every L."""
    base = mp.atan2(leg.ay, leg.ax)
    side = mp.atan2(leg.n * mp.sqrt(leg.radicand), leg.m)
    return [(base - side + a, base + t) for a, t in product((0, mp.pi), repeat=2)]


@pytest.mark.parametrize(("m", "fixed_leg"), sample(CASES, 1, 3))
def test_poses_that_are_singular_at_every_length(m: Manipulator, fixed_leg: int) -> None:
    permanent, slices = systems_of(m, fixed_leg).permanent, Slices.of(m, fixed_leg)
    with mp.workdps(DIGITS):
        poses = [place_of(pose, mpf(1)) for pose in _permanent_poses(permanent)]
        for (alpha, theta, _), length in product(poses, (mpf(3), mpf(7), mpf("-0.11"))):
            assert abs(slices.values((alpha, theta, length), "j").j) < mpf("1e-50")
        for leg in (permanent.slice_map.f, permanent.slice_map.g):
            for alpha, theta in stretched(leg):
                turned = ((alpha, theta + turn, mpf(1)) for turn in (0, mp.pi))
                assert any(same_place(own, pose) for own in turned for pose in poses)
        apart = [same_place(x, y) for i, x in enumerate(poses) for y in poses[:i]]
        assert not any(apart)


@pytest.mark.parametrize(("name", "fixed_leg", "kinds"), PERMANENT)
def test_the_lengths_at_which_they_are_degenerate(name: str, fixed_leg: int, kinds: list[str]) -> None:
    m = family(name)
    permanent, slices = systems_of(m, fixed_leg).permanent, Slices.of(m, fixed_leg)
    own = list(permanent_events(permanent))
    assert sorted(event.pose.kind for event in own) == kinds
    with mp.workdps(DIGITS):
        for event in own:
            alpha, theta, *legs = map(number, event.pose.coordinates(256))
            length = number(event.scaled_length(256)) / real(permanent.slice_map.scale)
            place = mp.radians(alpha), mp.radians(theta), length
            assert length > 0
            assert slices.kind(place) is event.pose.kind
            assert event.exact_length.ball(256).overlaps(event.scaled_length(256))
            assert abs(slices.values((*place[:2], length * 7 / 5), "j").j) < mpf("1e-50")
            for leg, expected in zip(legs, slices.free_legs(place), strict=True):
                assert abs(leg - expected) < mpf("1e-25") * real(slices.size)


@pytest.mark.parametrize(("name", "fixed_leg"), [case[:2] for case in PERMANENT])
def test_at_other_lengths_they_are_not_degenerate(name: str, fixed_leg: int) -> None:
    m = family(name)
    permanent, slices = systems_of(m, fixed_leg).permanent, Slices.of(m, fixed_leg)
    with mp.workdps(DIGITS):
        seen = {
            slices.kind(place_of(pose, mpf(length)))
            for pose in _permanent_poses(permanent)
            for length in ("0.37", "8.11", "93.7")
        }
    assert seen <= {PoseKind.ORDINARY, PoseKind.CUSP}


def test_poses_that_are_degenerate_at_every_length_are_not_isolated() -> None:
    with pytest.raises(NotGeneric):
        list(permanent_events(systems_of(family("both flat"), 1).permanent))


def test_an_event_at_a_quarter_of_a_turn_of_the_fixed_leg() -> None:
    """v = ∞ is no root of a polynomial, but a zero of the form; it stands for 90° and −90°."""
    m = Manipulator(*map(Fraction, (2, -2, 0, 2, 3, 3)))
    system, slices = systems_of(m, 3).swallowtails, Slices.of(m, 3)
    assert system.eliminant.zeros_at_infinity
    own = list(events_above(system, None))
    angles = []
    with mp.workdps(DIGITS):
        for event in own:
            alpha, theta, *_ = map(number, event.pose.coordinates(256))
            angles.append((alpha, theta))
            length = number(event.scaled_length(256)) / real(system.slice_map.scale)
            assert event.pose.kind is PoseKind.SWALLOWTAIL
            assert slices.kind((mp.radians(alpha), mp.radians(theta), length)) is PoseKind.SWALLOWTAIL
    assert angles == [(-90, 90), (90, -90)]


def test_events_above_exact_roots() -> None:
    m = family("similar, mirrored")
    system, slices = systems_of(m, 2).critical, Slices.of(m, 2)
    roots = exact_roots(norm_factors(system.eliminant.polynomial))
    own = [event for root in roots for event in events_above(system, root)]
    assert sorted(event.pose.kind for event in own) == ["beak-to-beak"] * 3 + ["lips"]
    with mp.workdps(DIGITS):
        for event in own[::2]:
            length = number(event.scaled_length(256)) / real(system.slice_map.scale)
            assert slices.kind(place_of(event.pose.exact().local.pose, length)) is event.pose.kind


def test_a_cusp_that_passes_such_a_pose_at_a_limit() -> None:
    m = family("similar, mirrored")
    permanent, slices = systems_of(m, 1).permanent, Slices.of(m, 1)
    slice_map = permanent.slice_map
    scaled = Fraction(27)
    length = scaled / slice_map.scale
    with mp.workdps(DIGITS):
        poses = [place_of(pose, real(length)) for pose in _permanent_poses(permanent)]
        cusps = [slices.free_legs(place) for place in poses if slices.kind(place) is PoseKind.CUSP]
        assert cusps
        squares = [[Fraction(int(mp.nint(leg**2))) for leg in legs] for legs in cusps]
        assert all(
            abs(leg**2 - real(square)) < mpf("1e-40")
            for legs, own in zip(cusps, squares, strict=True)
            for leg, square in zip(legs, own, strict=True)
        )
    for own in squares:
        for leg, square in zip((slice_map.f, slice_map.g), own, strict=True):
            here, elsewhere = (
                [x.rational for x in permanent_limits(permanent, leg, s * slice_map.scale**2)]
                for s in (square, square + 1)
            )
            assert scaled in here
            assert scaled not in elsewhere


def test_permanent_events_beside_an_equilateral_pair_need_no_field_of_their_direction(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sides = {"sides": ["9", "9", "9.000000009"]}
    m = Manipulator.from_json({"base": sides, "platform": {"sides": ["sqrt(84)"] * 3}})
    permanent = permanent_of(m, 2)
    with monkeypatch.context() as patch:
        patch.setattr(exact_events, "_upright", None)
        found = list(permanent_events(permanent))
        places = [(event.scaled_length(256), event.pose.coordinates(256)) for event in found]
        fields = [event.exact_length.field.degree for event in found]
    assert [event.pose.kind for event in found] == ["swallowtail"] * 4
    assert max(fields) == 16
    event, (length, place) = found[0], places[0]
    pose = event.pose.exact()
    assert pose.kind is event.pose.kind
    assert pose.length.ball(256).overlaps(length)
    assert event.exact_length.ball(256).overlaps(length)
    assert all(x.overlaps(y) for x, y in zip(pose.coordinates(256), place, strict=True))


@cache
def permanent_of(m: Manipulator, fixed_leg: int) -> System:
    return EventSystems.of(SliceMap.of(m, fixed_leg)).permanent


@pytest.mark.parametrize(
    ("name", "fixed_leg"),
    [
        ("flat base", 1),
        ("similar, mirrored", 2),
        ("right angles", 2),
        ("isosceles", 3),
        ("folded flat platform", 1),
        ("both flat", 1),
    ],
)
def test_degenerate_ones_are_not_denied(name: str, fixed_leg: int) -> None:
    assert not never_degenerate(permanent_of(family(name), fixed_leg))
