"""Full certificates of cusp curves: chains of tubes join the points of a curve, and curves at their ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise

from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, brief, worked
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, value
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.landmarks import Event
from rpr_solver.verify.ranges import Range
from rpr_solver.verify.tubes import LENGTH, Coordinates, Forms, Local, Pose, Tube, direction_of, moved

SIDES = ("from", "to")
Place = tuple[str, Fraction]
"""A point of a curve, by the name of the curve and the length."""


def joining(number: int, start: Place, stop: Place) -> str:
    """What a chain of tubes claims."""
    (first, a), (second, b) = start, stop
    return f"{number} tubes lead from {first} at {brief(a)} to {second} at {brief(b)}"


AtPoses = Callable[[int, str, Fraction, int], Finding]
"""Whether a curve that joins no other leads to its end: asked for its number, the side, the length of its
last point before this end, and how many curves are proved to lead from that length past the end."""
_ASK = "no tubes lead past it: ask for the whole range, where each curve has points up to its ends"


def leading(end: Record) -> str:
    """What an end of a curve claims besides its pose."""
    return "the curve leads to this end" + (f", and joins {end['joins']}" if end["joins"] else "")


@dataclass(frozen=True)
class _Chain:
    at: str
    start: Place
    stop: Place
    tubes: Sequence[Tube]

    @property
    def claim(self) -> str:
        return joining(len(self.tubes), self.start, self.stop)


@dataclass(frozen=True)
class _Turn:
    """An end at which two curves join: curve and side, both names, and the length of the points beside it."""

    curve: int
    side: str
    names: frozenset[str]
    length: Fraction


Joint = frozenset[Place] | _Turn
"""What a chain may join: two neighbouring points, or two curves at an end."""


class Chains:
    """The chains of a document, and what they are to join.

    Args:
        surface: the equations.
        members: the document, with a full certificate.

    Raises:
        InputError: naming a member that cannot be read.
    """

    def __init__(self, surface: Surface, members: Record) -> None:
        self._surface = surface
        self._curves: Sequence[Record] = members["curves"]
        self._by_name: dict[str | None, Record] = {curve["name"]: curve for curve in self._curves}
        self._length = f"l{surface.fixed}"
        self._span = members["range"]["from"], members["range"]["to"]
        at = "/certificate/full/chains"
        self._chains = [
            self._chain(chain, f"{at}/{n}")
            for n, chain in enumerate(members["certificate"]["full"]["chains"])
        ]

    def _chain(self, chain: Record, at: str) -> _Chain:
        start, stop = ((chain[side]["curve"], chain[side][self._length]) for side in SIDES)
        tubes = [Tube.of(self._surface, tube, f"{at}/tubes/{k}") for k, tube in enumerate(chain["tubes"])]
        return _Chain(at, start, stop, tubes)

    @property
    def bits(self) -> dict[Place, int]:
        """How finely each point must be known to be found in its tube."""
        result: dict[Place, int] = {}
        for chain in self._chains:
            for place, tube in ((chain.start, chain.tubes[0]), (chain.stop, chain.tubes[-1])):
                result[place] = max(result.get(place, 0), tube.bits)
        return result

    def claims(
        self,
        poses: Mapping[Place, Pose],
        cut: Callable[[], Range],
        at_poses: AtPoses,
        done: Callable[[int], None],
    ) -> Iterator[Claim]:
        """The claims of all chains, with the proved boxes of the points, and what no chain joins.

        The events are asked for when the first chain is looked at.
        """
        joined: set[Joint] = set()
        proved: set[Joint] = set()

        def chained(chain: _Chain) -> Finding:
            links, (status, reason) = self._found(chain, poses, cut())
            if status is not ClaimStatus.REFUSED:
                joined.update(links)
            if status is ClaimStatus.PROVED:
                proved.update(links)
            return status, reason

        for n, chain in enumerate(self._chains):
            done(n)
            yield worked(chain.at, chain.claim, partial(chained, chain))
        for n, curve in enumerate(self._curves):
            claim = "each two neighbouring points of the curve are joined by tubes"
            find = partial(self._joined, curve, joined, proved)
            yield worked(f"/curves/{n}/points", claim, find)
            for side in SIDES:
                if curve[side]["kind"] != "open":
                    find = partial(self._end, n, side, joined, proved)
                    if curve[side]["joins"] is None:
                        find = partial(self._alone, n, side, at_poses, proved)
                    yield worked(f"/curves/{n}/{side}", leading(curve[side]), find)

    def _joined(self, curve: Record, joined: Set[Joint], proved: Set[Joint]) -> Finding:
        links = list(self._neighbours(curve))
        if missing := [pair for pair in links if pair not in joined]:
            return ClaimStatus.REFUSED, f"{len(missing)} are not"
        known = all(pair in proved for pair in links)
        return ClaimStatus.PROVED if known else ClaimStatus.CHECKED, "as the chains show"

    def _end(self, n: int, side: str, joined: Set[Joint], proved: Set[Joint]) -> Finding:
        """Whether the curve leads to an end that is not open: a chain leads past it."""
        curve = self._curves[n]
        own = {turn for turn in self._turns if turn.side == side and curve["name"] in turn.names}
        if own & joined:
            return ClaimStatus.PROVED if own & proved else ClaimStatus.CHECKED, "tubes lead past it"
        (start, stop), length = self._span, curve[side][self._length]
        inside = start < length.lower and (stop is None or length.upper < stop)
        if inside and any(turn.curve == n for turn in own):
            return ClaimStatus.REFUSED, "no tubes lead past it"
        raise OpenError(_ASK)

    def _alone(self, n: int, side: str, at_poses: AtPoses, proved: Set[Joint]) -> Finding:
        """Whether a curve that joins no other leads to its end, by how many are proved to pass it."""
        end, step = self._curves[n][side][self._length], 1 if side == "to" else -1
        points = self._points(self._curves[n])[::-step]
        if not points:
            raise OpenError(_ASK)

        def passes(curve: Record) -> bool:
            return any(
                a == points[0]
                and (end.upper < b if side == "to" else b < end.lower)
                and frozenset(((curve["name"], a), (curve["name"], b))) in proved
                for a, b in pairwise(self._points(curve)[::step])
            )

        return at_poses(n, side, points[0], sum(map(passes, self._curves)))

    def _points(self, curve: Record) -> list[Fraction]:
        return [point[self._length] for point in curve["points"]]

    def _neighbours(self, curve: Record) -> Iterator[frozenset[Place]]:
        for a, b in pairwise(self._points(curve)):
            yield frozenset(((curve["name"], a), (curve["name"], b)))

    @cached_property
    def _links(self) -> set[frozenset[Place]]:
        return {pair for curve in self._curves for pair in self._neighbours(curve)}

    @cached_property
    def _turns(self) -> list[_Turn]:
        turns = []
        for n, curve in enumerate(self._curves):
            for side, place in zip(SIDES, (0, -1), strict=True):
                other = self._by_name.get(curve[side]["joins"])
                lengths = [self._points(x)[place:][:1] for x in (curve, other or {"points": []})]
                if lengths[0] and lengths[0] == lengths[1] and other is not curve:
                    names = frozenset((curve["name"], curve[side]["joins"]))
                    turns.append(_Turn(n, side, names, lengths[0][0]))
        return turns

    @cached_property
    def _forms(self) -> Forms:
        return Forms(self._surface)

    def _found(self, chain: _Chain, poses: Mapping[Place, Pose], cut: Range) -> tuple[Set[Joint], Finding]:
        """What a chain joins, and how its claim stands."""
        refused = ClaimStatus.REFUSED
        link = frozenset((chain.start, chain.stop))
        turns = {
            turn
            for turn in self._turns
            if link == {(name, turn.length) for name in turn.names} and len(link) == 2
        }
        if link not in self._links and not turns:
            reason = "these are no neighbours on a curve, nor points beside an end that joins"
            return set(), (refused, reason)
        if not {chain.start, chain.stop} <= poses.keys():
            return {link, *turns}, (ClaimStatus.NOT_CHECKED, "one of the points is not proved")
        ends = poses[chain.start], poses[chain.stop]
        found = chain_of(self._surface, self._forms, chain.tubes, ends, cut)
        if found.fault:
            return set(), (refused, found.fault)
        proof = "each holds one curve by Krawczyk's test and begins on that of the one before"
        if found.turning is None:
            reason = f"{proof}; where the length turns back is open"
            return turns or {link}, (ClaimStatus.CHECKED, reason)
        if not turns:
            if found.turning:
                return set(), (refused, "the length turns back on the way")
            return {link}, (ClaimStatus.PROVED, f"{proof}; the length never turns back")
        if len(found.turning) != 1:
            return set(), (refused, f"the length turns back {len(found.turning)} times on the way")
        ends_of = {turn: cut.listed(self._curves[turn.curve][turn.side]) for turn in turns}
        passed = {turn for turn, poses_there in ends_of.items() if found.turning[0] in poses_there}
        if not passed:
            return set(), (refused, "the pose of the end is not on the way")
        return {*passed}, (ClaimStatus.PROVED, f"{proof}; the length turns back once, at the pose of the end")


@dataclass(frozen=True)
class Chain:
    """What is found about a chain of tubes.

    Attributes:
        fault: why it proves nothing, empty if it joins the two points.
        turning: the events at which the length turns back; None if that is open in a tube.
    """

    fault: str
    turning: tuple[Event, ...] | None = None


def chain_of(
    surface: Surface, forms: Forms, tubes: Sequence[Tube], ends: tuple[Pose, Pose], cut: Range
) -> Chain:
    """Whether each tube holds one curve, that of the tube before, and the outer ones the two points."""
    start, stop = ends
    turning: list[Event | None] = []
    before: Local | None = None
    try:
        for k, tube in enumerate(tubes):
            local = Local(forms, tube)
            if not local.passes():
                return Chain(f"tube {k} is not proved to hold one point for each value of its parameter")
            middle = local.middle()
            if middle is None or not _is_regular(surface, tube, middle):
                return Chain(f"the point at the origin of tube {k} is not proved to be a triple pose")
            if before is None:
                entry = start.about(tube)
                if not tube.holds(entry):
                    return Chain("the first tube does not hold the first point")
            else:
                box = moved(middle, tube, before.tube)
                if not before.tube.holds(box):
                    return Chain(f"tube {k} does not begin in the tube before")
                turning += _Arc(before, entry, box).turning(cut)
                entry = middle
            before = local
        if before is None:
            return Chain("it has no tubes")
        box = stop.about(before.tube)
        if not before.tube.holds(box):
            return Chain("the last tube does not hold the last point")
        turning += _Arc(before, entry, box).turning(cut)
    except ArithmeticError:
        return Chain("two of its tubes, or a point and its tube, are far apart")
    known = tuple(event for event in turning if event is not None)
    return Chain("", known if len(known) == len(turning) else None)


@dataclass(frozen=True)
class _Arc:
    """The arc of a curve in a tube, from where a chain enters it to where it leaves it."""

    local: Local
    entry: Coordinates
    out: Coordinates

    def turning(self, cut: Range) -> list[Event | None]:
        """The events at which the length turns back; None for what is open.

        It does so at degenerate poses only, so at events (mathematics.md#turns).
        """
        tube, unit = self.local.tube, cut.events.surface.unit
        if tube.parameter == LENGTH:
            return []
        if cut.events.open:
            return [None]
        low, high = (x / unit for x in self.local.lengths())
        near = [k for k, (a, b) in enumerate(cut.spans) if a <= high and low <= b]
        on = {k: self._passes(cut.events.found[k]) if k < len(cut.events.found) else None for k in near}
        near = [k for k in near if on[k] is not False]
        if not near:
            return []
        first, last = min(cut.spans[k][0] for k in near), max(cut.spans[k][1] for k in near)
        ends = [tube.length_at(box[LENGTH]) for box in (self.entry, self.out)]
        sides = {1 if last < low / unit else -1 if high / unit < first else 0 for low, high in ends}
        if 0 in sides or len(cut.grouped(near)) != 1:
            return [None]
        if len(sides) == 2:
            return []
        return [next((cut.events.found[k] for k in near if on[k]), None)]

    def _passes(self, event: Event) -> bool | None:
        """Whether the pose of an event is on the arc; None if intervals do not tell."""
        bits = max(self.local.bits, event.scaled.bits)
        try:
            box = Pose(*(x.at(bits) for x in (*event.pose, event.scaled))).about(self.local.tube)
        except ZeroDivisionError:  # half a turn away, as far as intervals tell
            return None
        if not (inside := self.local.tube.holds(box)):
            return inside
        r, *ends = (x[self.local.tube.parameter].at(bits) for x in (box, self.entry, self.out))
        sides = [(r - end).sign for end in ends]
        return None if 0 in sides else sides[0] != sides[1]


def _is_regular(surface: Surface, tube: Tube, box: Sequence[Interval]) -> bool:
    """Whether the gradient of the leg along which E is taken is not zero: else E = 0 says nothing there."""
    bits = box[0].bits
    one = Interval.of(1, bits)
    pairs = []
    for x, origin in zip(box, tube.origins, strict=False):
        s, c = direction_of(origin, bits)
        sin, cos = c * x + s, c - s * x
        norm = sin * sin + cos * cos
        pairs.append(((cos * cos - sin * sin).over(norm), (sin * cos).scaled(2).over(norm)))
    here = Directions(pairs[0], pairs[1], surface.ring.radicand)
    length = Interval.of(tube.length, bits) * (one + box[2])
    [leg] = [leg for leg in surface.legs if leg.number == tube.leg]
    return any(value(here, slope, length).sign for slope in (leg.alpha, leg.theta))
