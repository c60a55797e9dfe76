"""The cusp table of a slice: counted exactly, printed to proved digits, with its certificate.

Two ways lead to a slice's cusps. If Q(u) is squarefree and prime to the spurious factors, each real
root is one transversal crossing of J = 0 and E = 0, and balls settle everything. Otherwise the roots
are taken apart exactly (by_fields.py) and each special pose is classified over a number field.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from flint import ctx, fmpz_poly

from rpr_solver.contract import DEFAULT_DIGITS, check_digits
from rpr_solver.errors import InputError
from rpr_solver.exact.decimals import digit_bits
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.precision import TIMES_BEFORE_EXACT, decided_or_none
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.rationals import exact_str, parse_exact
from rpr_solver.exact.real_roots import RealRoot, real_roots
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.slices.by_balls import SlicePoses
from rpr_solver.slices.by_fields import ExactPose, poses_above, poses_at_half_turn
from rpr_solver.slices.eliminant import DEGREE_U, Eliminant, eliminate
from rpr_solver.slices.joint_points import (
    ClassifiedPoint,
    JointPoint,
    cusps_and_degenerate,
    free_legs,
    in_order,
    point_of_balls,
    point_of_pose,
)
from rpr_solver.slices.shared_curves import SliceForms, without_shared_curves


@dataclass(frozen=True)
class SliceTable:
    """All cusps of one slice, sorted by the fixed leg's angle, and the degenerate points beside them."""

    fixed_leg: int
    length: Fraction
    digits: int
    cusps: tuple[JointPoint, ...]
    degenerate_points: tuple[Mapping[str, str], ...]
    certificate: Mapping[str, object] = field(repr=False)

    @property
    def count(self) -> int:
        """The number of cusps."""
        return len(self.cusps)

    def to_json(self) -> dict[str, object]:
        """The contract's slice object."""
        return {
            f"l{self.fixed_leg}": exact_str(self.length),
            "count": self.count,
            "cusps": [cusp.to_json(self.fixed_leg) for cusp in self.cusps],
            "degenerate_points": [dict(point) for point in self.degenerate_points],
            "certificate": dict(self.certificate),
        }


def cusp_table(
    manipulator: Manipulator,
    lengths: Sequence[int | str | Fraction],
    *,
    digits: int = DEFAULT_DIGITS,
    fixed_leg: int = 1,
) -> list[SliceTable]:
    """The cusps of several slices of one manipulator.

    Args:
        manipulator: the geometry.
        lengths: the lengths of the fixed leg, exact (see :func:`parse_exact`), all > 0.
        digits: significant digits of every printed number, 15 to 10000.
        fixed_leg: which leg is held, 1, 2 or 3.

    Raises:
        InputError: a length, ``digits`` or ``fixed_leg`` is out of range.
        SolverError: a slice could not be decided.
    """
    eliminant = eliminate(manipulator, fixed_leg)
    name = f"l{fixed_leg}"
    return [solve_slice(eliminant, parse_exact(x, name), digits) for x in lengths]


def solve_slice(eliminant: Eliminant, length: Fraction, digits: int = DEFAULT_DIGITS) -> SliceTable:
    """All cusps of the slice in which the eliminant's fixed leg has this length (user's unit).

    Raises:
        InputError: ``length`` is not positive, or ``digits`` is out of range.
        SolverError: the slice could not be decided; nothing was guessed.
    """
    check_slice(eliminant.slice_map.fixed_leg, length, digits)
    return _Slice(eliminant, length, digits).solve()


def check_slice(fixed_leg: int, length: Fraction, digits: int) -> None:
    """Refuse what is no slice.

    Raises:
        InputError: ``length`` is not positive, or ``digits`` is out of range.
    """
    if length <= 0:
        raise InputError.of(
            f"l{fixed_leg}",
            f"is {exact_str(length)}; a slice needs a leg length > 0 (at 0 its angle is undefined)",
        )
    check_digits(digits)


