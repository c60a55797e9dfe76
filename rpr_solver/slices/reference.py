"""One slice of one manipulator, by its polynomials alone: the reference; fast/ agrees with it to the byte.

There are two methods. If Q(u) is squarefree and prime to the spurious factors, each real root is one
transversal intersection of J = 0 and E = 0 (mathematics.md#simple-roots), and ball arithmetic decides
everything. Otherwise Q is factored, and each special pose is classified over a number field.

J and E may vanish together on curves, as for congruent triangles. A whole curve of poses is then degenerate,
and the eliminant vanishes identically. J and E are divided by the curves, on which there are no cusps
(mathematics.md#shared-curves); the quotients have an eliminant. All poses of such a curve are degenerate, and
most of them are alike. Named beside the curve are those where other parts of the singular curve cross it, or
both legs are stationary.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property, lru_cache, partial
from itertools import chain
from math import gcd

from flint import arb, arb_mat, ctx, fmpz_mpoly

from rpr_solver.errors import SolverError
from rpr_solver.exact import all_decided, decided
from rpr_solver.exact.biform import (
    RING,
    BiForm,
    T,
    divides,
    imaginary,
    leading_coefficient,
    rational_form,
    value,
    without_common_factors,
)
from rpr_solver.exact.decimals import digit_bits
from rpr_solver.exact.elimination import resultant
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors, roots_of
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.number_field import Algebraic
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, ball_of, real_roots
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent, Pose, common_root
from rpr_solver.model.joint_points import (
    ClassifiedPoint,
    ExactPose,
    PoseKind,
    common_poses,
    point_of_pose,
    tan_half,
)
from rpr_solver.model.slice_map import SliceMap, half_angles, slopes
from rpr_solver.slices.decimals import HalfAngle, PointDecimals
from rpr_solver.slices.eliminant import DEGREE_U, Eliminant
from rpr_solver.slices.slice_table import SliceTable, slice_certificate


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

    def equation(self, slice_map: SliceMap) -> str:
        """The equation of the curve in angles or half tangents, as documents print it."""
        bridge, leg = Bridge.of(slice_map), slice_map.fixed_leg
        alpha, _ = bridge.angles(leg)
        alpha = alpha.removeprefix("(").removesuffix(")") if alpha.startswith("(") else alpha
        if self.polynomial is None:
            return f"{alpha} = 180 deg"
        if self.polynomial in (T, -T):
            return f"{alpha} = 0 deg"
        polynomial = str(self.polynomial).replace("L", f"L{leg}")
        return f"{polynomial} = 0 with {bridge.tangents(leg)}"

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
    j, e, shared = divided(forms.singular, forms.coalescence, forms.slice_map.rho)
    [q] = BiForm.of(formal_resultant(j, e), j.radicand, 0, 0).primitive().rows
    if q.is_zero:
        raise SolverError("J and E share a curve of poses that is not rational; this slice is not supported")
    return replace(forms, singular=j, coalescence=e, shared=tuple(shared)), q


def divided(j: BiForm, e: BiForm, rho: int) -> tuple[BiForm, BiForm, list[Curve]]:
    """J and E, of one slice or of all, divided by the rational curves that they share; also these curves."""
    shared: list[Curve] = []
    if (drop := min(j.zeros_at_infinity, e.zeros_at_infinity)) > 0:
        shared.append(Curve(None))
        j = replace(j, degree_t=j.degree_t - j.zeros_at_infinity)
        e = replace(e, degree_t=e.degree_t - drop)
    j, e, common = without_common_factors(j, e)
    shared += (curve for factor in common for curve in _real_curves(factor, rho))
    return j, e, shared


def formal_resultant(j: BiForm, e: BiForm) -> fmpz_mpoly:
    """Res_t for the formal degrees in t, up to a constant.

    Where only one form loses degree in t, its zeros at t = ∞ multiply the other's leading term.
    """
    resultant = j.joined.resultant(e.joined, "t")
    resultant *= leading_coefficient(e.joined, 0) ** j.zeros_at_infinity
    resultant *= leading_coefficient(j.joined, 0) ** e.zeros_at_infinity
    return resultant


def _real_curves(common: fmpz_mpoly, rho: int) -> list[Curve]:
    """The irreducible curves of a common factor, without 1 + ρt² and 1 + ρu², which have no real points."""
    return [Curve(factor) for factor, _ in common.factor()[1] if not imaginary(factor, rho)]


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
            yield half_angles(slope, (1, 1), leg.rho, leg.radicand).sliced(forms.length)


def _common(first: BiForm, second: BiForm, forms: SliceForms) -> Iterator[ExactPose]:
    for root in roots_of(resultant(first, second)):
        for pose in common_poses(first, second, root, forms.length, forms.slice_map.rho) or ():
            yield ExactPose.of(forms.slice_map, pose)


_POWERS_OF_L = 3
_J, _E = 5, 7
"""The coefficients of J and of E in t, and in u."""
_ABOVE_DIGITS, _SPARE = 192, 128
"""Bits of the first working precision above those of the digits, and of any above those of half tangents."""
_TIMES_BEFORE_EXACT = 32
"""How many times the first precision is tried for a simple root, which enough of it always decides."""


class SlicePoses:
    """The slice of one *scaled* L at one working precision: the pose above a simple root of Q."""

    def __init__(self, slice_map: SliceMap, length: Fraction, bits: int) -> None:
        with ctx.workprec(bits):
            ball = ball_of(length)
            forms = _forms(slice_map, bits) * arb_mat(_POWERS_OF_L, 1, [arb(1), ball, ball * ball])
            self._forms = arb_mat(_J + _E, _E, forms.entries())

    def alpha(self, u: arb) -> HalfTangent | None:
        """tan(α/2) of the unique pose above a simple root u; None if the precision is insufficient."""
        powers = [arb(1)]
        while len(powers) < _E:
            powers.append(powers[-1] * u)
        values = (self._forms * arb_mat(_E, 1, powers)).entries()
        return common_root(values[:_J], values[_J:])


@lru_cache(maxsize=16)
def _forms(slice_map: SliceMap, bits: int) -> arb_mat:
    """J and E: a row of coefficients of three powers of L for each power of t and seven powers of u."""
    rows = []
    for row in chain(*slice_map.tables):
        parts = [c.ball(bits) for c in row]
        zeros = [arb(0)] * (_POWERS_OF_L - len(parts))
        rows += [[*(part[power] for part in parts), *zeros] for power in range(_E)]
    return arb_mat(rows)


def poses_above(forms: SliceForms, root: ExactRoot | None) -> Iterator[ExactPose]:
    """All real poses with J = E = 0 at one root u, classified; ordinary singular poses are left out.

    ``root`` is None for u = ∞, where θ = 180°.

    Raises:
        SolverError: J and E vanish on the whole line θ = const.
    """
    poses = common_poses(forms.singular, forms.coalescence, root, forms.length, forms.slice_map.rho)
    if poses is None:
        raise SolverError("the singular curve holds a whole line theta = const")
    for pose in poses:
        if not any(curve.holds(pose) for curve in forms.shared):
            exact = ExactPose.of(forms.slice_map, pose)
            if exact.kind is not PoseKind.ORDINARY:
                yield exact


class ReferenceSlice:
    """One slice of one manipulator, solved by itself.

    Args:
        eliminant: of the manipulator and its fixed leg.
        length: of the fixed leg, in the user's unit.
        digits: significant digits of every printed number.
    """

    def __init__(self, eliminant: Eliminant, length: Fraction, digits: int) -> None:
        self.eliminant = eliminant
        self.slice_map = eliminant.slice_map
        self.length = length
        self.scaled = length * self.slice_map.scale
        self.digits = digits
        self._bridge = Bridge.of(self.slice_map)
        self._collinear = self.slice_map.f.collinear
        self._closed = self.slice_map.f.closed(self.scaled)
        self._decimals = cache(partial(PointDecimals, self.slice_map, digits))

    def solve(self) -> SliceTable:
        """The table.

        Raises:
            SolverError: the slice could not be decided.
        """
        roots = self.roots
        cusps = None if roots is None else self._by_balls(roots)
        if roots is None or cusps is None:
            return self._exactly()
        return self._table(cusps, len(roots), [(DEGREE_U, 1)], "balls")

    @cached_property
    def roots(self) -> list[RealRoot] | None:
        """Those of Q if all are simple and none is spurious: each is one cusp; nothing else is degenerate."""
        return real_roots(self.q) if self.is_generic else None

    @cached_property
    def q(self) -> QuadraticPoly:
        """Q of the slice."""
        return self.eliminant.at(self.scaled)

    @cached_property
    def is_generic(self) -> bool:
        """Whether all 24 roots of Q are proved to be finite, simple and not spurious.

        Then each real root is a cusp, and nothing else is degenerate.
        """
        circular = QuadraticPoly.rational([1, 0, self.slice_map.rho], self.q.radicand)
        spurious = self._collinear, self._closed, circular
        return self._touching() is None and simple_and_finite(self.q, DEGREE_U, apart_from=spurious)

    def _touching(self) -> QuadraticPoly | None:
        """The common factor of both spurious factors (1 if they meet at u = ∞), or None if they do not meet.

        A zero of one spurious factor at which Q ≠ 0 is an ordinary pose (mathematics.md#spurious-poses).
        Where both vanish (leg f closes while stretched along its base line), poses are classified exactly.
        """
        common = self._collinear.common(self._closed)
        if common.degree > 0 or max(self._collinear.degree, self._closed.degree) < 2:
            return common
        return None

    def _by_balls(self, roots: list[RealRoot]) -> list[ClassifiedPoint] | None:
        """The cusps above simple roots; None if balls alone do not decide them."""
        start = digit_bits(self.digits) + _ABOVE_DIGITS
        finder = cache(partial(SlicePoses, self.slice_map, self.scaled))
        return all_decided(
            lambda root, bits: self._cusp(finder, root, bits), roots, start, _TIMES_BEFORE_EXACT * start
        )

    def _cusp(self, finder: Callable[[int], SlicePoses], root: RealRoot, bits: int) -> ClassifiedPoint | None:
        def angles(inner: int) -> tuple[HalfAngle, HalfAngle] | None:
            u, least = root.refined(inner - 64), bits - _SPARE
            with ctx.workprec(inner):
                t = finder(inner).alpha(u)
                alpha = t and HalfAngle.of(self._bridge.alpha(t), least)
                theta = HalfAngle.of(self._bridge.theta(HalfTangent(u, arb(1))), least)
            return (alpha, theta) if alpha and theta else None

        pose = decided(angles, bits, GREATEST_BITS, "the pose above a root could not be decided")
        with ctx.workprec(bits):
            return self._decimals(bits).cusp(ball_of(self.scaled), *pose)

    def _exactly(self) -> SliceTable:
        """The table from the irreducible factors over ℚ(ω); balls still settle simple roots if they can."""
        plane, q = SliceForms.of(self.slice_map, self.scaled), self.q
        if q.is_zero:
            plane, q = without_shared_curves(plane)
        factors = norm_factors(q)
        roots = list(exact_roots(factors))
        at_infinity = DEGREE_U - q.degree
        places = [*roots, *self._places_beside(roots, q, plane)]
        points = [point for root in places for point in self._points_above(plane, root)]
        points += (point_of_pose(pose, self.digits) for pose in special_poses(plane))
        shapes = Counter({at_infinity: 1}) if at_infinity and not plane.shared else Counter[int]()
        for factor in factors:
            for degree, multiplicity in factor.shape:
                shapes[multiplicity] += degree
        shape = [(degree, multiplicity) for multiplicity, degree in sorted(shapes.items())]
        curves = [
            {"kind": PoseKind.CURVE.value, "equation": curve.equation(self.slice_map)}
            for curve in plane.shared
        ]
        return self._table(points, len(roots), shape, "exact", curves)

    def _places_beside(
        self, roots: Sequence[ExactRoot], q: QuadraticPoly, plane: SliceForms
    ) -> Iterator[ExactRoot | None]:
        """The places beside the roots of Q that may have a degenerate pose above them; None is u = ∞."""
        touching = self._touching()
        if touching is not None:
            factors_of_q = [root.root.polynomial.a for root in roots]
            extra = exact_roots(norm_factors(touching))
            yield from (root for root in extra if root.root.polynomial.a not in factors_of_q)
        if q.degree < DEGREE_U or plane.shared or (touching is not None and touching.degree < 1):
            yield None

    def _points_above(self, plane: SliceForms, root: ExactRoot | None) -> Sequence[ClassifiedPoint]:
        """The degenerate points above a root; balls decide a simple one if they can."""
        if root and root.multiplicity == 1 and not plane.shared:
            spurious = (self._collinear * self._closed).norm
            is_own = spurious.gcd(root.root.polynomial.a).degree() == 0
            cusps = self._by_balls([root.root]) if is_own else None
            if cusps is not None:
                return cusps
        return [point_of_pose(pose, self.digits) for pose in poses_above(plane, root)]

    def _table(
        self,
        points: list[ClassifiedPoint],
        real_roots: int,
        cusp_factors: list[tuple[int, int]],
        method: str,
        curves: Sequence[Mapping[str, str]] = (),
    ) -> SliceTable:
        leg = self.slice_map.fixed_leg
        certificate = slice_certificate(leg, cusp_factors, real_roots, method, shared=bool(curves))
        return SliceTable.of(leg, self.length, self.digits, certificate, points, curves)
