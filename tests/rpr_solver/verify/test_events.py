"""All events of a fixed leg, and one by itself."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from fractions import Fraction
from functools import cache

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, Manipulator, census
from rpr_solver.slices import eliminate
from rpr_solver.transitions.event_systems import EventSystems, Landmark
from rpr_solver.transitions.isolated_events import limit_events
from rpr_solver.verify.core.members import POSE_KINDS
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Limits, Slice
from rpr_solver.verify.events import Crossings, Events, event_finding
from rpr_solver.verify.ranges import Range
from tests.support.families import family
from tests.support.sampling import long, sample
from tests.support.verified import geometry_of, printed, typed

SMALL = Manipulator(9, 4, 11, 14, 15, 13)


@cache
def events_of(manipulator: Manipulator, leg: int = 1, bits: int = 100) -> Events:
    return Events(Surface(geometry_of(manipulator), leg), bits)


def test_an_event_and_what_is_wrong_with_others() -> None:
    document = census(SMALL, digits=15, start=24).to_json()
    events = events_of(SMALL)
    assert events.open == ()
    [event] = document["transitions"][0]["events"]

    def found(length: str = document["transitions"][0]["l1"], **change: str) -> tuple[ClaimStatus, str]:
        return event_finding(events.surface, printed(length), typed({**event, **change}), events)

    assert found()[0] is ClaimStatus.PROVED
    digit = "1" if event["l2"].endswith("0") else "0"
    for wrong in (
        found(l2=event["l2"][:-1] + digit),
        found("37.5000000000000"),
        found(alpha_deg="12.3456789012345"),
        *(found(kind=kind) for kind in POSE_KINDS if kind != event["kind"]),
    ):
        assert wrong == (
            ClaimStatus.REFUSED,
            f"it is none of the {len(events.found)} events that are found anew",
        )


@pytest.mark.parametrize(
    ("manipulator", "leg"),
    [(SMALL, 2), long(EXAMPLES["innocenti"], 3), (EXAMPLES["zein-flat"], 1), long(family("isosceles"), 1)],
)
def test_all_events_are_those_of_the_solver(manipulator: Manipulator, leg: int) -> None:
    events = events_of(manipulator, leg)
    assert events.open == ()
    rows = [row for row in census(manipulator, digits=15, fixed_leg=leg).transitions for _ in row.events]
    assert len(rows) == len(events.found)
    for row, event in zip(rows, events.found, strict=True):
        assert printed(row.length).rounds(event.length(events.surface))
        assert event.kind in [other.kind for other in row.events]


FAMILIES_WITH_ALL_EVENTS = [
    *(("flat base", leg) for leg in (2, 1, 3)),
    *(("d1 = a2x", leg) for leg in (3, 1, 2)),
    *(("folded flat platform", leg) for leg in (1, 2)),
    *(("similar, mirrored", leg) for leg in (2, 3)),
    ("right angles", 2),
]


@pytest.mark.parametrize(("name", "leg"), sample(FAMILIES_WITH_ALL_EVENTS, 1, 10))
def test_events_are_all_where_roots_are_multiple_or_permanent_poses_degenerate(name: str, leg: int) -> None:
    events = events_of(family(name), leg)
    assert events.open == ()
    lengths = [
        *(event.length(events.surface) for event in events.found),
        *(landmark.length(events.surface) for landmark in events.unnamed),
    ]
    rows = census(family(name), digits=15, fixed_leg=leg).transitions
    assert all(any(printed(row.length).rounds(x) for x in lengths) for row in rows)
    assert all(any(printed(row.length).rounds(x) for row in rows) for x in lengths)


@pytest.mark.parametrize("leg", [1, long(3)])
def test_shared_angles_are_divided_out(leg: int) -> None:
    events = events_of(family("right angles"), leg)
    assert events.named
    assert any(len(p) > 1 for eliminant in events.eliminants for p in eliminant.system.shared)


def test_what_is_none_of_the_events_is_refused_where_all_are_known() -> None:
    manipulator = family("similar, mirrored")
    document, events = census(manipulator, digits=15).to_json(), events_of(manipulator)
    row = document["transitions"][0]
    assert events.named
    wrong = typed({**row["events"][0], "kind": "higher"})
    assert event_finding(events.surface, printed(row["l1"]), wrong, events)[0] is ClaimStatus.REFUSED
    events.open = ("one may be missing",)
    assert event_finding(events.surface, printed(row["l1"]), wrong, events)[0] is ClaimStatus.NOT_CHECKED


@pytest.mark.parametrize(
    ("manipulator", "leg", "number", "limit"),
    [(EXAMPLES["zein-flat"], 1, 3, "60"), long(SMALL, 2, 3, "7.5"), long(EXAMPLES["innocenti"], 3, 1, "31")],
)
def test_crossings_of_a_limit_are_those_of_the_solver(
    manipulator: Manipulator, leg: int, number: int, limit: str
) -> None:
    surface = Surface(geometry_of(manipulator), leg)
    crossings = Crossings(events_of(manipulator, leg), [(number, Fraction(limit))], 100)
    assert crossings.open == ()
    slice_map = eliminate(manipulator, leg).slice_map
    seen = (slice_map.f, slice_map.g)[surface.geometry.free_legs(leg).index(number)]
    square = (Fraction(limit) * slice_map.scale) ** 2
    lengths = sorted(
        float(event.scaled_length(100)) / slice_map.scale
        for event in limit_events(EventSystems.of(slice_map), seen, square)
        if not isinstance(event, Landmark)
    )
    own = sorted(float(event.length(surface).middle) for event in crossings.found)
    assert own == pytest.approx(lengths, rel=1e-12)


def test_the_number_within_a_limit_changes_at_a_crossing() -> None:
    surface, limits = Surface(geometry_of(EXAMPLES["zein-flat"]), 1), Limits({3: (None, Fraction(60))})
    length = Crossings(events_of(EXAMPLES["zein-flat"]), limits.each, 100).found[0].length(surface).middle
    off = Fraction(1, 10**6)
    counts = [limits.counted(Slice(surface.at(x))) for x in (length - off, length + off)]
    assert counts == [(7, True), (6, True)]


def test_no_cusp_has_a_leg_of_length_0() -> None:
    assert Crossings(events_of(SMALL), [(2, Fraction(0)), (3, Fraction(0))], 60).found == []


@pytest.mark.parametrize(("name", "told"), [(None, False), (("pair", 0, 1), True)])
def test_events_in_one_interval_are_of_one_length_only_by_a_name(name: object, told: bool) -> None:
    """As two may be whose lengths differ by less than the interval is wide, and slices between them."""
    events = copy(events_of(SMALL))
    event = replace(events.found[0], square=name)
    events.found = [event, event]
    assert (Range(events, [], Fraction(0), None).open == ()) is told


@pytest.mark.parametrize(
    ("m", "leg"),
    [
        # leg 2 closes with L = 0 at α = 180°, leg 3 elsewhere
        (Manipulator(-6, 3, 4, 6, 7, 5), 1),
        # two critical poses on an exact line
        (Manipulator(-6, 0, -7, 5, 3, 4, orientation="cw"), 2),
        # two double roots in ℚ(ω); above one are events whose tan(α/2) is not
        (Manipulator(6, 3, 4, 6, 7, 5), 2),
    ],
)
def test_all_are_found_where_equations_have_several_exact_roots(m: Manipulator, leg: int) -> None:
    events = events_of(m, leg)
    assert events.named
