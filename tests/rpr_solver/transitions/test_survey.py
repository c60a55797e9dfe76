"""The survey: equal events together by proof, a slice in each interval, and its number of aspects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from itertools import groupby, pairwise

import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, census, solve_slice
from rpr_solver.contract import silent
from rpr_solver.errors import Unproved
from rpr_solver.exact.number_field import Algebraic
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.aspects import aspect_cells
from rpr_solver.singular.sweep import sweep
from rpr_solver.transitions.event_systems import Event, EventSystems, Landmark
from rpr_solver.transitions.isolated_events import events
from rpr_solver.transitions.survey import (
    Survey,
    _bounds,
    grouped,
    survey,
)
from tests.support.families import family
from tests.support.number_fields import BOTH, RATIONALS, ROOT_TWO, in_both
from tests.support.shared import census_of


def rational(x: Fraction | int) -> Landmark:
    return Landmark(RATIONALS(Fraction(x)))


@cache
def events_of(m: Manipulator, fixed_leg: int) -> list[Event]:
    return list(events(EventSystems.of(SliceMap.of(m, fixed_leg))))


@given(
    st.lists(
        st.tuples(st.sampled_from(["ℚ", "√2", "√2 again", "√3"]), st.fractions(1, 3, max_denominator=3)),
        max_size=8,
    )
)
def test_lengths_ascend_and_equal_ones_are_together(pairs: list[tuple[str, Fraction]]) -> None:
    """Multiples of 1, √2 and √3: their squares tell the order."""
    units = {
        "ℚ": (RATIONALS(1), 1),
        "√2": (ROOT_TWO.generator, 2),
        "√2 again": (in_both("√2"), 2),
        "√3": (in_both("√3"), 3),
    }
    squares = {}
    for name, factor in pairs:
        unit, square = units[name]
        event = Landmark(unit * unit.field(factor))
        squares[id(event)] = (event, square * factor**2)
    groups = grouped([event for event, _ in squares.values()])
    result = [[squares[id(event)][1] for event in group] for group in groups]
    expected = [list(same) for _, same in groupby(sorted(square for _, square in squares.values()))]
    assert result == expected


@pytest.mark.parametrize("exponent", [20, 300, 1900])
def test_lengths_nearer_than_a_float_can_tell_are_told_apart(exponent: int) -> None:
    little = Fraction(1, 10**exponent)
    below, at, above = rational(1 - little), rational(1), rational(1 + little)
    assert grouped([above, at, below]) == [[below], [at], [above]]
    root = Landmark(ROOT_TWO.generator)
    beside = Landmark(in_both("√2") + BOTH(little))
    assert grouped([beside, root]) == [[root], [beside]]


@dataclass(frozen=True)
class Blurred:
    """An event whose balls all hold 1."""

    pose: None = None
    exact_length: Algebraic | None = None
    lasting: bool = False

    def scaled_length(self, bits: int) -> arb:
        return arb(1, arb(2) ** -bits)


def test_lengths_that_are_neither_equal_nor_apart_are_refused() -> None:
    with pytest.raises(Unproved, match="could not be proved to be one"):
        grouped([Blurred(), Blurred()])
    assert len(grouped([Blurred(), rational(2)])) == 2
    assert len(grouped([Blurred(exact_length=RATIONALS(1)), rational(1)])) == 1


def test_mirror_images_stand_together() -> None:
    """Held at the apex: each event off the mirror has an image, at the same length and of the same kind."""
    m = family("isosceles")
    groups = grouped(events_of(m, 3))
    pairs = [group for group in groups if len(group) > 1]
    assert pairs
    for first, second in pairs:
        assert first.pose
        assert second.pose
        assert first.pose.kind is second.pose.kind
        ours, theirs = (event.pose.coordinates(256) for event in (first, second))  # type: ignore[union-attr]
        # the free legs change places
        assert ours[2].overlaps(theirs[3])
        assert ours[3].overlaps(theirs[2])
        assert not ours[2].overlaps(ours[3])
    lengths = [float(group[0].scaled_length(64).mid()) for group in groups]
    assert lengths == sorted(lengths)
    assert len(set(lengths)) == len(lengths)


TWINS = [
    (Manipulator(*map(Fraction, ("22.5", "-6.3", "-8.4", "15", "20", "7"))), 1),
    (Manipulator(*map(Fraction, (5, 0, 12, 5, 12, 13)), orientation="cw"), 3),
]
"""Symmetries of another kind: a leg becomes a sum of both; base and platform change places."""


@pytest.mark.parametrize(("m", "fixed_leg"), TWINS)
def test_twins_of_less_visible_symmetries_stand_together(m: Manipulator, fixed_leg: int) -> None:
    groups = grouped(events_of(m, fixed_leg))
    assert sum(len(group) == 2 for group in groups) >= 5
    assert all(group[0].pose.kind is group[1].pose.kind for group in groups if len(group) == 2)  # type: ignore[union-attr]


ZEIN = EXAMPLES["zein-flat"]
FOLDED = family("folded flat platform")
"""It has a swallowtail at L1 = 1, a pose that is singular at every length."""


@cache
def surveyed(m: Manipulator, start: Fraction = Fraction(0), stop: Fraction | None = None) -> Survey:
    return survey(m, 1, silent, start=start, stop=stop)


def lengths_of(result: Survey) -> list[Fraction]:
    """The lengths of the events in the user's unit, to 25 digits."""
    scale = result.eliminant.slice_map.scale
    return [
        Fraction(group[0].scaled_length(256).mid().str(25, radius=False)) / scale for group in result.groups
    ]


