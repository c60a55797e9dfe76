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
from functools import lru_cache
from itertools import islice
from typing import Any

from flint import arb, arb_mat, ctx, nmod, nmod_poly

from rpr_solver.exact.factors import ExactRoot, roots_of
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
from rpr_solver.model.jets import LocalMap, Pose
from rpr_solver.model.joint_points import ExactPose, PoseKind, place, poses_at
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.transitions.event_systems import Landmark, NotGeneric, System

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


def events_above(system: System, root: ExactRoot | None) -> Iterator[Landmark]:
    """The events among the common zeros of a system above one root v; None is v = ∞."""
    for pose in located_poses(system, root):
        yield from event(system.slice_map, pose)


def located_poses(system: System, root: ExactRoot | None) -> Iterator[Pose[Algebraic]]:
    """The common zeros of a system above one root v, each with its L > 0."""
    for pose in _common_poses(system, root):
        plus, minus = (_singularity(system.slice_map, pose, sign) for sign in (1, -1))
        j1 = plus + minus  # twice J1; plus − minus is twice J0
        if j1.is_zero:
            continue  # L is infinite, or undetermined at a pose that is singular for every L
        length = (minus - plus) * j1.inverse()
        yield from _upright(replace(pose, length=length), system.slice_map.rho)


def permanent_events(permanent: System) -> Iterator[Landmark]:
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
            for upright in _upright(located, permanent.slice_map.rho):
                yield from event(permanent.slice_map, upright)


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
    x, y, field = pose.cos_theta, pose.sin_theta, pose.omega.field
    square = x * x + y * y * rho
    [root] = (x for x in adjoin_real_roots(field, [-square, field(0), field(1)]) if x.root.sign > 0)
    lifted, scale = pose.mapped(root.lift), root.root
    inverse = scale * root.lift(square.inverse() * sign)
    yield replace(
        lifted,
        cos_theta=lifted.cos_theta * inverse,
        sin_theta=lifted.sin_theta * inverse,
        length=lifted.length * scale * sign,
    )


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
    x, y = at.pose.cos_theta, at.pose.sin_theta
    direction2 = x * x + y * y * slice_map.rho
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
