"""Cusps followed from one length of the fixed leg to another, by boxes that hold all curves between.

The curves of J = E = 0 between two slices lie in the boxes that a sieve leaves, and no curve leaves boxes
that touch. Away from events a curve ascends in L and does not end, so it leads from a cusp of the lower slice
to one of the upper; at an event it turns back in L. So where boxes that touch hold one
cusp of either slice, and no event, these are of one curve; where they hold two cusps of one slice, none of
the other, and one event, both curves end there, and are one that turns back (mathematics.md#curves-by-boxes).
Otherwise parts of the slab are looked at.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import combinations
from math import hypot, log2, pi, remainder
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import arb

from rpr_solver.boxes import Balls, Box, Boxes, Functions, Jet, Undecided, sieved
from rpr_solver.verify.claims import Open
from rpr_solver.verify.components import components
from rpr_solver.verify.equations import Jets, Lengths, Slice
from rpr_solver.verify.finding import solved, torus
from rpr_solver.verify.numbers import ball
from rpr_solver.verify.systems import Coalescing
from rpr_solver.verify.work import Work

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Integers = NDArray[np.int64]

_PARTS, _NARROW, _LEAST = 16, 2.0**-6, 2.0**-60
"""The torus is cut in 16 by 16 boxes; boxes are left below a size, and a slab is below a share."""
_MOST, _MOST_LEFT, _BOXES_OF_A_UNIT = 200_000, 8000, 16
_CHUNK = 64
_NEAR = 2.0**-40
"""Boxes that are so near are taken to touch: it is more than all roundings of a turn."""
_ROUNDINGS = 2.0**-50
"""A bound, with room, of the relative error of two roundings."""
_MARK_BITS = 60
LOW, HIGH, EVENT = range(3)
Name = tuple[Fraction | int, int]
"""Of a pose on a curve: its side, or the length of a slice between, and its number there."""
_PLAIN = ((1, 1, 0), (2, 0, 1), (0, 2, 1))
"""So many cusps of the lower and the upper slice, and events, are of one curve: it passes, or turns."""


@dataclass(frozen=True)
class Mark:
    """A pose on a curve of cusps in a slab.

    Attributes:
        name: what it is called.
        side: whether it is a cusp of the lower slice, or of the upper one, or an event.
        box: α, θ, and u, its place between both slices.
    """

    name: Name
    side: int
    box: Box


@dataclass(frozen=True)
class Slab:
    """All poses with lengths of the fixed leg from one to another, by α, θ and u.

    Attributes:
        space: poses whose t is the length over the unit, or the unit over the length.
        first: t in the lower slice, where u = 0.
        last: t in the upper one; t and u vary evenly.
        top: u in the upper slice.
        narrow: the size of the boxes that are left.
        share: which part of a whole slab it is.
    """

    space: Lengths
    first: Fraction
    last: Fraction
    top: float
    narrow: float
    share: float = 1.0

    @classmethod
    def of(cls, space: Lengths, ends: tuple[Fraction, Fraction], cusps: Sequence[Sequence[Box]]) -> Slab:
        """That from one length to another, with the cusps of both slices."""
        unit = Fraction(2) ** space.mechanism.geometry.size
        first, last = (unit / x if space.beyond else x / unit for x in ends)
        travel, apart = _sizes([Mark((k, n), k, box) for k in (LOW, HIGH) for n, box in enumerate(cusps[k])])
        narrow = min(max(apart / 4, _NARROW / 4), 4 * _NARROW)
        return cls(space, first, last, min(max(4 * narrow, travel), 1.0), narrow)

    def marks(self, cusps: Sequence[Sequence[Box]], events: Sequence[Box]) -> list[Mark]:
        """The cusps of both slices, by α and θ, and the events between, by α, θ and L."""
        ends = (arb(0), arb(self.top))
        found = [Mark((k, n), k, [*box[:2], ends[k]]) for k in (LOW, HIGH) for n, box in enumerate(cusps[k])]
        return found + [Mark((EVENT, n), EVENT, [*x[:2], self._place(x[2])]) for n, x in enumerate(events)]

    @property
    def stages(self) -> Sequence[Functions]:
        """J, then E of both legs, on boxes of (α, θ, u)."""
        first, slope = ball(self.first), ball(self.last - self.first) / self.top
        return [partial(_inside, stage, first, slope) for stage in Coalescing(self.space, 1).stages]

    def square(self, box: Box) -> Functions:
        """There are fewer functions than variables."""
        raise Undecided(box)

    def _place(self, length: arb) -> arb:
        """u for a length."""
        unit = arb(2) ** self.space.mechanism.geometry.size
        t = unit / length if self.space.beyond else length / unit
        return (t - ball(self.first)) / ball(self.last - self.first) * self.top

    def strands(
        self, marks: Sequence[Mark], work: Work, within: Boxes | None = None
    ) -> list[frozenset[Name]]:
        """The names of the marks that are on one curve.

        Args:
            marks: all cusps of both slices and all events between, or those in ``within``.
            work: what may be spent.
            within: boxes that hold the curves that are looked for; all poses, if there are none.

        Raises:
            Open: it is not decided.
        """
        sieve = sieved(self, torus(_PARTS, (0.0, self.top)) if within is None else within, self.narrow, _MOST)
        boxes = sieve.boxes
        work.spend(1 + sieve.looked // _BOXES_OF_A_UNIT)
        if not sieve.ended or len(boxes) > _MOST_LEFT or self.share < _LEAST:
            raise Open("it is not decided which cusps are of one curve, as curves are very near")
        owner, groups = components(len(boxes), _touching(boxes, boxes)), defaultdict[int, list[Mark]](list)
        holders = _touching(Boxes.of([mark.box for mark in marks]), boxes)
        for n, group in sorted(set(zip(holders[0].tolist(), owner[holders[1]].tolist(), strict=True))):
            groups[group].append(marks[n])
        plain = {g for g, own in groups.items() if _is_plain(own)}
        found = [frozenset(mark.name for mark in groups[g]) for g in plain]
        unclear = [g for g in groups if g not in plain]
        if unclear:
            rest = [mark for g in unclear for mark in groups[g]]
            found += self._parted(rest, boxes[np.isin(owner, unclear)], work)
        return found

    def _parted(self, marks: Sequence[Mark], boxes: Boxes, work: Work) -> list[frozenset[Name]]:
        """The same, from what two parts of the slab say."""
        unit, cut = Fraction(2) ** self.space.mechanism.geometry.size, self._cut(marks)
        t, border = self.first + (self.last - self.first) * Fraction(cut), cut * self.top
        length = unit / t if self.space.beyond else unit * t
        across = boxes[(boxes.low[2] <= border) & (boxes.high[2] >= border)]
        system = Coalescing(Slice(self.space.mechanism, length), 1)
        cusps = solved(system, _squares(across, 4 * self.narrow), _MOST, work)
        if cusps.open:
            raise Open("it is not decided which cusps are between, as curves are very near")
        between = [((length, n), zero.within(_MARK_BITS)[:2]) for n, zero in enumerate(cusps.zeros)]
        found, held = [], 0
        for k, (first, last) in enumerate(((self.first, t), (t, self.last))):
            start, width = k * border, (1 - cut) if k else cut
            top = width * self.top
            own = [mark for mark in marks if mark.box[2] >= start and mark.box[2] <= start + top]
            held += len(own)
            own += [Mark(name, 1 - k, [*box, arb(border)]) for name, box in between]
            if not own:
                continue
            travel, apart = _sizes(own)
            narrow = min(self.narrow / 2, max(apart / 8, travel / 64))
            part = replace(
                self,
                first=first,
                last=last,
                top=min(max(4 * narrow, travel), 1.0),
                narrow=narrow,
                share=self.share * width,
            )
            # u of the part is (u − start) part.top / top
            low, high = ((x[2] - start) * (part.top / top) for x in (boxes.low, boxes.high))
            low, high = low - _ROUNDINGS * abs(low), high + _ROUNDINGS * abs(high)
            ours = (high >= 0) & (low <= part.top)
            low, high = np.maximum(low, 0), np.minimum(high, part.top)
            inside = Boxes(np.vstack([boxes.low[:2], low]), np.vstack([boxes.high[:2], high]))
            ends = {LOW: arb(0), HIGH: arb(part.top)}
            own = [
                Mark(x.name, x.side, [*x.box[:2], ends.get(x.side, (x.box[2] - start) * part.top / top)])
                for x in own
            ]
            found += part.strands(own, work, inside[ours])
        if held < len(marks):
            raise Open("it is not decided on which side of a slice between an event is")
        return joined(found, {name for name, _ in between})

    def _cut(self, marks: Iterable[Mark]) -> float:
        """Where the slab is cut: near an event that is near to its end, else in the middle."""
        places = [float(mark.box[2]) / self.top for mark in marks if mark.side == EVENT]
        low, high = min(places, default=0.5), 1 - max(places, default=0.5)
        near = 2.0 ** min(round(log2(max(min(low, high), _LEAST)) / 2), -1)
        return near if low <= high else 1 - near


def _sizes(marks: Sequence[Mark]) -> tuple[float, float]:
    """About how far cusps travel between two slices, and how far apart they are in one; powers of 2."""

    def distance(first: Mark, second: Mark) -> float:
        steps = (float((x - y).mid()) for x, y in zip(first.box[:2], second.box[:2], strict=True))
        return hypot(*(remainder(x, 2 * pi) for x in steps))

    apart = [distance(*pair) for pair in combinations(marks, 2) if pair[0].side == pair[1].side]
    travel = [min((distance(x, y) for y in marks if y.side != x.side), default=1.0) for x in marks]
    sizes = (min(max(x, 2.0**-60), 1.0) for x in (max(travel, default=1.0), min(apart, default=1.0)))
    first, second = (2.0 ** round(log2(x)) for x in sizes)
    return first, second


def joined(strands: Iterable[frozenset[Name]], shared: set[Name]) -> list[frozenset[Name]]:
    """Strands that share one of some names as one, without these names."""
    found: list[frozenset[Name]] = []
    for strand in strands:
        own = [other for other in found if other & strand & shared]
        found = [other for other in found if other not in own] + [strand.union(*own)]
    return [strand - shared for strand in found if strand - shared]


def _is_plain(marks: Sequence[Mark]) -> bool:
    sides = [mark.side for mark in marks]
    return tuple(map(sides.count, (LOW, HIGH, EVENT))) in _PLAIN


def _inside(functions: Functions, first: arb, slope: arb, box: Any, order: int) -> Sequence[Jets]:
    """Functions of (α, θ, t) as those of (α, θ, u), t being first + slope · u."""
    start, rate = Balls.of([first]), Balls.of([slope])
    found = functions([box[0], box[1], start + rate * box[2]], order)
    if not order:
        return found
    return [Jet(3, 1, [j.value, *j.gradient[:2], j.gradient[2] * rate]) for j in found]


def _squares(boxes: Boxes, size: float) -> Boxes:
    """The squares of a grid with the projections of boxes to α and θ, which are not wider than a square."""
    ends = [np.floor(x[:2] / size) for x in (boxes.low, boxes.high)]
    places = np.unique(np.hstack([[x[0], y[1]] for x in ends for y in ends]), axis=1)
    return Boxes(places * size, (places + 1) * size)


def _touching(first: Boxes, second: Boxes) -> Integers:
    """The pairs of boxes of both that touch, angles being equal that differ by turns; of shape (2, pairs)."""
    rows, columns = np.argsort(first.low[2]), np.argsort(second.low[2])
    first, second, pairs = first[rows], second[columns], [np.zeros((2, 0), np.int64)]
    widest = (second.high[2] - second.low[2]).max(initial=0) + 2 * _NEAR
    for start in range(0, len(first), _CHUNK):
        part = first[start : start + _CHUNK]
        # second boxes that begin before the last of these ends, and end after the first of them begins
        window = [part.low[2].min() - widest, part.high[2].max() + _NEAR]
        begin, end = np.searchsorted(second.low[2], window)
        near = second[begin:end]
        touch = np.ones((len(part), len(near)), bool)
        for k in range(3):
            low, high = part.low[k][:, None] - _NEAR, part.high[k][:, None] + _NEAR
            turns = (0.0, 2 * pi, -2 * pi) if k < 2 else (0.0,)
            touch &= np.any([(low + x <= near.high[k]) & (near.low[k] <= high + x) for x in turns], axis=0)
        found = np.nonzero(touch)
        pairs.append(np.array([rows[start + found[0]], columns[begin + found[1]]]))
    return np.hstack(pairs)
