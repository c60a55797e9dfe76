"""Krawczyk's test for two equations in two unknowns, and radii that pass it (mathematics.md#tubes).

For G(x) = x + N(x) and a box of radii ρ round a point where |G| ≤ ``residues``, if

    residues + |N′| ρ < ρ,        |N′| ≤ ``slopes`` over the box,

in both rows, then the box contains exactly one zero of G.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from flint import arb

Two: TypeAlias = tuple[arb, arb]
Slopes: TypeAlias = tuple[arb, arb, arb, arb]
"""Bounds of |N′|: of the first row, then of the second."""

_TRIALS = 3


def passes(residues: Two, slopes: Slopes, radii: Two) -> bool:
    """Whether radii pass the test."""
    (a, b, c, d), (p, q) = slopes, radii
    return bool(residues[0] + a * p + b * q < p and residues[1] + c * p + d * q < q)


def passing_radii(residues: Two, first: Two, slopes_over: Callable[[Two], Slopes]) -> tuple[Two | None, arb]:
    """Radii that pass the test, from a first trial; None if no trial passes.

    Also a sum of the bounds of the derivatives.
    """
    radii = first
    for _ in range(_TRIALS):
        a, b, c, d = slopes = slopes_over(radii)
        if passes(residues, slopes, radii):
            return radii, a + d
        # 3/2 times the radii that would just pass if the derivatives did not change
        det = (1 - a) * (1 - d) - b * c
        if not (a < 1 and det > 0):
            return None, a + b + c + d
        factor = arb(3) / (2 * det)
        radii = (
            (factor * ((1 - d) * residues[0] + b * residues[1])).abs_upper(),
            (factor * (c * residues[0] + (1 - a) * residues[1])).abs_upper(),
        )
    return None, a + d
