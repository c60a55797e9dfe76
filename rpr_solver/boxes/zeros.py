"""Zeros of as many functions as variables, proved in boxes of FLINT's balls, and refined.

A box on which a function is nowhere 0, by the mean value theorem, has no zero. Krawczyk's operator maps all
zeros of a box into its image: if the image is apart from the box there is none, and if it is in the interior
there is exactly one, a regular one (Krawczyk 1969, Moore 1977; mathematics.md#zeros-in-boxes).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flint import arb, arb_mat, ctx

from rpr_solver.boxes.systems import Box, Functions, Undecided
from rpr_solver.errors import ControlFlow

_SPARE = 64
"""Bits of a computation with a box as wide as 1, and what precisions are multiples of."""
_MOST_SPARE = 64 * _SPARE
"""A zero for which more are needed is not refined."""
_MOST_BITS = 1 << 40
"""Those of an exact number."""


class Empty(ControlFlow):
    """A box has no zero."""


def common(box: Box, other: Box) -> Box:
    """What two boxes share.

    Raises:
        Empty: nothing.
    """
    if not all(x.overlaps(y) for x, y in zip(box, other, strict=True)):
        raise Empty
    return [x.intersection(y) for x, y in zip(box, other, strict=True)]


def contains(room: Box, box: Box) -> bool:
    """Whether a box is within another."""
    return all(r.contains(x) for r, x in zip(room, box, strict=True))


def bits_of(box: Box) -> int:
    """The greatest number with radii of at most 2^−bits."""
    return -max((exp + man.bit_length() for man, exp in (_parts(x) for x in box) if man), default=-_MOST_BITS)


def widest(box: Box) -> arb:
    """The greatest radius."""
    return max(x.rad() for x in box)


def _parts(x: arb) -> tuple[int, int]:
    man, exp = x.rad().man_exp()
    return int(man), int(exp)


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


@dataclass(frozen=True)
class Zero:
    """The only zero of as many functions as variables in ``room``, a regular one: it is in ``at``."""

    functions: Functions
    room: Box
    at: Box

    @classmethod
    def alone(cls, functions: Functions, room: Box) -> Zero:
        """That of a box.

        Raises:
            Empty: there is none.
            Undecided: Krawczyk's test does not tell.
        """
        at = Expansion.of(functions, room).image()
        shared = common(room, at)
        if not all(r.contains_interior(x) for r, x in zip(room, at, strict=True)):
            raise Undecided
        return cls(functions, room, shared)

    def within(self, bits: int, about: Box | None = None) -> Box:
        """A box of it with radii of at most 2^−``bits``, by Newton's steps in rising precision.

        They may begin at a box ``about`` it, which is to be a good guess: else it is not used. It ends
        since a step has 8 more bits than the one before, or the spare bits double, of which few are allowed.

        Raises:
            Undecided: it is not reached.
        """
        box, spare, expand = (about and self._part_of(about)) or self.at, _SPARE, Expansion.plain
        while spare <= _MOST_SPARE:
            known = bits_of(box)
            if known >= bits:
                return box
            with ctx.workprec(min(2 * max(known, 0), bits) + spare):
                box = common(box, expand(self.functions, box).image())
            if bits_of(box) < min(known + 8, bits):
                # the derivatives vary, as beside another zero, or rounding stands in the way
                expand, spare = Expansion.of, 2 * spare
        raise Undecided

    def _part_of(self, box: Box) -> Box | None:
        """The part of a box where it is, if Krawczyk's test proves that it is in the box."""
        if not contains(self.room, box):
            return None
        try:
            return Zero.alone(self.functions, box).at
        except (Empty, Undecided):
            return None


Turned = Callable[[Box, Box], Box]
"""A box, with whole turns added so that it is next to another."""


def turned(*angles: int) -> Turned:
    """Turns of 2π in the variables with these numbers; none, where no variable is an angle."""

    def moved(box: Box, other: Box) -> Box:
        turn, result = 2 * arb.pi(), list(box)
        for k in angles:
            result[k] = box[k] - turn * ((box[k] - other[k]).mid() / turn + 0.5).mid().floor()
        return result

    return moved


def is_same(first: Zero, second: Zero, moved: Turned) -> bool:
    """Whether two zeros are one, but for turns.

    Raises:
        Undecided: the one may be on the border of the other's room.
    """
    for bits in (0, 32, 64, 128, 256):
        with ctx.workprec(2 * (bits + _SPARE)):
            here = moved(first.within(bits), second.room)
            if contains(second.room, here):
                return True
            if not all(r.overlaps(x) for r, x in zip(second.room, here, strict=True)):
                return False
    raise Undecided


def halves(box: Box) -> list[Box]:
    """Both halves of a box, cut across its widest side."""
    side = max(range(len(box)), key=lambda k: box[k].rad())
    middle, half = box[side].mid(), box[side].rad() / 2
    return [[*box[:side], arb(m, half), *box[side + 1 :]] for m in (middle - half, middle + half)]
