"""One slice of one manipulator, by its polynomials alone: the reference; fast/ agrees with it to the byte.

There are two methods. If Q(u) is squarefree and prime to the spurious factors, each real root is one
transversal intersection of J = 0 and E = 0 (mathematics.md#simple-roots), and ball arithmetic decides
everything. Otherwise Q is factored, and each special pose is classified over a number field.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache, cached_property, lru_cache, partial
from itertools import chain

from flint import arb, arb_mat, ctx, fmpz_poly

from rpr_solver.errors import SolverError
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.precision import GREATEST_BITS, all_decided, decided
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, ball_of, real_roots
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.exact_pose import ExactPose, common_poses
from rpr_solver.model.half_tangent import HalfTangent, common_root
from rpr_solver.model.joint_points import ClassifiedPoint, point_of_pose
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.eliminant import DEGREE_U, Eliminant
from rpr_solver.slices.grid import GridSlice, HalfAngle, first_bits, on_grid
from rpr_solver.slices.shared_curves import SliceForms, special_poses, without_shared_curves
from rpr_solver.slices.slice_table import SliceTable, root_certificate

_POWERS_OF_L = 3
_J, _E = 5, 7
"""The coefficients of J and of E in t, and in u."""
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
    poses = common_poses(forms.singular, forms.coalescence, root, forms.length)
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
        self._collinear = self.slice_map.f.collinear()
        self._closed = self.slice_map.f.closed(self.scaled)
        self._grid = cache(partial(GridSlice, self.slice_map, self.scaled, digits))

    def solve(self) -> SliceTable:
        """The table.

        Raises:
            SolverError: the slice could not be decided.
        """
        roots = self.roots
        cusps = None if roots is None else self._by_balls(roots)
        if roots is None or cusps is None:
            return self._exactly(self.eliminant.at(self.scaled))
        return self._table(cusps, len(roots), [(DEGREE_U, 1)], "balls")

    @cached_property
    def roots(self) -> list[RealRoot] | None:
        """Those of Q if all are simple and none is spurious: each is one cusp; nothing else is degenerate."""
        return real_roots(self.eliminant.at(self.scaled)) if self.is_generic else None

    @cached_property
    def is_generic(self) -> bool:
        """Whether it is proved that each real root of Q is a cusp, and nothing else is degenerate."""
        return self._generic(self.eliminant.at(self.scaled))

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
        start = first_bits(self.digits)
        finder = cache(partial(SlicePoses, self.slice_map, self.scaled))
        return all_decided(
            lambda root, bits: self._cusp(finder, root, bits), roots, start, _TIMES_BEFORE_EXACT * start
        )

    def _cusp(self, finder: Callable[[int], SlicePoses], root: RealRoot, bits: int) -> ClassifiedPoint | None:
        def boxes(inner: int) -> tuple[HalfAngle, HalfAngle] | None:
            u = root.refined(inner - 64)
            with ctx.workprec(inner):
                t = finder(inner).alpha(u)
                alpha, theta = t and on_grid(t, bits), on_grid(HalfTangent(u, arb(1)), bits)
            return (alpha, theta) if alpha and theta else None

        pose = decided(boxes, bits, GREATEST_BITS, "the pose above a root could not be decided")
        with ctx.workprec(bits):
            return self._grid(bits).point(*pose)

    def _exactly(self, q: QuadraticPoly) -> SliceTable:
        """The table from the irreducible factors over ℚ(ω); balls still settle simple roots if they can."""
        plane = SliceForms.of(self.slice_map, self.scaled)
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
            {"kind": PoseKind.CURVE.value, "equation": curve.equation(self.slice_map.fixed_leg)}
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
            extra = exact_roots(norm_factors(QuadraticPoly.rational(touching, q.radicand)))
            yield from (root for root in extra if root.root.polynomial.a not in factors_of_q)
        if q.degree < DEGREE_U or plane.shared or (touching is not None and touching.degree() < 1):
            yield None

    def _points_above(self, plane: SliceForms, root: ExactRoot | None) -> Sequence[ClassifiedPoint]:
        """The degenerate points above a root; balls decide a simple one if they can."""
        if root and root.multiplicity == 1 and not plane.shared:
            spurious = self._collinear * self._closed
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
        certificate = root_certificate(leg, cusp_factors, real_roots, method, shared=bool(curves))
        return SliceTable.of(leg, self.length, self.digits, certificate, points, curves)
