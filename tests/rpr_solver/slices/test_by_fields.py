"""Poses over number fields, against poses that are known in closed form and the article's equations."""

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from math import isqrt

import mpmath as mp
import pytest
from flint import arb, ctx, fmpz_poly

from rpr_solver import EXAMPLES, Manipulator, PoseKind, SolverError
from rpr_solver.exact.biform import BiForm, T, U
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.classify import cos_sin
from rpr_solver.model.exact_pose import ExactPose
from rpr_solver.model.jets import Pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.by_fields import poses_above
from rpr_solver.slices.shared_curves import Curve, SliceForms
from tests.support.article import coalescence, pose, singularity
from tests.support.families import family
from tests.support.shared import eliminant_of

BITS = 200
[ORIGIN] = exact_roots(norm_factors(QuadraticPoly.rational([0, 1])))
RATIONALS = Field.rationals()
SWALLOWTAIL = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
"""One swallowtail at L1 = 1, at θ = 180°."""


def forms_of(m: Manipulator, length: Fraction | int, leg: int = 1) -> SliceForms:
    slice_map = SliceMap.of(m, leg)
    return SliceForms.of(slice_map, length * slice_map.scale)


def roots_of(m: Manipulator, length: Fraction | int) -> list[ExactRoot]:
    eliminant = eliminant_of(m)
    return list(exact_roots(norm_factors(eliminant.at(length * eliminant.slice_map.scale))))


def ball(x: arb | Fraction) -> arb:
    return ball_of(x) if isinstance(x, Fraction) else x


def degrees(poses: Iterable[ExactPose]) -> list[tuple[PoseKind, int, int]]:
    """Kind, α and θ, of poses at whole degrees."""
    result = []
    for x in poses:
        a, t = (ball.unique_fmpz() for ball in x.coordinates(BITS)[:2])
        assert a is not None
        assert t is not None
        result.append((x.kind, int(a), int(t)))
    return sorted(result)


# a flat manipulator: four quadruple poses with all on one line


FLAT = family("both flat")
LENGTH = 3


def flat_poses(unit: Fraction = Fraction(1)) -> list[ExactPose]:
    """All lengths times a unit."""
    m = Manipulator(*(getattr(FLAT, name) * unit for name in ("a2x", "a3x", "a3y", "d1", "d2", "d3")))
    forms = forms_of(m, LENGTH * unit)
    return [x for root in (ORIGIN, None) for x in poses_above(forms, root)]


def test_both_half_turns_are_found() -> None:
    quadruple = PoseKind.QUADRUPLE
    assert degrees(flat_poses()) == [(quadruple, a, t) for a in (0, 180) for t in (0, 180)]


@pytest.mark.parametrize("unit", [Fraction(1), Fraction(2, 7)])
def test_rational_lengths_are_exact(unit: Fraction) -> None:
    """On a line a leg is the distance of two numbers."""
    for x in flat_poses(unit):
        [(_, alpha, theta)] = degrees([x])
        b1 = LENGTH if theta == 0 else -LENGTH
        side = 1 if alpha == 0 else -1
        expected = abs(b1 + 7 * side - 20) * unit, abs(b1 + 16 * side - 6) * unit
        assert tuple(x.coordinates(BITS)[2:]) == expected


def test_a_closed_leg_has_the_length_zero() -> None:
    """L1 = 13, B1B2 = 7 and A1A2 = 20: at α = θ = 0 the second leg closes."""
    poses = list(poses_above(forms_of(FLAT, 13), ORIGIN))
    closed = [x for x in poses if x.local.squared_lengths()[0].is_zero]
    assert [x.coordinates(BITS)[2] for x in closed] == [0]


# a swallowtail, and cusps beside it


@cache
def poses_of_the_swallowtail() -> list[ExactPose]:
    """The swallowtail lies at θ = 180°, where u has no value."""
    forms = forms_of(SWALLOWTAIL, 1)
    return [x for root in (*roots_of(SWALLOWTAIL, 1), None) for x in poses_above(forms, root)]


def test_a_slice_with_a_swallowtail() -> None:
    """Every pose with J = E = 0; the article's conditions hold there, though at θ = 180° they say 0 = 0."""
    poses = poses_of_the_swallowtail()
    assert sorted(x.kind for x in poses) == [PoseKind.CUSP] * 4 + [PoseKind.SWALLOWTAIL]
    assert [bool(x.coordinates(BITS)[1] == 180) for x in poses] == [False] * 4 + [True]
    with mp.workdps(38), ctx.workprec(BITS):
        for x in poses:
            balls = tuple(map(ball, x.coordinates(BITS)))
            alpha, theta, *free = (b.str(40, radius=False) for b in balls)
            at = pose(SWALLOWTAIL, "1", alpha, theta)
            assert abs(singularity(SWALLOWTAIL, at)) < mp.mpf(10) ** -30
            if x.kind is PoseKind.CUSP:
                assert abs(coalescence(SWALLOWTAIL, at)) < mp.mpf(10) ** -30
            for own, text in zip(at.lengths[1:], free, strict=True):
                assert abs(own - mp.mpf(text)) < mp.mpf(10) ** -30


