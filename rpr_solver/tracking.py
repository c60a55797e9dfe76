"""Which cusp of a slice becomes which cusp of another: tubes from slice to slice, matched with whole tables.

A table lists every cusp of its slice. So a tube's box that is apart from all cusps of a table but one has
come to that one; nothing is decided by nearness.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import arb, ctx

from rpr_solver.cusps import SliceTable, solve_slice
from rpr_solver.eliminant import Eliminant
from rpr_solver.errors import SolverError
from rpr_solver.events import Event
from rpr_solver.following import CuspForms, Follower, LostError, Place
from rpr_solver.numbers import exact_str
from rpr_solver.poses import HalfTangent
from rpr_solver.survey import Progress, Survey

_TUBES_A_TURN = 16
_PATIENCE, _GREAT_PATIENCE = 512, 1 << 13
"""Tubes spent on one cusp: between slices chosen well, and wherever slices may lie."""
_FIRST_BITS, _MAX_BITS = 128, 1 << 13

Cusp = tuple[Fraction, int]
"""A cusp by the length of its slice and its place in the table, from 0."""


class Tracker:
    """The slices of one eliminant, with so many digits at least, and the ways of their cusps."""

    def __init__(self, eliminant: Eliminant, digits: int) -> None:
        self.eliminant, self.digits = eliminant, digits
        self._forms = CuspForms(eliminant.surface)
        self._tables: dict[tuple[Fraction, int], SliceTable] = {}

    def table(self, length: Fraction, digits: int = 0) -> SliceTable:
        """A slice, kept."""
        key = length, max(digits, self.digits)
        if key not in self._tables:
            self._tables[key] = solve_slice(self.eliminant, *key)
        return self._tables[key]

    def follower(self, cusp: Cusp, *, upwards: bool) -> Follower:
        """Sets out from a cusp to larger or to smaller lengths."""
        length, index = cusp

        def start(bits: int) -> Place:
            return self._places(length, bits)[index]

        return Follower(self._forms, start, self._scaled(length), upwards=upwards)

    def destinations(
        self,
        followers: Mapping[int, Follower],
        low: Fraction,
        high: Fraction,
        *,
        until_full: Fraction | None = None,
    ) -> dict[int, Cusp]:
        """To which cusp of two slices each follower comes first, without leaving the lengths between.

        Who does not come to either is missing. With ``until_full`` no more is done once all cusps of that
        slice are met, and much until then.
        """
        patience = _PATIENCE if until_full is None else _GREAT_PATIENCE
        met: dict[int, Cusp] = {}
        still_free = None if until_full is None else self.table(until_full).count
        waiting = deque((name, follower, 0) for name, follower in followers.items())
        ends = {self._scaled(length): length for length in (low, high)}
        scaled_low, scaled_high = ends
        while waiting and still_free != 0:
            name, follower, spent = waiting.popleft()
            try:
                found = follower.walk(scaled_low, scaled_high, _TUBES_A_TURN)
            except LostError:
                continue
            if found is not None:
                length = ends[found[0]]
                met[name] = length, self._index(found[1], length)
                if still_free is not None and length == until_full:
                    still_free -= 1
            elif spent < patience:
                waiting.append((name, follower, spent + _TUBES_A_TURN))
        return met

    def _index(self, place: Place, length: Fraction) -> int:
        bits = _FIRST_BITS
        while bits <= _MAX_BITS:
            with ctx.workprec(bits):
                near = [i for i, cusp in enumerate(self._places(length, bits)) if not place.apart(cusp)]
            if len(near) == 1:
                return near[0]
            bits *= 2
        raise SolverError(f"cusps of the slice {exact_str(length)} are too close to tell which is followed")

    def _places(self, length: Fraction, bits: int) -> list[Place]:
        table = self.table(length, bits // 6)
        with ctx.workprec(bits):
            return [
                Place(*(_half_tangent(angle, table.digits) for angle in (cusp.alpha_deg, cusp.theta_deg)))
                for cusp in table.cusps
            ]

    def _scaled(self, length: Fraction) -> Fraction:
        return length * self.eliminant.surface.scale


def _half_tangent(degrees: str, digits: int) -> HalfTangent:
    """An angle that was rounded to so many digits."""
    exact = Fraction(degrees)
    angle = arb(exact.numerator) / exact.denominator
    angle = arb(angle.mid(), angle.rad() + abs(angle) * arb(10) ** (1 - digits)) * arb.pi() / 360
    return HalfTangent(angle.sin(), angle.cos())


@dataclass
class Track:
    """One cusp through the slices of a survey.

    ``cusps`` gives its place in the table of each slice, by the slice's number. ``born_with`` and
    ``dies_with`` are the numbers of the tracks into which the curve turns back at its ends, where known.
    """

    cusps: dict[int, int]
    born_with: int | None = None
    dies_with: int | None = None


@dataclass(frozen=True)
class Tracks:
    """All cusps of a survey.

    ``undecided`` are the groups of events at which tracks end and begin that may be the same.
    """

    tracks: tuple[Track, ...]
    undecided: frozenset[int]


def tracks(found: Survey, tracker: Tracker, progress: Progress) -> Tracks:
    """Follow every cusp of a survey from slice to slice."""
    everything: list[Track] = []
    undecided = set()
    alive: dict[int, Follower] = {}

    def begin(k: int, indices: Sequence[int]) -> None:
        for index in indices:
            alive[len(everything)] = tracker.follower((found.slices[k].length, index), upwards=True)
            everything.append(Track({k: index}))

    begin(0, range(found.slices[0].count))
    for k, (below, above) in enumerate(pairwise(found.slices)):
        names = {everything[name].cusps[k]: name for name in alive}
        met = tracker.destinations(alive, below.length, above.length)
        for name, (length, index) in met.items():
            if length == above.length:
                everything[name].cusps[k + 1] = index
            else:
                everything[name].dies_with = names[index]
        alive = {name: alive[name] for name, (length, _) in met.items() if length == above.length}
        taken = {everything[name].cusps[k + 1] for name in alive}
        born = [index for index in range(above.count) if index not in taken]
        if born and len(met) < len(names) and not _only(tracker, found.groups[k], len(taken)):
            undecided.add(k)
        first = len(everything)
        begin(k + 1, born)
        for track, index in zip(everything[first:], born, strict=True):
            sibling = _sibling(tracker, below.length, (above.length, index))
            track.born_with = None if sibling is None else first + born.index(sibling)
        progress(k + 2, len(found.slices))
    return Tracks(tuple(everything), frozenset(undecided))


def _only(tracker: Tracker, group: Sequence[Event], passing: int) -> bool:
    """Proof that no more than so many cusps pass events: there are no more at their very length."""
    exact = next((x.rational for e in group if (x := e.exact_length) and x.rational is not None), None)
    if exact is None:
        return False
    return tracker.table(exact / tracker.eliminant.surface.scale).count == passing


def _sibling(tracker: Tracker, low: Fraction, cusp: Cusp) -> int | None:
    """The cusp of the same slice to which the curve downwards from a cusp turns back."""
    length, _ = cusp
    met = tracker.destinations({0: tracker.follower(cusp, upwards=False)}, low, length)
    return met[0][1] if met and met[0][0] == length else None


def name_cusps(
    tracker: Tracker, starts: Mapping[Fraction, Mapping[int, int]], lengths: Sequence[Fraction]
) -> Iterator[tuple[Fraction, dict[int, int]]]:
    """The names of the cusps of more slices, from those of a slice in each interval between transitions.

    Args:
        tracker: of the manipulator.
        starts: for each slice where names are known, its cusps' places in the table by name.
        lengths: the slices in question.

    Yields:
        Each length, in no order, with its cusps' places in the table by name.

    Raises:
        SolverError: a cusp of some slice could not be given its name.
    """
    known = sorted(starts)
    wanted = sorted(set(lengths))
    for low, high in pairwise([None, *known, None]):
        inside = [x for x in wanted if (low is None or low < x) and (high is None or x < high)]
        names: dict[Fraction, dict[int, int]] = {length: {} for length in inside}
        for start, order in ((low, inside), (high, inside[::-1])):
            if start is not None:
                _pass(tracker, start, starts[start], order, names)
        for length in inside:
            if len(names[length]) < tracker.table(length).count:
                raise SolverError(f"not all cusps of the slice {exact_str(length)} could be followed to it")
            yield length, names[length]
    yield from ((length, dict(starts[length])) for length in wanted if length in starts)


def _pass(
    tracker: Tracker,
    start: Fraction,
    cusps: Mapping[int, int],
    order: Sequence[Fraction],
    names: Mapping[Fraction, dict[int, int]],
) -> None:
    """Follow the cusps of one slice through others, nearest first, as far as these lack names."""
    alive: dict[int, Follower] | None = None
    for length in order:
        if len(names[length]) == tracker.table(length).count:
            return
        if alive is None:
            upwards = length > start
            alive = {name: tracker.follower((start, i), upwards=upwards) for name, i in cusps.items()}
        low, high = sorted((start, length))
        met = tracker.destinations(alive, low, high, until_full=length)
        alive = {name: alive[name] for name, (where, _) in met.items() if where == length}
        names[length].update({name: met[name][1] for name in alive})
