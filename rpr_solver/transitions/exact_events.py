"""Events that balls cannot decide, by exact arithmetic: multiple roots, and poses singular for every L.

Both kinds of pose are common zeros, in a number field, of two forms in (t, v) above a root v (or v = ∞) of
their eliminant. The L of an event follows from J0 and J1, or from E and v·∇E as polynomials in L.

A root v = tan θ/√ρ gives the direction of the fixed leg as (1, v), which is not of length 1, with an L of
either sign to go with it; :func:`_upright` makes them a direction of length 1 and an L > 0.

That no pose is singular for every L and degenerate for some is proved modulo one prime. Such poses are found
by four square roots, so for one prime in about sixteen all of them are over 𝔽ₚ. There the conditions of a
degenerate pose are polynomials in L, coprime as a rule, and what is coprime modulo p is so over the numbers
(mathematics.md#permanent-poses).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import islice
from typing import Any, Literal

from flint import arb, arb_mat, ctx, fmpz_poly, nmod, nmod_poly

from rpr_solver.exact import decided
from rpr_solver.exact.factors import ExactRoot, minimal_polynomial, roots_of, same_number
from rpr_solver.exact.modular import primes, sylvester
from rpr_solver.exact.number_field import (
    Algebraic,
    Extension,
    Field,
    Polynomial,
    adjoin_real_roots,
    poly_gcd,
    poly_mod,
    poly_product,
    poly_sum,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import RealRoot, real_roots
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.joint_points import ExactPose, PoseKind, classify, place, poses_at, same_angle
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.transitions.event_systems import (
    BallPose,
    Coordinates,
    Event,
    Landmark,
    NotGeneric,
    System,
)

_MOST_PRIMES = 200


def never_degenerate(permanent: System) -> bool:
    """Whether a prime proves it; False if none of many does."""
    for p, omega in islice(primes(permanent.slice_map.radicand, permanent.slice_map.rho), _MOST_PRIMES):
        poses = _poses(permanent, p, omega)
        if poses is not None:
            return all(_differ(permanent.slice_map, pose) for pose in poses)
    return False


Root = tuple[int, int]
"""A tangent modulo a prime as numerator and denominator, 1 and 0 for infinity."""


def _poses(permanent: System, p: int, omega: int) -> list[Pose[nmod_poly]] | None:
    """All permanent poses over 𝔽ₚ, with L as the variable; None if some are not over 𝔽ₚ."""
    eliminant = permanent.eliminant
    directions = _roots(eliminant.polynomial.residue(p, omega), eliminant.degree)
    poses = []
    for y, x in directions or ():
        v = nmod(y, p) if x else None
        first, second = (form.above(v, nmod(omega, p)) for form in (permanent.first, permanent.second))
        ts = _common_roots(first, second, p)
        if ts is None:
            return None
        poses += [_pose(t, (y, x), p, omega, permanent.slice_map.rho) for t in ts]
    return poses or None


def _roots(polynomial: nmod_poly, degree: int) -> list[Root] | None:
    """The roots of a form of this degree, each once; None if it is 0 or not all are over 𝔽ₚ."""
    if not polynomial:
        return None
    roots = polynomial.roots()
    if sum(multiplicity for _, multiplicity in roots) < polynomial.degree():
        return None
    at_infinity = [(1, 0)] if polynomial.degree() < degree else []
    return [*((int(root), 1) for root, _ in roots), *at_infinity]


def _common_roots(first: list[nmod], second: list[nmod], p: int) -> list[Root] | None:
    """The common roots of two forms; None if both are 0 or not all are over 𝔽ₚ."""
    common = nmod_poly(first, p).gcd(nmod_poly(second, p))
    return _roots(common, common.degree() + (not first[-1] and not second[-1]))


def _pose(t: Root, v: Root, p: int, omega: int, rho: int) -> Pose[nmod_poly]:
    n, d = t
    # −ρ is no square modulo p
    norm = pow(rho * n * n + d * d, -1, p)
    cos, sin = (d * d - rho * n * n) * norm, 2 * n * d * norm
    cos_alpha, sin_alpha, cos_theta, sin_theta, constant = (
        nmod_poly([x % p], p) for x in (cos, sin, v[1], v[0], omega)
    )
    return Pose(cos_alpha, sin_alpha, cos_theta, sin_theta, nmod_poly([0, 1], p), constant)


def _differ(slice_map: SliceMap, pose: Pose[nmod_poly]) -> bool:
    """Whether no L ≠ 0, and not ∞ either, makes a pose degenerate that is singular for every L.

    Where it does, ∇J = 0, or E and v·∇E vanish for both legs.
    """
    local = LocalMap.at(slice_map, pose, 3)
    j = local.singularity()
    along = [local.along(leg, j) for leg in (local.f, local.g)]
    second = [local.along(leg, e) for leg, e in zip((local.f, local.g), along, strict=True)]
    critical = [(j.alpha.value, 1), (j.theta.value, 1)]
    coalescent = [*((e.value, 2) for e in along), *((e.value, 3) for e in second)]
    return _coprime(critical) and _coprime(coalescent)


def _coprime(multiples: Sequence[tuple[nmod_poly, int]]) -> bool:
    """Whether forms in L of these degrees have no common root; they are given times L."""
    p = multiples[0][0].modulus()
    forms = [(multiple // nmod_poly([0, 1], p), degree) for multiple, degree in multiples]
    common = nmod_poly([], p)
    for form, _ in forms:
        common = common.gcd(form)
    return common.degree() == 0 and any(form.degree() == degree for form, degree in forms)


_APART_BITS = 512


def events_above(system: System, root: ExactRoot | None) -> Iterator[Event]:
    """The events among the common zeros of a system above one root v; None is v = ∞."""
    for pose in _with_lengths(system, root):
        yield from _event_in_direction(system.slice_map, pose)


@dataclass(frozen=True, eq=False)
class DirectedEvent:
    """An event at a pose in a number field, with a direction (x, y) that is not of length 1.

    Attributes:
        kind: of the pose.
        local: the pose, with x = ±1, or x = 0 and y = ±1, and with L > 0 over the length of the direction.
    """

    kind: PoseKind
    local: LocalMap[Algebraic]
    lasting: Literal[False] = False
    change: None = None

    @property
    def pose(self) -> BallPose:
        """The degenerate pose."""
        return BallPose(self.kind, self.coordinates, self.exact)

    @cached_property
    def square(self) -> Algebraic:
        """L² (scaled)."""
        pose = self.local.pose
        return pose.length * pose.length * _square(pose, self.local.slice_map.rho)

    @cached_property
    def exact_length(self) -> Algebraic:
        """L (scaled), in the field that it generates."""
        squares = minimal_polynomial(self.square).numer()
        factors = fmpz_poly([x for c in squares.coeffs() for x in (c, 0)]).factor()[1]
        roots = [root for factor, _ in factors for root in real_roots(QuadraticPoly.rational(factor))]

        def equal(bits: int) -> RealRoot | None:
            own = self.scaled_length(bits)
            near = [root for root in roots if root.refined(bits).overlaps(own)]
            return near[0] if len(near) == 1 else None

        root = decided(equal, _APART_BITS, GREATEST_BITS, "a length could not be placed in its field")
        return Field(root).generator

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""
        square = self.square.ball(bits)
        with ctx.workprec(bits):
            return square.sqrt()

    def coordinates(self, bits: int) -> Coordinates:
        """α and θ in degrees, exact at multiples of 90, and the free legs in the user's unit."""
        slice_map, p = self.local.slice_map, self.local.pose
        bridge = Bridge.of(slice_map)
        alpha = bridge.alpha_degrees(p.cos_alpha, p.sin_alpha, p.omega, bits)
        theta = bridge.theta_degrees(p.cos_theta, p.sin_theta, p.omega, bits)
        squares = (
            self.square + jet.value * 2 + p.omega.field(leg.platform2 + leg.base2)
            for leg, jet in ((slice_map.f, self.local.f), (slice_map.g, self.local.g))
        )
        balls = [square.ball(bits) for square in squares]
        with ctx.workprec(bits):
            first, second = (ball.sqrt() / slice_map.scale_ball() for ball in balls)
        return alpha, theta, first, second

    def is_at(self, other: DirectedEvent) -> bool:
        """Whether both poses have the same α and θ."""
        p, q = self.local.pose, other.local.pose
        return (
            same_number(p.cos_theta, q.cos_theta)
            and same_number(p.sin_theta, q.sin_theta)
            and same_angle((p.cos_alpha, p.sin_alpha), (q.cos_alpha, q.sin_alpha))
        )

    def exact(self) -> ExactPose:
        """The same pose with a direction of length 1, in a larger field."""
        [pose] = _upright(self.local.pose, self.local.slice_map.rho)
        return ExactPose.of(self.local.slice_map, pose)


