"""Cusp tables: checked input, the reference vectors, and slices as objects of a document."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from decimal import ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction

import mpmath as mp
import pytest

from rpr_solver import (
    EXAMPLES,
    Manipulator,
    SliceTable,
    Unproved,
    cusp_table,
    eliminate,
    parse_exact,
    slice_json,
    solve_slice,
    table_document,
    table_json,
)
from rpr_solver.slices.cusp_table import slices_json
from tests.support.article import coalescence, pose, singularity
from tests.support.reference import CASES
from tests.support.sampling import long
from tests.support.shared import eliminant_of

INNOCENTI = EXAMPLES["innocenti"]


def manipulator(
    a2x: object, a3x: object, a3y: object, d1: object, d2: object, d3: object, side: str
) -> Manipulator:
    return Manipulator.from_json(
        {"a2x": a2x, "a3x": a3x, "a3y": a3y, "d1": d1, "d2": d2, "d3": d3, "orientation": side}
    )


def kinds(table: SliceTable) -> dict[str, int]:
    return dict(Counter(p["kind"] for p in table.degenerate_points))


BESIDE = [
    ("26.78638", "26.78639", (6, 8)),
    ("28.09489", "28.0949", (8, 10)),
    ("30.94691", "30.94692", (6, 4)),
]


@pytest.mark.parametrize(
    ("low", "high", "counts", "places"),
    [
        (*BESIDE[1], 7),
        *(long(*transition, 30) for transition in BESIDE),
    ],
)
def test_slices_beside_a_transition(low: str, high: str, counts: tuple[int, int], places: int) -> None:
    """Bisection with exact counts converges to the transition; the counts are monotonic."""
    eliminant = eliminant_of(INNOCENTI)
    a, b = Fraction(low), Fraction(high)
    assert (solve_slice(eliminant, a, 15).count, solve_slice(eliminant, b, 15).count) == counts
    while b - a > Fraction(1, 10**places):
        middle = Fraction(round((a + b) / 2 * 10 ** (places + 2)), 10 ** (places + 2))
        count = solve_slice(eliminant, middle, 15).count
        assert count in counts
        a, b = (middle, b) if count == counts[0] else (a, middle)
    merging = {c.theta1_deg for c in solve_slice(eliminant, a if counts[0] > counts[1] else b, 40).cusps}
    assert len(merging) == max(counts)


def test_similar_triangles_have_nodes_and_no_cusps() -> None:
    eliminant = eliminate(manipulator(30, 0, 40, 15, 25, 20, "ccw"))
    for length in (2, 9, 60):
        table = solve_slice(eliminant, Fraction(length))
        assert table.count == 0
        assert kinds(table).keys() == {"node"}


def test_congruent_triangles_share_a_whole_curve() -> None:
    table = solve_slice(eliminate(manipulator(30, 0, 40, 30, 50, 40, "ccw")), Fraction(5))
    assert table.count == 0
    assert table.degenerate_points[0] == {"kind": "curve", "equation": "alpha = 0 deg"}


def test_a_flat_manipulator_has_quadruple_poses_and_no_cusps() -> None:
    flat = manipulator(20, 6, 0, 7, 9, 16, "ccw")
    for length in (3, 11, 30):
        table = solve_slice(eliminate(flat), Fraction(length))
        assert (table.count, kinds(table)) == (0, {"quadruple": 4})
        angles = {(p["alpha_deg"], p["theta1_deg"]) for p in table.degenerate_points}
        half_turn = "180." + "0" * 87
        assert angles == {(a, t) for a in ("0", half_turn) for t in ("0", half_turn)}


@pytest.mark.parametrize("places", [3, long(9), 30, long(60)])
def test_a_slice_exactly_at_a_rational_transition(places: int) -> None:
    """A swallowtail at L1 = 1: four cusps before and at it, six after, however near."""
    eliminant = eliminate(manipulator(2, -4, 4, 1, 4, 3, "cw"))
    step = Fraction(1, 10**places)
    before, at, after = (solve_slice(eliminant, 1 + d) for d in (-step, Fraction(0), step))
    assert (before.count, at.count, after.count) == (4, 4, 6)
    assert (kinds(before), kinds(at), kinds(after)) == ({}, {"swallowtail": 1}, {})
    factors = at.certificate["factors"]
    assert {"degree": 1, "multiplicity": 2, "origin": "cusps"} in factors  # type: ignore[operator]


@pytest.mark.parametrize("exponent", [-30, 30])
def test_extreme_scales_give_the_same_digits(exponent: int) -> None:
    factor = Fraction(10) ** exponent
    names = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
    huge = replace(INNOCENTI, **{name: getattr(INNOCENTI, name) * factor for name in names})
    [table] = cusp_table(INNOCENTI, ["14.98"])
    [scaled] = cusp_table(huge, [Fraction("14.98") * factor])
    for cusp, other in zip(table.cusps, scaled.cusps, strict=True):
        assert (cusp.alpha_deg, cusp.theta1_deg) == (other.alpha_deg, other.theta1_deg)
        assert Fraction(other.l2) == Fraction(cusp.l2) * factor


def test_digits_from_15_to_1000() -> None:
    eliminant = eliminate(INNOCENTI)
    long = solve_slice(eliminant, Fraction("14.98"), 1000)
    for digits in (15, 90, 317):
        for cusp, exact in zip(
            solve_slice(eliminant, Fraction("14.98"), digits).cusps, long.cusps, strict=True
        ):
            error = abs(Fraction(Decimal(cusp.l2)) - Fraction(Decimal(exact.l2)))
            assert 2 * error <= Fraction(10) ** (Decimal(cusp.l2).adjusted() + 1 - digits)


def test_cusps_come_in_the_order_of_theta() -> None:
    for length in ("14.98", "27", "28.1"):
        [table] = cusp_table(INNOCENTI, [length])
        angles = [Decimal(c.theta1_deg) for c in table.cusps]
        assert angles == sorted(angles)
        assert all(-180 < a <= 180 for a in angles)


def test_a_slice_is_its_table_or_its_error() -> None:
    eliminant = eliminate(INNOCENTI, 2)
    assert slice_json(eliminant, Fraction(9), 15) == solve_slice(eliminant, Fraction(9), 15).to_json()
    bad = slice_json(eliminant, Fraction(-9, 2), 15)
    assert bad.keys() == {"l2", "error"}
    assert bad["l2"] == "-4.5"
    assert bad["error"]["type"] == "input-error"  # type: ignore[index]


def test_one_bad_slice_does_not_spoil_the_others() -> None:
    steps: list[tuple[int, int]] = []
    lengths = [Fraction(9), Fraction(0), Fraction(20)]
    document = table_document(
        INNOCENTI, lengths, fixed_leg=3, digits=15, progress=lambda *step: steps.append(step)
    )
    eliminant = eliminate(INNOCENTI, 3)
    slices = [slice_json(eliminant, length, 15) for length in lengths]
    assert ["error" in item for item in slices] == [False, True, False]
    assert document == table_json(INNOCENTI, 3, 15, slices)
    assert list(document) == ["geometry", "geometry_hash", "fixed_leg", "digits", "solver_version", "slices"]
    assert steps == [(0, 3), (1, 3), (2, 3), (3, 3)]


def test_what_is_unproved_is_a_solver_error_in_its_place() -> None:
    def refuse(length: Fraction) -> SliceTable:
        raise Unproved(f"nothing is known of {length}")

    [item] = slices_json(refuse, [Fraction(1, 3)], 1, lambda *_: None)
    error = {"type": "solver-error", "detail": "nothing is known of 1/3"}
    assert item == {"l1": "1/3", "error": error}


SLICES = {
    f"{case['name']}-{item['l1']}": (case["geometry"], item) for case in CASES for item in case["slices"]
}


FIRST_SLICES = {f"{case['name']}-{case['slices'][0]['l1']}" for case in CASES}


@pytest.mark.parametrize(
    ("geometry", "expected"),
    [pytest.param(*x, id=n) if n in FIRST_SLICES else long(*x, id=n) for n, x in SLICES.items()],
)
def test_reference_slice(geometry: dict[str, str], expected: dict[str, object]) -> None:
    eliminant = eliminant_of(Manipulator.from_json(geometry))
    slice_json = solve_slice(eliminant, parse_exact(str(expected["l1"]), "l1"), 90).to_json()
    assert slice_json["count"] == expected["count"]
    nearest = Context(prec=90, rounding=ROUND_HALF_EVEN)
    for cusp, truth in zip(slice_json["cusps"], expected["cusps"], strict=True):  # type: ignore[call-overload]
        assert cusp.keys() == truth.keys()
        for key, text in cusp.items():
            assert Decimal(text) == nearest.create_decimal(truth[key]), key
            assert len(text.lstrip("-0.").replace(".", "")) == 90
    with mp.workdps(100):
        for cusp in slice_json["cusps"]:  # type: ignore[attr-defined]
            at = pose(eliminant.manipulator, str(expected["l1"]), cusp["alpha_deg"], cusp["theta1_deg"])
            assert abs(singularity(eliminant.manipulator, at)) < mp.mpf(10) ** -80
            assert abs(coalescence(eliminant.manipulator, at)) < mp.mpf(10) ** -80
            for length, text in zip(at.lengths[1:], (cusp["l2"], cusp["l3"]), strict=True):
                assert abs(length - mp.mpf(text)) < mp.mpf(10) ** -85 * length
