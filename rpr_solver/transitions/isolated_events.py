"""The events of a manipulator: each pose at which cusps of the slices meet, with its L, proved.

An event is a real common zero of one of the systems of event_systems.py with L = −J0/J1 > 0, or a pose
that is singular for every L and degenerate for some L. Simple ones are decided by balls; the others, and
poses that are always singular, exactly (exact_events.py).

The events are complete (mathematics.md#completeness-of-the-events). If all degenerate poses of a slice
are cusps, they are transversal zeros of (J, E) and continue to the neighbouring slices. Another one with
∇f ≠ 0 and J1 ≠ 0 satisfies M1 = M2 = 0 or C = W = 0. If J1 = 0, it is singular for every L (or L is
infinite). If ∇f = 0, it is singular for every L too, or leg f is closed and two poses coalesce
(mathematics.md#stationary-legs).

If C and W share an angle α, its poses are degenerate at their L and never cusps; C divided by the angle still
vanishes at all cusps, and a cusp can meet such a pose only where this quotient vanishes. If M1 and M2 share
an angle, L is constant along it. Both kinds of length are events without a pose (event_systems.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise
from math import lcm
from typing import Literal

from flint import arb, ctx, fmpz_poly

from rpr_solver.exact import decided, decided_or_none
from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.factors import ExactRoot, exact_counterparts, simple_and_other_roots
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.precision import EVENT_BITS, GREATEST_BITS
from rpr_solver.exact.quadratic import QuadraticPoly, omega_ball
from rpr_solver.exact.real_roots import RealRoot, real_roots
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.jets import HalfTangent, LocalMap, common_root, pose_of, singular_length
from rpr_solver.model.joint_points import ExactPose, PoseKind
from rpr_solver.model.slice_map import Leg
from rpr_solver.transitions.event_systems import (
    BallPose,
    Coordinates,
    Event,
    EventSystems,
    Landmark,
    System,
    leg_form,
    limit_system,
)
from rpr_solver.transitions.exact_events import (
    events_above,
    located_poses,
    permanent_events,
    permanent_limits,
)
from rpr_solver.transitions.vanishing import level, vanishes

_START_BITS = 256
_LOST_BITS = 32
"""What an event may lack of the bits that are asked for."""
_SPARE_BITS = 64
"""With which a pose is computed beyond those that are asked for."""
Signs = tuple[PoseKind, arb]
"""The kind of an event, and a number whose sign is that of the change of the number of cusps."""
Namer = Callable[[LocalMap[arb], LocalMap[arb]], Signs | None]
"""The kind of an event from the jets at its pose, and at that of length −L; None if balls do not prove it."""


@dataclass(frozen=True)
class Located:
    """A pose in balls of about ``bits`` bits, with L > 0 (scaled)."""

    alpha: HalfTangent
    theta: HalfTangent
    length: arb
    bits: int


@dataclass(frozen=True)
class BallEvent:
    """An event above a simple root of an eliminant, refined on demand; without a kind only L is an answer."""

    system: System
    root: RealRoot
    kind: PoseKind | None
    change: int | None = None
    exact_length: None = None
    lasting: Literal[False] = False
    _known: list[Located] = field(default_factory=list, init=False, repr=False, compare=False)

    @property
    def pose(self) -> BallPose | None:
        """The degenerate pose, if the event has a kind."""
        return None if self.kind is None else BallPose(self.kind, self.coordinates, self.exact)

    def scaled_length(self, bits: int) -> arb:
        """L (scaled) as a ball."""
        return self._refined(bits).length

    def coordinates(self, bits: int) -> Coordinates:
        """α and θ in degrees, α = 0 exact where it can be, and the free legs in the user's unit."""
        place = self._refined(bits)
        with ctx.workprec(place.bits):
            squares = _local(self.system, place, 0).squared_lengths()
            scale = self.system.slice_map.scale_ball()
            angles = [self._angle(x.degrees(), k) for k, x in enumerate((place.alpha, place.theta))]
            f, g = (self._root(square, k) / scale for k, square in enumerate(squares))
            return angles[0], angles[1], f, g

    def _angle(self, degrees: arb, which: int) -> arb:
        """α or θ, exact if it is 0 or 180 degrees."""
        near = (degrees / 180).unique_fmpz()
        return degrees if near is None or not self._is_level[which]() else arb(180 * abs(int(near)))

    def _root(self, square: arb, which: int) -> arb:
        """The root of a squared leg, exact if it is 0."""
        return arb(0) if square.contains(0) and self._is_closed[which]() else square.sqrt()

    @cached_property
    def _is_level(self) -> tuple[Callable[[], bool], Callable[[], bool]]:
        """Whether α, and whether θ, is proved to be 0 or 180 degrees."""
        alpha, theta = level(self.system.slice_map)
        return cache(lambda: self.is_zero(alpha)), cache(lambda: self.is_zero(theta))

    @cached_property
    def _is_closed(self) -> tuple[Callable[[], bool], Callable[[], bool]]:
        """Whether either free leg is proved to have length 0."""
        slice_map = self.system.slice_map
        f, g = (leg_form(slice_map, leg, Fraction(0)) for leg in (slice_map.f, slice_map.g))
        return cache(lambda: self.is_zero(f)), cache(lambda: self.is_zero(g))

    def is_zero(self, form: BiForm) -> bool:
        """Whether a form in t and v is proved to be 0 at the pose."""
        return bool(vanishes(self.system, self.root, form))

    def direction(self, bits: int) -> arb:
        """θ in degrees, as in the coordinates."""
        place = self._refined(bits)
        with ctx.workprec(place.bits):
            return place.theta.degrees()

    def exact(self) -> ExactPose:
        """The same pose in a number field, for equalities that balls cannot prove, such as an angle of 0."""
        [root] = exact_counterparts([self.root], self.system.factors)
        [pose] = located_poses(self.system, root)
        return ExactPose.of(self.system.slice_map, pose)

    def _refined(self, bits: int) -> Located:
        """The pose with L to ``bits`` bits or nearly so; the best one is kept."""
        if not self._known or self._known[0].bits < bits:

            def accurate(more: int) -> Located | None:
                located = _located(self.system, self.root, more)
                if located is None or located.length.rel_accuracy_bits() < bits - _LOST_BITS:
                    return None
                return located

            message = "an event could not be located on its curve"
            located = decided(accurate, bits, GREATEST_BITS, message)
            self._known[:] = [located]
        return self._known[0]