class _Slice:
    def __init__(self, eliminant: Eliminant, length: Fraction, digits: int) -> None:
        self.eliminant = eliminant
        self.slice_map = eliminant.slice_map
        self.length = length
        self.scaled = length * self.slice_map.scale
        self.digits = digits
        self._collinear = self.slice_map.f.collinear()
        self._closed = self.slice_map.f.closed(self.scaled)
        self.digit_bits = digit_bits(digits)

    def solve(self) -> SliceTable:
        q = self.eliminant.at(self.scaled)
        if self._generic(q):
            roots = real_roots(q)
            cusps = self._by_balls(roots)
            if cusps is not None:
                return self._table(cusps, len(roots), [(DEGREE_U, 1)], "balls")
        return self._exactly(q)

    def _generic(self, q: QuadraticPoly) -> bool:
        """Proof that all 24 roots are finite, simple and not spurious."""
        spurious = self._collinear * self._closed * fmpz_poly([1, 0, 1])
        return self._touching() is None and simple_and_finite(q, DEGREE_U, apart_from=spurious)

    def _touching(self) -> fmpz_poly | None:
        """The common root of both spurious factors (1 if it is u = ∞), or None if they share none.

        Elsewhere a spurious pose that is no root of Q is an ordinary one: its whole intersection
        number, 1, comes from ∇f = 0. Where leg f closes while stretched along its base line the two
        factors meet, that count says less, and the poses are looked at exactly.
        """
        common = self._collinear.gcd(self._closed)
        if common.degree() > 0 or max(self._collinear.degree(), self._closed.degree()) < 2:
            return common
        return None

    def _by_balls(self, roots: list[RealRoot]) -> list[ClassifiedPoint] | None:
        """The cusps above simple roots; None where balls alone do not come to an end."""
        cusps: list[ClassifiedPoint] = []

        def complete(bits: int) -> list[ClassifiedPoint] | None:
            poses = SlicePoses(self.slice_map, self.scaled, bits)
            for root in roots[len(cusps) :]:
                if (cusp := self._cusp(poses, root)) is None:
                    return None
                cusps.append(cusp)
            return cusps

        start = self.digit_bits + 192
        return decided_or_none(complete, start, TIMES_BEFORE_EXACT * start)

    def _cusp(self, poses: SlicePoses, root: RealRoot) -> ClassifiedPoint | None:
        u = root.refined(poses.bits - 64)
        with ctx.workprec(poses.bits):
            t = poses.alpha(u)
            cusp = t and poses.cusp(u, t)
            if not cusp:
                return None
            return point_of_balls(cusp, self.digits, poses.bits)

    def _exactly(self, q: QuadraticPoly) -> SliceTable:
        """Take every root apart over ℚ(ω); simple ones still go the way of balls where they can."""
        spurious, touching = self._collinear * self._closed, self._touching()
        lengths = self.scaled, -self.scaled
        if not q.is_zero:
            plane, turned = (SliceForms.of(self.slice_map, length) for length in lengths)
        else:
            (plane, q), (turned, _) = (without_shared_curves(self.slice_map, length) for length in lengths)
        points: list[ClassifiedPoint] = []
        factors = norm_factors(q)
        roots = list(exact_roots(factors))
        extra: list[ExactRoot] = []
        if touching is not None:
            extra = list(exact_roots(norm_factors(QuadraticPoly.rational(touching, q.radicand))))
        known = [root.root.polynomial.a for root in roots]
        for root in roots + [root for root in extra if root.root.polynomial.a not in known]:
            simple = root.multiplicity == 1 and not plane.shared
            if simple and spurious.gcd(root.root.polynomial.a).degree() == 0:
                cusps = self._by_balls([root.root])
                if cusps is not None:
                    points += cusps
                    continue
            points += map(self._point, poses_above(plane, root))
        at_infinity = DEGREE_U - q.degree
        touches_infinity = touching is not None and touching.degree() < 1
        if at_infinity or plane.shared or touches_infinity:
            points += map(self._point, poses_at_half_turn(turned))
        shapes: dict[int, int] = {at_infinity: 1} if at_infinity and not plane.shared else {}
        for degree, multiplicity in (shape for factor in factors for shape in factor.shape):
            shapes[multiplicity] = shapes.get(multiplicity, 0) + degree
        shape = [(degree, multiplicity) for multiplicity, degree in sorted(shapes.items())]
        curves = [
            {"kind": PoseKind.CURVE.value, "equation": curve.equation(self.slice_map.fixed_leg)}
            for curve in plane.shared
        ]
        return self._table(points, len(roots), shape, "exact", curves)

    def _point(self, pose: ExactPose) -> ClassifiedPoint:
        return point_of_pose(pose, self.digits)

    def _table(
        self,
        points: list[ClassifiedPoint],
        real_roots: int,
        cusp_factors: list[tuple[int, int]],
        method: str,
        curves: Sequence[Mapping[str, str]] = (),
    ) -> SliceTable:
        leg = self.slice_map.fixed_leg
        points = in_order(points)
        cusps, degenerate = cusps_and_degenerate(points, leg)
        certificate = {
            "eliminant_degree": sum(degree * multiplicity for degree, multiplicity in cusp_factors),
            "real_roots": real_roots,
            "factors": _factor_table(self.eliminant, cusp_factors, shared=bool(curves)),
            "method": method,
            "working_bits": max((x.bits for x in points), default=0),
            "proofs": [dict(x.proof) for x in cusps],
        }
        return SliceTable(
            leg, self.length, self.digits, tuple(x.point for x in cusps), (*curves, *degenerate), certificate
        )


def _factor_table(
    eliminant: Eliminant, cusp_factors: list[tuple[int, int]], *, shared: bool
) -> list[dict[str, object]]:
    """The factors of Res_t(J, E), a form of degree 48 in u, each with where it comes from."""
    cusps: list[dict[str, object]] = [
        {"degree": degree, "multiplicity": multiplicity, "origin": "cusps"}
        for degree, multiplicity in cusp_factors
    ]
    if shared:
        return cusps
    leg = eliminant.slice_map.fixed_leg
    closed, _ = free_legs(leg)
    return [
        {"degree": 2, "multiplicity": 1, "origin": f"L{closed}=0"},
        {"degree": 2, "multiplicity": 2, "origin": f"leg {leg} along A{min(leg, closed)}A{max(leg, closed)}"},
        {"degree": 2, "multiplicity": 9, "origin": "circular"},
        *cusps,
    ]
