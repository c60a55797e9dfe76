"""Curves of degenerate poses that J and E share, and the special poses on them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import gcd, prod

import pytest
from flint import fmpz, fmpz_mat, fmpz_mpoly, fmpz_poly
from hypothesis import given

from rpr_solver import EXAMPLES, Manipulator, SolverError, solve_slice
from rpr_solver.exact.biform import OMEGA, BiForm, Rows, T, U
from rpr_solver.exact.modular import sylvester
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.model.jets import Pose
from rpr_solver.model.joint_points import cos_sin
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.reference import SliceForms, without_shared_curves
from tests.support.families import CONGRUENT_FLAT
from tests.support.shared import eliminant_of
from tests.support.strategies import examples, lengths

RATIONALS = Field.rationals()
LENGTH = Fraction(5)


def with_factors(
    *factors: fmpz_mpoly,
    only_j: fmpz_mpoly = T**0,
    infinite: tuple[int, int] = (0, 0),
    name: str = "zein-flat",
) -> SliceMap:
    """A slice map whose J and E are multiplied by polynomials in t and u, and have more zeros at t = ∞."""
    slice_map = replace(SliceMap.of(EXAMPLES[name]))  # a copy, which is changed
    extras = ((*factors, only_j), factors)
    for which, extra, zeros in zip(("singular", "coalescence"), extras, infinite, strict=True):
        form = getattr(slice_map, which)
        product = prod(extra, start=form.joined)
        (t, u, *_), (old_t, old_u, *_) = product.degrees(), form.joined.degrees()
        degrees = form.degree_t + t - old_t + zeros, form.degree_u + u - old_u
        vars(slice_map)[which] = BiForm.of(product, slice_map.radicand, *degrees)
    return slice_map


def sliced_without(slice_map: SliceMap, length: Fraction) -> tuple[SliceForms, QuadraticPoly]:
    return without_shared_curves(SliceForms.of(slice_map, length))


def formal_resultant(forms: SliceForms, u: int) -> int:
    """Res_t at one u, for a rational height."""
    j, e = ([row.a(fmpz(u)) for row in rows] for rows in (forms.singular.rows, forms.coalescence.rows))
    return int(fmpz_mat(sylvester(j, e, fmpz(0))).det())


def primitive(rows: Rows) -> list[QuadraticPoly]:
    """A form up to a rational factor."""
    content = gcd(*(int(c) for row in rows for part in (row.a, row.b) for c in part.coeffs()))
    lead = next(c for row in reversed(rows) for part in (row.a, row.b) for c in reversed(part.coeffs()))
    return [row / fmpz_poly([content if lead > 0 else -content]) for row in rows]


def assert_plain(forms: SliceForms, q: QuadraticPoly) -> None:
    """What is left when the factors are gone."""
    plain, expected = sliced_without(SliceMap.of(EXAMPLES["zein-flat"]), LENGTH)
    assert primitive(forms.singular.rows) == primitive(plain.singular.rows)
    assert primitive(forms.coalescence.rows) == primitive(plain.coalescence.rows)
    assert q in (expected, expected * -1)


# a slice without such curves


@given(lengths(40, (1, 2)))
@examples(8)
def test_where_nothing_is_shared_the_eliminant_has_all_its_factors(length: Fraction) -> None:
    """The whole resultant: w² (u²+1)⁹ q Q, and the forms as they are."""
    for m in (EXAMPLES["zein-flat"], Manipulator(*map(Fraction, (7, 3, 5, 4, 5, 6)))):
        eliminant = eliminant_of(m)
        slice_map, scaled = eliminant.slice_map, length * eliminant.slice_map.scale
        forms, whole = sliced_without(slice_map, scaled)
        assert forms == SliceForms.of(slice_map, scaled)
        known = slice_map.f.collinear.a**2 * fmpz_poly([1, 0, 1]) ** 9 * slice_map.f.closed(scaled).a
        expected = (eliminant.at(scaled) * (known / known.content())).primitive()
        assert whole in (expected, expected * -1)


# curves that are put in


@pytest.mark.parametrize(
    ("factor", "equation"),
    [
        (T, "alpha = 0 deg"),
        (-T, "alpha = 0 deg"),
        (T * U - 3, "t*u - 3 = 0 with t = tan(alpha/2), u = tan(theta1/2)"),
    ],
)
def test_a_shared_curve_is_divided_out(factor: fmpz_mpoly, equation: str) -> None:
    forms, q = sliced_without(with_factors(factor), LENGTH)
    assert [curve.equation(forms.slice_map) for curve in forms.shared] == [equation]
    assert_plain(forms, q)


def test_several_curves_and_powers_are_divided_out_and_each_is_said_once() -> None:
    """t² in J and in E, and two other curves; what is imaginary is divided out and no curve of poses."""
    forms, q = sliced_without(with_factors(T, T, U - 2, T * U + 1, T**2 + 1, U**2 + 1), LENGTH)
    assert sorted(str(curve.polynomial) for curve in forms.shared) == ["t", "t*u + 1", "u - 2"]
    assert_plain(forms, q)


@pytest.mark.parametrize("infinite", [(1, 1), (2, 2), (3, 1)])
def test_a_half_turn_of_the_platform_is_a_curve_too(infinite: tuple[int, int]) -> None:
    """J loses every power of it, as of other curves."""
    forms, q = sliced_without(with_factors(infinite=infinite), LENGTH)
    assert [curve.equation(forms.slice_map) for curve in forms.shared] == ["alpha = 180 deg"]
    assert_plain(forms, q)


@pytest.mark.parametrize("infinite", [(1, 0), (0, 1), (0, 2)])
def test_zeros_at_infinity_of_one_form_alone_count(infinite: tuple[int, int]) -> None:
    """The eliminant keeps the formal degrees in t."""
    forms, q = sliced_without(with_factors(infinite=infinite), LENGTH)
    assert forms.shared == ()
    values = [(formal_resultant(forms, u), int(q.a(fmpz(u)))) for u in (2, 3, -5, 7)]
    ratio = Fraction(values[0][0], values[0][1])
    assert [Fraction(x) for x, _ in values] == [ratio * y for _, y in values]
    assert ratio != 0


def test_a_curve_that_is_not_rational_is_refused() -> None:
    slice_map = with_factors(T * U - OMEGA, name="innocenti")
    with pytest.raises(SolverError, match="not rational"):
        sliced_without(slice_map, LENGTH)


# congruent triangles


@pytest.mark.parametrize(("sign", "equation"), [(1, "alpha = 0 deg"), (-1, "alpha = 180 deg")])
@pytest.mark.parametrize("leg", [1, 2, 3])
def test_congruent_triangles_move_in_parallel(sign: int, equation: str, leg: int) -> None:
    """Turned by half a turn, the platform is parallel to the base at α = 180°."""
    m = Manipulator(*map(Fraction, (30 * sign, 0, 40 * sign, 30, 50, 40)))
    slice_map = SliceMap.of(m, leg)
    assert SliceForms.of(slice_map, LENGTH).shared == ()
    forms, q = sliced_without(slice_map, LENGTH * slice_map.scale)
    assert [curve.equation(slice_map) for curve in forms.shared] == [equation]
    assert not q.is_zero
    assert forms.singular.degree_t < 4


# which poses lie on a curve


def at(t: Fraction | None, u: Fraction | None) -> Pose[Algebraic]:
    """The pose with these half tangents; None is 180°."""
    (cos_a, sin_a), (cos_t, sin_t) = (
        cos_sin(None if x is None else RATIONALS(x), RATIONALS, 1) for x in (t, u)
    )
    return Pose(cos_a, sin_a, cos_t, sin_t, RATIONALS(1), RATIONALS(1))


@pytest.mark.parametrize("fixed_leg", [1, 2, 3])
@pytest.mark.parametrize("length", [Fraction(5), Fraction(213, 10)])
def test_both_legs_are_stationary_at_two_poses_of_a_flat_curve(fixed_leg: int, length: Fraction) -> None:
    """All legs along the base, and of one length: translations along the base change nothing."""
    table = solve_slice(eliminant_of(CONGRUENT_FLAT, fixed_leg), length, 15)
    angle = f"theta{fixed_leg}_deg"
    on_curve = {
        point[angle]: point["kind"]
        for point in table.degenerate_points
        if point.get("alpha_deg") == "180.000000000000"
    }
    assert on_curve == {"0": "higher", "180.000000000000": "higher"}
    assert table.degenerate_points[0]["equation"] == "alpha = 180 deg"
