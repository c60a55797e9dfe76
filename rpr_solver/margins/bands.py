"""The lengths of a range in parts, for all geometries of a box: bounds of the numbers of cusps, what is open.

Poses of transitions are located for all geometries (located.py); where their lengths overlap, the order of
the transitions counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import log10
from typing import NamedTuple

from rpr_solver.margins.counterexamples import rounded_down, rounded_up
from rpr_solver.margins.located import Located
from rpr_solver.model.lengths import LengthRange

_DIGITS = 4

ORDER = "the order of the transitions is not the same, or not proved to be, for every geometry"
SINGULAR = "a transition is not proved to be a simple one, or not for every geometry"
OUTSIDE = "a transition beyond the end of the range may lie within it"
UNDECIDED = "whether there is another transition could not be decided"


class Span(NamedTuple):
    """Lengths of the fixed leg, in the user's unit; None is an open end."""

    start: Fraction
    stop: Fraction | None

    def meets(self, other: Span) -> bool:
        """Whether they have a length in common."""
        pairs = ((self, other), (other, self))
        return all(b.stop is None or a.start <= b.stop for a, b in pairs)

    def rounded(self) -> Span:
        """One of few more digits than its width asks for, which holds this."""
        if self.stop is None:
            return Span(rounded_down(self.start, _DIGITS), None)
        digits = _DIGITS
        if self.start < self.stop:
            digits = max(int(log10(self.stop / (self.stop - self.start))) + digits, digits)
        return Span(rounded_down(self.start, digits), rounded_up(self.stop, digits))


class OpenRange(NamedTuple):
    """Lengths about which not all is proved, and why."""

    span: Span
    reason: str


class Piece(NamedTuple):
    """Lengths, and the least and the greatest number of cusps of slices there, of all geometries.

    ``least`` and ``most`` are None where they are not known.
    """

    span: Span
    least: int | None
    most: int | None


class Transition(NamedTuple):
    """A transition of the given geometry.

    Attributes:
        length: as given.
        poses: those of its poses that are located.
        is_whole: whether these are all.
        span: where every geometry has them; if these are not all, lengths near by, which stay open.
    """

    length: Fraction
    poses: tuple[Located, ...]
    is_whole: bool
    span: Span

    @classmethod
    def of(cls, length: Fraction, poses: Sequence[Located | None], reach: Fraction) -> Transition:
        """The transition at a length with these poses, None for one that is not located.

        Args:
            length: that of the given geometry.
            poses: None for one that is not located.
            reach: how far it moves, nearly; used if some are not located.
        """
        known = tuple(pose for pose in poses if pose is not None)
        ends = [end for pose in known for end in pose.span]
        is_whole = 0 < len(known) == len(poses)
        if not is_whole:
            ends += [max(length - 2 * reach, Fraction(0)), length + 2 * reach]
        return cls(length, known, is_whole, Span(min(ends), max(ends)).rounded())

    def is_below(self, other: Transition) -> bool:
        """Whether each has one pose, and every geometry has this at a lesser length than the other."""
        return len(self.poses) == len(other.poses) == 1 and self.poses[0].is_below(other.poses[0])


def merged(spans: Sequence[Span]) -> list[Span]:
    """The union, ascending."""
    found: list[Span] = []
    for span in sorted(spans, key=lambda one: one.start):
        last = found.pop() if found and found[-1].meets(span) else span
        stop = None if last.stop is None or span.stop is None else max(last.stop, span.stop)
        found.append(Span(last.start, stop))
    return found


@dataclass(frozen=True)
class _Group:
    """Transitions whose lengths may coincide, or lengths at which there may be others."""

    span: Span
    transitions: tuple[Transition, ...]
    is_decided: bool

    @cached_property
    def is_ordered(self) -> bool:
        """Whether every geometry has the transitions in the same order."""
        single = all(len(one.poses) == 1 for one in self.transitions)
        return single and all(a.is_below(b) for a, b in pairwise(self.transitions))


@dataclass(frozen=True)
class Bands:
    """What is known of the lengths of a range.

    Attributes:
        span: the range.
        transitions: those of all lengths.
        left: where there may be others.
        counts: the numbers of cusps of the given geometry between transitions.
    """

    span: Span
    transitions: Sequence[Transition]
    left: Sequence[Span]
    counts: Sequence[int]

    def span_of(self, length: Fraction) -> Span | None:
        """Where every geometry has the transition of a length."""
        nearest = min(self.transitions, key=lambda one: abs(one.length - length))
        return nearest.span if nearest.is_whole else None

    @cached_property
    def groups(self) -> list[_Group]:
        """The lengths at which not all geometries have the same number of cusps, or may not."""
        spans = [one.span for one in self.transitions if one.span.meets(self.span)]
        return [
            _Group(
                whole,
                tuple(one for one in self.transitions if one.span.meets(whole)),
                not any(span.meets(whole) for span in self.left),
            )
            for whole in merged([*spans, *self.left])
        ]

    def pieces(self) -> Iterator[Piece]:
        """The range in parts."""
        at: Fraction | None = self.span.start
        for group in self.groups:
            start, stop = self._clipped(group.span)
            if at is not None and at < start:
                count = self._count(at, start)
                yield Piece(Span(at, start), count, count)
            yield Piece(Span(start, stop), *self._bounds(group))
            at = stop
        if at is not None and (self.span.stop is None or at < self.span.stop):
            count = self._count(at, self.span.stop)
            yield Piece(Span(at, self.span.stop), count, count)

    def open(self) -> Iterator[OpenRange]:
        """What is not proved."""
        for group in self.groups:
            inside = [one for one in group.transitions if one.length in LengthRange(*self.span)]
            reason = None
            if not group.is_decided:
                reason = UNDECIDED if all(one.is_whole for one in group.transitions) else SINGULAR
            elif len(inside) < len(group.transitions):
                reason = OUTSIDE
            elif not group.is_ordered:
                reason = ORDER
            if reason:
                yield OpenRange(self._clipped(group.span), reason)

    def _clipped(self, span: Span) -> Span:
        """Its part in the range."""
        stops = [stop for stop in (span.stop, self.span.stop) if stop is not None]
        return Span(max(span.start, self.span.start), min(stops) if stops else None)

    def _count(self, start: Fraction, stop: Fraction | None) -> int:
        """The number of cusps of the given geometry between two lengths without a transition between."""
        inside = start + 1 if stop is None else (start + stop) / 2
        return self.counts[sum(one.length < inside for one in self.transitions)]

    def _bounds(self, group: _Group) -> tuple[int | None, int | None]:
        """The least and the greatest number of cusps: each pose makes a difference of two, or none."""
        if not group.is_decided:
            return None, None
        first = self.transitions.index(group.transitions[0])
        counts = self.counts[first : first + len(group.transitions) + 1]
        if group.is_ordered:
            return min(counts), max(counts)
        steps = sum(len(one.poses) for one in group.transitions)
        ends = counts[0] + counts[-1]
        return max(ends // 2 - steps, 0), ends // 2 + steps