def _event_in_direction(slice_map: SliceMap, pose: Pose[Algebraic]) -> Iterator[Event]:
    """The event at a pose with a direction of any length and an L of either sign.

    Where both legs have gradient 0, the pose is asked for exactly.
    """
    sign = pose.length.sign
    if not sign:
        return
    turned = replace(
        pose, cos_theta=pose.cos_theta * sign, sin_theta=pose.sin_theta * sign, length=pose.length * sign
    )
    # J and all its derivatives depend on the end of the fixed leg alone
    local = LocalMap.at(slice_map, turned, 4)
    kind = classify(local)
    if kind is PoseKind.QUADRUPLE:
        yield from (found for upright in _upright(pose, slice_map.rho) for found in event(slice_map, upright))
    elif kind not in (PoseKind.ORDINARY, PoseKind.CUSP):
        yield DirectedEvent(kind, local)


def located_poses(system: System, root: ExactRoot | None) -> Iterator[Pose[Algebraic]]:
    """The common zeros of a system above one root v, each with its L > 0."""
    for pose in _with_lengths(system, root):
        yield from _upright(pose, system.slice_map.rho)


def _with_lengths(system: System, root: ExactRoot | None) -> Iterator[Pose[Algebraic]]:
    """The same with directions that are not of length 1, and an L of either sign."""
    for pose in _common_poses(system, root):
        plus, minus = (_singularity(system.slice_map, pose, sign) for sign in (1, -1))
        j1 = plus + minus  # twice J1; plus − minus is twice J0
        if j1.is_zero:
            continue  # L is infinite, or undetermined at a pose that is singular for every L
        yield replace(pose, length=(minus - plus) * j1.inverse())


