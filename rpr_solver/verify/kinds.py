"""The kind of a degenerate pose: what vanishes there is decided exactly, what does not by intervals.

The kinds are those of mathematics.md#kinds-of-degenerate-poses.
"""

from __future__ import annotations

from collections.abc import Callable

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, value
from rpr_solver.verify.core.system import Graded, Leg, Surface, slope

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
