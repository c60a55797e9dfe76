"""All real poses of one joint vector: exactly counted, each with its exact multiplicity.

If the sixth-degree form has six simple finite roots, each real one is a single regular pose, and ball
arithmetic decides everything. Otherwise the form is factored and its roots lie in number fields: the
multiplicity of an α is the sum over the poses with this α of the intersection numbers of L2² = const and
L3² = const (mathematics.md#the-fibre).

With leg 1 fixed, X = B1 and v = R(α) m − a for each other leg, the squared lengths are

    |X|² = s₁,    |X + v|² = s   ⟺   2 v·X = s − s₁ − |v|²,

two equations linear in X. Their solution, substituted into |X|² = s₁, gives one form of degree 6 in
the half tangent t of α (mathematics.md#the-fibre). Only squares of the leg lengths occur.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any

from flint import arb, ctx, fmpq

from rpr_solver.errors import SolverError, Unproved
from rpr_solver.exact import all_decided, decided
from rpr_solver.exact.decimals import angle_text, digit_bits, round_all, sorted_by_balls
from rpr_solver.exact.factors import ExactRoot, exact_roots, norm_factors
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.number_field import Algebraic, adjoin_real_roots
from rpr_solver.exact.precision import GREATEST_BITS, TIMES_BEFORE_EXACT
from rpr_solver.exact.quadratic import QuadraticPoly, omega_ball
from rpr_solver.exact.rationals import rational_sqrt
from rpr_solver.exact.real_roots import RealRoot, ball_of, real_roots
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent, LocalMap, Pose, direction
from rpr_solver.model.joint_points import cos_sin, place
from rpr_solver.model.shared_joints import Joint, shares_joints
from rpr_solver.model.slice_map import Leg, SliceMap

DEGREE = 6
_OF_DETERMINANT = 2
"""The degree of v₂ × v₃ without its factor 1 + ρt²."""


@dataclass(frozen=True)
class LinearSystem:
    """``weight`` · vᵢ·X = cᵢ for the two free legs, at one α, in any ring; y in √ρ."""

    first: tuple[Any, Any]
    second: tuple[Any, Any]
    right: tuple[Any, Any]
    weight: int
    rho: int

    @property
    def determinant(self) -> Any:
        """v₂ × v₃: zero where the two equations are dependent."""
        (a, b), (c, d) = self.first, self.second
        return a * d - b * c

    @property
    def numerators(self) -> tuple[Any, Any]:
        """``whole`` · determinant · X."""
        (a, b), (c, d), (e, f) = self.first, self.second, self.right
        x = e * d - f * b
        return x if self.rho == 1 else x * self.rho, f * a - e * c

    @property
    def whole(self) -> int:
        """The factor of both numerators."""
        return self.weight * self.rho


@dataclass(frozen=True)
class Closure:
    """The closure equations of one joint vector: ``squares`` are s₁, s₂, s₃ in scaled units."""

    slice_map: SliceMap
    squares: tuple[Fraction, Fraction, Fraction]

    @classmethod
    def of(cls, slice_map: SliceMap, squares: Sequence[Fraction]) -> Closure:
        """From squared lengths in the user's unit; leg 1 must be the slice map's fixed leg."""
        s1, s2, s3 = (s * slice_map.scale**2 for s in squares)
        return cls(slice_map, (s1, s2, s3))

    @property
    def denominator(self) -> int:
        """A common denominator of the squares."""
        return lcm(*(s.denominator for s in self.squares))

    def linear(self, cos: Any, sin: Any, one: Any, omega: Any) -> LinearSystem:
        """The linear system at α, where c : s : 1 = ``cos`` : ``sin`` : ``one`` is the turn."""
        den = self.denominator
        s1, *others = self.squares

        def equation(leg: Leg, square: Fraction) -> tuple[tuple[Any, Any], Any]:
            x, y = leg.rotated(cos, sin, omega)
            constant = int(den * (square - s1 - leg.platform2 - leg.base2))
            ax, ay = leg.base_times(one, omega)
            u, v = leg.base[0].times(x, omega), leg.base[1].times(y, omega)
            right = one * constant + (u + (v if leg.rho == 1 else v * leg.rho)) * (2 * den)
            return (x - ax, y - ay), right

        first, second = (
            equation(leg, s) for leg, s in zip((self.slice_map.f, self.slice_map.g), others, strict=True)
        )
        return LinearSystem(first[0], second[0], (first[1], second[1]), 2 * den, self.slice_map.rho)

    @cached_property
    def sextic(self) -> QuadraticPoly:
        """A(t) + ω B(t), primitive and of formal degree 6; a lower degree is a root at α = 180°."""
        radicand, rho, den = self.slice_map.radicand, self.slice_map.rho, self.denominator
        cos, sin, one = (QuadraticPoly.rational(c, radicand) for c in ([1, 0, -rho], [0, 2], [1, 0, rho]))
        system = self.linear(cos, sin, one, QuadraticPoly.omega(radicand))
        x, y = system.numerators
        determinant: QuadraticPoly = system.determinant / one.a
        # both terms are divisible by 1 + ρt² once: X is isotropic at its roots
        norm: QuadraticPoly = (x * x + y * y * rho) / one.a
        factor = 4 * den * int(den * self.squares[0]) * rho**2
        return (norm - one * determinant * determinant * factor).primitive()


@dataclass(frozen=True)
class DecimalPose:
    """A pose in decimals: α, θ1, θ2, θ3 in degrees and the coordinates of B1; α and θ1 also as balls."""

    alpha: arb
    theta: arb
    texts: tuple[str, ...]
    multiplicity: int


@dataclass(frozen=True)
class Fibre:
    """The fibre of direct kinematics over a joint vector.

    ``circle_at`` is the α, 0 or 180, at which B1 can be anywhere on a circle; None if there is none.
    ``turns``: whether the platform can turn about a joint that two legs share.
    """

    poses: tuple[DecimalPose, ...]
    circle_at: int | None
    factors: tuple[tuple[int, int], ...]
    """(degree, multiplicity) of the sixth-degree form's factors; they add up to 6."""
    method: str
    turns: bool = False


