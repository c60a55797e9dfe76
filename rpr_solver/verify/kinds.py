"""The kind of a degenerate pose: what vanishes there is decided exactly, what does not by intervals.

The kinds are those of mathematics.md#kinds-of-degenerate-poses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, direction, value
from rpr_solver.verify.core.roots import has_root, real_roots
from rpr_solver.verify.core.surds import ZERO, Poly, derivative, primitive
from rpr_solver.verify.core.system import Graded, Leg, Surface, System, at_length, in_half_tangent, slope
from rpr_solver.verify.landmarks import Event, Landmark

Vanishes = Callable[[Graded, int], bool]
"""Whether a polynomial is exactly 0, of degree k + 1 in θ in the k-th power of the length, or of degree k."""


class Unclear(Exception):  # noqa: N818 - a verdict, not a fault
    """Poses are not isolated, or degenerate for every length, or not told apart."""


def kind_of(surface: Surface, here: Directions, length: Interval, vanishes: Vanishes) -> str | None:
    """The kind of a pose with J = 0 that is degenerate and no cusp; None if it is not told.

    Raises:
        Unclear: something is 0 at one of two poses.
    """

    def at(p: Graded) -> Interval:
        return value(here, p, length)

    regular = [leg for leg in surface.legs if at(leg.alpha).sign or at(leg.theta).sign]
    if not regular:
        gradients = [p for leg in surface.legs for p in (leg.alpha, leg.theta)]
        if all(vanishes(p, 0) for p in gradients) and _independent(surface, at).sign:
            return "quadruple"
        return None
    if all(vanishes(p, 1) for p in surface.slopes):
        return _at_a_node(surface, regular[0], at, vanishes)
    if any(at(p).sign for p in surface.slopes):
        leg = regular[0]
        first, second = (at(slope(leg.kernel2, theta=theta)) for theta in (False, True))
        third = at(leg.alpha) * second - at(leg.theta) * first
        if third.sign and vanishes(leg.kernel, 1) and vanishes(leg.kernel2, 1):
            return "swallowtail"
    return None


def _at_a_node(
    surface: Surface, leg: Leg[Graded], at: Callable[[Graded], Interval], vanishes: Vanishes
) -> str | None:
    """The kind of a pose where J and its gradient vanish, by the Hessian of J."""
    (a, b), (c, d) = ([at(slope(p, theta=theta)) for theta in (False, True)] for p in surface.slopes)
    shape = (a * d - b * c).sign
    moving: Graded = ({}, surface.singular[1])
    doubtful = [p for p in (moving, leg.kernel2) if not at(p).sign]
    if not shape or (doubtful and not any(vanishes(p, 1) for p in doubtful)):
        return None
    if doubtful:
        return "isolated-point" if shape > 0 else "node"
    return "lips" if shape > 0 else "beak-to-beak"


def _independent(surface: Surface, at: Callable[[Graded], Interval]) -> Interval:
    """The resultant of both Hessians as quadratic forms: if it is not 0, they have no common zero."""
    rows = []
    for leg in surface.legs:
        first, mixed = (at(slope(leg.alpha, theta=theta)) for theta in (False, True))
        rows.append((first, mixed.scaled(2), at(slope(leg.theta, theta=True))))
    f, g = rows
    outer, low, high = (f[i] * g[k] - g[i] * f[k] for i, k in ((0, 2), (0, 1), (1, 2)))
    return outer * outer - low * high


def on_axis(system: System, cos: int, bits: int) -> Iterator[Event]:
    """The poses of a slice with α = 0 (``cos`` is 1) or 180° (−1) where J and its gradient are 0, exactly.

    They are the common roots of three polynomials in tan(θ/2).
    """
    surface, ring, scaled = system.surface, system.ring, system.length * system.surface.unit

    def here(p: Graded) -> Poly:
        turned = {(k, m, i, j): x for (i, j, k, m), x in at_length(p, scaled).items()}
        degree = max((i + j for i, j, _, _ in turned), default=0)
        return in_half_tangent(turned, degree, lambda power, odd: 0 if odd else cos**power)

    forms = [here(p) for p in (surface.singular, *surface.slopes)]
    common: Poly = ()
    for form in forms:
        common = ring.gcd(common, primitive(form)) if common else primitive(form)
    if not common:
        return
    once = ring.field_quotient(common, ring.gcd(common, derivative(common))) if len(common) > 1 else common
    if all(form[-1] == ZERO for form in forms):
        once += (ZERO,)
    one = Interval.of(cos, bits), Interval.of(0, bits)
    for root in real_roots(ring, once) if len(once) > 1 else ():
        pose = Directions(one, direction(ring, once, root, bits), ring.radicand)
        length = Interval.of(scaled, bits)
        kind = kind_of(surface, pose, length, lambda p, _, root=root: has_root(ring, once, root, here(p)))  # type: ignore[misc]
        zeros = {"alpha_deg"} if cos > 0 else set()
        if not (root.lower or root.upper or root.inverted):
            zeros.add(f"theta{surface.fixed}_deg")
        if kind is not None:
            yield Event.at(kind, pose, Landmark(length), zeros)
