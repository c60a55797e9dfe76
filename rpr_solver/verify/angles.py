"""The pairs of event_lines.py at one angle α, as polynomials in v = tan θ."""

from __future__ import annotations

from fractions import Fraction

from rpr_solver.verify.core.roots import Root, has_root
from rpr_solver.verify.core.surds import ONE, ZERO, Poly, Surd, at_quotient, interpolated, plus
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.event_lines import MOST_POINTS, EventLine, EventSystem
from rpr_solver.verify.landmarks import Event
from rpr_solver.verify.permanent import Vectors, conjugate

_DEGREE = 6
"""More than the degree in v of each form, at a constant α."""


def pair_at(surface: Surface, system: EventSystem, t: tuple[Surd, Surd]) -> tuple[Poly, Poly, Poly]:
    """Both forms of a system, and J1, at t = tan(α/2), a quotient; each but for a constant factor."""
    points: list[int] = []
    values: list[list[tuple[Fraction | int, Fraction | int]]] = []
    for k in range(MOST_POINTS):
        line = EventLine.of(surface, k)
        try:
            p, q, (first, second) = line.pair(system)
        except ZeroDivisionError:
            continue
        rows = (p, first), (q, second), (line.singular[1], 1)
        points.append(k)
        here = [(at_quotient(surface.ring, row, t), factor) for row, factor in rows]
        values.append([(factor * a, factor * b) for (a, b), factor in here])
        if len(points) > _DEGREE:
            break
    first_form, second_form, permanent = (
        interpolated(points, column) for column in zip(*values, strict=True)
    )
    return first_form, second_form, permanent


def without_length(surface: Surface, system: EventSystem) -> Poly:
    """The product of v − v₀ over those common zeros of a pair at which a free leg closes with L = 0.

    If |a| = |m|, leg f is closed with L = 0 at m z = a, whatever θ is. There φ = J0 = 0, so each pose of this
    angle α that is not permanent has the length 0; and likewise for leg g.
    """
    ring, v = surface.ring, Vectors.of(surface)
    product: Poly = (ONE,)
    for ground, platform in ((v.a, v.m), (v.b, v.n)):
        turned, size = v.times(ground, conjugate(platform)), v.times(platform, conjugate(platform))[0]
        if v.times(ground, conjugate(ground))[0] != size:
            continue
        t = turned[1], plus(size, turned[0])
        first, second, permanent = pair_at(surface, system, (ONE, ZERO) if t[0] == t[1] == ZERO else t)
        common = ring.gcd(first, second) if first and second else first or second or (ONE,)
        while len(shared := ring.gcd(common, permanent)) > 1:
            common = ring.field_quotient(common, shared)
        product = ring.product(product, common)
    return product


def is_level(surface: Surface, system: EventSystem, event: Event, part: Poly, root: Root) -> bool:
    """Whether α is exactly 0 at the event above a simple root of an eliminant that is not known exactly.

    Above the root is one common zero with J1 ≠ 0, so it is that at α = 0, if there is one: J1 ≠ 0 in the box.
    """
    if not event.pose[0].contains(0):
        return False
    forms = pair_at(surface, system, (ZERO, ONE))[:2]
    padded = [form + (ZERO,) * (len(part) - len(form)) for form in forms]
    return bool(root.width) and all(has_root(surface.ring, part, root, form) for form in padded)
