"""Cusp curves: each point a cusp of its slice, none missing or twice, each end a transition."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, partial

from rpr_solver.contract import MOST_CUSPS, Progress
from rpr_solver.verify.chains import SIDES, Chains, Place, leading
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, brief, judged, worked
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.numbers import Printed, bits_of
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Cusps, Located, Point
from rpr_solver.verify.events import Events, event_finding
from rpr_solver.verify.ranges import DEGENERATE, Range, bits_in
from rpr_solver.verify.tables import sorted_turns
from rpr_solver.verify.tubes import Pose

JOINED = "each curve joins its points, leads to its ends, and joins others there"
_ASK = "the tubes that show it are in the full certificate: ask for --certificate full"
_ROUNDED = "up to half a unit of the last digit of an end"
_LENGTH_ONLY = ("unclassified", "undecided", "several")


def curve_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a document of cusp curves."""
    yield from _Curves(document).claims(progress)


@dataclass(frozen=True)
class _Listed:
    """A point of a curve: the numbers of the curve and of the point in it."""

    curve: int
    place: int
    point: Record

    @property
    def at(self) -> str:
        return f"/curves/{self.curve}/points/{self.place}"


class _Curves:
    def __init__(self, document: Document) -> None:
        self.fixed, self.members = document.fixed, document.members
        self.surface = Surface(document.geometry, document.fixed)
        self.curves: tuple[Record, ...] = self.members["curves"]
        self.name = f"l{self.fixed}"
        self.ends: list[tuple[Printed, Printed | None]] = [
            (curve["from"][self.name], curve["to"][self.name]) for curve in self.curves
        ]
        self.known: dict[tuple[object, ...], Finding] = {}
        self.settled: dict[Fraction, int] = {}
        """The number of cusps at each length at which all are proved and listed, each on its curve."""
        self.slices: dict[Fraction, list[_Listed]] = {}
        for n, curve in enumerate(self.curves):
            for k, point in enumerate(curve["points"]):
                self.slices.setdefault(point[self.name], []).append(_Listed(n, k, point))

    @cached_property
    def cut(self) -> Range:
        """All events, and the range."""
        rows = [event for curve in self.curves for side in SIDES for event in curve[side]["events"]]
        numbers = [x for event in rows for x in Point.of(event, self.surface).numbers]
        ends = [x for pair in self.ends for x in pair if x is not None]
        span = self.members["range"]["from"], self.members["range"]["to"]
        bits = max(bits_of([*numbers, *ends]), bits_in(span, self.members.get("degenerate", ())))
        return Range(Events(self.surface, bits), [], *span)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        chains = Chains(self.surface, self.members) if "certificate" in self.members else None
        done = len(self.curves) + len(self.slices)
        total = done + (len(self.members["certificate"]["full"]["chains"]) if chains else 0)
        yield from self._named()
        for n, curve in enumerate(self.curves):
            for side in SIDES:
                yield from self._end(f"/curves/{n}/{side}", curve[side])
            claim = "the points ascend between the ends"
            yield worked(f"/curves/{n}/points", claim, partial(self._ordered, curve, n))
        bits = chains.bits if chains else {}
        poses: dict[Place, Pose] = {}
        for n, (length, listed) in enumerate(sorted(self.slices.items(), key=lambda item: item[0])):
            progress(len(self.curves) + n, total)
            own = list(self._slice(length, listed, bits, poses))
            yield from own
            if all(claim.established for claim in own):
                self.settled[length] = len(listed)

        def at_poses(n: int, side: str, last: Fraction, passing: int) -> Finding:
            others = self.settled.get(last, 0) - passing
            return self.cut.reached(self.curves[n][side], last, others, above=side == "from")

        if chains:

            def chained(n: int) -> None:
                progress(done + n, total)

            yield from chains.claims(poses, lambda: self.cut, at_poses, chained)
            yield from self._open_ends()
        else:
            yield Claim("/curves", JOINED, ClaimStatus.NOT_CHECKED, _ASK)
        yield worked("/curves", "these are all curves of the range", self._all)
        listed_degenerate = self.members.get("degenerate", ())
        yield worked("/degenerate", DEGENERATE, lambda: self.cut.degenerate(listed_degenerate))
        progress(1, 1)

    def _all(self) -> Finding:
        """Whether the curves are all: between any two events as many pass as a slice there has cusps."""
        for gap in self.cut.gaps(0):
            length, found = self.cut.slice_in(gap)
            passes = [self._passes(n, length) for n in range(len(self.curves))]
            if found is None or None in passes:
                raise OpenError("the cusps of a slice are not counted")
            if found[0] != passes.count(True):
                reason = (
                    f"the slice at {brief(length)} has {found[0]}, and {passes.count(True)} curves pass it"
                )
                return ClaimStatus.REFUSED, reason
            if not found[1]:
                return ClaimStatus.CHECKED, "the cusps of a slice are not proved to be all"
        return self.cut.rests_on_all()

    def _open_ends(self) -> Iterator[Claim]:
        """That curves lead to 0 or ∞."""
        for side in SIDES:
            for n, curve in enumerate(self.curves):
                if curve[side]["kind"] == "open":
                    lengths = [point[self.name] for point in curve["points"]]
                    find = partial(self._leads_on, side, lengths)
                    yield worked(f"/curves/{n}/{side}", leading(curve[side]), find)

    def _leads_on(self, side: str, lengths: Sequence[Fraction]) -> Finding:
        """Whether no event is beyond some point of a curve, at which it might end."""
        spans = self.cut.spans
        beyond = lengths and all(
            high < max(lengths) if side == "to" else min(lengths) < low for low, high in spans
        )
        if not beyond or self.cut.events.open:
            raise OpenError("events are beyond its points: ask for a point of it beyond all transitions")
        return ClaimStatus.PROVED, "all events are on the other side of a point of it"

    def _named(self) -> Iterator[Claim]:
        """Names are different, each curve is in the range, and joined ends name each other."""
        by_name = {curve["name"]: curve for curve in self.curves}
        wrong = "" if len(by_name) == len(self.curves) else "two curves have one name"
        for curve in self.curves:
            for side in SIDES:
                end, joins = curve[side], curve[side]["joins"]
                other = by_name.get(joins)
                if joins == curve["name"] or (joins is not None and end["kind"] in ("open", "undecided")):
                    wrong = f"{curve['name']} joins {joins}"
                elif other is not None:
                    backward = other[side]
                    alike = (backward["joins"], backward[self.name]) == (curve["name"], end[self.name])
                    if not alike or not _same(backward["events"], end["events"]):
                        wrong = f"{curve['name']} joins {joins}, which does not join it there"
        claim = "curves have different names, and those that join name each other"
        yield judged("/curves", claim, not wrong, "as printed", wrong)
        start, stop = self.members["range"]["from"], self.members["range"]["to"]
        right = stop is None or start < stop
        for low, high in self.ends:
            right = right and (stop is None or low.lower <= stop) and (high is None or start <= high.upper)
        right = right and all(start <= x and (stop is None or x <= stop) for x in self.slices)
        claim, wrong = "the curves meet the range, and points are in it", "a curve or a point is beyond it"
        yield judged("/range", claim, right, "as printed", wrong)
        for n, curve in enumerate(self.curves):
            if not curve["points"]:
                claim, reason = "a curve without points is there", "no point of it is given"
                yield Claim(f"/curves/{n}", claim, ClaimStatus.NOT_CHECKED, reason)

    def _end(self, at: str, end: Record) -> Iterator[Claim]:
        kind, length, listed = end["kind"], end[self.name], end["events"]
        if kind == "open":
            is_end = length is None if at.endswith("/to") else length is not None and length.is_zero
            right = is_end and not listed
            wrong = "an open end is at 0 or has no length, and no pose"
            yield judged(at, "an end: open", right, "the end of all lengths", wrong)
            return
        if length is None or length.is_zero or (not listed and kind not in _LENGTH_ONLY):
            reason = "it has no length, or no pose"
            yield Claim(at, f"an end: {kind}", ClaimStatus.REFUSED, reason)
            return
        if not listed:
            yield Claim(at, f"an end: {kind}", ClaimStatus.NOT_CHECKED, "no pose is given there")
        for k, event in enumerate(listed):
            claim = f"a {event['kind']} at this length"
            yield worked(f"{at}/events/{k}", claim, partial(self._event, length, event))
        kinds = {event["kind"] for event in listed}
        if listed and kind != "undecided" and kind != ("several" if len(kinds) > 1 else next(iter(kinds))):
            reason = "the pose is of another kind"
            yield Claim(f"{at}/kind", "the kind of the pose", ClaimStatus.REFUSED, reason)
        # where curves join, the claim that they do says which
        if kind == "undecided" or (len(listed) > 1 and not (end["joins"] and "certificate" in self.members)):
            reason = "it is not said which pose is the end of the curve"
            yield Claim(at, f"an end: {kind}", ClaimStatus.NOT_CHECKED, reason)

    def _event(self, length: Printed, event: Record) -> Finding:
        key = (length.text, *(getattr(x, "text", x) for x in event.values()))
        if key not in self.known:
            self.known[key] = event_finding(self.surface, length, event, self.cut.events)
        return self.known[key]

    def _passes(self, n: int, length: Fraction, *, exactly: bool = True) -> bool | None:
        """Whether a length lies between the ends of a curve.

        Where the digits of an end leave it open, the proved length of its event tells, if that is asked for;
        None if that leaves it open too.
        """
        start, stop = self.ends[n]
        sides = [start.below(length), stop is None or stop.above(length)]
        for k, sense in enumerate((-1, 1)):
            if sides[k] is None and exactly and False not in sides:
                off = self._beyond(n, SIDES[k], length)
                sides[k] = None if not off else off == sense
        return False if False in sides else None if None in sides else True

    def _beyond(self, n: int, side: str, length: Fraction) -> int:
        """The sign of the length of an end less another; 0 if it is open, or which event it is."""
        end = self.curves[n][side]
        own = self.cut.listed(end)
        if len(own) != 1 or not self.cut.events.named:
            return 0
        exact = own[0].length(self.surface)
        return (exact - Interval.of(length, exact.bits)).sign

    def _ordered(self, curve: Record, n: int) -> Finding:
        """Whether the points ascend between the ends."""
        start, stop = self.ends[n]
        lengths = [point[self.name] for point in curve["points"]]
        inside = [self._passes(n, x) for x in lengths]
        apart = stop is None or start.lower < stop.upper
        if False in inside or not apart or lengths != sorted(set(lengths)):
            return ClaimStatus.REFUSED, "a point lies beyond an end, or they are not ascending"
        if None in inside or not (lengths or stop is None or start.upper < stop.lower):
            return ClaimStatus.CHECKED, _ROUNDED
        return ClaimStatus.PROVED, "as printed, and as the events show"

    def _met(self, length: Fraction, there: Set[int], *, exactly: bool = True) -> Finding:
        """Whether the curves that pass a length are those with a point there."""
        passes = [self._passes(n, length, exactly=exactly) for n in range(len(self.curves))]
        if any(known is not None and known != (n in there) for n, known in enumerate(passes)):
            reason = "a curve that passes this length has no point there, or one that does not pass has one"
            return ClaimStatus.REFUSED, reason
        return (ClaimStatus.CHECKED, _ROUNDED) if None in passes else (ClaimStatus.PROVED, "as the ends show")

    def _slice(
        self,
        length: Fraction,
        listed: list[_Listed],
        bits: Mapping[Place, int],
        poses: dict[Place, Pose],
    ) -> Iterator[Claim]:
        """All points of one length: different cusps, numbered as in the table, and as many as there are.

        The boxes of the points are put into ``poses``, as fine as ``bits`` says.
        """
        at = listed[0].at
        if len(listed) > MOST_CUSPS:
            claim, reason = "different curves are different cusps", f"no slice has more than {MOST_CUSPS}"
            yield Claim(at, claim, ClaimStatus.REFUSED, reason)
            return
        located = cache(lambda: self._located(length, listed, bits, poses))
        for n, item in enumerate(listed):
            yield worked(item.at, "a cusp with these digits", lambda n=n: located()[0][n].finding)  # type: ignore[misc]
        angles = [item.point[f"theta{self.fixed}_deg"].value for item in listed]
        printed = [item.point["cusp"] for item in listed]
        order = list(zip(angles, printed, strict=True))
        ranked = sorted(range(len(order)), key=order.__getitem__)  # any order where angles are printed alike
        numbers = [ranked.index(n) + 1 for n in range(len(order))]
        claim, there = "every curve of this length has a point", {item.curve for item in listed}
        found = self._met(length, there, exactly=False)
        if found[0] is ClaimStatus.CHECKED:
            yield worked(at, claim, lambda: self._met(length, there))
        elif found[0] is ClaimStatus.REFUSED:
            yield Claim(at, claim, *found)
            return
        by_number = [value for _, (value, _) in sorted(zip(printed, order, strict=True))]
        if sorted(printed) != sorted(numbers) or not sorted_turns(by_number):
            reason = f"they are {numbers}, at {', '.join(item.at for item in listed[:2])}, …"
            yield Claim(at, "the numbers of the cusps", ClaimStatus.REFUSED, reason)
        claim = f"the {len(listed)} curves of {self.name} = {brief(length)} have all cusps of the slice"
        yield worked(at, claim, lambda: _complete(len(listed), located()[1]))

    def _located(
        self,
        length: Fraction,
        listed: list[_Listed],
        bits: Mapping[Place, int],
        poses: dict[Place, Pose],
    ) -> tuple[list[Located], Cusps]:
        """The points of one length among the cusps of its slice; their boxes are put into ``poses``."""
        part = self.cut.events.slice_of(length)
        places = [(self.curves[item.curve]["name"], length) for item in listed]
        points = [Point.of(item.point, part.system) for item in listed]
        ranked = sorted(range(len(listed)), key=lambda n: listed[n].point["cusp"])
        found, cusps = part.located([points[n] for n in ranked], max(bits.get(place, 0) for place in places))
        located = dict(zip(ranked, found, strict=True))
        for n, place in enumerate(places):
            if (box := located[n].box) is not None:
                scaled = Interval.of(length * self.surface.unit, box.alpha.bits)
                poses[place] = Pose(box.alpha, box.theta, scaled)
        return [located[n] for n in range(len(listed))], cusps


def _complete(number: int, cusps: Cusps) -> Finding:
    """Whether a slice has no other cusps than the points of the curves."""
    total = len(cusps.boxes) + cusps.missing
    if number != total:
        return ClaimStatus.REFUSED, f"the slice has {total}"
    if cusps.complete:
        return ClaimStatus.PROVED, f"{number} are found anew, and there are no others"
    return ClaimStatus.CHECKED, "others may be on lines where Q has multiple roots"


def _same(first: Sequence[Record], second: Sequence[Record]) -> bool:
    return [dict(event) for event in first] == [dict(event) for event in second]
