"""Paths without a singularity: ends, the sign of J along the arcs, samples, limits, windings, anew."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise
from math import cos, pi, sin
from typing import Any

from rpr_solver.contract import Progress
from rpr_solver.verify.arcs import (
    Controls,
    Piece,
    Place,
    directions,
    halves_of,
    in_radians,
    mean,
    point_at,
)
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, finding, judged, worked
from rpr_solver.verify.clearance import clearance_claims, shape_claims, steepest
from rpr_solver.verify.core.intervals import Interval, degrees
from rpr_solver.verify.core.krawczyk import value
from rpr_solver.verify.core.numbers import Printed
from rpr_solver.verify.core.reader import Record, spend_exact
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.path_ends import ENDS, PathEnds, bound_claims, closed, obstacle_claims
from rpr_solver.verify.tables import slice_at
from rpr_solver.verify.timings import Timing

_SPARE_BITS, _TURN = 96, 360
_DIRECTIONS, _DEEPEST = 16, 24
Holds = Callable[[Piece, bool, bool], bool | None]
"""Whether something holds on a piece, which may be the first or the last one; None if it is too wide."""


def path_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of the document of a path, or of why there is none."""
    progress(0, 1)
    path = _Path(document)
    for end in ENDS:
        yield worked(f"/{end}", path.what(end), partial(path.end, end))
    yield from obstacle_claims(path) if "obstacle" in document.members else path.claims()
    progress(1, 1)


