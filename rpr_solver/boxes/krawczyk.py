"""Krawczyk's test, that a box has exactly one zero of as many functions as variables.

Krawczyk's operator maps all zeros of a box into its image: if the image is apart from the box there is none,
and if it is in the interior there is exactly one, a regular one (Krawczyk 1969, Moore 1977;
mathematics.md#zeros-in-boxes). :class:`Expansion` has it with balls.

:func:`contracts` is the same test by bounds, for functions that are about the identity: G(x) = x + N(x). Any
functions become so when they are multiplied by about the inverse of their derivative. For a box of radii ρ
round a point where |G| ≤ ``residues``, with |N′| ≤ ``slopes`` over the box, if

    residues + slopes ρ < ρ

in each row, x ↦ −N(x) maps the box into its interior and contracts it (mathematics.md#tubes).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from flint import arb, arb_mat

from rpr_solver.boxes.systems import Box, Functions, Undecided

Two: TypeAlias = tuple[arb, arb]
Slopes: TypeAlias = tuple[Two, Two]
"""Bounds of |N′|, by rows."""

_TRIALS = 3
"""Radii that are tried. With fewer, less is proved, and nothing wrong."""


@dataclass(frozen=True)
class Expansion:
    """Functions on a box, with their derivatives there in linear dependence on the point.

    The derivative of function i in variable k is in slopes[i][k] + Σₗ curves[l][i][k] · (xₗ − middleₗ) at
    each point x of the box. So linear combinations of functions may cancel before an absolute value is taken.
    """

    middle: Box
    steps: Box
    values: Sequence[arb]
    slopes: Sequence[Sequence[arb]]
    curves: Sequence[Sequence[Sequence[arb]]]

    @classmethod
    def of(cls, functions: Functions, box: Box) -> Expansion:
        """By the mean value theorem of the derivatives, from the middle."""
        middle = [x.mid() for x in box]
        steps = [x - m for x, m in zip(box, middle, strict=True)]
        here, whole = functions(middle, 1), functions(box, 2)
        curves = [[f.d(k).gradient for f in whole] for k in range(len(box))]
        return cls(middle, steps, [f.value for f in here], [f.gradient for f in here], curves)

    @classmethod
    def plain(cls, functions: Functions, box: Box) -> Expansion:
        """The derivatives on the whole box as they are, which is enough for a box about a zero."""
        middle = [x.mid() for x in box]
        steps = [x - m for x, m in zip(box, middle, strict=True)]
        values = [f.value for f in functions(middle, 0)]
        return cls(middle, steps, values, [f.gradient for f in functions(box, 1)], ())

    @property
    def excluded(self) -> bool:
        """Whether a function is nowhere 0 on the box: by Taylor's theorem of second order."""
        for i, value in enumerate(self.values):
            total = value
            for k, step in enumerate(self.steps):
                slope = self.slopes[i][k]
                for curve, other in zip(self.curves, self.steps, strict=False):
                    slope += curve[i][k] * other / 2
                total += slope * step
            if not total.contains(0):
                return True
        return False

    def image(self) -> Box:
        """The image of the box under Krawczyk's operator, x̂ − Y F(x̂) + (1 − Y F′) (x − x̂).

        The functions are as many as the variables, and Y is about the inverse of their derivative. All zeros
        of the box are in the image; if this is in the interior of the box, it has exactly one, a regular one.

        Raises:
            Undecided: the derivative is about singular.
        """
        count = range(len(self.middle))
        slopes = arb_mat([list(row) for row in self.slopes])
        try:
            about = arb_mat([[slopes[i, k].mid() for k in count] for i in count]).inv()
        except ZeroDivisionError:
            raise Undecided from None
        inverse = arb_mat([[about[i, k].mid() for k in count] for i in count])
        rest = arb_mat([[int(i == k) for k in count] for i in count]) - inverse * slopes
        for curve, step in zip(self.curves, self.steps, strict=False):
            rest -= inverse * arb_mat([list(row) for row in curve]) * step
        moved = rest * arb_mat([[x] for x in self.steps]) - inverse * arb_mat([[x] for x in self.values])
        return [m + moved[i, 0] for i, m in enumerate(self.middle)]


def newton(functions: Functions, start: Box, steps: int) -> Box:
    """A point after some steps of Newton's method, of which nothing is proved.

    Raises:
        Undecided: a derivative on the way is about singular.
    """
    point = start
    for _ in range(steps):
        found = functions(point, 1)
        slopes = arb_mat([[x.mid() for x in f.gradient] for f in found])
        try:
            moves = slopes.solve(arb_mat([[f.value.mid()] for f in found]))
        except ZeroDivisionError:
            raise Undecided from None
        point = [(x - moves[k, 0]).mid() for k, x in enumerate(point)]
    return point


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
