"""Boxes that cannot hold a common zero of functions, removed many at a time, in doubles.

Nothing is proved here but that a box has no zero, by the mean value theorem with bounds of all roundings
(mathematics.md#the-sieve). What is left is narrowed to where the zeros can be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from flint import arb

from rpr_solver.boxes.balls import EPS, Balls, padded
from rpr_solver.boxes.systems import Box, Functions, System

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.boxes.balls import Doubles, Truths

_BATCH = 4096
"""So many boxes at once keep the arrays in the processor's cache."""


@dataclass(frozen=True)
class Boxes:
    """Many boxes by their ends, arrays of shape (variables, boxes): all points between, the ends included."""

    low: Doubles
    high: Doubles

    @classmethod
    def of(cls, boxes: Sequence[Box]) -> Boxes:
        """Boxes of FLINT, each in one of doubles; an end that no double bounds is infinite."""
        low, high = (np.array(ends).T for ends in zip(*(Balls.of(box).ends() for box in boxes), strict=True))
        return cls(np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high))

    @classmethod
    def joined(cls, parts: Sequence[Boxes]) -> Boxes:
        """The boxes of several."""
        return cls(np.hstack([x.low for x in parts]), np.hstack([x.high for x in parts]))

    def __len__(self) -> int:
        return int(self.low.shape[1])

    @cached_property
    def middle(self) -> Doubles:
        """A point of each box, about its middle: the one at which functions are evaluated."""
        return np.clip(0.5 * self.low + 0.5 * self.high, self.low, self.high)

    @cached_property
    def radius(self) -> Doubles:
        """How far the ends are from the middles, at most."""
        return padded(np.maximum(self.high - self.middle, self.middle - self.low))

    def __getitem__(self, which: Truths | NDArray[np.intp] | slice) -> Boxes:
        return Boxes(self.low[:, which], self.high[:, which])

    def halved(self, sides: NDArray[np.intp] | None = None) -> Boxes:
        """Both halves of each box, cut across a side, else its widest; they share the number between them."""
        side = np.arange(len(self.low))[:, None] == (self.radius.argmax(0) if sides is None else sides)
        return Boxes.joined(
            [
                Boxes(self.low, np.where(side, self.middle, self.high)),
                Boxes(np.where(side, self.middle, self.low), self.high),
            ]
        )

    def balls(self) -> list[Box]:
        """The boxes for FLINT."""
        return [
            [arb(a).union(arb(b)) for a, b in zip(low, high, strict=True)]
            for low, high in zip(self.low.T.tolist(), self.high.T.tolist(), strict=True)
        ]


@dataclass(frozen=True)
class Expansion:
    """Functions on boxes: Fᵢ(x) is in valueᵢ + Σₖ slopeᵢₖ · (xₖ − middleₖ) for each point x of a box.

    The middles are those of ``boxes``, at which the values are. ``values`` has the shape (functions, boxes),
    ``slopes`` (functions, variables, boxes).
    """

    boxes: Boxes
    values: Balls
    slopes: Balls

    @classmethod
    def of(cls, functions: Functions, boxes: Boxes) -> Expansion:
        """By the mean value theorem: each slope is a mean of derivatives between the middle and x."""
        points = [Balls.exact(x) for x in boxes.middle]
        wholes = [Balls(x, r) for x, r in zip(boxes.middle, boxes.radius, strict=True)]
        values = [f.value for f in functions(points, 0)]
        slopes = [Balls.stacked(f.gradient) for f in functions(wholes, 1)]
        return cls(boxes, Balls.stacked(values), Balls.stacked(slopes))

    def __getitem__(self, which: Truths) -> Expansion:
        return Expansion(self.boxes[which], self.values[:, which], self.slopes[:, :, which])

    @cached_property
    def _reach(self) -> Doubles:
        """Bounds of |slopeᵢₖ · (xₖ − middleₖ)|."""
        return padded((abs(self.slopes.mid) + self.slopes.rad) * self.boxes.radius)

    @property
    def excluded(self) -> Truths:
        """Whether a function is nowhere 0 on a box."""
        whole = Balls(self.values.mid, padded(self.values.rad + self._reach.sum(1)))
        return np.logical_or.reduce(whole.excludes_zero)  # type: ignore[no-any-return]

    def combined(self) -> Expansion:
        """The functions, and as many linear combinations of them as variables, with slopes in about one each.

        Any combination is 0 where all functions are: how the multipliers are found decides nothing.
        """
        multipliers = Balls.exact(_multipliers(self.slopes.mid, self.boxes.radius))
        values = (multipliers * self.values[None]).sum(1)
        slopes = (multipliers[:, :, None] * self.slopes[None]).sum(1)
        return Expansion(self.boxes, Balls.joined([self.values, values]), Balls.joined([self.slopes, slopes]))

    def narrowed(self) -> tuple[Boxes, Truths]:
        """The parts of the boxes where the functions can all be 0, and which boxes have such a part."""
        count, radii = len(self.boxes.low), self.values.rad[:, None]
        total = self._reach.sum(1, keepdims=True)
        # Fᵢ(x) = 0 says xₖ = middleₖ − (valueᵢ + Σ_{l ≠ k} slopeᵢₗ (xₗ − middleₗ)) / slopeᵢₖ;
        # the sum without a term is the sum less the term, but for n + 1 roundings
        others = padded(radii + (total - self._reach) + (count + 1) * EPS * total)
        rest = Balls(np.broadcast_to(self.values.mid[:, None], others.shape), others)
        least, most = (Balls.exact(self.boxes.middle) - rest / self.slopes).ends()
        # fmax and fmin: an end that is no number says nothing
        low = np.fmax(self.boxes.low, np.fmax.reduce(least))
        high = np.fmin(self.boxes.high, np.fmin.reduce(most))
        return Boxes(low, high), np.all(low <= high, axis=0)


