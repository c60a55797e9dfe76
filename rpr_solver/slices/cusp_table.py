"""The cusp table of a slice: counted exactly, printed to proved digits, with its certificate.

There are two methods. If Q(u) is squarefree and prime to the spurious factors, each real root is one
transversal intersection of J = 0 and E = 0 (mathematics.md#simple-roots), and ball arithmetic decides
everything. Otherwise Q is factored, and each special pose is classified over a number field (by_fields.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache, partial

from flint import ctx, fmpz_poly

from rpr_solver.contract import DEFAULT_DIGITS, check_digits, check_leg, check_type
from rpr_solver.exact.decimals import digit_bits
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors, shapes_json
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.precision import TIMES_BEFORE_EXACT, all_decided
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.rationals import Exact
from rpr_solver.exact.real_roots import RealRoot, real_roots
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.slices.by_balls import SlicePoses
from rpr_solver.slices.by_fields import poses_above
from rpr_solver.slices.certificate import Factor, RootCertificate
from rpr_solver.slices.eliminant import DEGREE_U, Eliminant, eliminate
from rpr_solver.slices.joint_points import ClassifiedPoint, free_legs, point_of_balls, point_of_pose
from rpr_solver.slices.lengths import slice_length, slice_lengths
from rpr_solver.slices.shared_curves import SliceForms, without_shared_curves
from rpr_solver.slices.slice_table import SliceTable


def cusp_table(
    manipulator: Manipulator,
    lengths: Exact | Iterable[Exact],
    *,
    digits: int = DEFAULT_DIGITS,
    fixed_leg: int = 1,
) -> list[SliceTable]:
    """The cusps of the slices of a manipulator, counted by proof.

    In a slice one leg has a fixed length. The cusps of a slice are the joint vectors at which exactly three
    poses coalesce: J = 0 (the article's equation 6) and E = 0 (equivalent there to its equation 10), with
    proof that no further pose coalesces.

    Args:
        manipulator: the geometry.
        lengths: one length of the fixed leg or several, exact (see :data:`Exact`), > 0, in the user's unit.
            A text is one number, never a sequence.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
        fixed_leg: the leg of fixed length, 1, 2 or 3.

    Returns:
        A table for each length, in the order of ``lengths``.

    Raises:
        InputError: naming each length at fault by the leg and its place (``l1[0]``), or ``digits``,
            ``fixed_leg`` or ``manipulator``.
        SolverError: a slice could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> cusp_table(EXAMPLES["zein-flat"], [10, "34.5"], digits=15)
    [<SliceTable L1=10: 4 cusps, 15 digits>, <SliceTable L1=34.5: 8 cusps, 15 digits>]
    """
    digits, leg = check_digits(digits), check_leg(fixed_leg)
    exact = slice_lengths(lengths, leg)
    eliminant = eliminate(manipulator, leg)
    return [solve_slice(eliminant, length, digits) for length in exact]


def solve_slice(eliminant: Eliminant, length: Exact, digits: int = DEFAULT_DIGITS) -> SliceTable:
    """All cusps of one slice; several slices of one manipulator share its eliminant.

    Args:
        eliminant: of the manipulator and its fixed leg (see :func:`eliminate`).
        length: of the fixed leg, exact, > 0, in the user's unit.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: ``length`` (named by the leg, such as ``l1``), ``digits`` or ``eliminant`` is wrong.
        SolverError: the slice could not be decided.

    >>> from rpr_solver import EXAMPLES, eliminate
    >>> eliminant = eliminate(EXAMPLES["zein-flat"])
    >>> [solve_slice(eliminant, length, 15).count for length in ("10", "34.5", 100)]
    [4, 8, 4]
    """
    check_type(eliminant, Eliminant, "eliminant")
    exact = slice_length(length, eliminant.slice_map.fixed_leg)
    return _Slice(eliminant, exact, check_digits(digits)).solve()


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
        """The common factor of both spurious factors (1 if they meet at u = ∞), or None if they do not meet.

        A zero of one spurious factor at which Q ≠ 0 is an ordinary pose (mathematics.md#spurious-poses).
        Where both vanish (leg f closes while stretched along its base line), poses are classified exactly.
        """
        common = self._collinear.gcd(self._closed)
        if common.degree() > 0 or max(self._collinear.degree(), self._closed.degree()) < 2:
            return common
        return None

    def _by_balls(self, roots: list[RealRoot]) -> list[ClassifiedPoint] | None:
        """The cusps above simple roots; None if balls alone do not decide them."""
        start = self.digit_bits + 192
        poses = cache(partial(SlicePoses, self.slice_map, self.scaled))
        return all_decided(
            lambda root, bits: self._cusp(poses(bits), root), roots, start, TIMES_BEFORE_EXACT * start
        )

    def _cusp(self, poses: SlicePoses, root: RealRoot) -> ClassifiedPoint | None:
        u = root.refined(poses.bits - 64)
        with ctx.workprec(poses.bits):
            t = poses.alpha(u)
            cusp = poses.cusp(u, t) if t else None
            return point_of_balls(cusp, self.slice_map.fixed_leg, self.digits, poses.bits) if cusp else None

    def _exactly(self, q: QuadraticPoly) -> SliceTable:
        """The table from the irreducible factors over ℚ(ω); balls still settle simple roots if they can."""
        spurious, touching = self._collinear * self._closed, self._touching()
        plane = SliceForms.of(self.slice_map, self.scaled)
        if q.is_zero:
            plane, q = without_shared_curves(plane)
        factors = norm_factors(q)
        roots = list(exact_roots(factors))
        places: list[ExactRoot | None] = [*roots]
        if touching is not None:
            factors_of_q = [root.root.polynomial.a for root in roots]
            extra = exact_roots(norm_factors(QuadraticPoly.rational(touching, q.radicand)))
            places += (root for root in extra if root.root.polynomial.a not in factors_of_q)
        at_infinity = DEGREE_U - q.degree
        if at_infinity or plane.shared or (touching is not None and touching.degree() < 1):
            places.append(None)
        points: list[ClassifiedPoint] = []
        for root in places:
            cusps = None
            if root and root.multiplicity == 1 and not plane.shared:
                own = spurious.gcd(root.root.polynomial.a).degree() == 0
                cusps = self._by_balls([root.root]) if own else None
            if cusps is None:
                cusps = [point_of_pose(pose, self.digits) for pose in poses_above(plane, root)]
            points += cusps
        shapes: dict[int, int] = {at_infinity: 1} if at_infinity and not plane.shared else {}
        for degree, multiplicity in (shape for factor in factors for shape in factor.shape):
            shapes[multiplicity] = shapes.get(multiplicity, 0) + degree
        shape = [(degree, multiplicity) for multiplicity, degree in sorted(shapes.items())]
        curves = [
            {"kind": PoseKind.CURVE.value, "equation": curve.equation(self.slice_map.fixed_leg)}
            for curve in plane.shared
        ]
        return self._table(points, len(roots), shape, "exact", curves)

    def _table(
        self,
        points: list[ClassifiedPoint],
        real_roots: int,
        cusp_factors: list[tuple[int, int]],
        method: str,
        curves: Sequence[Mapping[str, str]] = (),
    ) -> SliceTable:
        leg = self.slice_map.fixed_leg
        certificate: RootCertificate = {
            "eliminant_degree": sum(degree * multiplicity for degree, multiplicity in cusp_factors),
            "real_roots": real_roots,
            "factors": _factor_table(leg, cusp_factors, shared=bool(curves)),
            "method": method,
        }
        return SliceTable.of(leg, self.length, self.digits, certificate, points, curves)


def _factor_table(leg: int, cusp_factors: list[tuple[int, int]], *, shared: bool) -> list[Factor]:
    """The factors of Res_t(J, E), a form of degree 48 in u, with their origins."""
    cusps: list[Factor] = [{**shape, "origin": "cusps"} for shape in shapes_json(cusp_factors)]
    if shared:
        return cusps
    closed, _ = free_legs(leg)
    return [
        {"degree": 2, "multiplicity": 1, "origin": f"L{closed}=0"},
        {"degree": 2, "multiplicity": 2, "origin": f"leg {leg} along A{min(leg, closed)}A{max(leg, closed)}"},
        {"degree": 2, "multiplicity": 9, "origin": "circular"},
        *cusps,
    ]