class _Path(PathEnds):
    def claims(self) -> Iterator[Claim]:
        """The claims of a path."""
        certificate, sign = self.members["certificate"], self.members["sign"]
        arcs: Sequence[Sequence[Any]] = certificate["arcs"]
        right = (arcs[0][0], arcs[-1][-1]) == ENDS and all(p[-1] == q[0] for p, q in pairwise(arcs))
        yield judged("/certificate/arcs", "the arcs join both ends", right, "each begins where one ends")
        right = not any(certificate["turns"]["from"].values())
        yield judged("/certificate/turns", "the path begins in the turn of its start", right, "as it is")
        yield worked("/closed", "whether it comes back to its leg lengths", partial(closed, self))
        relation = "J > 0" if sign > 0 else "J < 0"
        yield worked("/sign", f"{relation} all along the arcs", self._sign)
        at = "/certificate/least_determinant"
        yield worked(at, "the determinant is nowhere less", self._least)
        yield worked("/between", "the length of the fixed leg is kept", self._between)
        for name, limit in (self.members["limits"] or {}).items():
            claim = f"{name} keeps its limits all along the arcs"
            yield worked(f"/limits/{name}", claim, partial(self._limits, name, limit))
        yield from self._round()
        yield from _Samples(self).claims()
        fixed = f"l{self.surface.fixed}"
        ends = {end: self.lengths(end)[fixed] for end in ENDS}
        yield from Timing(self.members, fixed, ends, self.pieces, self.lengths_at).claims()
        # what may take all the work that is left comes last
        if (clearance := self.members.get("clearance")) is not None:
            yield from clearance_claims(clearance, self.pieces, sign)
            yield from bound_claims(self)
            yield from shape_claims(clearance, self.pieces, arcs, lambda: self.factor)

    def controls(self, place: Callable[[str], Place]) -> list[Controls]:
        turns = self.members["certificate"]["turns"]
        known: dict[Any, Place] = {}
        for end in ENDS:
            alpha, theta, length = place(end)
            whole = [Interval.of(_TURN * n, self.bits) for n in turns[end].values()]
            known[end] = alpha + whole[0], theta + whole[1], length
        for p in {p for arc in self.members["certificate"]["arcs"] for p in arc if not isinstance(p, str)}:
            alpha, theta = (Interval.of(x, self.bits) for x in p[:2])
            known[p] = alpha, theta, Interval.of(p[2] * self.surface.unit, self.bits)
        return [tuple(known[p] for p in arc) for arc in self.members["certificate"]["arcs"]]

    @cached_property
    def arcs(self) -> list[Controls]:
        """The control points of the arcs."""
        return self.controls(self.place)

    @cached_property
    def pieces(self) -> list[Piece]:
        """The arcs as pieces that are halved where they must be."""
        return [Piece(self.forms, controls) for controls in self.arcs]

    def leaves(self, holds: Holds) -> Iterator[Piece | None]:
        """The pieces on which something holds, in order; None, at the end, where it does not."""
        last = len(self.pieces) - 1
        for n, whole in enumerate(self.pieces):
            stack = [(whole, n == 0, n == last)]
            while stack:
                piece, is_first, is_last = stack.pop()
                found = holds(piece, is_first, is_last)
                if found is None:
                    left, right = piece.halves
                    stack += [(right, False, is_last), (left, is_first, False)]
                    continue
                yield piece if found else None
                if not found:
                    return

    def everywhere(self, holds: Holds) -> bool:
        """Whether something holds on all arcs."""
        return None not in self.leaves(holds)

    def _sign(self) -> Finding:
        sign = self.members["sign"]

        def holds(piece: Piece, _first: bool, _last: bool) -> bool | None:
            if piece.middle(0).sign == -sign:
                return False
            return True if piece.value(0).sign == sign and piece.hull[2].sign > 0 else None

        return finding(bool(sign) and self.everywhere(holds), "by intervals on pieces", "J has another sign")

    @cached_property
    def factor(self) -> int:
        return self.forms.content(self.place("from"))

    def _least(self) -> Finding:
        least: Fraction = self.members["certificate"]["least_determinant"].value * 4 * self.surface.unit

        def size(j: Interval, f: Interval, g: Interval) -> tuple[Fraction, Fraction]:
            """Bounds of the absolute value of J, and what it must be."""
            inner = max(j.lower, -j.upper, 0) * self.factor
            outer = max(j.upper, -j.lower) * self.factor
            unit = 1 << j.bits
            legs = f.root() * g.root()
            if Fraction(outer, unit) < least * Fraction(legs.lower, unit):
                return Fraction(-1), Fraction(0)
            return Fraction(inner, unit), least * Fraction(legs.upper, unit)

        def holds(piece: Piece, _first: bool, _last: bool) -> bool | None:
            f, g = piece.value(1), piece.value(2)
            if f.upper <= 0 or g.upper <= 0:
                return None
            if size(*(piece.middle(n) for n in range(3)))[0] < 0:
                return False
            inner, needed = size(piece.value(0), f, g)
            return True if inner >= needed and inner > 0 else None

        return finding(self.everywhere(holds), "by intervals on pieces", "it is less somewhere")

    def _between(self) -> Finding:
        between = self.members["between"]
        fixed = f"l{self.surface.fixed}"
        if between is None:
            held = {
                p[2] for arc in self.members["certificate"]["arcs"] for p in arc if not isinstance(p, str)
            }
            held |= {self.lengths(end)[fixed] for end in ENDS}
            return finding(len(held) == 1, "it is held", "it is not held, and no lengths are given")
        return finding(self._fixed(between["from"], between["to"]), "by the control points", "it is left")

    def _fixed(self, low: Fraction | None, high: Fraction | None) -> bool:
        """Whether the fixed leg keeps limits along the arcs."""
        ends = {end: self.lengths(end)[f"l{self.surface.fixed}"] for end in ENDS}
        arcs = self.members["certificate"]["arcs"]
        return all(_within([ends[p] if isinstance(p, str) else p[2] for p in arc], low, high) for arc in arcs)

    def _limits(self, name: str, limit: Record) -> Finding:
        unit, low, high = self.surface.unit, limit["min"], limit["max"]
        if name == f"l{self.surface.fixed}":
            return finding(self._fixed(low, high), "by the control points", "a limit is exceeded")
        number = 1 + self.surface.free.index(int(name[1]))
        walls = [(side, bound) for side, bound in ((-1, low), (1, high)) if bound is not None]

        def holds(piece: Piece, first: bool, last: bool) -> bool | None:
            found: list[bool | None] = []
            for side, bound in walls:
                square = Interval.of((bound * unit) ** 2, self.bits)
                room = (square - piece.value(number)).scaled(side)
                if (square - piece.middle(number)).scaled(side).sign < 0:
                    return False
                slope = piece.change(number).scaled(side).sign
                leaves = first and slope < 0 and _is_at(self.lengths("from")[name], bound)
                comes = last and slope > 0 and _is_at(self.lengths("to")[name], bound)
                found.append(True if room.lower >= 0 or leaves or comes else None)
            return None if None in found else True

        return finding(self.everywhere(holds), "by intervals on pieces", "a limit is exceeded")

    def _round(self) -> Iterator[Claim]:
        cusp, winding, at = self.members["cusp"], self.members["winding"], "/winding"
        twins = self.members.get("twins", ())
        if cusp is None or winding is None:
            right = cusp is None and winding is None and not twins
            yield judged(at, "a path that is no loop has no cusp", right, "as it is")
            return
        own = (cusp, *twins)
        claim = f"it goes round {'cusps' if twins else 'cusp'} {', '.join(map(str, own))} {winding} times"
        yield worked(at, f"{claim}, and round no other", lambda: self._winding(own, winding))

    def _winding(self, own: Sequence[int], winding: int) -> Finding:
        is_closed = closed(self)[0] is ClaimStatus.PROVED and self.members["closed"]
        if not is_closed or len(set(own)) < len(own) or self.members["between"] is not None:
            return ClaimStatus.REFUSED, "it is no closed path in one slice"
        cusps = slice_at(self.surface, self.lengths("from")[f"l{self.surface.fixed}"]).cusps(self.bits)
        if not cusps.complete:
            raise OpenError("it is not proved that these cusps are all")
        if max(own) > len(cusps.boxes):
            return ClaimStatus.REFUSED, f"there are {len(cusps.boxes)} cusps"
        length = Interval.of(self.scaled("from"), self.bits)
        for number, box in enumerate(cusps.boxes, 1):
            place = degrees(box.alpha).at(self.bits), degrees(box.theta).at(self.bits), length
            here = directions(place, self.surface.ring.radicand)
            centre = [value(here, leg.squared, length) for leg in self.surface.legs]
            if self._turns(centre) != (winding if number in own else 0):
                return ClaimStatus.REFUSED, f"it goes round cusp {number} otherwise"
        return ClaimStatus.PROVED, "by half planes that hold the pieces"

    def _turns(self, centre: Sequence[Interval]) -> int:
        """How often the image goes round a point: each piece lies in an open half plane beside it."""

        def side(piece: Piece) -> int | None:
            for n, (k, sign) in enumerate(((1, 1), (2, 1), (1, -1), (2, -1))):
                if (piece.value(k) - centre[k - 1]).sign == sign:
                    return n
            return None

        pieces = self.leaves(lambda piece, _first, _last: None if side(piece) is None else True)
        sides = [n for piece in pieces if piece is not None and (n := side(piece)) is not None]
        steps = [(y - x + 1) % 4 - 1 for x, y in zip(sides, [*sides[1:], sides[0]], strict=True)]
        return sum(steps) // 4