def events(systems: EventSystems) -> Iterator[Event]:
    """All events with L > 0, in arbitrary order.

    Raises:
        NotGeneric: the events are not isolated.
    """
    permanent = systems.permanent
    yield from _system_events(systems.swallowtails, _swallowtail, permanent)
    yield from _system_events(systems.critical, _critical, permanent)
    for system in systems.near_shared_angles:
        yield from _system_events(system, None, permanent)
    yield from permanent_events(systems.permanent)
    for closing in stretched_closings(systems.slice_map.f):
        yield replace(closing, change=0)


def limit_events(systems: EventSystems, leg: Leg, square: Fraction) -> Iterator[Event]:
    """The lengths L > 0 at which a cusp has, or may have, the squared free leg ``square`` (scaled).

    Raises:
        NotGeneric: these lengths are not isolated.
    """
    closing = systems.permanent
    yield from _system_events(limit_system(systems, leg, square), None, closing)
    yield from map(Landmark, permanent_limits(systems.permanent, leg, square))


def stretched_closings(leg: Leg) -> Iterator[Landmark]:
    """The positive L with L = ±|a| ± |m|: a and m the base and platform sides between the legs."""
    yield from sums_of_lengths(Fraction(leg.base2), Fraction(leg.platform2))


def sums_of_lengths(first: Fraction, second: Fraction) -> Iterator[Landmark]:
    """The positive sums and differences of the roots of two squares."""
    d = lcm(first.denominator, second.denominator)
    a2, m2 = int(first * d), int(second * d)
    quartic = fmpz_poly([(a2 - m2) ** 2, 0, -2 * d * (a2 + m2), 0, d * d])
    for factor, _ in quartic.factor()[1]:
        yield from positive_roots(factor)


def positive_roots(factor: fmpz_poly) -> Iterator[Landmark]:
    """The positive roots of an irreducible polynomial as lengths (scaled)."""
    for root in real_roots(QuadraticPoly.rational(factor)):
        length = Field(root).generator
        if length.sign > 0:
            yield Landmark(length)


def _system_events(system: System, name: Namer | None, closing: System) -> Sequence[Event]:
    """The events of one system, with their kinds if ``name`` gives them, else their lengths alone.

    Where J0 or J1, the forms of ``closing``, is 0, L is 0 or infinite.

    Those of balls come first, and either ascend in θ: the order in which events of equal L are listed.
    """
    eliminant = system.eliminant.polynomial
    if simple_and_finite(eliminant, system.eliminant.degree):
        proved = [_prove(system, root, name) for root in real_roots(eliminant)]
        if None not in proved:
            return _ordered(filter(None, proved))
    simple, others = simple_and_other_roots(eliminant)
    by_balls, undecided = [], []
    for root in simple:
        if (event := _prove(system, root, name)) is not None:
            by_balls.append(event)
        elif not any(vanishes(system, root, form) for form in (closing.first, closing.second)):
            undecided.append(root)
    if undecided:
        others += exact_counterparts(undecided, system.factors)
    places: list[ExactRoot | None] = [*others]
    if system.eliminant.zeros_at_infinity:
        places.append(None)
    exact = [event for place in places for event in _exact_events(system, place, named=name is not None)]
    return [*_ordered(by_balls), *sorted(exact, key=_direction)]


def _ordered(found: Iterable[BallEvent]) -> list[BallEvent]:
    """The events in the order in which those of equal L are listed."""
    by_length = sorted(found, key=lambda event: event.scaled_length(_START_BITS).mid())
    balls = [event.scaled_length(_START_BITS) for event in by_length]
    if not any(low.overlaps(high) for low, high in pairwise(balls)):
        return by_length
    return sorted(by_length, key=_direction)