def test_irrational_lengths_are_not_called_rational() -> None:
    for x in poses_of_the_swallowtail():
        for length, square in zip(x.coordinates(BITS)[2:], x.local.squared_lengths(), strict=True):
            value = square.rational
            assert isinstance(length, arb) == (value is None or not is_square(value))


def is_square(x: Fraction) -> bool:
    return all(isqrt(n) ** 2 == n for n in (x.numerator, x.denominator))


# what is left out


def test_ordinary_poses_are_left_out() -> None:
    """θ = 0 puts leg 1 along A1A2: ∇f = 0 at a pose there, so J = E = 0, and it is no more than that."""
    assert list(poses_above(forms_of(EXAMPLES["zein-flat"], 10), ORIGIN)) == []
    assert list(poses_above(forms_of(EXAMPLES["zein-flat"], 10), None)) == []


def test_poses_on_a_shared_curve_are_left_out() -> None:
    """α = 0, then α = 180°, and then θ = 0, on which both poses lie, of a flat manipulator."""
    forms = forms_of(FLAT, LENGTH)
    quadruple = PoseKind.QUADRUPLE
    assert degrees(poses_above(replace(forms, shared=(Curve(T),)), ORIGIN)) == [(quadruple, 180, 0)]
    assert degrees(poses_above(replace(forms, shared=(Curve(None),)), ORIGIN)) == [(quadruple, 0, 0)]
    assert degrees(poses_above(replace(forms, shared=(Curve(U),)), ORIGIN)) == []


def test_a_line_of_poses_is_refused() -> None:
    forms = forms_of(EXAMPLES["zein-flat"], 10)
    u = BiForm.of(U, forms.slice_map.radicand, 0, 1)
    on_a_line = replace(forms, singular=forms.singular * u, coalescence=forms.coalescence * u)
    with pytest.raises(SolverError, match="line theta = const"):
        list(poses_above(on_a_line, ORIGIN))


# the parts


@pytest.mark.parametrize("leg", [1, 2, 3])
@pytest.mark.parametrize("t", [Fraction(1, 2), None])
def test_jets_at_a_rational_pose(leg: int, t: Fraction | None) -> None:
    """f and g by the corners of the platform, with ω = 1 as in every rational manipulator."""
    slice_map = SliceMap.of(family("similar"), leg)
    u, length = Fraction(-2, 3), Fraction(7)
    cos_a, sin_a = (Fraction(-1), Fraction(0)) if t is None else (Fraction(3, 5), Fraction(4, 5))
    x, y = length * Fraction(5, 13), length * Fraction(-12, 13)
    angles = (cos_sin(None if half is None else RATIONALS(half), RATIONALS) for half in (t, u))
    at = Pose(*(x for pair in angles for x in pair), RATIONALS(length), RATIONALS(1))
    local = ExactPose.of(slice_map, at).local
    for leg_map, square in zip((slice_map.f, slice_map.g), local.squared_lengths(), strict=True):
        along = x + cos_a * leg_map.m - sin_a * leg_map.n - leg_map.ax
        across = y + sin_a * leg_map.m + cos_a * leg_map.n - leg_map.ay
        assert square.rational == along**2 + across**2
    assert local.f.order == local.g.order == 4


def test_coordinates_hold_irrational_numbers() -> None:
    """A pose at tan(α/2) = √2 and tan(θ/2) = −√2, with L = √2."""
    [_, root] = exact_roots(norm_factors(QuadraticPoly(fmpz_poly([-2, 0, 1]), fmpz_poly([0]), 1)))
    u, one = root.in_field()
    slice_map = SliceMap.of(family("similar"))
    x = ExactPose.of(slice_map, Pose(*cos_sin(u, u.field), *cos_sin(-u, u.field), u, one))
    with ctx.workprec(BITS):
        angle = 2 * arb(2).sqrt().atan() * 180 / arb.pi()
        squares = [square.ball(BITS) for square in x.local.squared_lengths()]
        lengths = [square.sqrt() / slice_map.scale_ball() for square in squares]
        own = map(ball, x.coordinates(BITS))
        for got, expected in zip(own, (angle, -angle, *lengths), strict=True):
            assert got.overlaps(expected)
            assert got.rel_accuracy_bits() > BITS - 40
