"""Counts of slices without their cusps, and short numbers between others."""

from collections.abc import Callable, Iterator
from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, Manipulator
from rpr_solver.verify.core.system import System
from rpr_solver.verify.counts import Bounds, changed, count_of, drawn_within, sampled, simplest_between
from tests.support.families import family
from tests.support.verified import geometry_of, printed


def counted(manipulator: Manipulator, length: str) -> tuple[int, bool] | None:
    return count_of(System.of(geometry_of(manipulator), 1, Fraction(length)))


def test_counts() -> None:
    assert counted(EXAMPLES["zein-flat"], "34.5") == (8, True)
    assert counted(family("congruent"), "9") is None


@pytest.mark.long
def test_cusps_are_searched_for_beside_multiple_roots() -> None:
    assert counted(family("similar"), "9") == (0, False)


def test_short_numbers() -> None:
    low = Fraction("9.1868068")
    for high in (Fraction("9.1868069"), Fraction("9.3"), Fraction(200)):
        between = simplest_between(low, high)
        assert low < between < high
        assert between.denominator <= 10 / (high - low) + 1


def test_slices_are_drawn_anew_within_an_interval() -> None:
    bounds: Bounds = Fraction(36), Fraction("36.00001")
    drawn = {drawn_within(bounds) for _ in range(20)}
    assert len(drawn) > 15
    assert all(bounds[0] < x < bounds[1] for x in drawn)


def counts(*found: tuple[int, bool] | None) -> Callable[[Fraction], tuple[int, bool] | None]:
    answers: Iterator[tuple[int, bool] | None] = iter(found)
    return lambda _: next(answers)


@pytest.mark.parametrize(
    ("found", "status"),
    [
        (((4, True), (4, True)), ClaimStatus.CHECKED),
        (((4, True), (6, True)), ClaimStatus.REFUSED),
        ((None,), ClaimStatus.NOT_CHECKED),
    ],
)
def test_slices_refute_an_interval_or_leave_it_open(
    found: tuple[tuple[int, bool] | None, ...], status: ClaimStatus
) -> None:
    claim = sampled("/x", 4, (Fraction(1), Fraction(2)), counts(*found), 2)
    assert (claim.status, claim.established) == (status, False)
    assert sampled("/x", 4, None, counts(), 2).status is ClaimStatus.NOT_CHECKED


def test_a_number_that_changes() -> None:
    cut, outer = printed("2.00"), (Fraction(1), Fraction(3))

    def status(numbers: tuple[int, int], *found: tuple[int, bool] | None) -> ClaimStatus:
        return changed("/x", cut, outer, numbers, counts(*found)).status

    assert status((4, 6), (4, True), (6, True)) is ClaimStatus.PROVED
    assert status((4, 6), (4, True), (6, False)) is ClaimStatus.CHECKED
    assert status((4, 6), (4, True), (4, True)) is ClaimStatus.REFUSED
    assert status((4, 4), (4, True), (4, True)) is ClaimStatus.REFUSED
    assert status((4, 6), None) is ClaimStatus.NOT_CHECKED
    near = changed("/x", cut, (Fraction("1.999"), None), (4, 6), counts((4, True), (6, True)))
    assert near.status is ClaimStatus.NOT_CHECKED