def _exact_events(system: System, root: ExactRoot | None, *, named: bool) -> Iterator[Event]:
    if named:
        yield from events_above(system, root)
    else:
        yield from (Landmark(pose.length) for pose in located_poses(system, root))


def _direction(event: Event) -> arb:
    """A middle of θ in degrees, −180 for 180; 0 if only the length is known."""
    if event.pose is None:
        return arb(0)
    if isinstance(event, BallEvent):
        theta = event.direction(_START_BITS)
    else:
        theta = event.pose.coordinates(_START_BITS)[1]
    return arb(-180) if theta == 180 else theta.mid()


def _prove(system: System, root: RealRoot, name: Namer | None) -> BallEvent | None:
    """The event above a simple root; None if balls do not decide it."""

    def event(bits: int) -> BallEvent | None:
        place = _located(system, root, bits)
        if place is None:
            return None
        kind = change = None
        if name is not None:
            with ctx.workprec(bits):
                order, other = _ORDERS[name]
                mirrored = _local(system, replace(place, length=-place.length), other)
                signs = name(_local(system, place, order), mirrored)
            if signs is None:
                return None
            kind, sign = signs
            change = None if sign.contains(0) else 2 if sign > 0 else -2
        found = BallEvent(system, root, kind, change)
        if place.length.rel_accuracy_bits() >= bits - _LOST_BITS:
            found._known.append(place)
        return found

    return decided_or_none(event, _START_BITS, EVENT_BITS)


def _located(system: System, root: RealRoot, bits: int) -> Located | None:
    """The pose above a root v = tan θ/√ρ; None if the precision is insufficient.

    At one of the directions θ and θ + π it has L > 0, unless L = 0, which no precision decides.
    """
    v, work = root.refined(bits), bits + _SPARE_BITS
    with ctx.workprec(work):
        first, second = ([row.ball(work)(v) for row in form.rows] for form in (system.first, system.second))
        t = common_root(first, second)
        if t is None:
            return None
        slice_map, omega = system.slice_map, omega_ball(system.slice_map.radicand, work)
        bridge = Bridge.of(slice_map)
        alpha, tip = bridge.alpha(t), bridge.vector(arb(1), v)
        # with the direction (1, v), which is longer than 1, L is as much shorter
        length = singular_length(slice_map, alpha.cos_sin(), tip, omega)
        if not length.is_finite() or length.contains(0):
            return None
        rho = slice_map.rho
        norm = (1 + rho * v * v).sqrt()
        theta = HalfTangent(v, norm + 1) if length > 0 else HalfTangent(norm + 1, -rho * v)
        return Located(alpha, bridge.theta(theta), abs(length) * norm, bits)


def _local(system: System, place: Located, order: int) -> LocalMap[arb]:
    omega = omega_ball(system.slice_map.radicand, place.bits)
    return LocalMap.at(system.slice_map, pose_of(place.alpha, place.theta, place.length, omega), order)


def _swallowtail(local: LocalMap[arb], mirrored: LocalMap[arb]) -> Signs | None:
    j = local.singularity()
    e = local.along(local.f, j)
    fourth = local.along(local.f, local.along(local.f, e)).value
    rank = not all(x.value.contains(0) for x in (local.f.alpha, local.f.theta))
    smooth = not all(x.value.contains(0) for x in (j.alpha, j.theta))
    if not rank or not smooth or fourth.contains(0):
        return None
    # 2L ∂J/∂L and 2L ∂v/∂L, as J/L and v are linear in L
    growth = j.joined(mirrored.singularity(), lambda x, y: 3 * x + y)
    swing = local.f - mirrored.f
    moved = local.along(local.f, growth).value + local.along(swing, j).value
    slopes = [(a.value, b.value) for a, b in zip(j.gradient, e.gradient, strict=True)]
    # 2L dE/dL on J = 0, times |∇J|²
    passed = moved * sum(a * a for a, _ in slopes) - growth.value * sum(a * b for a, b in slopes)
    return PoseKind.SWALLOWTAIL, -fourth * passed


def _critical(local: LocalMap[arb], mirrored: LocalMap[arb]) -> Signs | None:
    j = local.singularity()
    hessian = j.alpha.alpha.value * j.theta.theta.value - j.alpha.theta.value * j.alpha.theta.value
    third = local.along(local.f, local.along(local.f, j)).value
    if hessian.contains(0) or third.contains(0):
        return None
    growth = 3 * j.value + mirrored.singularity().value  # 2L ∂J/∂L
    return PoseKind.LIPS if hessian > 0 else PoseKind.BEAK_TO_BEAK, -hessian * third * growth


_ORDERS: Mapping[Namer, tuple[int, int]] = {_swallowtail: (4, 2), _critical: (3, 1)}
"""Of the jets that are wanted."""
