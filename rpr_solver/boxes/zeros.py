"""Zeros of as many functions as variables, each known to be the only one of a room, and refined."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from flint import arb, ctx

from rpr_solver.boxes.box import Empty, bits_of, common, contains
from rpr_solver.boxes.krawczyk import Expansion
from rpr_solver.boxes.systems import Box, Functions, Undecided

_SPARE = 64
"""Bits of a computation with a box as wide as 1, and what precisions are multiples of."""
_MOST_SPARE = 64 * _SPARE
"""A zero for which more are needed is not refined."""


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
