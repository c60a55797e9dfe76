"""Cusp curves: cusps are followed through all lengths, and right documents are verified."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import pytest

from rpr_solver import EXAMPLES, Manipulator, cusp_curves
from rpr_solver.verify.claims import Open
from rpr_solver.verify.equations import Lengths, Mechanism
from rpr_solver.verify.finding import cusps_of
from rpr_solver.verify.geometry import Geometry
from rpr_solver.verify.slabs import HIGH, LOW, Slab, joined
from rpr_solver.verify.work import Work
from tests.rpr_solver.verify.forgeries import first_line
from tests.support.families import family

ZEIN = EXAMPLES["zein-flat"]
MECHANISM = Mechanism(Geometry.read(ZEIN.to_json(), ""), 1)


@cache
def curves(name: str = "") -> object:
    return cusp_curves(family(name) if name else Manipulator(9, 4, 11, 14, 15, 13), digits=15)


def strands(low: int | str, high: int | str, work: Work, without: int = 0) -> list[tuple[int, ...]]:
    """How many cusps of each slice, and events, are together between two slices without an event between."""
    ends = Fraction(low), Fraction(high)
    cusps = [[zero.within(60) for zero in cusps_of(MECHANISM, x, Work(0)).zeros] for x in ends]
    cusps[1] = cusps[1][without:]
    slab = Slab.of(Lengths(MECHANISM), ends, cusps)
    found = slab.strands(slab.marks(cusps, []), work)
    return sorted(tuple(sum(side == s for side, _ in strand) for s in (LOW, HIGH)) for strand in found)


def test_each_cusp_is_followed_to_another_one() -> None:
    assert strands(27, 31, Work(0)) == [(1, 1)] * 6


def test_a_cusp_that_is_followed_to_none_leaves_all_open() -> None:
    with pytest.raises(Open):
        strands(27, 31, Work(0), without=1)


def test_work_is_bounded() -> None:
    work = Work(0)
    work.spend(work.left - 10)
    with pytest.raises(Open):
        strands(27, 31, work)


def test_strands_that_share_a_cusp_between_are_one() -> None:
    parts = [
        frozenset({(0, 1), (9, 1)}),
        frozenset({(9, 1), (9, 2)}),
        frozenset({(9, 2), (1, 1)}),
        frozenset({(0, 2), (1, 2)}),
    ]
    shared = {(9, 1), (9, 2)}
    assert joined(parts, shared) == [frozenset({(0, 1), (1, 1)}), frozenset({(0, 2), (1, 2)})]


def test_curves_of_a_window_are_verified_to_their_ends_without_a_certificate() -> None:
    document = curves().part("15", "18", lengths=[Fraction(16), Fraction(17)]).to_json()  # type: ignore[attr-defined]
    assert first_line(document).startswith("VERIFIED: ")


@pytest.mark.long
def test_all_curves_are_verified() -> None:
    assert first_line(curves().to_json()).startswith("VERIFIED: ")  # type: ignore[attr-defined]


@pytest.mark.long
def test_curves_of_degenerate_families_are_named() -> None:
    assert first_line(curves("congruent, mirrored").to_json()).startswith("NOT VERIFIED: ")  # type: ignore[attr-defined]