def fibre(closure: Closure, digits: int) -> Fibre:
    """All real poses, sorted by α, then θ1.

    Raises:
        SolverError: the form vanishes identically, or digits could not be proved.
    """
    return _Fibre(closure, digits).solve()


class _Fibre:
    def __init__(self, closure: Closure, digits: int) -> None:
        self.closure = closure
        self.slice_map = closure.slice_map
        self.bridge = Bridge.of(closure.slice_map)
        self.digits = digits
        self.digit_bits = digit_bits(digits)

    def solve(self) -> Fibre:
        sextic = self.closure.sextic
        if sextic.is_zero and shares_joints(self.slice_map):
            return Fibre(_sorted([*self._beside_a_turn()]), None, (), "exact", turns=True)
        if sextic.is_zero:
            raise SolverError("the manipulator is movable with all legs locked, so alpha is undetermined")
        if simple_and_finite(sextic, DEGREE):
            poses = self._by_balls(real_roots(sextic))
            if poses is not None:
                return Fibre(_sorted(poses), None, ((DEGREE, 1),), "balls")
        return self._exactly()

    def _by_balls(self, roots: Sequence[RealRoot]) -> list[DecimalPose] | None:
        """The regular pose above each simple root; None if balls alone do not decide them."""
        start = self.digit_bits + 128
        return all_decided(self._ball_pose, roots, start, TIMES_BEFORE_EXACT * start)

    def _ball_pose(self, root: RealRoot, bits: int) -> DecimalPose | None:
        t = root.refined(bits - 32)
        with ctx.workprec(bits):
            omega = omega_ball(self.slice_map.radicand, bits)
            square = t * t * self.slice_map.rho
            cos, sin, one = 1 - square, 2 * t, 1 + square
            system = self.closure.linear(cos, sin, one, omega)
            determinant = system.determinant * system.whole
            if determinant.contains(0):
                return None
            x, y = (n / determinant for n in system.numerators)
            alpha = self.bridge.alpha(HalfTangent(t, arb(1))).degrees()
            others = ((x + vx / one, y + vy / one) for vx, vy in (system.first, system.second))
            b1, *rest = (self.bridge.vector(*vector) for vector in ((x, y), *others))
            angles = [direction(*vector) for vector in (b1, *rest)]
            scale = self.slice_map.scale_ball()
            return self._decimal_pose((alpha, *angles), [z / scale for z in b1], 1)

    def _beside_a_turn(self) -> Iterator[DecimalPose]:
        """The isolated poses where the platform can turn about a shared joint with all legs locked.

        The turn has one X for each α, so that they are where the determinant is 0: of the two X there, one is
        that of the turn, which is p, or −p turned by α (:attr:`Joint.radius`).
        """
        radicand, rho = self.slice_map.radicand, self.slice_map.rho
        cos, sin, one = (QuadraticPoly.rational(c, radicand) for c in ([1, 0, -rho], [0, 2], [1, 0, rho]))
        system = self.closure.linear(cos, sin, one, QuadraticPoly.omega(radicand))
        determinant: QuadraticPoly = system.determinant / one.a
        roots: list[tuple[ExactRoot | None, int]] = [
            (root, root.multiplicity) for root in exact_roots(norm_factors(determinant))
        ]
        if at_infinity := _OF_DETERMINANT - determinant.degree:
            roots.append((None, at_infinity))
        joint = Joint.of(self.slice_map)
        for root, order in roots:
            for pose in self._on_line(root) or ():
                one_there = pose.omega.field(1)
                x, y = (z.times(one_there, pose.omega) for z in joint.radius)
                if joint.is_on_platform:
                    c, s = pose.cos_alpha, pose.sin_alpha
                    x, y = s * y * rho - c * x, -(s * x) - c * y
                if not ((pose.cos_theta - x).is_zero and (pose.sin_theta - y).is_zero):
                    yield self._exact_pose(pose, order)

    def _exactly(self) -> Fibre:
        poses: list[DecimalPose] = []
        circle_at = None
        factors = norm_factors(self.closure.sextic)
        shapes = [shape for factor in factors for shape in factor.shape]
        roots: list[tuple[ExactRoot | None, int]] = [
            (root, root.multiplicity) for root in exact_roots(factors)
        ]
        if at_infinity := DEGREE - self.closure.sextic.degree:
            shapes.append((1, at_infinity))
            roots.append((None, at_infinity))
        for root, order in roots:
            simple = self._by_balls([root.root]) if root and order == 1 else None
            above = self._above(root, order) if simple is None else simple
            if above is None:
                # congruent triangles: B1B2 is parallel to A1A2
                circle_at = 180 if root is None else 0
            else:
                poses += above
        return Fibre(_sorted(poses), circle_at, tuple(sorted(shapes)), "exact")

    def _above(self, root: ExactRoot | None, order: int) -> list[DecimalPose] | None:
        """The poses at one α, a root of this order; None if they form a whole circle."""
        poses = self._on_line(root)
        if poses is None:
            return None
        multiplicities = _shared(self.closure, poses, order) if len(poses) > 1 else (order,) * len(poses)
        return [self._exact_pose(*each) for each in zip(poses, multiplicities, strict=True)]

    def _on_line(self, root: ExactRoot | None) -> list[Pose[Algebraic]] | None:
        """The poses at one α, each with X in the place of the direction of leg 1; None if they form a whole
        circle."""
        t, omega = place(root, self.slice_map.radicand)
        field = omega.field
        rho = self.slice_map.rho
        cos, sin = cos_sin(t, field, rho)
        system = self.closure.linear(cos, sin, field(1), omega)
        determinant = system.determinant
        if not determinant.is_zero:
            inverse = (determinant * system.whole).inverse()
            x, y = (n * inverse for n in system.numerators)
            return [Pose(cos, sin, x, y, field(1), omega)]
        sides = zip((system.first, system.second), system.right, strict=True)
        line = next(((v, c) for v, c in sides if not (v[0].is_zero and v[1].is_zero)), None)
        if line is None:
            return None if all(c.is_zero for c in system.right) else []
        (vx, vy), right = line
        # X lies on one line, at ``foot`` + w (−ρ vy, vx), and on the circle of leg 1
        inverse = (vx * vx + vy * vy * rho).inverse()
        shift = right * inverse * field(fmpq(1, system.weight))
        x, y = vx * shift, vy * shift
        foot = Pose(cos, sin, x, y, field(1), omega)
        w2 = (field(self.closure.squares[0]) - x * x - y * y * rho) * inverse * field(fmpq(1, rho))
        if w2.is_zero:
            return [foot]
        if w2.sign < 0:
            return []
        poses = []
        for extension in adjoin_real_roots(field, [-w2, field(0), field(1)]):
            at, w = foot.mapped(extension.lift), extension.root
            x, y = at.cos_theta - w * extension.lift(vy) * rho, at.sin_theta + w * extension.lift(vx)
            poses.append(replace(at, cos_theta=x, sin_theta=y))
        return poses

    def _exact_pose(self, pose: Pose[Algebraic], multiplicity: int) -> DecimalPose:
        """A pose of length 1, so that its direction θ is B1."""
        x, y, omega = pose.cos_theta, pose.sin_theta, pose.omega
        vectors = [(x, y)]
        for leg in (self.slice_map.f, self.slice_map.g):
            mx, my = leg.rotated(pose.cos_alpha, pose.sin_alpha, omega)
            ax, ay = leg.base_times(omega.field(1), omega)
            vectors.append((x + mx - ax, y + my - ay))
        scale, bridge = self.slice_map.scale, self.bridge
        b1 = [coordinate(*z) for z in bridge.coordinates(x, y, omega)]

        def decimals(bits: int) -> DecimalPose | None:
            with ctx.workprec(bits):
                alpha = bridge.alpha_degrees(pose.cos_alpha, pose.sin_alpha, omega, bits)
                angles = [alpha, *(bridge.theta_degrees(*vector, omega, bits) for vector in vectors)]
                point = [z / scale if isinstance(z, Fraction) else z(bits) / ball_of(scale) for z in b1]
                return self._decimal_pose(angles, point, multiplicity)

        message = "the digits of a pose could not be decided"
        return decided(decimals, self.digit_bits + 128, GREATEST_BITS, message)

    def _decimal_pose(
        self, angles: Sequence[arb], b1: Sequence[arb | Fraction], multiplicity: int
    ) -> DecimalPose | None:
        """The pose, if all its digits are proved."""
        texts = round_all((*angles, *b1), self.digits)
        if texts is None:
            return None
        alpha, theta1, *_ = angles
        return DecimalPose(alpha, theta1, (*map(angle_text, texts[:4]), *texts[4:]), multiplicity)


