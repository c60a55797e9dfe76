"""Intervals of lengths: a slice strictly inside each, short to write, whatever the range and its ends."""

from collections.abc import Iterable
from fractions import Fraction
from functools import cache
from itertools import pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, solve_slice
from rpr_solver.contract import silent
from rpr_solver.errors import Unproved
from rpr_solver.exact.number_field import Field
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_types import Event, Landmark
from rpr_solver.transitions.survey import (
    LimitEvents,
    Survey,
    _bounds,
    _gap,
    _short_between,
    survey,
)
from tests.support.families import family
from tests.support.shared import eliminant_of

ZEIN = EXAMPLES["zein-flat"]
FOLDED = family("folded flat platform")
"""It has a swallowtail at L1 = 1, a pose that is singular at every length."""
RATIONALS = Field.rationals()


@cache
def surveyed(m: Manipulator, start: Fraction = Fraction(0), stop: Fraction | None = None) -> Survey:
    return survey(m, 1, silent, start=start, stop=stop)


def landmark(x: Fraction) -> Landmark:
    return Landmark(RATIONALS(x))


def lengths_of(result: Survey) -> list[Fraction]:
    """The lengths of the events in the user's unit, to 25 digits."""
    scale = result.eliminant.slice_map.scale
    return [
        Fraction(group[0].scaled_length(256).mid().str(25, radius=False)) / scale for group in result.groups
    ]


def decimals(x: Fraction) -> int:
    """The digits behind the point."""
    return next(n for n in range(400) if (x * 10**n).denominator == 1)


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


def test_the_lengths_of_slices_are_short_decimals() -> None:
    """One digit more than the gap between its neighbours needs, at most."""
    result = surveyed(ZEIN)
    ends = [Fraction(0), *lengths_of(result)]
    for (low, high), table in zip(pairwise(ends), result.slices, strict=False):
        assert (high - low) * 10 ** decimals(table.length) <= 400 or decimals(table.length) == 0
    assert decimals(result.slices[-1].length) == 0


def test_the_slices_are_those_of_the_eliminant() -> None:
    result = surveyed(FOLDED)
    for table in result.slices:
        assert table.count == solve_slice(eliminant_of(FOLDED), table.length, 20).count
        assert table.digits == 15


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


def test_a_narrow_range_has_one_slice() -> None:
    result = surveyed(ZEIN, Fraction(20), Fraction(20) + Fraction(1, 10**60))
    [table] = result.slices
    assert 0 < table.length - 20 < Fraction(1, 10**60)


def test_further_lengths_are_looked_at_on_both_sides() -> None:
    inside, outside = [Fraction(5, 2), Fraction(50)], Fraction(10**4)

    def more(slice_map: SliceMap, _: LimitEvents) -> Iterable[Event]:
        return [landmark(x * slice_map.scale) for x in (*inside, outside)]

    stop = Fraction(60)
    result = survey(FOLDED, 1, silent, stop=stop, more=more)
    assert lengths_of(result) == sorted([*lengths_of(surveyed(FOLDED, stop=stop)), *inside])
    assert len(result.slices) == len(result.groups) + 1


@pytest.mark.parametrize(("m", "method"), [(ZEIN, "events"), (family("similar"), "components")])
def test_components_take_the_place_of_events_that_are_not_isolated(m: Manipulator, method: str) -> None:
    found: list[Event] = []

    def more(slice_map: SliceMap, limit_events: LimitEvents) -> Iterable[Event]:
        found.extend(limit_events(slice_map.f, Fraction(10**6)))
        return found

    result = survey(m, 1, silent, more=more)
    assert result.method == method
    assert found
    assert len(result.groups) >= (len(found) if method == "events" else 1)


def test_progress_grows_to_its_end() -> None:
    steps: list[tuple[int, int]] = []
    result = survey(FOLDED, 1, lambda done, total: steps.append((done, total)), digits=15)
    assert [done for done, _ in steps] == list(range(1, len(steps) + 1))
    assert steps[-1][0] == steps[-1][1] == 4 + len(result.slices)


@given(st.fractions(0, 1000), st.fractions(0, 1000, max_denominator=10**30))
def test_a_short_decimal_between(low: Fraction, gap: Fraction) -> None:
    assume(gap > 0)
    x = _short_between(low, low + gap)
    assert low < x < low + gap
    digits = decimals(x)
    assert digits == 0 or gap * 10**digits < 40


@pytest.mark.parametrize("exponent", [0, 50, 3000])
def test_a_gap_is_almost_the_whole_distance(exponent: int) -> None:
    little = Fraction(1, 10**exponent)
    below, above = landmark(Fraction(1, 3)), landmark(Fraction(1, 3) + little)
    low, high = _gap(below, above)
    assert Fraction(1, 3) <= low < high <= Fraction(1, 3) + little
    assert high - low > little * Fraction(9, 10)
    assert _gap(None, below)[0] == 0


def test_equal_lengths_have_no_gap() -> None:
    third = landmark(Fraction(1, 3))
    with pytest.raises(Unproved, match="could not be separated"):
        _gap(third, landmark(Fraction(1, 3)))
