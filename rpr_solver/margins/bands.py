"""The lengths of a range in parts, for all geometries of a box: bounds of the numbers of cusps, what is open.

Poses of transitions are located for all geometries (located.py); where their lengths overlap, the order of
the transitions counts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import groupby, pairwise
from math import inf, log10, nextafter
from typing import Any, NamedTuple

import numpy as np

from rpr_solver.exact.decimals import rounded_down, rounded_up
from rpr_solver.exact.numerals import double
from rpr_solver.exact.turns import TURN
from rpr_solver.margins.expansions import ANGLES
from rpr_solver.margins.located import CRITICAL, SWALLOWTAILS, Located, Start, locate
from rpr_solver.margins.problems import GeometryBox, Problem
from rpr_solver.margins.zones import Zones
from rpr_solver.model.lengths import LengthRange

_DIGITS = 4
_LEAST_SIDE = Fraction(1, 2)
"""In tolerances: boxes with sides this short are not cut further."""
_REACHES = 8, 64
"""In tolerances: how far a transition that is not located is taken to move if its rate is not known, and the
reach, to first order, from which on its rate is not trusted."""

_NEAR = Fraction(1, 20)
"""Transitions within this share of their length of a range are located: their zones may extend into it."""

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
        """A span that contains this one, with ends of only a few digits more than its width needs."""
        if self.stop is None:
            return Span(rounded_down(self.start, _DIGITS), None)
        digits = _DIGITS
        if self.start < self.stop:
            digits = max(int(log10(self.stop / (self.stop - self.start))) + digits, digits)
        return Span(rounded_down(self.start, digits), rounded_up(self.stop, digits))


EVERYWHERE = Span(Fraction(0), None)


class OpenRange(NamedTuple):
    """Lengths for which something is not proved, and why."""

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


_End = Fraction | tuple[Transition, ...] | None
"""An end of a stretch of lengths: exact, or one of several transitions; None is an open end."""


def _spans(end: _End) -> list[Span]:
    """Where an end is, ascending."""
    if isinstance(end, tuple):
        return sorted((one.span for one in end), key=lambda span: span.start)
    return [Span(end or Fraction(0), end)]


def _greatest(stops: Iterable[Fraction | None]) -> Fraction | None:
    """The last of some upper ends; None if one is open."""
    found = list(stops)
    return None if None in found else max(x for x in found if x is not None)


class _Stretch(NamedTuple):
    """Lengths, and whether the numbers of cusps there are admitted, for every geometry."""

    start: _End
    stop: _End
    is_admitted: bool


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

    def windows(self, admits: Callable[[int], bool]) -> Iterator[Fraction | None]:
        """For each window that some geometry may have an upper bound of its width in the range, for all of
        them; None if there is none. All transitions that meet the range are to be located, none left.

        A window is a longest stretch of lengths with numbers that are not admitted. Its ends are those of the
        range, or transitions, of which it is known how they move together. Where their order is not known, a
        window is between the least and the greatest of their lengths.
        """
        for is_admitted, same in groupby(self._stretches(admits), key=lambda one: one.is_admitted):
            if not is_admitted:
                run = list(same)
                width = self._width(run[0].start, run[-1].stop)
                if width is None or width > 0:
                    yield width

    def _stretches(self, admits: Callable[[int], bool]) -> Iterator[_Stretch]:
        """The range, and a little more, in stretches that follow one another."""
        at: _End = self.span.start
        count = self._count(self.span.start, self.span.stop) if not self.groups else 0
        for group in self.groups:
            places = [self.transitions.index(one) for one in group.transitions]
            if group.is_ordered and all(one.is_whole for one in group.transitions):
                for place in places:
                    yield _Stretch(at, (self.transitions[place],), admits(self.counts[place]))
                    at = (self.transitions[place],)
            else:
                yield _Stretch(at, group.transitions, admits(self.counts[places[0]]))
                is_admitted = all(number is not None and admits(number) for number in self._bounds(group))
                yield _Stretch(group.transitions, group.transitions, is_admitted)
                at = group.transitions
            count = self.counts[places[-1] + 1]
        yield _Stretch(at, self.span.stop, admits(count))

    def _width(self, start: _End, stop: _End) -> Fraction | None:
        """An upper bound of the distance of two ends within the range, for all geometries."""
        whole = self._clipped(Span(_spans(start)[0].start, _greatest(x.stop for x in _spans(stop))))
        widths = [] if whole.stop is None else [whole.stop - whole.start]
        if isinstance(start, tuple) and isinstance(stop, tuple) and all(x.is_whole for x in (*start, *stop)):
            below, above = ([pose for one in end for pose in one.poses] for end in (start, stop))
            widths.append(max(a.farthest(b) for a in below for b in above))
        return min(widths, default=None)

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


def transitions_of(
    listed: Sequence[Mapping[str, Any]], box: GeometryBox, near: Span = EVERYWHERE
) -> list[Transition]:
    """Transitions of the middle geometry of a box, located for all its geometries.

    Args:
        listed: the transitions, as a census has them.
        box: the geometries.
        near: transitions that are far from these lengths are not located.
    """
    name = f"l{box.fixed_leg}"
    found: list[list[Located | None]] = [[None] * len(one["events"]) for one in listed]
    otherwise, most = (reach * box.radius * max(box.weights) for reach in _REACHES)
    widths = [Fraction(0) if one["events"] else otherwise for one in listed]
    groups: dict[Fraction, tuple[Problem, list[tuple[int, int]], list[Start]]] = {}
    for k, transition in enumerate(listed):
        length = Fraction(transition[name])
        if not Span(length * (1 - _NEAR) - most, length * (1 + _NEAR) + most).meets(near):
            continue
        [problem] = box.over(Fraction(0), 2 * length, {})
        _, places, starts = groups.setdefault(problem.unit, (problem, [], []))
        for place, event in enumerate(transition["events"]):
            places.append((k, place))
            angles = event["alpha_deg"], event[f"theta{box.fixed_leg}_deg"]
            starts.append(Start(event["kind"], *angles, transition[name]))
    for problem, places, starts in groups.values():
        for (k, place), (pose, reach) in zip(places, locate(problem, starts), strict=True):
            found[k][place] = pose
            widths[k] = max(widths[k], Fraction(reach) if reach < most else otherwise)
    lengths = (Fraction(transition[name]) for transition in listed)
    return [Transition.of(*one) for one in zip(lengths, found, widths, strict=True)]


def zones_of(
    problem: Problem,
    box: GeometryBox,
    transitions: Sequence[Transition],
    unknown: Sequence[Span] = (),
    *,
    goes_on: bool = False,
) -> Zones:
    """The zones of located poses, in a problem's unit, and all poses at lengths that stay open anyway."""
    every = [(pose.low, pose.high, pose.system) for one in transitions for pose in one.poses]
    low_turn, high_turn = (Fraction(-TURN),) * ANGLES, (Fraction(2 * TURN),) * ANGLES
    for start, stop in unknown:
        ends = (*low_turn, start), (*high_turn, stop or start)
        every += [(*ends, system) for system in (SWALLOWTAILS, CRITICAL)]
    low, high = (np.empty((ANGLES + 1, len(every))) for _ in range(2))
    for k, (below, above, _) in enumerate(every):
        low[:ANGLES, k], high[:ANGLES, k] = below[:ANGLES], above[:ANGLES]
        low[ANGLES, k], high[ANGLES, k] = _of_problem(problem, below[ANGLES], above[ANGLES])
    tests = np.array([system for _, _, system in every], dtype=np.int64)
    side = double(_LEAST_SIDE * box.radius * max(box.weights) / problem.unit)
    return Zones(low, high, tests, (side * TURN, side * TURN, side), goes_on)


def _of_problem(problem: Problem, low: Fraction, high: Fraction) -> tuple[float, float]:
    """Lengths as a problem has them, rounded inward."""
    a, b = low / problem.unit, high / problem.unit
    if problem.inverse:
        a, b = 1 / b, (1 / a if a > 0 else Fraction(2))
    return nextafter(double(a), inf), nextafter(double(b), -inf)
