"""Events that are known exactly: where one angle is, or both are, at permanent poses too, and in pairs.

At one angle α the pairs of event_lines.py are polynomials in v = tan θ.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

from rpr_solver.verify.core.intervals import Interval, ends_of
from rpr_solver.verify.core.krawczyk import Directions, enclosed
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.core.roots import Root, has_root, quotients
from rpr_solver.verify.core.schema import BESIDE
from rpr_solver.verify.core.surds import (
    ONE,
    ZERO,
    Indivisible,
    Poly,
    Ring,
    Surd,
    at_quotient,
    interpolated,
    negative,
    plus,
    radical,
    trimmed,
    without,
)
from rpr_solver.verify.core.system import Graded, Surface
from rpr_solver.verify.event_lines import EventEliminant, EventLine, EventSystem, event_eliminant, on_lines
from rpr_solver.verify.landmarks import Event, Landmark, Shape, distinct
from rpr_solver.verify.permanent import Field, Permanent, Vectors, conjugate, permanent_poses, plain

_DEGREE = 6
"""More than the degree in v of each form, at a constant α."""
_SPARE_BITS, _SIMPLE = 64, 1 << 24


def pair_at(surface: Surface, system: EventSystem, t: tuple[Surd, Surd]) -> tuple[Poly, Poly, Poly]:
    """Both forms of a system, and J1, at t = tan(α/2), a quotient; each but for a constant factor."""

    def rows(line: EventLine) -> list[tuple[Fraction, Fraction]]:
        p, q, (first, second) = line.pair(system)
        whole = (p, first), (q, second), (line.singular[1], Fraction(1))
        here = [(at_quotient(surface.ring, row, t), factor) for row, factor in whole]
        return [(factor * a, factor * b) for (a, b), factor in here]

    found = on_lines(surface, _DEGREE + 1, rows)
    first, second, permanent = (
        interpolated([*found], column) for column in zip(*found.values(), strict=True)
    )
    return first, second, permanent


def divided(surface: Surface, system: EventSystem) -> tuple[EventSystem, Poly] | None:
    """A system whose equations vanish at whole angles α, without these, and the form of these angles.

    None if the equations vanish at none, or share other factors.

    At an angle at which M1 = M2 = 0 there is no event; at one at which C = W = 0 there is none if J0 = 0 too,
    as then L = 0 (mathematics.md#shared-angles).
    """
    ring = surface.ring
    try:
        found = on_lines(surface, _DEGREE + 1, lambda line: (*line.pair(system)[:2], line.singular[0]))
    except Indivisible:
        return None
    columns = [*zip(*found.values(), strict=True)]
    if not all(any(any(map(any, row)) for row in column) for column in columns[:2]):
        return None
    (first, first_top), (second, second_top), (length, length_top) = (
        _content(ring, column) for column in columns
    )
    common, top = ring.gcd(first, second), bool(first_top and second_top)
    if len(common) == 1 and not top:
        return None
    if not system.is_critical and (without(ring, common, length) != (ONE,) or (top and not length_top)):
        return None
    shared = [
        ring.field_quotient(own, without(ring, own, common)) + (ZERO,) * (zeros if top else 0)
        for own, zeros in ((first, first_top), (second, second_top))
    ]
    (p, q, _), (a, b) = found[min(found)], (len(form) - 1 for form in shared)
    degree = 3 if system.is_critical else 4
    size = degree * (len(p) - 1 - a + len(q) - 1 - b)
    angles = radical(ring, common) + (ZERO,) * top
    return replace(system, degree=size, powers=(0, 0, 0), shared=(shared[0], shared[1])), angles


def beside(surface: Surface, system: EventSystem, angles: Poly) -> EventEliminant:
    """The eliminant of the first equation and the angles that were left out: at each of its zeros L = 0."""
    order = len(angles) - 1

    def value(line: EventLine) -> tuple[Fraction, Fraction]:
        p, _, (factor, _) = line.pair(system)
        a, b = surface.ring.resultant(p, angles)
        return factor**order * a, factor**order * b

    return event_eliminant(surface, replace(system, name=BESIDE, degree=4 * order), value=value)


def _content(ring: Ring, rows: Sequence[Poly]) -> tuple[Poly, int]:
    """The common divisor of forms in t, and how often t = ∞ is a root of all."""
    common: Poly = ()
    for row in rows:
        common = ring.gcd(common, trimmed(row)) if common else trimmed(row)
    return common or (ONE,), min(len(row) - len(trimmed(row)) for row in rows)


def without_length(surface: Surface, system: EventSystem) -> Poly:
    """The product of v − v₀ over common zeros of a pair at angles α at which J0 = 0 for every θ.

    Each pose of such an angle that is not permanent has the length 0. If |a| = |m|, leg f is closed with
    L = 0 at m z = a, whatever θ is, so J0 = 0 there, and likewise for leg g; others are looked for among the
    factors of J0.
    """
    ring = surface.ring
    product: Poly = (ONE,)
    for t in _without_any_length(surface):
        first, second, permanent = pair_at(surface, system, t)
        common = ring.gcd(first, second) if first and second else first or second or (ONE,)
        product = ring.product(product, without(ring, common, permanent))
    return product


def _without_any_length(surface: Surface) -> list[tuple[Surd, Surd]]:
    """Quotients tan(α/2) at which J0 = 0 for every θ."""
    ring, v = surface.ring, Vectors.of(surface)
    rest, top = _content(ring, [EventLine.of(surface, k).singular[0] for k in range(_DEGREE)])
    found = [(ONE, ZERO)] if top else []
    for ground, platform in ((v.a, v.m), (v.b, v.n)):
        turned, size = v.times(ground, conjugate(platform)), v.times(platform, conjugate(platform))[0]
        t = turned[1], plus(size, turned[0])
        # at m z = a = -m, where t is infinite, both are 0
        if v.times(ground, conjugate(ground))[0] != size or t[1] == ZERO:
            continue
        if len(left := without(ring, rest, (negative(t[0]), t[1]))) < len(rest):
            rest, found = left, [*found, t]
    return [*found, (negative(rest[0]), rest[1])] if len(rest) == 2 else found


def is_level(surface: Surface, system: EventSystem, event: Event, part: Poly, root: Root) -> bool:
    """Whether α is exactly 0 at the event above a simple root of an eliminant that is not known exactly.

    Above the root is one common zero with J1 ≠ 0, so it is that at α = 0, if there is one: J1 ≠ 0 in the box.
    """
    if not event.pose[0].contains(0):
        return False
    forms = pair_at(surface, system, (ZERO, ONE))[:2]
    padded = [form + (ZERO,) * (len(part) - len(form)) for form in forms]
    return bool(root.width) and all(has_root(surface.ring, part, root, form) for form in padded)


def exactly(event: Event, functions: Sequence[Graded]) -> Event:
    """The same event, with a name of its length if that and tan(α/2) and tan(θ/2) are simple fractions.

    Args:
        event: the only zero of some of the functions in its box.
        functions: those that vanish at it; all of them are to vanish at the fractions.
    """
    length, turns = _simple(event.scaled), []
    for (cos, sin), box in zip((event.directions.alpha, event.directions.theta), event.pose, strict=True):
        beside = Interval.of(1, cos.bits) + cos
        if not beside.sign or (t := _simple(sin.over(beside))) is None:
            return event
        turn = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
        fine = enclosed(tuple(Interval.of(x, cos.bits + _SPARE_BITS) for x in turn))  # type: ignore[arg-type]
        if not fine.inside(*ends_of(box)):
            return event
        turns.append(turn)
    if length is None or not event.scaled.contains(length):
        return event
    if not all(is_zero(p, turns, length) for p in functions):
        return event
    return replace(event, square=(length * length, Fraction(0)))


def _simple(x: Interval) -> Fraction | None:
    """A fraction with a small denominator in an interval."""
    near = x.middle.limit_denominator(_SIMPLE)
    return near if x.contains(near) else None


def is_zero(p: Graded, turns: Sequence[tuple[Fraction, Fraction]], length: Fraction) -> bool:
    """Whether a polynomial is 0 for these cosines and sines of α and θ, and this scaled length."""
    spend(sum(map(len, p)) * 20, max(x.denominator.bit_length() for x in (length, *turns[0], *turns[1])) * 8)
    (cos, sin), (along, across) = turns
    a = b = Fraction(0)
    for k, row in enumerate(p):
        for (i, j, m, n), (x, y) in row.items():
            factor = cos**i * sin**j * along**m * across**n * length**k
            a, b = a + x * factor, b + y * factor
    return not (a or b)


def on_shared_curve(shape: Shape, length: Fraction, bits: int) -> list[Event]:
    """The poses of the curve that congruent triangles share at which both gradients are 0.

    There are two if the triangles are flat, else none (mathematics.md#special-shapes).
    """
    surface, found = shape.surface, list[Event]()
    if shape.area or shape.ratio not in (1, -1):
        return found
    scaled, zero = length * surface.unit, Interval.of(0, bits)
    for cos in (1, -1):
        turns = [(shape.ratio, Fraction(0)), (Fraction(cos), Fraction(0))]
        zeros = {f"l{leg.number}" for leg in surface.legs if is_zero(leg.squared, turns, scaled)}
        zeros |= {"alpha_deg"} if shape.ratio > 0 else set()
        zeros |= {f"theta{surface.fixed}_deg"} if cos > 0 else set()
        alpha, theta = ((Interval.of(x, bits), zero) for x, _ in turns)
        here = Directions(alpha, theta, surface.ring.radicand)
        found.append(Event.at("higher", here, Landmark(Interval.of(scaled, bits)), zeros))
    return found


Near = Callable[[tuple[Interval, Interval], Fraction], Event | None]
"""Proves the event near angles in radians and a scaled length, if there is one."""


def landmarks_on(line: EventLine, system: EventSystem, bits: int, near: Near) -> dict[object, Landmark]:
    """The lengths of the events of a line that is known exactly, by names of their poses.

    Events themselves, where tan(α/2) is in ℚ(ω), too, and their kind is told (mathematics.md#exact-lines), or
    where they are proved in boxes.
    """
    common, at_infinity = line.common(system)
    angles = quotients(line.ring, (*common, ZERO) if at_infinity else common)
    if not common or angles is None:
        return {object(): _boxed(line, *pose, near) for pose in line.poses(system, bits)}
    found: dict[object, Landmark] = {}
    for n, d in angles:
        x, y, z = (line.ring.times(*pair) for pair in ((d, d), (n, n), (n, d)))
        turn = (plus(x, negative(y)), ZERO), (plus(z, z), ZERO), (plus(x, y), ZERO)
        pose = Permanent(Field(line.ring, ONE), turn, ((line.v.d, ZERO), (line.v.n, ZERO)))
        for length in pose.lengths([pose.in_length(line.surface.singular, 1)], bits):
            event = length.landmark if system.kinds == ("limit",) else length.event(line.surface)
            found[pose.name] = replace(event, beside=(0, 0)) if isinstance(event, Event) else event
    return found


def _boxed(line: EventLine, here: Directions, length: Interval, near: Near) -> Landmark:
    """The event at a zero of a system on a line, if it is the only one in a proved box; else its length."""
    pose = enclosed(here.alpha), enclosed(here.theta)
    event = near(pose, length.middle)
    if event is None:
        return Landmark(length)
    pairs = zip((*pose, length), (*event.pose, event.scaled), strict=True)
    zeros = set() if any(line.v.n) else {f"theta{line.surface.fixed}_deg"}
    alone = all(x.inside(*ends_of(box)) for x, box in pairs)
    return replace(event, zeros=frozenset(zeros)) if alone else Landmark(length)


def degenerate_lengths(surface: Surface, bits: int) -> list[Landmark]:
    """All lengths > 0 at which a pose that is singular for every length is degenerate and no cusp.

    Raises:
        Unclear: they are not isolated, or not told apart.
    """
    found: list[Landmark] = []
    for pose in permanent_poses(surface):
        own = [*pose.lengths([pose.in_length(p, 1) for p in surface.slopes], bits)]
        others = [pose.in_length(p, 1) for leg in surface.legs for p in (leg.kernel, leg.kernel2)]
        own += pose.lengths(others, bits)
        known = [(x.landmark.square, x.sign) for x in own]
        found += [x.event(surface) for n, x in enumerate(own) if not known[n][0] or known[n] not in known[:n]]
    return found


def lengths_at_limit(surface: Surface, squared: Graded, bits: int) -> list[Landmark]:
    """All lengths > 0 at which a pose that is singular for every length may be a cusp at a joint limit.

    Args:
        surface: the equations.
        squared: the squared length of a free leg, less that of its limit.
        bits: to which the lengths are needed.

    Raises:
        Unclear: they are not isolated, or not told apart.
    """
    found: list[Landmark] = []
    for pose in permanent_poses(surface):
        kernels = [pose.in_length(leg.kernel, 1) for leg in surface.legs]
        found += (x.landmark for x in pose.lengths([*kernels, pose.in_length(squared, 0)], bits))
    return distinct(found)


def in_pairs(surface: Surface, events: Sequence[Event], others: Sequence[Landmark]) -> list[Event]:
    """The events, those of isosceles triangles with a name of their length where two have the same one.

    If |a| = |b| and |m| = |n|, e ↦ u ē and z ↦ w z̄ with u = b/ā and w = n̄/(m u̅) exchange f and g, so they map
    events to events of the same length (mathematics.md#equal-lengths): to that whose box meets the image, if
    none of the ``others``, of which only the length is known, may be there.
    """
    v = Vectors.of(surface)
    sizes = [v.times(x, conjugate(x))[0] for x in (v.a, v.b, v.m, v.n)]
    if sizes[0] != sizes[1] or sizes[2] != sizes[3]:
        return list(events)
    ground = v.times(v.a, v.b)
    platform = v.times(ground, conjugate(v.times(v.m, v.n)))
    field = Field(v.ring, ONE)
    result = list(events)
    for n, event in enumerate(events):
        here, images = event.directions, []
        for (cos, sin), axis in ((here.alpha, platform), (here.theta, ground)):
            x, y = (field.interval(plain(part), cos.bits) for part in axis)
            size = (x * x + y * y).root()
            images.append(((x * cos + y * sin).over(size), (y * cos - x * sin).over(size)))
        near = [
            k
            for k, other in enumerate(events)
            if all(
                a.meets(b)
                for own, image in zip((other.directions.alpha, other.directions.theta), images, strict=True)
                for a, b in zip(own, image, strict=True)
            )
        ]
        alone = event.square is None and not any(event.scaled.meets(x.scaled) for x in others)
        if len(near) == 1 and near[0] != n and alone:
            name = events[near[0]].square or ("pair", *sorted((n, near[0])))
            result[n] = replace(event, square=name)
    return result