def permanent_events(permanent: System) -> Iterator[Event]:
    """The events at poses that are singular for every L (J0 = J1 = 0).

    Raises:
        NotGeneric: such a pose is degenerate for every L.
    """
    if never_degenerate(permanent):
        return
    for pose in _permanent_poses(permanent):
        for extension in _degenerate_lengths(permanent.slice_map, pose):
            if extension is None:
                raise NotGeneric
            located = replace(pose.mapped(extension.lift), length=extension.root)
            yield from _event_in_direction(permanent.slice_map, located)


def special_lengths(slice_map: SliceMap, pose: Pose[Algebraic]) -> Iterator[Landmark]:
    """The events at a pose that is singular for every L, also if it is degenerate for every L."""
    for extension in _degenerate_lengths(slice_map, pose):
        if extension is not None:
            yield from event_at(slice_map, pose, extension)


def event_at(slice_map: SliceMap, pose: Pose[Algebraic], length: Extension) -> Iterator[Landmark]:
    """The event at a pose for an L over its field, if this L > 0 and the pose is degenerate and no cusp."""
    if length.root.sign > 0:
        yield from event(slice_map, replace(pose.mapped(length.lift), length=length.root))


def _upright(pose: Pose[Algebraic], rho: int) -> Iterator[Pose[Algebraic]]:
    """The same pose with a direction of length 1 and L > 0; nothing if L is 0."""
    sign = pose.length.sign
    if not sign:
        return
    field, square = pose.omega.field, _square(pose, rho)
    [root] = (x for x in adjoin_real_roots(field, [-square, field(0), field(1)]) if x.root.sign > 0)
    lifted, scale = pose.mapped(root.lift), root.root
    inverse = scale * root.lift(square.inverse() * sign)
    yield replace(
        lifted,
        cos_theta=lifted.cos_theta * inverse,
        sin_theta=lifted.sin_theta * inverse,
        length=lifted.length * scale * sign,
    )


