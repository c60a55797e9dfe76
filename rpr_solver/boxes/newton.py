"""Interval Newton steps: from a point near a zero to a box that holds it alone, and to more of its digits.

For a point x̂ of a box X the image of X is x̂ − F′(X)⁻¹ F(x̂). All zeros of X are in it, and if it is in the
interior of X, X has exactly one, a regular one (mathematics.md#isolated-poses).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flint import arb, arb_mat, ctx

from rpr_solver.boxes.systems import Box

_STEPS = 12
"""Steps at one precision: from a third of the bits, say, each about doubles what is known."""
_SPARE = 32
"""The least radius of a room leaves so many bits of the precision for roundings."""

Step = Callable[[Box, Box], Box | None]
"""The image of a box, from a point of it; None if there is none, or it is not finite."""


def newton_image(point: Box, values: Sequence[arb], slopes: Sequence[Sequence[arb]]) -> Box | None:
    """The image of a box, from the values at a point of it and the slopes over it."""
    try:
        move = arb_mat([list(row) for row in slopes]).solve(arb_mat([[-x] for x in values]))
    except ZeroDivisionError:
        return None
    image = [x + move[k, 0] for k, x in enumerate(point)]
    return image if all(x.is_finite() for x in image) else None


@dataclass(frozen=True)
class Alone:
    """A box with one zero, and a smaller box of this zero."""

    room: Box
    at: Box


def alone_near(step: Step, start: Box, reach: Sequence[arb] | None = None) -> Alone | None:
    """The zero to which Newton's method leads; None without a proof, or if it goes farther than ``reach``."""
    first = point = [x.mid() for x in start]
    for _ in range(_STEPS):
        image = step(point, point)
        if image is None or (reach is not None and not _within(image, first, reach)):
            return None
        size, point = _distance(image, point), [x.mid() for x in image]
        if size < arb(2) ** -(ctx.prec // 3):
            break
    image = step(point, point)
    if image is None:
        return None
    radius = (2 * _distance(image, point)).max(arb(2) ** -(ctx.prec - _SPARE)).abs_upper()
    room = [arb(x, radius) for x in point]
    at = step(point, room)
    if at is None or not all(x.contains_interior(y) for x, y in zip(room, at, strict=True)):
        return None
    return Alone(room, at)


def narrowed(step: Step, box: Box, bits: int) -> Box:
    """A box of the same zero, with radii below 2^−``bits`` if the working precision is enough."""
    for _ in range(_STEPS):
        if all(x.rad() < arb(2) ** -bits for x in box):
            break
        image = step([x.mid() for x in box], box)
        if image is None:
            break
        new = [x.intersection(y) for x, y in zip(box, image, strict=True)]
        stuck = all(2 * y.rad() > x.rad() for x, y in zip(box, new, strict=True))
        box = new
        if stuck:
            break
    return box


def _within(box: Box, point: Box, reach: Sequence[arb]) -> bool:
    return all(abs(x - y) < r for x, y, r in zip(box, point, reach, strict=True))


def _distance(box: Box, point: Box) -> arb:
    """How far a box is from a point, at most."""
    first, *others = (abs(x - y) for x, y in zip(box, point, strict=True))
    for other in others:
        first = first.max(other)
    return first