@pytest.mark.parametrize("m", [ZEIN, FOLDED, family("congruent, mirrored")])
def test_each_slice_lies_strictly_between_its_neighbours(m: Manipulator) -> None:
    result = surveyed(m)
    scale = result.eliminant.slice_map.scale
    assert len(result.slices) == len(result.groups) + 1
    for k, group in enumerate(result.groups):
        for event in group:
            low, high = (x / scale for x in _bounds(event, 256))
            assert result.slices[k].length < low <= high < result.slices[k + 1].length
    assert result.slices[0].length > 0


@pytest.mark.parametrize("cut", [Fraction(20), Fraction(32), Fraction(1, 100), Fraction(10**6)])
def test_two_ranges_that_meet_hold_the_events_of_the_whole(cut: Fraction) -> None:
    whole, below, above = surveyed(ZEIN), surveyed(ZEIN, stop=cut), surveyed(ZEIN, cut)
    assert lengths_of(below) + lengths_of(above) == lengths_of(whole)
    counts = [table.count for table in (*below.slices, *above.slices)]
    place = len(below.groups)
    assert counts.pop(place) == counts[place]
    assert counts == [table.count for table in whole.slices]
    assert below.slices[-1].length < cut < above.slices[0].length


def test_an_event_at_the_end_of_a_range_is_outside() -> None:
    whole = lengths_of(surveyed(FOLDED))
    assert 1 in whole
    below, above = surveyed(FOLDED, stop=Fraction(1)), surveyed(FOLDED, Fraction(1))
    assert lengths_of(below) == [x for x in whole if x < 1]
    assert lengths_of(above) == [x for x in whole if x > 1]
    assert below.slices[-1].length < 1 < above.slices[0].length


@pytest.mark.parametrize("exponent", [3, 40, 400])
def test_an_event_right_inside_the_end_of_a_range_is_inside(exponent: int) -> None:
    """A range of which both ends are beside the event, one slice on either side."""
    little = Fraction(1, 10**exponent)
    result = surveyed(FOLDED, 1 - little, 1 + little)
    assert lengths_of(result) == [1]
    below, above = result.slices
    assert 1 - little < below.length < 1 < above.length < 1 + little
    beside = surveyed(FOLDED, 1 + little / 10, 1 + little)
    assert not beside.groups
    [table] = beside.slices
    assert table.count == above.count


@pytest.mark.parametrize("name", ["zein-flat", "innocenti"])
def test_the_numbers_are_those_of_slices_at_both_ends_of_an_interval(name: str) -> None:
    whole = census_of(EXAMPLES[name])
    slice_map = SliceMap.of(EXAMPLES[name])
    assert {None, 1} & set(whole.aspects) == set()
    for interval, number in zip(whole.to_json()["intervals"], whole.aspects, strict=True):
        start, stop = Fraction(interval["from"]), Fraction(interval["to"] or 2 * Fraction(interval["from"]))
        assert interval["aspects"] == number
        for part in (Fraction(1, 9), Fraction(7, 8)):
            length = start + part * (stop - start)
            assert len(aspect_cells(sweep(slice_map, length * slice_map.scale))) == number


def test_where_events_are_not_isolated_no_number_is_given() -> None:
    part = census(family("similar"), start=5, stop=6, digits=15)
    assert set(part.aspects) == {None}
    assert [interval["aspects"] for interval in part.to_json()["intervals"]] == list(part.aspects)


def test_a_pose_that_solves_several_systems_is_listed_once() -> None:
    [transition] = census(FOLDED, fixed_leg=3, digits=15, start="3.9", stop="4.1").transitions
    assert transition.length == "4.00000000000000"
    assert [event.kind for event in transition.events] == ["node"]


@pytest.mark.parametrize("name", ["innocenti", "zein-flat", "sixteen-cusps", "eighteen-cusps"])
@pytest.mark.parametrize("leg", [1, 2])
def test_what_changes_at_events_is_what_slices_on_both_sides_have(name: str, leg: int) -> None:
    found = survey(EXAMPLES[name], leg, silent)
    counts = [solve_slice(found.eliminant, part.length, 15).count for part in found.slices]
    assert [part.count for part in found.slices] == counts
    proved = [
        (before + sum(event.change for event in group), after)
        for group, (before, after) in zip(found.groups, pairwise(counts), strict=True)
        if all(event.change is not None for event in group)
    ]
    assert proved
    assert all(expected == after for expected, after in proved)


def test_sides_of_very_different_sizes_are_refused_at_once() -> None:
    far = replace(EXAMPLES["innocenti"], a2x=Fraction(10) ** 399)
    for fixed_leg in (1, 2, 3):
        with pytest.raises(Unproved, match="1e60"):
            census(far, fixed_leg=fixed_leg, digits=15)
    wide = replace(EXAMPLES["innocenti"], a2x=Fraction(10) ** 20)
    assert len(census(wide, digits=15).transitions) == 20