def _square(pose: Pose[Algebraic], rho: int) -> Algebraic:
    """The squared length of the direction of the fixed leg."""
    x, y = pose.cos_theta, pose.sin_theta
    return x * x + y * y * rho


def permanent_limits(permanent: System, leg: Leg, square: Fraction) -> Iterator[Algebraic]:
    """The L > 0 at which a cusp passes a pose that is singular for every L, with leg² = square there.

    There are hardly ever any; mostly balls prove that there are none.
    """
    for in_length in _in_lengths(permanent):
        yield from _limits(permanent.slice_map, in_length, leg, square)


def limits_at(slice_map: SliceMap, pose: Pose[Algebraic], leg: Leg, square: Fraction) -> Iterator[Algebraic]:
    """The L > 0 at which a pose that is singular for every L may be a cusp with leg² = square.

    Raises:
        NotGeneric: it is degenerate and has leg² = square for every L.
    """
    yield from _limits(slice_map, _coalescences(slice_map, pose), leg, square)


@dataclass(frozen=True, eq=False)
class _Coalescences:
    """A pose with its jets as polynomials in L, and E / L along either leg."""

    pose: Pose[Algebraic]
    local: LocalMap[Any]
    along: list[Polynomial]


@lru_cache(maxsize=2)
def _in_lengths(permanent: System) -> list[_Coalescences]:
    """Those of the permanent poses, for all limits."""
    return [_coalescences(permanent.slice_map, pose) for pose in _permanent_poses(permanent)]


def _coalescences(slice_map: SliceMap, pose: Pose[Algebraic]) -> _Coalescences:
    local, field = _in_length(slice_map, pose), pose.omega.field
    j, length = local.singularity(), [field(0), field(1)]
    along = [_without(local.along(leg, j).value.coefficients, length) for leg in (local.f, local.g)]
    return _Coalescences(pose, local, along)


def _limits(slice_map: SliceMap, at: _Coalescences, leg: Leg, square: Fraction) -> Iterator[Algebraic]:
    index, field = (slice_map.f, slice_map.g).index(leg), at.pose.omega.field
    # that of the direction counts: it need not be 1
    direction2 = _square(at.pose, slice_map.rho)
    gap = at.local.squared_lengths()[index] + _InLength(field, [field(-square), field(0), direction2 - 1])
    for e in at.along:
        if not _apart(e, gap.coefficients):
            common = poly_gcd(e, gap.coefficients)
            if not common:
                raise NotGeneric
            for extension in adjoin_real_roots(field, squarefree_part(common)):
                placed = replace(at.pose.mapped(extension.lift), length=extension.root)
                yield from (upright.length for upright in _upright(placed, slice_map.rho))


def _apart(p: Sequence[Algebraic], q: Sequence[Algebraic]) -> bool:
    """Proves by balls that two polynomials have no common root; False if they give no proof."""
    if len(p) == 1 or len(q) == 1:
        return True
    if not p or not q:
        return False
    balls = [[c.ball(_APART_BITS) for c in r] for r in (p, q)]
    with ctx.workprec(_APART_BITS):
        return not arb_mat(sylvester(balls[0], balls[1], arb(0))).det().contains(0)


def _permanent_poses(permanent: System) -> Iterator[Pose[Algebraic]]:
    for root in roots_of(permanent.eliminant):
        yield from _common_poses(permanent, root)


