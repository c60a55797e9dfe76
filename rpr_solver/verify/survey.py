"""A range of lengths in gaps between events: in all slices of a gap are as many cusps, and aspects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from flint import arb, ctx

from rpr_solver.verify.aspects import number_of_aspects
from rpr_solver.verify.claims import Open, settled
from rpr_solver.verify.equations import Mechanism, Slice
from rpr_solver.verify.events import (
    BEAK_TO_BEAK,
    LIPS,
    QUADRUPLE,
    Event,
    Exchange,
    Limit,
    all_of,
    decided,
    events_of,
)
from rpr_solver.verify.finding import cusps_of
from rpr_solver.verify.work import Work

_MORE = Fraction(1, 16)
"""How much wider a range is that is looked at, in relation to its ends."""
_BITS = (64, 128, 256, 512, 1024, 2048)
"""Bits after the point with which lengths are compared."""


@dataclass(frozen=True)
class Group:
    """All events of one length of the fixed leg, which lies between two rational ones, apart from others."""

    events: Sequence[Event]
    low: Fraction
    high: Fraction


@dataclass(frozen=True)
class Survey:
    """All events of a range, by length, and what is the same in all slices of a gap between them.

    Attributes:
        mechanism: the manipulator.
        start: the lower end of the range.
        stop: the upper end; None for infinity.
        limits: of the free legs: only cusps strictly within them count.
        work: what may be spent.
    """

    mechanism: Mechanism
    start: Fraction
    stop: Fraction | None
    limits: Sequence[Limit]
    work: Work

    @cached_property
    def _span(self) -> tuple[Fraction, Fraction | None]:
        """A wider range, so that gaps at the ends of this one are not narrow if it begins beside an event."""
        return self.start * (1 - _MORE), None if self.stop is None else self.stop * (1 + _MORE)

    @settled
    def _all_groups(self) -> Sequence[Group]:
        """The events of the wider range, those of one length together, ascending.

        Raises:
            Open: some are not isolated, or it is open whether two lengths are equal.
        """
        events = events_of(self.mechanism, *self._span, self.limits, self.work)
        marks = {self.start, self._span[0], *(x for x in (self.stop, self._span[1]) if x is not None)}
        for bits in _BITS:
            self.work.spend(len(events), bits)
            groups = self._grouped(events, bits)
            ends = [x for group in groups for x in (group.low, group.high)]
            # no mark is an end, or within a group
            apart = ends == sorted(set(ends)) and not any(
                group.low <= x <= group.high for group in groups for x in marks
            )
            if apart and all(self._are_equal(group.events) for group in groups):
                return groups
        raise Open("it is open whether two events have the same length")

    @cached_property
    def groups(self) -> Sequence[Group]:
        """The events of the range, those of one length together, ascending.

        Raises:
            Open: some are not isolated, or it is open whether two lengths are equal.
        """
        return [
            x for x in self._all_groups if x.low > self.start and (self.stop is None or x.high < self.stop)
        ]

    def _grouped(self, events: Sequence[Event], bits: int) -> Sequence[Group]:
        """The events in groups whose lengths overlap as balls."""
        with ctx.workprec(bits + 64):
            lengths = [(event.lengths(bits)[self.mechanism.fixed], event) for event in events]
            parts: list[list[tuple[arb, Event]]] = []
            for length, event in sorted(lengths, key=lambda pair: pair[0].mid()):
                if parts and any(length.overlaps(other) for other, _ in parts[-1]):
                    parts[-1].append((length, event))
                else:
                    parts.append([(length, event)])
            return [
                Group(
                    [event for _, event in part],
                    min(_rational(x.lower()) for x, _ in part),
                    max(_rational(x.upper()) for x, _ in part),
                )
                for part in parts
            ]

    def _are_equal(self, events: Sequence[Event]) -> bool:
        """Whether it is proved that events have one length: there is one, or two are images of each other."""
        exchange = Exchange(self.mechanism)
        return len(events) == 1 or (len(events) == 2 and exchange.takes(events[0], events[1]))

    @cached_property
    def gaps(self) -> Sequence[tuple[Fraction, Fraction | None]]:
        """The open intervals of lengths between events; the first and the last may exceed the range."""
        below = [group.high for group in self._all_groups if group.high <= self.start]
        above = [group.low for group in self._all_groups if self.stop is not None and group.low >= self.stop]
        lows = [below[-1] if below else self._span[0], *(group.high for group in self.groups)]
        highs = [*(group.low for group in self.groups), above[0] if above else self._span[1]]
        return list(zip(lows, highs, strict=True))

    def sample(self, first: int, last: int) -> Fraction:
        """A length in the widest of some neighbouring gaps, in relation to the length."""
        low, high = max(self.gaps[first : last + 1], key=_share)
        if high is None:
            return 2 * low if low else Fraction(2) ** self.mechanism.geometry.size
        # the multiple of a power of 2 next to the middle
        width = high - low
        step = Fraction(2) ** (width.numerator.bit_length() - width.denominator.bit_length() - 4)
        return (low + high) / 2 // step * step

    @settled
    def counts(self) -> Sequence[int]:
        """The number of cusps in all slices of each gap: that of one slice, and the changes at events.

        Raises:
            Open: one of them is not decided.
        """
        base = max(range(len(self.gaps)), key=lambda n: _share(self.gaps[n]))
        counts = [self._count(self.sample(base, base))]
        for group in self.groups[base:]:
            counts.append(counts[-1] + self._change(group))
        for group in reversed(self.groups[:base]):
            counts.insert(0, counts[0] - self._change(group))
        return counts

    def _change(self, group: Group) -> int:
        return sum(event.change(self.limits) for event in group.events)

    def _count(self, length: Fraction) -> int:
        found, own = cusps_of(self.mechanism, length, self.work), Slice(self.mechanism, length)
        if found.open:
            raise Open("a slice has degenerate poses, or nearly so")
        return sum(
            decided(lambda bits, x=zero: admitted(own, x.within(bits), self.limits))  # type: ignore[misc]
            for zero in found.zeros
        )

    def aspects(self, n: int) -> int:
        """The number of aspects of all slices of a gap.

        Raises:
            Open: it is not decided.
        """
        if self.mechanism.geometry.is_similar_pair:
            raise Open("J = 0 is not smooth in slices of similar triangles")
        # J = 0 is smooth in all slices but those of lips and beak-to-beaks
        first = last = n
        while first > 0 and not _parts_curves(self.groups[first - 1]):
            first -= 1
        while last < len(self.groups) and not _parts_curves(self.groups[last]):
            last += 1
        return self._aspects(first, last)

    def _aspects(self, first: int, last: int) -> int:
        known: dict[int, int] = self._numbers
        if first not in known:
            own = Slice(self.mechanism, self.sample(first, last))
            known[first] = sum(number_of_aspects([own], self.work).values())
        return known[first]

    @cached_property
    def _numbers(self) -> dict[int, int]:
        return {}


def admitted(own: Slice, box: list[arb], limits: Sequence[Limit]) -> bool | None:
    """Whether a pose of a slice keeps all limits strictly; None if that is open."""
    lengths = own.on(box, 0).lengths
    return all_of(x.admits(lengths) for x in limits)


def _parts_curves(group: Group) -> bool:
    """Whether the singular curve is not smooth at a length."""
    return any(event.kind in (LIPS, BEAK_TO_BEAK, QUADRUPLE) for event in group.events)


def _share(gap: tuple[Fraction, Fraction | None]) -> Fraction:
    """How wide a gap is in relation to its upper end."""
    low, high = gap
    return Fraction(1) if high is None else (high - low) / high


def _rational(x: arb) -> Fraction:
    """An exact ball."""
    man, exp = x.man_exp()
    return int(man) * Fraction(2) ** int(exp)
