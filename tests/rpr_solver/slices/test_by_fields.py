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
from rpr_solver.exact.biform import T, U
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.by_fields import (
    ExactPose,
    local_map,
    poses_above,
    poses_at_half_turn,
)
from rpr_solver.slices.shared_curves import Curve, SliceForms
from tests.support.article import coalescence, pose, singularity
from tests.support.families import family
from tests.support.shared import eliminant_of

BITS = 200
RATIONALS = Field.rationals()
SWALLOWTAIL = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
"""One swallowtail at L1 = 1, at θ = 180°."""


def forms_of(m: Manipulator, length: Fraction | int, leg: int = 1) -> SliceForms:
    slice_map = SliceMap.of(m, leg)
    return SliceForms.of(slice_map, length * slice_map.scale)


def roots_of(m: Manipulator, length: Fraction | int) -> list[ExactRoot]:
    eliminant = eliminant_of(m)
    return list(exact_roots(norm_factors(eliminant.at(length * eliminant.slice_map.scale))))


def degrees(poses: Iterable[ExactPose]) -> list[tuple[PoseKind, int, int]]:
    """Kind, α and θ, of poses at whole degrees."""
    result = []
    for x in poses:
        alpha, theta, *_ = x.coordinates(BITS)
        a, t = (ball.unique_fmpz() for ball in (alpha, theta))
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
    plane, turned = (forms_of(m, length * unit) for length in (LENGTH, -LENGTH))
    return [*poses_above(plane, ExactRoot.origin(1)), *poses_at_half_turn(turned)]


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
        assert x.exact_lengths() == expected
        for ball, length in zip(x.coordinates(BITS)[2:], expected, strict=True):
            with ctx.workprec(BITS):
                assert (ball - ball_of(length)).contains(0)


def test_a_closed_leg_has_the_length_zero() -> None:
    """L1 = 13, B1B2 = 7 and A1A2 = 20: at α = θ = 0 the second leg closes."""
    closed = [x for x in poses_above(forms_of(FLAT, 13), ExactRoot.origin(1)) if x.f.is_zero]
    assert [x.exact_lengths()[0] for x in closed] == [0]
    assert all(x.coordinates(BITS)[2].is_zero() for x in closed)


# a swallowtail, and cusps beside it


@cache
def poses_of_the_swallowtail() -> list[ExactPose]:
    """The swallowtail lies at θ = 180°, where u has no value."""
    plane, turned = (forms_of(SWALLOWTAIL, length) for length in (1, -1))
    return [
        *(x for root in roots_of(SWALLOWTAIL, 1) for x in poses_above(plane, root)),
        *poses_at_half_turn(turned),
    ]


def test_a_slice_with_a_swallowtail() -> None:
    """Every pose with J = E = 0; the article's conditions hold there, though at θ = 180° they say 0 = 0."""
    poses = poses_of_the_swallowtail()
    assert sorted(x.kind for x in poses) == [PoseKind.CUSP] * 4 + [PoseKind.SWALLOWTAIL]
    assert [x.theta_offset for x in poses] == [0] * 4 + [180]
    with mp.workdps(38), ctx.workprec(BITS):
        for x in poses:
            alpha, theta, *free = (ball.str(40, radius=False) for ball in x.coordinates(BITS))
            at = pose(SWALLOWTAIL, "1", alpha, theta)
            assert abs(singularity(SWALLOWTAIL, at)) < mp.mpf(10) ** -30
            if x.kind is PoseKind.CUSP:
                assert abs(coalescence(SWALLOWTAIL, at)) < mp.mpf(10) ** -30
            for own, text in zip(at.lengths[1:], free, strict=True):
                assert abs(own - mp.mpf(text)) < mp.mpf(10) ** -30


def test_irrational_lengths_are_not_called_rational() -> None:
    for x in poses_of_the_swallowtail():
        for length, square in zip(x.exact_lengths(), (x.f, x.g), strict=True):
            value = square.rational
            assert (length is None) == (value is None or not is_square(value))


def is_square(x: Fraction) -> bool:
    return all(isqrt(n) ** 2 == n for n in (x.numerator, x.denominator))


