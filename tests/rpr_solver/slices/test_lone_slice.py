"""How one slice is decided: by balls where its eliminant is generic, else over number fields."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import fmpz_poly

from rpr_solver import EXAMPLES, Manipulator, SliceTable, solve_slice
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.slices.lone_slice import LoneSlice
from tests.support.families import family
from tests.support.newton import count_cusps
from tests.support.shared import eliminant_of


def slice_of(m: Manipulator, length: str, digits: int = 20, leg: int = 1) -> LoneSlice:
    return LoneSlice(eliminant_of(m, leg), Fraction(length), digits)


def method(table: SliceTable) -> str:
    return table.certificate["method"]


@pytest.mark.parametrize(
    ("name", "length"),
    [("congruent, mirrored", "9"), pytest.param("similar, mirrored", "7/2", marks=pytest.mark.long)],
)
def test_number_fields_and_balls_lead_to_the_same_cusps(
    name: str, length: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the last digit, where balls are not allowed to say anything."""
    own = slice_of(family(name), length).solve()
    assert own.count > 0
    monkeypatch.setattr(LoneSlice, "_by_balls", lambda *_: None)
    exact = slice_of(family(name), length).solve()
    assert exact.to_json()["cusps"] == own.to_json()["cusps"]
    assert exact.degenerate_points == own.degenerate_points
    assert (method(exact), exact.certificate["factors"]) == ("exact", own.certificate["factors"])


@pytest.mark.parametrize("length", ["17", "43"])
@pytest.mark.parametrize(("a2x", "degree"), [(30, 1), (-30, 0)])
def test_where_a_leg_closes_stretched_along_its_base_line_poses_are_looked_at_exactly(
    a2x: int, length: str, degree: int
) -> None:
    """L1 = |A1A2| ± |B1B2|, so that leg 2 closes at θ1 = 0, or at 180° where u is infinite."""
    m = Manipulator(*map(Fraction, (a2x, 11, 27, 13, 9, 4)))
    common = slice_of(m, length)._touching()
    assert common is not None
    assert common.degree() == degree
    assert degree == 0 or common(0) == 0
    table = slice_of(m, length).solve()
    assert method(table) == "exact"
    assert table.count == len(count_cusps(m, float(length), starts=10))
    beside = Fraction(length) + Fraction(1, 10**9)
    assert slice_of(m, str(beside))._touching() is None
    assert method(solve_slice(eliminant_of(m), beside, 15)) == "balls"


def test_a_generic_slice_is_proved_to_be_one() -> None:
    swallowtail = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
    for m, length, generic in (
        (EXAMPLES["zein-flat"], "10", True),
        (EXAMPLES["zein-flat"], "17", False),
        (swallowtail, "1", False),
        (swallowtail, "1.000001", True),
        (family("similar"), "5", False),
        (family("congruent"), "5", False),
    ):
        x = slice_of(m, length)
        assert x._generic(x.eliminant.at(x.scaled)) == generic


def test_a_root_that_could_be_spurious_is_not_generic() -> None:
    """Polynomials of degree 24 with simple roots, one of them at a known factor's."""
    x = slice_of(EXAMPLES["zein-flat"], "10")
    f = x.slice_map.f
    assert x._generic(QuadraticPoly.rational([-2, *[0] * 23, 1]))
    for factor in (f.collinear(), f.closed(x.scaled), fmpz_poly([1, 0, 1])):
        rest = fmpz_poly([-2, *[0] * (23 - factor.degree()), 1])
        assert not x._generic(QuadraticPoly.rational(factor * rest))


@pytest.mark.parametrize(
    ("name", "length"),
    [("congruent, mirrored", "9"), ("similar", "5"), ("both flat", "3")],
)
def test_a_slice_that_is_decided_exactly_accounts_for_the_whole_resultant(name: str, length: str) -> None:
    table = slice_of(family(name), length).solve()
    assert method(table) == "exact"
    assert sum(f["degree"] * f["multiplicity"] for f in table.certificate["factors"]) == 48
    assert table.certificate["eliminant_degree"] == 24


@pytest.mark.parametrize(
    ("leg", "origins"),
    [
        (1, ["L2=0", "leg 1 along A1A2"]),
        (2, ["L1=0", "leg 2 along A1A2"]),
        (3, ["L1=0", "leg 3 along A1A3"]),
    ],
)
def test_known_factors_are_named_by_the_leg_that_closes(leg: int, origins: list[str]) -> None:
    """The leg f of the slice map: the first of the free ones."""
    factors = solve_slice(eliminant_of(EXAMPLES["zein-flat"], leg), 10, 15).certificate["factors"]
    shapes = [(2, 1), (2, 2), (2, 9), (24, 1)]
    expected = zip(shapes, [*origins, "circular", "cusps"], strict=True)
    assert [((f["degree"], f["multiplicity"]), f["origin"]) for f in factors] == list(expected)


def test_roots_at_infinity_are_accounted_for() -> None:
    """The swallowtail at L1 = 1 lies at u = ∞, twice."""
    certificate = (
        slice_of(Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw"), "1").solve().certificate
    )
    cusps = [(f["degree"], f["multiplicity"]) for f in certificate["factors"] if f["origin"] == "cusps"]
    assert cusps == [(22, 1), (1, 2)]
    assert certificate["eliminant_degree"] == 24


def test_where_a_curve_is_shared_the_known_factors_are_not_claimed() -> None:
    certificate = slice_of(family("congruent"), "5").solve().certificate
    assert {f["origin"] for f in certificate["factors"]} <= {"cusps"}
    assert method(slice_of(family("congruent"), "5").solve()) == "exact"
