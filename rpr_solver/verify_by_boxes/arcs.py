"""Arcs of a path: Bézier curves in (α, θ, L), cut into pieces on which functions of the pose are bounded.

A piece over [0, 1] lies in the hull of its control points, and its derivative in that of n times their
differences. So a function F of the pose is within F(1/2) + F′(piece) [−1/2, 1/2] on it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from flint import arb

from rpr_solver.boxes import Balls, Box
from rpr_solver.verify_by_boxes.claims import OpenError
from rpr_solver.verify_by_boxes.equations import Jets, Lengths, Poses
from rpr_solver.verify_by_boxes.numbers import ball
from rpr_solver.verify_by_boxes.work import Work

Controls = Sequence[Box]
"""The control points of an arc: α and θ in radians, and the fixed length in units, as balls."""
Of = Callable[[Poses], Jets]
"""A function of the pose."""
_DEEPEST = 40
_AROUND = arb(0, 0.5)


@dataclass(frozen=True)
class Values:
    """A function on a piece: in the middle, everywhere, and its derivatives along the piece."""

    middle: arb
    whole: arb
    slope: arb


@dataclass(frozen=True)
class Piece:
    """A piece of an arc, over [0, 1].

    Attributes:
        space: poses of all lengths of the fixed leg.
        controls: its control points.
        work: what may be spent.
        is_first: whether it begins the path.
        is_last: whether it ends the path.
        depth: how often the arc was halved.
    """

    space: Lengths
    controls: Controls
    work: Work
    is_first: bool
    is_last: bool
    depth: int = 0

    @cached_property
    def halves(self) -> tuple[Piece, Piece]:
        """Both halves.

        Raises:
            OpenError: it is too small, or there is no work left.
        """
        if self.depth >= _DEEPEST:
            raise OpenError("it is not decided on pieces of the arcs that are very small")
        left, right, row = [], [], list(self.controls)
        while row:
            left.append(row[0])
            right.append(row[-1])
            row = [[(x + y) / 2 for x, y in zip(p, q, strict=True)] for p, q in pairwise(row)]
        depth = self.depth + 1
        return (
            Piece(self.space, left, self.work, self.is_first, is_last=False, depth=depth),
            Piece(self.space, right[::-1], self.work, is_first=False, is_last=self.is_last, depth=depth),
        )

    @cached_property
    def box(self) -> Box:
        """A box with all its points."""
        return [_hull(column) for column in zip(*self.controls, strict=True)]

    @cached_property
    def _speed(self) -> Box:
        """All its derivatives."""
        degree = len(self.controls) - 1
        steps = [[(y - x) * degree for x, y in zip(p, q, strict=True)] for p, q in pairwise(self.controls)]
        return [_hull(column) for column in zip(*steps, strict=True)]

    @cached_property
    def _wide(self) -> Poses:
        self.work.spend()
        return self.space.on(self.box, 1)

    @cached_property
    def _middle(self) -> Poses:
        return self.space.on(self.halves[0].controls[-1], 0)

    def values(self, of: Of) -> Values:
        """A function on it."""
        middle = of(self._middle).value
        gradient = of(self._wide).gradient
        slope = sum((x * v for x, v in zip(gradient, self._speed, strict=True)), arb(0))
        return Values(middle, middle + slope * _AROUND, slope)


def _hull(numbers: Iterable[arb]) -> arb:
    first, *others = numbers
    for x in others:
        first = first.union(x)
    return first


Holds = Callable[[Piece], bool | None]
"""Whether something holds on a piece; None if it is too wide to tell."""


def leaves(pieces: Iterable[Piece], holds: Holds) -> Iterator[tuple[Piece, bool]]:
    """Pieces of arcs on which something is known to hold, or not to, in order.

    Invariant: those that came, and those of ``todo`` from the last to the first, are the arc. It ends since
    pieces are halved so often only.

    Raises:
        OpenError: it is not decided.
    """
    for whole in pieces:
        todo = [whole]
        while todo:
            piece = todo.pop()
            found = holds(piece)
            if found is None:
                todo += reversed(piece.halves)
            else:
                yield piece, found


def everywhere(pieces: Iterable[Piece], holds: Holds) -> bool:
    """Whether something holds on all arcs."""
    return all(found for _, found in leaves(pieces, holds))


def point_at(controls: Controls, tau: Fraction) -> Box:
    """The point of an arc at a parameter, by de Casteljau's scheme."""
    first, second, row = ball(1 - tau), ball(tau), list(controls)
    while len(row) > 1:
        row = [[x * first + y * second for x, y in zip(p, q, strict=True)] for p, q in pairwise(row)]
    return row[0]


def along(controls: Controls, tau: Balls) -> tuple[list[Balls], list[Balls]]:
    """The points of an arc at many parameters, and the derivatives there, in doubles."""
    row = [[Balls.of([x]) for x in point] for point in controls]
    degree = len(row) - 1
    while len(row) > 2:
        row = [[p + (q - p) * tau for p, q in zip(*pair, strict=True)] for pair in pairwise(row)]
    steps = [q - p for p, q in zip(*row, strict=True)]
    return [p + step * tau for p, step in zip(row[0], steps, strict=True)], [x * float(degree) for x in steps]