def coordinate(number: Algebraic, square: Fraction) -> Fraction | Callable[[int], arb]:
    """A number times the root of a square: exact if it is rational, else a ball at a working precision."""
    factor, value = rational_sqrt(square), number.rational
    if value == 0:
        return Fraction(0)
    if value is not None and factor is not None:
        return value * factor
    return lambda bits: number.ball(bits) * (ball_of(square).sqrt() if factor is None else ball_of(factor))


def _shared(closure: Closure, poses: Sequence[Pose[Algebraic]], order: int) -> tuple[int, ...]:
    """The multiplicities of the poses with one α; they add up to that of α, the ``order``."""
    if order == 2:
        return (1, 1)
    first, second = (_local_multiplicity(closure, pose) for pose in poses)
    if first is None and second is not None:
        first = order - second
    if first is None:
        raise Unproved("the multiplicity of two poses with one alpha could not be told apart")
    if second is not None and first + second != order:
        raise SolverError("the multiplicities of two poses do not add up; please report this joint vector")
    return first, order - first


def _local_multiplicity(closure: Closure, pose: Pose[Algebraic]) -> int | None:
    """The intersection number of f = s₂ and g = s₃ on the slice; None where both gradients vanish.

    Where ∇f ≠ 0 it is one more than the number of derivatives of g along f = s₂ that vanish
    (mathematics.md#poses-that-coalesce).
    """
    local = LocalMap.at(closure.slice_map, pose, DEGREE + 1)
    for leg in (local.f, local.g):
        if leg.alpha.value.is_zero and leg.theta.value.is_zero:
            continue
        j = local.singularity()
        for multiplicity in range(1, DEGREE + 1):
            if not j.value.is_zero:
                return multiplicity
            j = local.along(leg, j)
    return None


def _sorted(poses: Sequence[DecimalPose]) -> tuple[DecimalPose, ...]:
    return tuple(sorted_by_balls(poses, lambda pose: (pose.alpha, pose.theta)))
