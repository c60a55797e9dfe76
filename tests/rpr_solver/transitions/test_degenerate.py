"""Degeneracies on whole intervals: reported for every family and every fixed leg, and only there."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, product

import pytest
from flint import fmpz_mat, fmpz_mpoly
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    Degeneracy,
    Eliminant,
    LengthRange,
    Manipulator,
    PoseKind,
    Requirement,
    census,
    check,
    cusp_curves,
    restrict_census,
    solve_slice,
)
from rpr_solver.exact.biform import BiForm, L, T, U
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.eliminant import Coefficients
from rpr_solver.transitions.degeneracies import _curves, _has_no_curves
from tests.support.families import FAMILIES, family
from tests.support.sampling import long
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

ENDS = st.one_of(st.none(), st.integers(1, 12))


@given(st.integers(0, 10), ENDS, st.integers(0, 10), ENDS)
@examples(60)
def test_a_part_is_the_intersection(low: int, high: int | None, start: int, stop: int | None) -> None:
    if (high is not None and high <= low) or (stop is not None and stop <= start):
        return
    whole = Degeneracy(1, PoseKind.CURVE, str(low), None if high is None else str(high))
    part = whole.within(LengthRange(Fraction(start), None if stop is None else Fraction(stop)))
    inside = [
        x
        for x in (Fraction(2 * n + 1, 2) for n in range(14))
        if low < x and start < x and (high is None or x < high) and (stop is None or x < stop)
    ]
    assert (part is not None) == bool(inside)
    if part is not None:
        assert Fraction(part.start) == max(low, start)
        assert (part.stop and int(part.stop)) == min((x for x in (high, stop) if x), default=None)


def test_a_single_length_is_inside_or_not() -> None:
    at_five = Degeneracy(1, PoseKind.CURVE, "5", "5", equation="alpha = 0 deg")
    assert at_five.within(LengthRange(Fraction(4), Fraction(6))) == at_five
    assert at_five.within(LengthRange(Fraction(6), None)) is None
    assert Degeneracy.from_json(at_five.to_json(), 1) == at_five


DEGENERATE = ("both flat", "similar", "congruent", "congruent, mirrored")
"""The families that are degenerate in all slices of an interval, whichever leg is fixed."""
CONGRUENT = family("congruent")
CURVE = {"kind": "curve", "from": "0", "to": None, "equation": "alpha = 0 deg"}


def said(parts: tuple[Degeneracy, ...], length: Fraction) -> Counter[str]:
    """The numbers of degenerate points that a slice should have, by kind or equation."""
    found: Counter[str] = Counter()
    for part in parts:
        if Fraction(part.start) < length and (part.stop is None or length < Fraction(part.stop)):
            found[part.equation or part.kind] += part.count or 1
    return found


def listed(m: Manipulator, fixed_leg: int, length: Fraction) -> Counter[str]:
    table = solve_slice(eliminant_of(m, fixed_leg), length, 15)
    return Counter(point.get("equation", point["kind"]) for point in table.degenerate_points)


EACH_TIME = {("both flat", 2), *product(("similar", "congruent"), (1, 2, 3))}


@pytest.mark.parametrize(
    ("name", "fixed_leg"),
    [case if case in EACH_TIME else long(*case) for case in product(FAMILIES, (1, 2, 3))],
)
def test_the_slices_of_every_family_have_what_is_said(name: str, fixed_leg: int) -> None:
    m = family(name)
    table = census(m, fixed_leg=fixed_leg, digits=15)
    parts = table.degenerate
    assert bool(parts) == (name in DEGENERATE)
    ends = sorted({Fraction(0), *(Fraction(x) for p in parts for x in (p.start, p.stop) if x is not None)})
    for length in [*((a + b) / 2 for a, b in pairwise(ends)), ends[-1] + Fraction(17, 13), Fraction(61, 3)]:
        assert listed(m, fixed_leg, length) == said(parts, length)


@pytest.mark.parametrize("fixed_leg", [1, 2, 3])
@pytest.mark.parametrize(("sign", "angle"), [(1, 0), (-1, 180)])
def test_congruent_triangles_have_a_curve_in_every_slice(sign: int, angle: int, fixed_leg: int) -> None:
    m = Manipulator.from_json({**CONGRUENT.to_json(), "a2x": 30 * sign, "a3y": 40 * sign})
    curve, nodes = census(m, fixed_leg=fixed_leg, digits=15).degenerate
    assert curve.to_json() == {**CURVE, "equation": f"alpha = {angle} deg"}
    assert (nodes.kind, nodes.count, nodes.start) == ("node", 2, "0")


def test_census_check_and_curves_say_the_same() -> None:
    span = LengthRange(Fraction(5), Fraction(20))
    [curve, nodes] = census(CONGRUENT, start=5, stop=20, digits=15).degenerate
    assert repr(curve) == (
        "<Degeneracy curve of degenerate poses in every slice for L1 from 5 to 20: alpha = 0 deg>"
    )
    assert (nodes.start, nodes.stop) == ("5", "20")
    report = check(CONGRUENT, Requirement(start=5, stop=20, max_cusps=0), digits=15)
    curves = cusp_curves(CONGRUENT, digits=15).within(5, 20)
    assert report.degenerate == curves.degenerate == (curve, nodes)
    assert type(curves).from_json(curves.to_json()) == curves
    whole = census(CONGRUENT, digits=30).to_json()
    part = restrict_census(whole, span.start, span.stop, 15)
    assert part is not None
    assert part["degenerate"] == [curve.to_json(), nodes.to_json()]
    for answer in (report, curves, census(CONGRUENT, digits=15)):
        assert "degenerate" in repr(answer)
        assert "alpha = 0 deg" in answer._repr_html_()


def test_a_requirement_can_refuse_it() -> None:
    strict, lax = (
        check(CONGRUENT, Requirement(start=38, max_cusps=4, degenerate=word), digits=15)
        for word in ("refused", "allowed")
    )
    assert (strict.passed, lax.passed) == (False, True)
    assert strict.violations == lax.violations == ()
    assert strict.degenerate == lax.degenerate
    clean = replace(strict, degenerate=())
    assert clean.passed
    assert repr(check(CONGRUENT, Requirement(start=5, max_cusps=0, degenerate="refused"))).endswith(
        "passed of 1, degenerate: refused>"
    )


# curves that no manipulator is known to have: put in


FLAT = eliminant_of(EXAMPLES["zein-flat"])


def altered(singular: fmpz_mpoly, coalescence: fmpz_mpoly, *, root: int | None = None) -> Eliminant:
    """Other J and E, with the eliminant 0, or one that vanishes for the *scaled* length ``root`` alone."""
    own = FLAT.slice_map
    slice_map = SliceMap(own.fixed_leg, own.scale, own.rho, own.radicand, own.f, own.g)
    for name, p in (("singular", singular), ("coalescence", coalescence)):
        vars(slice_map)[name] = BiForm.of(p, 1, *map(int, p.degrees()[:2]))
    vars(slice_map)["tables"] = slice_map.singular.coefficients, slice_map.coalescence.coefficients
    a, none = fmpz_mat(25, 11), fmpz_mat(25, 11)
    if root is not None:
        for i, k in product(range(25), range(10)):
            a[i, k + 1] += FLAT.a[i, k]
            a[i, k] -= FLAT.a[i, k] * root
    return Eliminant(FLAT.manipulator, slice_map, Coefficients(slice_map, (a, none)))


J, E = FLAT.slice_map.singular.joined, FLAT.slice_map.coalescence.joined


def test_a_curve_at_one_length_has_both_ends_there() -> None:
    eliminant = altered((T * U - 2) * T**3 + (L - 60) * J, (T * U - 2) * (U + 3) + (L - 60) * E, root=60)
    assert eliminant.at(Fraction(60)).is_zero
    [curve] = _curves(eliminant, LengthRange(), 15)
    length = Fraction(60) / eliminant.slice_map.scale
    assert curve.start == curve.stop
    assert abs(Fraction(curve.start) - length) <= length / 10**14
    assert curve.equation == "t*u - 2 = 0 with t = tan(alpha/2), u = tan(theta1/2)"
    assert list(_curves(eliminant, LengthRange(length), 15)) == []
    assert list(_curves(eliminant, LengthRange(Fraction(0), length), 15)) == []


def test_a_curve_that_moves_from_slice_to_slice_has_the_length_in_its_equation() -> None:
    """L is scaled in J and E, and in the user's unit in the equation."""
    factor = T * U * L - FLAT.slice_map.scale.numerator
    assert FLAT.slice_map.scale.denominator == 1
    [curve] = _curves(altered(J * factor, E * factor), LengthRange(), 15)
    assert curve.equation == "t*u*L1 - 1 = 0 with t = tan(alpha/2), u = tan(theta1/2)"


def test_beside_a_shared_curve_there_may_be_one_at_a_single_length() -> None:
    j, e = T * (U - 2) + (L - 60) * (T + 5), T * (U - 2) + (L - 60) * (U * T + 7)
    always, *once = _curves(altered(j * (T - 1), e * (T - 1)), LengthRange(), 15)
    assert (always.start, always.stop) == ("0", None)
    assert str(always.equation).startswith("t - 1 = 0")
    assert {(curve.start, curve.stop) for curve in once} == {("60.0000000000000", "60.0000000000000")}
    assert {str(curve.equation)[:9] for curve in once} == {"u - 2 = 0", "alpha = 0"}


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_a_prime_shows_that_ordinary_manipulators_have_no_curves(leg: int) -> None:
    """For each that has none over every L, two values of u will do."""
    for manipulator in EXAMPLES.values():
        assert _has_no_curves(SliceMap.of(manipulator, leg))
    assert not _has_no_curves(SliceMap.of(CONGRUENT, leg))
