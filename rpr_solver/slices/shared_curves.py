"""Curves on which both J and E vanish in a slice, as for congruent triangles, and the special poses on them.

A whole curve of poses is then degenerate, and the eliminant vanishes identically. J and E are divided by the
curves, on which there are no cusps (mathematics.md#shared-curves); the quotients have an eliminant. All poses
of such a curve are degenerate, and most of them are alike. Named beside the curve are those where other parts
of the singular curve cross it, or both legs are stationary."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from math import gcd

from flint import fmpz_mpoly

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import (
    RING,
    BiForm,
    T,
    U,
    divides,
    leading_coefficient,
    rational_form,
    value,
    without_common_factors,
)
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.number_field import Algebraic
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.model.classify import tan_half
from rpr_solver.model.exact_pose import ExactPose, common_poses
from rpr_solver.model.jets import Pose
from rpr_solver.model.slice_map import SliceMap, half_angles, slopes


@dataclass(frozen=True)
class Curve:
    """A curve of degenerate poses: a polynomial in t = tan(α/2) and u = tan(θ/2); None is α = 180°.

    A curve that moves from slice to slice has a polynomial with L too.
    """

    polynomial: fmpz_mpoly | None

    @property
    def form(self) -> BiForm:
        """The curve of one slice as a form."""
        if self.polynomial is None:
            return rational_form(T**0, 1, 0)
        degree_t, degree_u, *_ = self.polynomial.degrees()
        return rational_form(self.polynomial, degree_t, degree_u)

    def holds(self, pose: Pose[Algebraic]) -> bool:
        """Whether a pose lies on the curve."""
        t, u = tan_half(pose.cos_alpha, pose.sin_alpha), tan_half(pose.cos_theta, pose.sin_theta)
        return value(self.form, t, u, pose.omega).is_zero

    def equation(self, fixed_leg: int) -> str:
        """The equation of the curve in angles or half tangents, as documents print it."""
        if self.polynomial is None:
            return "alpha = 180 deg"
        if self.polynomial in (T, -T):
            return "alpha = 0 deg"
        polynomial = str(self.polynomial).replace("L", f"L{fixed_leg}")
        return f"{polynomial} = 0 with t = tan(alpha/2), u = tan(theta{fixed_leg}/2)"

    def in_unit(self, scale: Fraction) -> Curve:
        """The curve with L in the user's unit, of which ``scale`` makes the *scaled* one."""
        if self.polynomial is None:
            return self
        top = self.polynomial.degrees()[2]
        n, d = scale.numerator, scale.denominator
        terms = {key: c * n ** key[2] * d ** (top - key[2]) for key, c in self.polynomial.to_dict().items()}
        content = gcd(*(int(c) for c in terms.values()))
        return Curve(RING.from_dict({key: c / content for key, c in terms.items()}))


@dataclass(frozen=True)
class SliceForms:
    """J and E of one slice, without the curves they share."""

    slice_map: SliceMap
    length: Fraction
    singular: BiForm
    coalescence: BiForm
    shared: tuple[Curve, ...] = ()

    @classmethod
    def of(cls, slice_map: SliceMap, length: Fraction) -> SliceForms:
        """The slice of one *scaled* length, with nothing divided out."""
        return cls(slice_map, length, slice_map.singular.sliced(length), slice_map.coalescence.sliced(length))


def without_shared_curves(forms: SliceForms) -> tuple[SliceForms, QuadraticPoly]:
    """Divides J and E by the curves they share in a slice; also their new eliminant.

    Raises:
        SolverError: J and E share a curve that is not rational.
    """
    j, e, shared = divided(forms.singular, forms.coalescence)
    [q] = BiForm.of(formal_resultant(j, e), j.radicand, 0, 0).primitive().rows
    if q.is_zero:
        raise SolverError("J and E share a curve of poses that is not rational; this slice is not supported")
    return replace(forms, singular=j, coalescence=e, shared=tuple(shared)), q


def divided(j: BiForm, e: BiForm) -> tuple[BiForm, BiForm, list[Curve]]:
    """J and E, of one slice or of all, divided by the rational curves that they share; also these curves."""
    shared: list[Curve] = []
    if (drop := min(j.zeros_at_infinity, e.zeros_at_infinity)) > 0:
        shared.append(Curve(None))
        j = replace(j, degree_t=j.degree_t - j.zeros_at_infinity)
        e = replace(e, degree_t=e.degree_t - drop)
    j, e, common = without_common_factors(j, e)
    shared += (curve for factor in common for curve in _real_curves(factor))
    return j, e, shared


def formal_resultant(j: BiForm, e: BiForm) -> fmpz_mpoly:
    """Res_t for the formal degrees in t, up to a constant.

    Where only one form loses degree in t, its zeros at t = ∞ multiply the other's leading term.
    """
    resultant = j.joined.resultant(e.joined, "t")
    resultant *= leading_coefficient(e.joined, 0) ** j.zeros_at_infinity
    resultant *= leading_coefficient(j.joined, 0) ** e.zeros_at_infinity
    return resultant


def _real_curves(common: fmpz_mpoly) -> list[Curve]:
    """The irreducible curves of a common factor, without t² + 1 and u² + 1, which have no real points."""
    imaginary = (T**2 + 1, U**2 + 1)
    return [Curve(factor) for factor, _ in common.factor()[1] if factor not in imaginary]


def special_poses(forms: SliceForms) -> list[ExactPose]:
    """The poses with ∇J = 0 on simple curves that were divided out of a slice, and those with ∇f = ∇g = 0."""
    poses: list[ExactPose] = []
    for curve in forms.shared:
        own, rest = curve.form, forms.slice_map.singular.sliced(forms.length)
        simple = not divides(own * own, rest) if not own.a.is_one() else rest.zeros_at_infinity == 1
        for other in _others(forms, curve):
            for pose in () if divides(own, other) else _common(own, other, forms):
                if _stands_out(pose, simple) and not any(pose.is_at(x) for x in poses):
                    poses.append(pose)
    return poses


def _stands_out(pose: ExactPose, simple: bool) -> bool:
    local = pose.local
    j = local.singularity()
    legs = (leg for moving in (local.f, local.g) for leg in (moving.alpha, moving.theta))
    slopes = (j.alpha, j.theta) if simple else legs
    return all(slope.value.is_zero for slope in slopes)


def _others(forms: SliceForms, curve: Curve) -> Iterator[BiForm]:
    """Forms of which one vanishes where ∇J = 0 on the curve: other factors of J, gradients of the legs."""
    yield forms.singular
    yield from (other.form for other in forms.shared if other is not curve)
    for leg in (forms.slice_map.f, forms.slice_map.g):
        for slope in slopes(leg):
            yield half_angles(slope, (1, 1), leg.radicand).sliced(forms.length)


def _common(first: BiForm, second: BiForm, forms: SliceForms) -> Iterator[ExactPose]:
    eliminant = resultant(first, second)
    roots: list[ExactRoot | None] = list(exact_roots(norm_factors(eliminant.polynomial)))
    if eliminant.zeros_at_infinity:
        roots.append(None)
    for root in roots:
        for pose in common_poses(first, second, root, forms.length) or ():
            yield ExactPose.of(forms.slice_map, pose)