def test_the_turned_slice_shows_the_same_pose() -> None:
    """−L with θ + 180° is L with θ: a root u of Q becomes −1/u."""
    x = poses_of_the_swallowtail()[0]
    minimal = roots_of(SWALLOWTAIL, 1)[0].root.polynomial.a.coeffs()
    flipped = QuadraticPoly.rational([(-1) ** k * c for k, c in enumerate(reversed(minimal))])
    turned = forms_of(SWALLOWTAIL, -1)
    u = x.u.ball(BITS)
    with ctx.workprec(BITS):
        [root] = (r for r in exact_roots(norm_factors(flipped)) if (r.root.refined(BITS) * u).contains(-1))
    [y] = poses_above(turned, root)
    assert (y.kind, y.theta_offset) == (x.kind, 180)
    with ctx.workprec(BITS):
        alpha, theta, *lengths = (
            a - b for a, b in zip(x.coordinates(BITS), y.coordinates(BITS), strict=True)
        )
        assert theta.contains(0) or theta.contains(-360)
        assert all(gap.contains(0) for gap in (alpha, *lengths))


# what is left out


def test_ordinary_poses_are_left_out() -> None:
    """θ = 0 puts leg 1 along A1A2: ∇f = 0 at a pose there, so J = E = 0, and it is no more than that."""
    assert list(poses_above(forms_of(EXAMPLES["zein-flat"], 10), ExactRoot.origin(1))) == []
    assert list(poses_at_half_turn(forms_of(EXAMPLES["zein-flat"], -10))) == []


def test_poses_on_a_shared_curve_are_left_out() -> None:
    """α = 0, and then α = 180°, of a flat manipulator."""
    forms = forms_of(FLAT, LENGTH)
    origin = ExactRoot.origin(1)
    quadruple = PoseKind.QUADRUPLE
    assert degrees(poses_above(replace(forms, shared=(Curve(T),)), origin)) == [(quadruple, 180, 0)]
    assert degrees(poses_above(replace(forms, shared=(Curve(None),)), origin)) == [(quadruple, 0, 0)]
    assert degrees(poses_above(replace(forms, shared=(Curve(U),)), origin)) == [(quadruple, 180, 0)]


def test_a_line_of_poses_is_refused() -> None:
    forms = forms_of(EXAMPLES["zein-flat"], 10)
    u = QuadraticPoly.rational([0, 1], forms.slice_map.radicand)
    on_a_line = replace(
        forms,
        singular=tuple(row * u for row in forms.singular),
        coalescence=tuple(row * u for row in forms.coalescence),
    )
    with pytest.raises(SolverError, match="line theta = const"):
        list(poses_above(on_a_line, ExactRoot.origin(1)))


# the parts


@pytest.mark.parametrize("leg", [1, 2, 3])
@pytest.mark.parametrize("t", [Fraction(1, 2), None])
def test_jets_at_a_rational_pose(leg: int, t: Fraction | None) -> None:
    """f and g by the corners of the platform, with ω = 1 as in every rational manipulator."""
    slice_map = SliceMap.of(family("similar"), leg)
    u, length = Fraction(-2, 3), Fraction(7)
    cos_a, sin_a = (Fraction(-1), Fraction(0)) if t is None else (Fraction(3, 5), Fraction(4, 5))
    x, y = length * Fraction(5, 13), length * Fraction(-12, 13)
    local = local_map(slice_map, length, None if t is None else RATIONALS(t), RATIONALS(u), RATIONALS(1))
    for leg_map, square in zip((slice_map.f, slice_map.g), local.squared_lengths(), strict=True):
        along = x + cos_a * leg_map.m - sin_a * leg_map.n - leg_map.ax
        across = y + sin_a * leg_map.m + cos_a * leg_map.n - leg_map.ay
        assert square.rational == along**2 + across**2
    assert local.f.order == local.g.order == 4


def test_coordinates_hold_irrational_numbers() -> None:
    """A pose at tan(α/2) = √2 and tan(θ/2) = −√2 with f = 2 and g = 8, in scaled units."""
    [_, root] = exact_roots(norm_factors(QuadraticPoly(fmpz_poly([-2, 0, 1]), fmpz_poly([0]), 1)))
    u, _ = root.in_field()
    slice_map = SliceMap.of(EXAMPLES["innocenti"])
    x = ExactPose(PoseKind.CUSP, u, -u, 180, u * u, u * u * 4, slice_map)
    with ctx.workprec(BITS):
        angle = 2 * arb(2).sqrt().atan() * 180 / arb.pi()
        lengths = [arb(n).sqrt() / slice_map.scale_ball() for n in (2, 8)]
        for ball, expected in zip(x.coordinates(BITS), (angle, 180 - angle, *lengths), strict=True):
            assert ball.overlaps(expected)
            assert ball.rel_accuracy_bits() > BITS - 40
    assert x.exact_lengths() == (None, None)
