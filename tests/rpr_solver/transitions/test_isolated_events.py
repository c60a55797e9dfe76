"""Events: each is what it is said to be, none is at L ≤ 0, and Newton's method comes upon no other."""

from fractions import Fraction
from functools import cache
from typing import Any

import mpmath as mp
import pytest
from flint import arb
from mpmath import mpf

from rpr_solver import EXAMPLES, Manipulator, PoseKind, solve_slice
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.jets import Jet, LocalMap, Pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_systems import Event, EventSystems
from rpr_solver.transitions.isolated_events import (
    BallEvent,
    _critical,
    _swallowtail,
    events,
    limit_events,
)
from tests.support.definitions import DIGITS, Point, Slices, number, real, same_place
from tests.support.families import family
from tests.support.sampling import sample
from tests.support.shared import eliminant_of

INNOCENTI, ZEIN = EXAMPLES["innocenti"], EXAMPLES["zein-flat"]
CASES = [(ZEIN, 1), (ZEIN, 3), (INNOCENTI, 1), (family("similar, mirrored"), 2)]
BITS = 256


@cache
def systems_of(m: Manipulator, fixed_leg: int) -> EventSystems:
    return EventSystems.of(SliceMap.of(m, fixed_leg))


@cache
def events_of(m: Manipulator, fixed_leg: int) -> list[Event]:
    return list(events(systems_of(m, fixed_leg)))


def place_of(event: Event, slice_map: SliceMap) -> Point:
    assert event.pose is not None
    alpha, theta, *_ = map(number, event.pose.coordinates(BITS))
    length = number(event.scaled_length(BITS)) / real(slice_map.scale)
    return mp.radians(alpha), mp.radians(theta), length


@pytest.mark.parametrize(("m", "fixed_leg"), sample(CASES, 1, 3))
def test_every_event_is_of_its_kind_by_the_definitions(m: Manipulator, fixed_leg: int) -> None:
    slices, slice_map = Slices.of(m, fixed_leg), SliceMap.of(m, fixed_leg)
    with mp.workdps(DIGITS):
        for event in events_of(m, fixed_leg):
            if event.pose is None:
                continue
            place = place_of(event, slice_map)
            assert slices.kind(place) is event.pose.kind
            _, _, first, second = map(number, event.pose.coordinates(BITS))
            for leg, expected in zip((first, second), slices.free_legs(place), strict=True):
                assert abs(leg - expected) <= mpf("1e-25") * real(slices.size)


@pytest.mark.parametrize(("m", "fixed_leg"), sample(CASES, 1))
def test_newton_comes_upon_no_other(m: Manipulator, fixed_leg: int) -> None:
    slices, slice_map = Slices.of(m, fixed_leg), SliceMap.of(m, fixed_leg)
    with mp.workdps(DIGITS):
        places = [place_of(event, slice_map) for event in events_of(m, fixed_leg) if event.pose]
        by_newton = slices.by_newton(40)
        assert len(by_newton) > 4
        for place in by_newton:
            assert any(same_place(place, other) for other in places), place


@pytest.mark.parametrize(("m", "fixed_leg"), CASES)
def test_no_event_has_a_length_of_0_or_less(m: Manipulator, fixed_leg: int) -> None:
    assert all(event.scaled_length(BITS) > 0 for event in events_of(m, fixed_leg))


def test_a_ball_event_is_the_same_in_a_number_field() -> None:
    """Of similar triangles: the eliminant of its critical poses has factors of low degree."""
    m, fixed_leg = CASES[3]
    systems = systems_of(m, fixed_leg)
    critical = [
        x for x in events_of(m, fixed_leg) if isinstance(x, BallEvent) and x.system is systems.critical
    ]
    for event in critical:
        assert event.pose
        exact = event.pose.exact()
        assert exact.kind is event.kind
        assert exact.length.ball(200).overlaps(event.scaled_length(200))
        pairs = zip(exact.coordinates(200), event.coordinates(200), strict=True)
        assert all((ball_of(x) if isinstance(x, Fraction) else x).overlaps(y) for x, y in pairs)
    assert {event.kind for event in critical} == {PoseKind.LIPS, PoseKind.BEAK_TO_BEAK}


