"""The singular curves as chains of arcs: strands from node to node or closed, and connected components."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

from rpr_solver.singular.sweep import Meeting, Sweep

T = TypeVar("T", bound=Hashable)
Cell = tuple[int, int]
"""A line and the number of a meeting on it."""


class UnionFind(Generic[T]):
    """Classes of things that are joined pairwise."""

    def __init__(self, things: Iterable[T]) -> None:
        self._above = {thing: thing for thing in things}

    def root(self, thing: T) -> T:
        """The representative of a class."""
        above = self._above
        while above[thing] != thing:
            above[thing] = thing = above[above[thing]]
        return thing

    def join(self, first: T, second: T) -> None:
        """Makes one class of two."""
        self._above[self.root(second)] = self.root(first)

    def classes(self) -> list[list[T]]:
        """The classes, each in the order in which its things were given."""
        result: dict[T, list[T]] = {}
        for thing in self._above:
            result.setdefault(self.root(thing), []).append(thing)
        return list(result.values())


@dataclass(frozen=True)
class Step:
    """An arc of a slab as part of a strand; ``upwards`` if θ increases."""

    slab: int
    arc: int
    upwards: bool


@dataclass(frozen=True)
class Chain:
    """Arcs that continue each other, with J > 0 on their left in the (α, θ) plane.

    Attributes:
        steps: the arcs; none for an isolated point.
        cells: the meetings at its start, between its steps and at its end: one more than ``steps``, the
            last being the first if the chain is closed; none where there are no lines.
        closed: whether it is closed, without a node on it.
    """

    steps: tuple[Step, ...]
    cells: tuple[Cell, ...]
    closed: bool


def components(sweep: Sweep) -> list[list[Chain]]:
    """The connected components of J = 0, each as its strands; an isolated point is a strand without steps."""
    chains = list(_chains(sweep))
    joined = UnionFind(range(len(chains)))
    at: dict[Cell, int] = {}
    for number, chain in enumerate(chains):
        for cell in chain.cells:
            joined.join(at.setdefault(cell, number), number)
    return [[chains[k] for k in group] for group in joined.classes()]


def _chains(sweep: Sweep) -> Iterator[Chain]:
    if not sweep.lines:
        yield from (
            Chain((Step(0, arc, _upwards(sweep, 0, arc)),), (), True)
            for arc in range(len(sweep.slabs[0].arcs))
        )
        return
    walked: set[tuple[int, int]] = set()
    arcs = [(slab, arc) for slab, part in enumerate(sweep.slabs) for arc in range(len(part.arcs))]
    starts = sorted(arcs, key=lambda x: _continues(_meeting(sweep, _cells(sweep, *x)[0])))
    for slab, arc in starts:
        if (slab, arc) not in walked:
            yield _walked(sweep, slab, arc, walked)
    for line, part in enumerate(sweep.lines):
        for number, meeting in enumerate(part.meetings):
            if not meeting.left and not meeting.right:
                yield Chain((), ((line, number),), False)


def _walked(sweep: Sweep, slab: int, arc: int, walked: set[tuple[int, int]]) -> Chain:
    """The chain that leaves the first meeting of an arc, in the direction with J > 0 on its left."""
    first = cell = _cells(sweep, slab, arc)[0]
    steps, cells = [], [cell]
    while True:
        walked.add((slab, arc))
        _, cell = _cells(sweep, slab, arc)
        steps.append(Step(slab, arc, _upwards(sweep, slab, arc)))
        cells.append(cell)
        meeting = _meeting(sweep, cell)
        if not _continues(meeting):
            return Chain(tuple(steps), tuple(cells), False)
        here = (0 if steps[-1].upwards else 1, arc)
        [(side, arc)] = [end for end in _ends(meeting) if end != here]
        line = cell[0]
        slab = line if side else (line - 1) % len(sweep.slabs)
        if (slab, arc) in walked:
            return Chain(tuple(steps), tuple(cells), cell == first)


def _ends(meeting: Meeting) -> list[tuple[int, int]]:
    """(0, arc) for the arcs on the left, (1, arc) for those on the right."""
    return [*((0, arc) for arc in meeting.left), *((1, arc) for arc in meeting.right)]


def _continues(meeting: Meeting) -> bool:
    """Whether exactly two arcs meet, so that a strand goes on."""
    return len(meeting.left) + len(meeting.right) == 2


def _meeting(sweep: Sweep, cell: Cell) -> Meeting:
    return sweep.lines[cell[0]].meetings[cell[1]]


def _upwards(sweep: Sweep, slab: int, arc: int) -> bool:
    """Whether J > 0 before the arc, at smaller α."""
    return sweep.slabs[slab].signs[arc - 1] > 0


def _cells(sweep: Sweep, slab: int, arc: int) -> tuple[Cell, Cell]:
    """The meetings at the start and the end of an arc in its direction."""

    def cell(line: int, side: int) -> Cell:
        meetings = sweep.lines[line].meetings
        return line, next(k for k, m in enumerate(meetings) if arc in (m.left, m.right)[side])

    low, high = cell(slab, 1), cell(sweep.line_after(slab), 0)
    return (low, high) if _upwards(sweep, slab, arc) else (high, low)
