"""Boxes of FLINT's balls: what two share, their sizes, their halves."""

from __future__ import annotations

from flint import arb

from rpr_solver.boxes.systems import Box
from rpr_solver.errors import ControlFlow

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


def halves(box: Box) -> list[Box]:
    """Both halves of a box, cut across its widest side."""
    side = max(range(len(box)), key=lambda k: box[k].rad())
    middle, half = box[side].mid(), box[side].rad() / 2
    return [[*box[:side], arb(m, half), *box[side + 1 :]] for m in (middle - half, middle + half)]
