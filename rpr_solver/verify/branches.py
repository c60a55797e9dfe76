"""Cusp curves found anew: each cusp of a slice belongs to a branch, which begins and ends at events.

All events are known, and cusps are followed through slabs between slices, one at least between any two
events. A branch is an arc of a curve of cusps on which L ascends; it begins at an event, where another one
begins as well, or is there for all small lengths, and it ends likewise
(mathematics.md#curves-by-boxes).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

from rpr_solver.boxes import Zero
from rpr_solver.verify.claims import Open
from rpr_solver.verify.equations import LENGTH, Lengths
from rpr_solver.verify.events import QUADRUPLE, Event
from rpr_solver.verify.finding import cusps_of
from rpr_solver.verify.slabs import EVENT, HIGH, LOW, Slab
from rpr_solver.verify.survey import Survey

_MARK_BITS = 60


@dataclass(eq=False)
class Branch:
    """An arc of a curve of cusps.

    Attributes:
        cusps: the number of its cusp, among those found, by the lengths of the slices that it passes.
        begins: the event where it begins; None if it is there for all small lengths.
        ends: the event where it ends; None if it is there for all great lengths.
    """

    cusps: dict[Fraction, int] = field(default_factory=dict)
    begins: Event | None = None
    ends: Event | None = None


@dataclass(frozen=True)
class Branches:
    """All branches of a manipulator with one leg fixed.

    Attributes:
        slices: the cusps of each slice, by its length.
        all: the branches.
    """

    slices: Mapping[Fraction, Sequence[Zero]]
    all: Sequence[Branch]

    @classmethod
    def of(cls, survey: Survey, lengths: Iterable[Fraction]) -> Branches:
        """Those of a survey of all lengths, by slices of some lengths and one in each other gap.

        Raises:
            Open: events or cusps are not all known, or it is not decided which cusps are of one branch.
        """
        if any(event.kind == QUADRUPLE for group in survey.groups for event in group.events):
            raise Open("curves are not followed through a pose at which both free legs vanish")
        places = sorted({*lengths, *_samples(survey, lengths)})
        slices = {x: _cusps(survey, x) for x in places}
        branches = [Branch({places[0]: k}) for k in range(len(slices[places[0]]))]
        unit = Fraction(2) ** survey.mechanism.geometry.size
        spaces = [Lengths(survey.mechanism, beyond=beyond) for beyond in (False, True)]
        for low, high in pairwise(places):
            groups = [group for group in survey.groups if low < group.low and group.high < high]
            events = [event for group in groups for event in group.events]
            _followed(branches, survey, spaces[low >= unit], (low, high), slices, events)
        return cls(slices, branches)

    def at(self, length: Fraction, cusp: int) -> Branch:
        """That of a cusp of a slice."""
        return next(branch for branch in self.all if branch.cusps.get(length) == cusp)


def _samples(survey: Survey, lengths: Iterable[Fraction]) -> list[Fraction]:
    """A length in each gap that has none of some lengths, and the unit, if it is among them."""
    known, found = list(lengths), []
    for n, (low, high) in enumerate(survey.gaps):
        if not any(low < x and (high is None or x < high) for x in known):
            found.append(survey.sample(n, n))
    unit = Fraction(2) ** survey.mechanism.geometry.size
    return [*found, unit] if min(known + found) < unit < max(known + found) else found


def _cusps(survey: Survey, length: Fraction) -> Sequence[Zero]:
    """All cusps of a slice between events."""
    if not any(low < length and (high is None or length < high) for low, high in survey.gaps):
        raise Open("a slice is too near to an event")
    found = cusps_of(survey.mechanism, length, survey.work)
    if found.open:
        raise Open("a slice has degenerate poses, or nearly so")
    return found.zeros


def _followed(
    branches: list[Branch],
    survey: Survey,
    space: Lengths,
    ends: tuple[Fraction, Fraction],
    slices: Mapping[Fraction, Sequence[Zero]],
    events: Sequence[Event],
) -> None:
    """Follows all branches through a slab, and adds those that begin in it."""
    cusps = [[zero.within(_MARK_BITS) for zero in slices[length]] for length in ends]
    places = [
        [*x.zero.within(_MARK_BITS)[:LENGTH], x.lengths(_MARK_BITS)[survey.mechanism.fixed]] for x in events
    ]
    slab = Slab.of(space, ends, cusps)
    marks = slab.marks(cusps, places)
    low, high = ends
    strands = slab.strands(marks, survey.work)
    if sorted(name for strand in strands for name in strand) != sorted(mark.name for mark in marks):
        raise Open("not every cusp is followed")
    for strand in strands:
        below, above, turns = ([k for s, k in strand if s == side] for side in (LOW, HIGH, EVENT))
        own = [branch for branch in branches if branch.cusps.get(low) in below]
        match len(below), len(above), len(turns):
            case 1, 1, 0:
                own[0].cusps[high] = above[0]
            case 2, 0, 1:
                own[0].ends = own[1].ends = events[turns[0]]
            case 0, 2, 1:
                branches += [Branch({high: k}, begins=events[turns[0]]) for k in above]
            case _:
                raise Open("events of one length are not told apart")
