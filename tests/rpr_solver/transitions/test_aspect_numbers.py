"""Numbers of aspects in a census: they are those of any slice of the interval."""

from __future__ import annotations

from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, census
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.aspects import aspect_cells
from rpr_solver.singular.sweep import sweep
from tests.support.families import family
from tests.support.shared import census_of


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


def test_an_island_is_an_aspect_of_its_own() -> None:
    part = census(EXAMPLES["innocenti"], start=26, stop=30, digits=15)
    assert 3 in part.aspects
    assert 2 in part.aspects


def test_where_events_are_not_isolated_no_number_is_given() -> None:
    part = census(family("similar"), start=5, stop=6, digits=15)
    assert set(part.aspects) == {None}
    assert [interval["aspects"] for interval in part.to_json()["intervals"]] == list(part.aspects)