class _Samples:
    """The samples of a path."""

    def __init__(self, path: _Path) -> None:
        self.path = path

    def claims(self) -> Iterator[Claim]:
        """The claims of all samples."""
        samples: Sequence[Record] = self.path.members["samples"]
        last, duration = len(samples) - 1, self.path.members["duration"]
        times = [x["time"] for x in samples]
        if "deviation" in self.path.members:
            right = (times[0], times[-1]) == (0, duration) and all(x < y for x, y in pairwise(times))
            yield judged("/samples", "the times ascend from 0 to the duration", right, "exactly")
        else:
            right = times == [duration * Fraction(n, last) for n in range(last + 1)]
            yield judged("/samples", "the times are equally spaced, from 0 to the duration", right, "exactly")
        places = [x["place"] for x in samples]
        count = len(self.path.members["certificate"]["arcs"])
        right = places[0] == 0 and places[-1] == count and all(x <= y for x, y in pairwise(places))
        yield judged("/samples", "the samples follow each other from end to end", right, "by their places")
        for n, sample in enumerate(samples):
            at = f"/samples/{n}"
            yield worked(
                at, "a point of the arcs at its place, with these digits", partial(self._point, sample)
            )
            claim = "no singular pose is nearer than this"
            yield worked(f"{at}/clearance_deg", claim, partial(self._clearance, sample))

    def _wrong(self, sample: Record, at: Place) -> tuple[str | None, bool]:
        """A number of a sample that is proved wrong in a box, and whether all are proved right."""
        values = {**dict(zip(self.path.names, at, strict=False)), **self.path.lengths_at(at)}
        legs = [values[f"l{leg}"] for leg in self.path.surface.free]
        bottom = (legs[0] * legs[1]).scaled(4 * self.path.surface.unit**3)
        values["determinant"] = self.path.singular(at).scaled(self.path.factor).over(bottom)
        right = True
        for name, number in values.items():
            printed: Printed = sample[name]
            rounds = number.contains(0) and not number.radius if printed.is_zero else printed.rounds(number)
            if printed.is_zero and number.contains(0):
                rounds = rounds or None
            if rounds is False:
                return name, False
            right = right and bool(rounds)
        return None, right

    def _point(self, sample: Record) -> Finding:
        wrong, right = self._wrong(sample, _place_of(self.path.arcs, sample["place"]))
        if wrong and any(map(self.path.is_given, ENDS)):
            own = self.path
            ways = own.controls(lambda end: own.wide(end) if own.is_given(end) else own.place(end))
            wrong, right = self._wrong(sample, _place_of(ways, sample["place"]))[0], False
        if wrong:
            return ClaimStatus.REFUSED, f"{wrong} has other digits there"
        if not right:
            raise OpenError("its digits are not decided, as an angle of an end is rounded, or a number is 0")
        return ClaimStatus.PROVED, "computed anew from the arcs"

    def _clearance(self, sample: Record) -> Finding:
        at, printed = _place_of(self.path.arcs, sample["place"]), sample["clearance_deg"]
        here, radius = (
            directions(at, self.path.surface.ring.radicand),
            in_radians(Interval.of(printed.value, self.path.bits)),
        )
        j = value(here, self.path.forms.functions[0], at[2])
        slopes = [value(here, p, at[2]) for p in self.path.forms.slopes[0][:2]]
        slope = (slopes[0] * slopes[0] + slopes[1] * slopes[1]).root()
        bend = steepest(self.path.forms, at[2]) * radius * radius
        if max(j.lower, -j.upper) * 2 > (slope * radius).upper * 2 + bend.upper:
            return ClaimStatus.PROVED, "by the slope of J there, and its second derivatives anywhere"
        for k in range(_DIRECTIONS):
            step = [printed.value * Fraction(f(2 * pi * k / _DIRECTIONS)) for f in (cos, sin)]
            alpha, theta = (
                x + Interval.of(y * 999 / 1000, self.path.bits) for x, y in zip(at, step, strict=False)
            )
            if self.path.singular((alpha, theta, at[2])).sign == -j.sign:
                return ClaimStatus.REFUSED, "a singular pose is nearer"
        raise OpenError("this bound is not proved here")


def _place_of(arcs: Sequence[Controls], place: Fraction) -> Place:
    """The point of the arcs at a place."""
    if place > len(arcs):
        raise OpenError("there is no such place")
    arc = min(int(place), len(arcs) - 1)
    return point_at(arcs[arc], place - arc)


def _is_at(length: object, bound: Fraction) -> bool:
    """Whether an end has exactly this length; the slope there shows on which side of it the piece is."""
    return isinstance(length, Fraction) and length == bound


def _within(numbers: Sequence[Fraction], low: Fraction | None, high: Fraction | None, depth: int = 0) -> bool:
    """Whether a polynomial with these control points keeps limits between its ends.

    Raises:
        OpenError: it is not decided.
    """
    spend_exact(len(numbers) ** 2, *numbers)
    if (low is None or min(numbers) >= low) and (high is None or max(numbers) <= high):
        return True
    if any(
        (low is not None and x < low) or (high is not None and x > high) for x in (numbers[0], numbers[-1])
    ):
        return False
    if depth >= _DEEPEST:
        raise OpenError("it is not decided whether the length of the fixed leg keeps its limits")
    return all(_within(half, low, high, depth + 1) for half in halves_of(numbers, mean))