@pytest.mark.parametrize(("m", "fixed_leg", "limit"), [(ZEIN, 1, 20), (ZEIN, 2, 31), (INNOCENTI, 1, 15)])
@pytest.mark.parametrize("free", [0, 1])
def test_at_a_limit_event_a_cusp_has_the_limits_length(
    m: Manipulator, fixed_leg: int, limit: int, free: int
) -> None:
    systems, slices = systems_of(m, fixed_leg), Slices.of(m, fixed_leg)
    slice_map = systems.slice_map
    leg, square = (slice_map.f, slice_map.g)[free], (limit * slice_map.scale) ** 2
    cuts = [x for x in limit_events(systems, leg, square) if isinstance(x, BallEvent)]
    assert len(cuts) > 1
    with mp.workdps(DIGITS):
        for cut in cuts:
            assert cut.pose is None
            alpha, theta, *legs = map(number, cut.coordinates(BITS))
            assert abs(legs[free] - limit) < mpf("1e-50")
            place = (
                mp.radians(alpha),
                mp.radians(theta),
                number(cut.scaled_length(BITS)) / real(slice_map.scale),
            )
            assert place[2] > 0
            assert slices.kind(place) is PoseKind.CUSP


@pytest.mark.parametrize("free", [0, 1])
def test_between_limit_events_no_cusp_passes_the_limit(free: int) -> None:
    systems, limit = systems_of(ZEIN, 1), 31
    slice_map = systems.slice_map
    cuts = [
        float(x.scaled_length(64).mid()) / float(slice_map.scale)
        for x in (
            *limit_events(systems, (slice_map.f, slice_map.g)[free], (limit * slice_map.scale) ** 2),
            *events_of(ZEIN, 1),
        )
    ]

    def below(length: Fraction) -> int:
        cusps = solve_slice(eliminant_of(ZEIN), length, 15).cusps
        legs = ([c.to_json()["l2"], c.to_json()["l3"]][free] for c in cusps)
        return sum(Fraction(x) < limit for x in legs)

    counts: dict[int, set[int]] = {}
    for n in range(1, 60):
        counts.setdefault(sum(cut < n for cut in cuts), set()).add(below(Fraction(n)))
    assert all(len(x) == 1 for x in counts.values())
    assert len(set().union(*counts.values())) > 2


def jets(f: dict[tuple[int, int], int], g: dict[tuple[int, int], int]) -> LocalMap[arb]:
    """f and g by the coefficients of their Taylor series."""

    def jet(terms: dict[tuple[int, int], int]) -> Jet[arb]:
        factorials = (1, 1, 2, 6, 24)
        return Jet.build(4, lambda i, j: arb(terms.get((i, j), 0) * factorials[i] * factorials[j]))

    nowhere: Any = None
    return LocalMap(SliceMap.of(ZEIN), Pose(*[nowhere] * 6), jet(f), jet(g))


X = {(1, 0): 1}


@pytest.mark.parametrize(
    ("f", "g", "swallowtail", "critical"),
    [
        (X, {(0, 4): 1, (1, 1): 1}, PoseKind.SWALLOWTAIL, None),
        (X, {(0, 5): 1, (1, 1): 1}, None, None),
        (X, {(0, 3): 1, (2, 1): 1}, None, PoseKind.LIPS),
        (X, {(0, 3): 1, (2, 1): -1}, None, PoseKind.BEAK_TO_BEAK),
        (X, {(0, 3): -1, (2, 1): -1}, None, PoseKind.LIPS),
        (X, {(0, 4): 1, (1, 2): -1}, None, None),
        (X, {(0, 3): 1, (3, 1): 1}, None, None),
        ({(2, 0): 1, (0, 2): -1}, {(1, 1): 1}, None, None),
    ],
)
def test_balls_name_a_normal_form_only_where_they_prove_it(
    f: dict[tuple[int, int], int],
    g: dict[tuple[int, int], int],
    swallowtail: PoseKind | None,
    critical: PoseKind | None,
) -> None:
    local = jets(f, g)
    kinds = [found and found[0] for found in (_swallowtail(local, local), _critical(local, local))]
    assert kinds == [swallowtail, critical]