def event(slice_map: SliceMap, pose: Pose[Algebraic]) -> Iterator[Landmark]:
    """The event at a pose and its L, if it is degenerate and no cusp."""
    exact = ExactPose.of(slice_map, pose)
    if exact.kind not in (PoseKind.ORDINARY, PoseKind.CUSP):
        yield Landmark(exact.length, exact)


def _common_poses(system: System, root: ExactRoot | None) -> list[Pose[Algebraic]]:
    """The real poses above a root, with the direction (1, v); their length 1 is a placeholder."""
    v, omega = place(root, system.slice_map.radicand)
    x, y = (omega.field(0), omega.field(1)) if v is None else (omega.field(1), v)
    at_v = system.first.above(v, omega), system.second.above(v, omega)
    if (poses := poses_at(*at_v, x, y, omega.field(1), omega, system.slice_map.rho)) is None:
        raise NotGeneric
    return poses


def _singularity(slice_map: SliceMap, pose: Pose[Algebraic], length: int) -> Algebraic:
    at = replace(pose, length=pose.omega.field(length))
    return LocalMap.at(slice_map, at, 1).singularity().value


def _degenerate_lengths(slice_map: SliceMap, pose: Pose[Algebraic]) -> Iterator[Extension | None]:
    """The L at which a pose that is always singular is degenerate as well; None stands for every L."""
    field = pose.omega.field
    local = _in_length(slice_map, pose)
    j = local.singularity()
    conditions = [[j.alpha.value, j.theta.value]]
    for leg in (local.f, local.g):
        e = local.along(leg, j)
        conditions.append([e.value, local.along(leg, e).value])
    slopes = [poly_gcd(*(x.value.coefficients for x in (leg.alpha, leg.theta))) for leg in (local.f, local.g)]
    if not all(slopes):
        # one leg has gradient 0 for every L: only the other one gives conditions
        conditions = [conditions[0]] + [c for c, s in zip(conditions[1:], slopes, strict=True) if s]
        slopes = [s for s in slopes if s]
    factors: list[Polynomial] = []
    for vanishing, condition in zip([[], *slopes], conditions, strict=True):
        first, second = (x.coefficients for x in condition)
        for factor in ([field(0), field(1)], vanishing, *factors):
            first, second = _without(first, factor), _without(second, factor)
        common = poly_gcd(first, second)  # of degree 0 as a rule
        if not common:
            yield None
            continue
        factors.append(common)
        yield from adjoin_real_roots(field, squarefree_part(common))


def _in_length(slice_map: SliceMap, pose: Pose[Algebraic]) -> LocalMap[Any]:
    """The jets at a pose as polynomials in L."""
    field = pose.omega.field
    constant = pose.mapped(lambda x: _InLength(field, [x]))
    return LocalMap.at(slice_map, replace(constant, length=_InLength(field, [field(0), field(1)])), 3)


def _without(p: Polynomial, factor: Polynomial) -> Polynomial:
    """p divided by everything that it shares with a factor."""
    while p and factor and len(common := poly_gcd(p, factor)) > 1:
        p = poly_mod(p, common)[0]
    return p


@dataclass(frozen=True, eq=False)
class _InLength:
    """A polynomial in L over a number field: a ring for jets."""

    field: Field
    coefficients: Sequence[Algebraic]

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", trimmed(self.coefficients))

    def __add__(self, other: _InLength | int) -> _InLength:
        own = [self.field(other)] if isinstance(other, int) else other.coefficients
        return _InLength(self.field, poly_sum(self.coefficients, own))

    def __neg__(self) -> _InLength:
        return _InLength(self.field, [-x for x in self.coefficients])

    def __sub__(self, other: _InLength) -> _InLength:
        return self + -other

    def __mul__(self, other: _InLength | int) -> _InLength:
        if isinstance(other, int):
            return _InLength(self.field, [x * other for x in self.coefficients])
        return _InLength(self.field, poly_product(self.coefficients, other.coefficients))
