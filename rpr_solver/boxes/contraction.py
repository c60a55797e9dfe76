"""Krawczyk's test by bounds, for functions that are about the identity: G(x) = x + N(x).

Any functions become so when they are multiplied by about the inverse of their derivative. For a box of radii
ρ round a point where |G| ≤ ``residues``, with |N′| ≤ ``slopes`` over the box, if

    residues + slopes ρ < ρ

in each row, x ↦ −N(x) maps the box into its interior and contracts it: the box has exactly one zero of G
(mathematics.md#tubes). The operator of zeros.py is the same test, with balls in place of bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from flint import arb

Two: TypeAlias = tuple[arb, arb]
Slopes: TypeAlias = tuple[Two, Two]
"""Bounds of |N′|, by rows."""

_TRIALS = 3
"""Radii that are tried. With fewer, less is proved, and nothing wrong."""


def contracts(residues: Sequence[Any], slopes: Sequence[Sequence[Any]], radii: Sequence[Any]) -> Any:
    """Whether the test is passed: a truth for balls, an array of truths for arrays of doubles."""
    passed: Any = True
    for residue, row, radius in zip(residues, slopes, radii, strict=True):
        total = residue
        for slope, reach in zip(row, radii, strict=True):
            total = total + slope * reach
        passed = passed & (total < radius)
    return passed


def contracting_radii(
    residues: Two, first: Two, slopes_over: Callable[[Two], Slopes]
) -> tuple[Two | None, arb]:
    """Radii that pass the test, from a first trial; None if no trial passes.

    Also a sum of the bounds of the derivatives.
    """
    radii = first
    for _ in range(_TRIALS):
        (a, b), (c, d) = slopes = slopes_over(radii)
        if contracts(residues, slopes, radii):
            return radii, a + d
        # 3/2 times the radii that would just pass if the derivatives did not change:
        # (1 − slopes)⁻¹ residues
        det = (1 - a) * (1 - d) - b * c
        if not (a < 1 and det > 0):
            return None, a + b + c + d
        factor = arb(3) / (2 * det)
        radii = (
            (factor * ((1 - d) * residues[0] + b * residues[1])).abs_upper(),
            (factor * (c * residues[0] + (1 - a) * residues[1])).abs_upper(),
        )
    return None, a + d