def _multipliers(slopes: Doubles, widths: Doubles) -> Doubles:
    """About a left inverse of each matrix of slopes, by least squares, with rows and columns of like size."""
    with np.errstate(all="ignore"):
        scaled = slopes * widths
        sizes = np.sqrt((scaled * scaled).sum(1, keepdims=True))
        rows = np.moveaxis(scaled / sizes, 2, 0)
        columns = rows.transpose(0, 2, 1)
        normal = columns @ rows + 2.0**-40 * np.eye(rows.shape[2])
        sound = np.isfinite(normal).all((1, 2), keepdims=True)
        inverse = np.linalg.inv(np.where(sound, normal, np.eye(rows.shape[2]))) @ columns
        result = np.moveaxis(inverse, 0, 2) * widths[:, None] / sizes[:, 0]
    return np.where(np.isfinite(result), result, 0.0)


@dataclass(frozen=True)
class Sieved:
    """What a sieve leaves.

    Attributes:
        boxes: they hold all zeros.
        looked: the number of boxes that were looked at.
        ended: whether all that are left are narrow; else it was given up.
    """

    boxes: Boxes
    looked: int
    ended: bool


def sieved(system: System, start: Boxes, narrow: float, most: int) -> Sieved:
    """The parts of some boxes where all functions can be 0, cut until they are narrow.

    All boxes are narrowed by each stage of the system, and those that did not become half as wide are cut
    across their widest side. A box is left when all its radii are below ``narrow``, and all are before more
    than ``most`` are looked at.

    Invariant: each zero in ``start`` is in a box of ``left`` or ``boxes``, as each box that is not excluded
    is in just one of those left, kept and cut. It ends since ``looked`` grows.

    Raises:
        ValueError: a box of ``start`` has an end that is not finite.
    """
    if not (np.isfinite(start.low).all() and np.isfinite(start.high).all()):
        raise ValueError("the sieve takes boxes with finite ends")
    boxes, left, looked = start, [], 0
    with np.errstate(all="ignore"):
        while len(boxes) and looked + len(boxes) <= most:
            looked += len(boxes)
            batches = [boxes[k : k + _BATCH] for k in range(0, len(boxes), _BATCH)]
            pairs = [_narrowed(system, batch) for batch in batches]
            boxes, before = Boxes.joined([x for x, _ in pairs]), np.concatenate([y for _, y in pairs])
            after = boxes.radius.max(0)
            small, slow = after < narrow, after > 0.5 * before
            wide, cut = ~small, ~small & slow
            left.append(boxes[small])
            boxes = Boxes.joined([boxes[wide & ~slow], boxes[cut].halved()])
    return Sieved(Boxes.joined([*left, boxes]), looked, not len(boxes))


def _narrowed(system: System, boxes: Boxes) -> tuple[Boxes, Doubles]:
    """The parts of boxes that all stages leave, each with the size of its box."""
    sizes = boxes.radius.max(0)
    for n, stage in enumerate(system.stages):
        if not len(boxes):
            break
        expansion = Expansion.of(stage, boxes)
        keep = ~expansion.excluded
        expansion, sizes = expansion[keep], sizes[keep]
        parts, some = (expansion.combined() if n == len(system.stages) - 1 else expansion).narrowed()
        boxes, sizes = parts[some], sizes[some]
    return boxes, sizes
