"""Cusp curves: cusps are followed through all lengths, and right documents are verified."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import pytest
from flint import arb

from rpr_solver import EXAMPLES, Manipulator, cusp_curves
from rpr_solver.verify_by_boxes.claims import OpenError
from rpr_solver.verify_by_boxes.components import components
from rpr_solver.verify_by_boxes.equations import Lengths, Mechanism
from rpr_solver.verify_by_boxes.finding import cusps_of
from rpr_solver.verify_by_boxes.geometry import Geometry
from rpr_solver.verify_by_boxes.slabs import HIGH, LOW, Slab, joined
from rpr_solver.verify_by_boxes.work import Work
from tests.rpr_solver.verify_by_boxes.forgeries import first_line
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
    with pytest.raises(OpenError):
        strands(27, 31, Work(0), without=1)


def test_work_is_bounded() -> None:
    work = Work(0)
    work.spend(work.left - 10)
    with pytest.raises(OpenError):
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


def test_components_are_named_by_their_least_node() -> None:
    import numpy as np

    pairs = np.array([[4, 1, 5], [2, 3, 4]])
    assert components(6, pairs).tolist() == [0, 1, 2, 1, 2, 2]


def test_marks_are_where_their_slices_are() -> None:
    slab = Slab.of(Lengths(MECHANISM), (Fraction(27), Fraction(31)), [[], []])
    marks = slab.marks([[[arb(0), arb(0)]], [[arb(1), arb(1)]]], [[arb(0), arb(0), arb(29)]])
    low, high, event = (mark.box[2] for mark in marks)
    assert (low, high) == (0, slab.top)
    assert event.overlaps(high / 2)


def test_curves_of_a_window_are_verified_to_their_ends_without_a_certificate() -> None:
    document = curves().part("15", "18", lengths=[Fraction(16), Fraction(17)]).to_json()  # type: ignore[attr-defined]
    assert first_line(document).startswith("VERIFIED: ")


@pytest.mark.long
def test_all_curves_are_verified() -> None:
    assert first_line(curves().to_json()).startswith("VERIFIED: ")  # type: ignore[attr-defined]


def test_curves_of_degenerate_families_are_named() -> None:
    assert first_line(curves("congruent, mirrored").to_json()).startswith("NOT VERIFIED: ")  # type: ignore[attr-defined]
