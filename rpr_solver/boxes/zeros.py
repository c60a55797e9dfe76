"""Branch and prune: all zeros of a system in some boxes, each proved to be alone in a box, by balls of FLINT.

A box on which a function is nowhere 0, by the mean value theorem, has no zero. Krawczyk's operator maps all
zeros of a box into its image: if the image is apart from the box there is none, and if it is in the interior
there is exactly one, a regular one (Krawczyk 1969, Moore 1977). Any other box is narrowed, or cut in two.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from flint import arb, arb_mat, ctx

from rpr_solver.boxes.systems import Box, Functions, System, Undecided

_SPARE = 64
"""Bits of a computation with a box as wide as 1, and what precisions are multiples of."""
_MOST_BITS = 1 << 40
"""Those of an exact number."""


class Empty(Exception):  # noqa: N818 - no error: a box is done
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


def _parts(x: arb) -> tuple[int, int]:
    man, exp = x.rad().man_exp()
    return int(man), int(exp)


@dataclass(frozen=True)
class Expansion:
    """Functions on a box: Fᵢ(x) is in valueᵢ + Σₖ slopeᵢₖ · (xₖ − middleₖ) for each point x of the box."""

    box: Box
    middle: Box
    values: Sequence[arb]
    slopes: Sequence[Sequence[arb]]

    @classmethod
    def of(cls, functions: Functions, box: Box) -> Expansion:
        """By the mean value theorem: values at the middle, derivatives on the whole box."""
        middle = [x.mid() for x in box]
        values = [f.value for f in functions(middle, 0)]
        return cls(box, middle, values, [f.gradient for f in functions(box, 1)])

    @property
    def excluded(self) -> bool:
        """Whether a function is nowhere 0 on the box."""
        steps = [x - m for x, m in zip(self.box, self.middle, strict=True)]
        return any(
            not sum((s * x for s, x in zip(row, steps, strict=True)), value).contains(0)
            for value, row in zip(self.values, self.slopes, strict=True)
        )

    def image(self) -> Box:
        """The image of the box under Krawczyk's operator, x̂ − Y F(x̂) + (1 − Y F′) (x − x̂).

        The functions are as many as the variables, and Y is about the inverse of their derivative. All zeros
        in the box are in the image; if this is in the interior of the box, there is exactly one, a regular one.

        Raises:
            Undecided: the derivative is about singular.
        """
        count = range(len(self.box))
        slopes = arb_mat([list(row) for row in self.slopes])
        try:
            about = arb_mat([[slopes[i, k].mid() for k in count] for i in count]).inv()
        except ZeroDivisionError:
            raise Undecided from None
        inverse = arb_mat([[about[i, k].mid() for k in count] for i in count])
        rest = arb_mat([[int(i == k) for k in count] for i in count]) - inverse * slopes
        steps = arb_mat([[x - m] for x, m in zip(self.box, self.middle, strict=True)])
        moved = rest * steps - inverse * arb_mat([[x] for x in self.values])
        return [m + moved[i, 0] for i, m in enumerate(self.middle)]


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

    def within(self, bits: int) -> Box:
        """A box of it with radii of at most 2^−``bits``, by Newton's steps in rising precision.

        Raises:
            Undecided: a few times as many bits are not enough.
        """
        box = self.at
        for step in range(8 + 2 * bits.bit_length()):
            if bits_of(box) >= bits:
                return box
            with ctx.workprec(min(_SPARE << (step // 2), 4 * (bits + _SPARE))):
                box = common(box, Expansion.of(self.functions, box).image())
        raise Undecided

    def near(self, box: Box) -> Box | None:
        """The part of a given box where it is, by one step from there; None if it is not in the box.

        Raises:
            Undecided: it may be in the box, or not.
        """
        if not contains(self.room, box):
            raise Undecided
        try:
            return Zero.alone(self.functions, box).at
        except Empty:
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


@dataclass
class Search:
    """All zeros of a system in some boxes: those that are proved, and boxes in which others may be.

    A proved zero may be a little outside of the boxes that were searched. ``looked`` is the number of boxes
    that were looked at.
    """

    zeros: list[Zero] = field(default_factory=list)
    doubts: list[Box] = field(default_factory=list)
    looked: int = 0


def search(
    system: System,
    start: Iterable[Box],
    least: float,
    most: int,
    moved: Turned | None = None,
    weights: Sequence[float] | None = None,
) -> Search:
    """Finds all zeros of a system in some boxes.

    Boxes are cut until each is known to have no zero or one, or is below ``least`` in all sides, or ``most``
    boxes have been looked at; what is undecided then is in doubt. ``moved`` says which zeros are one;
    the width of a side counts times its weight.

    Invariant: each zero in ``start`` is one of ``zeros``, or is in a box of ``todo`` or of ``doubts``. It ends
    since ``looked`` grows.
    """
    found, todo, moved = Search(), list(start), moved or turned()
    while todo:
        if found.looked >= most:
            found.doubts += todo
            break
        box = todo.pop()
        found.looked += 1
        with ctx.workprec(_SPARE * (1 + 3 * max(bits_of(box), 0) // _SPARE)):
            rest = _rest(system, box, found.zeros, moved)
            if rest is None:
                continue
            if max(x.rad() for x in rest) < least:
                found.doubts.append(rest)
            elif 2 * max(x.rad() for x in rest) < max(x.rad() for x in box):
                todo.append(rest)
            else:
                todo += halves(rest, weights or [1.0] * len(box))
    return found


def _rest(system: System, box: Box, zeros: list[Zero], moved: Turned) -> Box | None:
    """The part of a box where zeros may be that are not among those known; a zero that is proved is added."""
    if any(contains(zero.room, moved(box, zero.room)) for zero in zeros):
        return None
    room = [arb(x.mid(), 2 * x.rad()) for x in box]
    try:
        functions = system.square(room)
    except Undecided:
        return None if Expansion.of(system.stages[-1], box).excluded else box
    expansion = Expansion.of(functions, room)
    if expansion.excluded:
        return None
    try:
        at = expansion.image()
        part = common(box, at)
        if all(r.contains_interior(x) for r, x in zip(room, at, strict=True)):
            zero = Zero(functions, room, at)
            if not any(is_same(zero, other, moved) for other in zeros):
                zeros.append(zero)
            return None
    except Empty:
        return None
    except Undecided:
        return box
    return part


def halves(box: Box, weights: Sequence[float]) -> list[Box]:
    """Two halves of a box, across the side that is widest when widths count times weights."""
    side = max(range(len(box)), key=lambda k: box[k].rad() * weights[k])
    middle, half = box[side].mid(), box[side].rad() / 2
    return [[*box[:side], arb(m, half), *box[side + 1 :]] for m in (middle - half, middle + half)]
