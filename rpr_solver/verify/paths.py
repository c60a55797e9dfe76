"""Paths without a singularity: the sign of J along the arcs, samples, limits and windings, found anew."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

from flint import arb, ctx

from rpr_solver.boxes import Box
from rpr_solver.contract import LEGS, Progress
from rpr_solver.verify.arcs import Controls, Piece, everywhere, leaves, point_at
from rpr_solver.verify.claims import Claim, Open, Refused, demand, open_claim
from rpr_solver.verify.clearance import bend_bound, is_clear, keeps_clear
from rpr_solver.verify.conditioning import Rates, has_condition, is_between
from rpr_solver.verify.equations import THETA, Jets
from rpr_solver.verify.finding import cusps_of
from rpr_solver.verify.members import Document
from rpr_solver.verify.no_paths import obstacle_claims
from rpr_solver.verify.numbers import Printed, ball
from rpr_solver.verify.path_ends import ENDS, PIECE_BITS, PathEnds, in_order
from rpr_solver.verify.reader import Record
from rpr_solver.verify.timing import keeps_time
from rpr_solver.verify.work import Work

_TURN = 360
_OF_EIGENVALUES = 5
"""The work for the singular values on a piece."""
_NOT_VERIFIED = {
    "others": "what becomes of the other poses",
    "motion": "all legs keep the limits of motion",
    "deviation": "linear motion between samples deviates by no more",
}
"""Members of a path that claim what nothing here decides."""


def path_claims(document: Document, work: Work, progress: Progress) -> Iterator[Claim]:
    """The claims of the document of a path, or of why there is none."""
    progress(0, 1)
    path = _Path(document, work)
    yield from path.end_claims()
    yield from obstacle_claims(path) if "obstacle" in document.members else path.claims()
    progress(1, 1)


class _Path(PathEnds):
    """A path by its arcs: what is claimed of it is claimed of all of their points."""

    def claims(self) -> Iterator[Claim]:
        """All claims but those of the ends."""
        members, sign, timing = self.members, self.members["sign"], self.members["timing"]
        yield self.claim_by("/certificate/arcs", "the arcs join both ends", self._joined)
        yield self.claim_by("/certificate/turns", "it begins in the turn of its start", self._begun)
        yield self.claim_by(
            "/connected", "there is a path", lambda: demand(members["connected"], "it is given")
        )
        yield self.claim_by("/closed", "whether it comes back to its leg lengths", self._closed)
        yield self.claim_by("/sign", f"J {'>' if sign > 0 else '<'} 0 all along the arcs", self._sign)
        at = "/certificate/least_determinant"
        yield self.claim_by(at, "the determinant is nowhere less in absolute value", self._least)
        yield self.claim_by("/between", "the length of the fixed leg is kept", self._between)
        for name, limit in (members["limits"] or {}).items():
            keeps = partial(self._keeps, name, limit["min"], limit["max"])
            yield self.claim_by(f"/limits/{name}", f"{name} keeps its limits all along the arcs", keeps)
        yield self.claim_by("/winding", "how often it goes round which cusps", self._winding)
        yield from self._sample_claims()
        if timing == "motion":
            yield open_claim("/timing", "it runs by its law of motion", "motions are not verified")
        else:
            claim = f"it runs by the law {timing}, to a thousandth of its length"
            yield self.claim_by(
                "/timing", claim, lambda: keeps_time(self.space, self.coarse, members, self.work)
            )
        for name, claim in _NOT_VERIFIED.items():
            if members.get(name) is not None:
                yield open_claim(f"/{name}", claim, "this is not verified")
        if "clearance" in members:
            yield from self._clearance_claims(members["clearance"])
        if (condition := members.get("condition")) is not None:
            if condition["asked"] is not None:
                enough = partial(demand, condition["max"] <= condition["asked"], "it is greater")
                yield self.claim_by("/condition/asked", "none is greater than was asked for", enough)
            claim = "the condition numbers of all poses are between these"
            yield self.claim_by("/condition", claim, self._conditions)

    @property
    def exact_arcs(self) -> Sequence[Sequence[Any]]:
        """The control points as the document has them: ends by name, others by α and θ in degrees and L."""
        arcs: Sequence[Sequence[Any]] = self.members["certificate"]["arcs"]
        return arcs

    def arcs(self) -> list[Controls]:
        """The control points of the arcs, at the working precision."""
        if ctx.prec not in self._arcs:
            self._arcs[ctx.prec] = self._refined()
        return self._arcs[ctx.prec]

    @cached_property
    def _arcs(self) -> dict[int, list[Controls]]:
        return {}

    def _refined(self) -> list[Controls]:
        turns, degree = self.members["certificate"]["turns"], arb.pi() / 180
        known: dict[Any, Box] = {}
        for end in ENDS:
            alpha, theta, length = self.place(end)
            first, second = (n * _TURN * degree for n in turns[end].values())
            known[end] = [alpha + first, theta + second, length]
        for p in {p for arc in self.exact_arcs for p in arc if not isinstance(p, str)}:
            known[p] = [ball(p[0]) * degree, ball(p[1]) * degree, ball(p[2] / self.unit)]
        return [[known[p] for p in arc] for arc in self.exact_arcs]

    @property
    def coarse(self) -> list[Controls]:
        """The control points of the arcs, at the precision of the pieces."""
        return [piece.controls for piece in self.pieces]

    @cached_property
    def pieces(self) -> list[Piece]:
        """The arcs as pieces, at a precision that is enough for signs."""
        with ctx.workprec(PIECE_BITS):
            arcs = self.arcs()
        last = len(arcs) - 1
        return [Piece(self.space, arc, self.work, n == 0, n == last) for n, arc in enumerate(arcs)]

    def _joined(self) -> str:
        arcs = self.exact_arcs
        demand((arcs[0][0], arcs[-1][-1]) == ENDS, "they do not begin and end at the ends")
        demand(all(p[-1] == q[0] for p, q in pairwise(arcs)), "one begins elsewhere than the one before ends")
        return "each begins where the one before ends"

    def _begun(self) -> str:
        return demand(not any(self.members["certificate"]["turns"]["from"].values()), "it has turns there")

    def _closed(self) -> str:
        says, first, second = self.members["closed"], *(self.lengths(end) for end in ENDS)
        if any(map(self.is_given, ENDS)):
            with ctx.workprec(PIECE_BITS):
                pairs = list(zip(*(self.legs(self.place(end)).values() for end in ENDS), strict=True))
            if all(x.overlaps(y) for x, y in pairs):
                raise Open("the lengths of both ends are not told apart")
            return demand(not says, "both ends have different lengths", "both ends have different lengths")
        same = all(first[name] == second[name] for name in LEGS)
        return demand(says == same, "the lengths of both ends say otherwise", "by the lengths of both ends")

    def _sign(self) -> str:
        sign = self.members["sign"]
        demand(sign, "0 is no sign")

        def holds(piece: Piece) -> bool | None:
            j = piece.values(lambda poses: poses.singular)
            if j.middle * sign < 0:
                return False
            return True if j.whole * sign > 0 and piece.box[2] > 0 else None

        return demand(everywhere(self.pieces, holds), "J has the other sign somewhere", "on pieces, by balls")

    def _least(self) -> str:
        # J / (4 √f √g) in units is the determinant, f and g being the squared lengths of the free legs
        first, second = self.mechanism.free
        least: Printed = self.members["certificate"]["least_determinant"]
        square = ball((4 * least.value / self.unit) ** 2)

        def holds(piece: Piece) -> bool | None:
            gap = piece.values(
                lambda poses: (
                    poses.singular * poses.singular - poses.square(first) * poses.square(second) * square
                )
            )
            if gap.middle < 0:
                return False
            return True if gap.whole > 0 else None

        return demand(everywhere(self.pieces, holds), "it is less somewhere", "on pieces, by balls")

    @cached_property
    def rates(self) -> Rates:
        """The matrices of the rates of its legs."""
        geometry, scale = self.mechanism.geometry, self.members["condition"]["length_scale"]
        return Rates(geometry, self.mechanism.fixed, scale)

    def _conditions(self) -> str:
        low, high = (ball(self.members["condition"][name]) for name in ("min", "max"))
        unit = ball(self.unit)

        def holds(piece: Piece) -> bool | None:
            self.work.spend(_OF_EIGENVALUES)
            middle = piece.halves[0].controls[-1]
            return is_between(
                self.rates.at(middle, middle[2] * unit),
                self.rates.at(piece.box, piece.box[2] * unit),
                low,
                high,
            )

        return demand(everywhere(self.pieces, holds), "one is not", "by singular values on pieces")

    def _between(self) -> str:
        between = self.members["between"]
        if between is not None:
            return self._fixed_keeps(between["from"], between["to"])
        held = {p[2] for arc in self.exact_arcs for p in arc if not isinstance(p, str)}
        held |= {self.length(end) for end in ENDS}
        return demand(len(held) == 1, "it varies, and no lengths are given", "it is held")

    def _keeps(self, name: str, low: Fraction | None, high: Fraction | None) -> str:
        if name == self.fixed:
            return self._fixed_keeps(low, high)
        leg, walls = int(name[1]), [(side, x) for side, x in ((1, low), (-1, high)) if x is not None]

        def holds(piece: Piece) -> bool | None:
            square, known = piece.values(lambda poses: poses.square(leg)), True
            for side, bound in walls:
                wall = ball((bound / self.unit) ** 2)
                if (square.middle - wall) * side < 0:
                    return False
                # an end may be at its limit, if the leg moves away from it
                leaves_it = piece.is_first and self._is_at("from", name, bound) and square.slope * side > 0
                comes_to_it = piece.is_last and self._is_at("to", name, bound) and square.slope * side < 0
                known = known and bool((square.whole - wall) * side >= 0 or leaves_it or comes_to_it)
            return True if known else None

        return demand(everywhere(self.pieces, holds), "a limit is exceeded", "on pieces, by balls")

    def _is_at(self, end: str, name: str, bound: Fraction) -> bool:
        """Whether a leg has exactly a length at an end."""
        return not self.is_given(end) and bool(self.lengths(end)[name] == bound)

    def _fixed_keeps(self, low: Fraction | None, high: Fraction | None) -> str:
        def beyond(lengths: Sequence[Fraction]) -> bool:
            return any((low is not None and x < low) or (high is not None and x > high) for x in lengths)

        arcs = [[self.length(p) if isinstance(p, str) else p[2] for p in arc] for arc in self.exact_arcs]
        demand(not any(beyond([arc[0], arc[-1]]) for arc in arcs), "an end of an arc is beyond it")
        if any(map(beyond, arcs)):
            raise Open("a control point is beyond it")
        return "all control points keep it"

    def _winding(self) -> str:
        cusp, winding, twins = (self.members.get(name) for name in ("cusp", "winding", "twins"))
        if cusp is None or winding is None:
            none = cusp is None and winding is None and not twins
            return demand(none, "only a loop goes round cusps", "it is no loop")
        own = (cusp, *(twins or ()))
        demand(len(set(own)) == len(own), "a cusp is named twice")
        demand(self.members["closed"] and "l1" in self.members, "it is no closed path")
        demand(self.members["between"] is None, "it is in no slice")
        found = cusps_of(self.mechanism, self.length("from"), self.work)
        if found.open:
            raise Open("it is not proved that the cusps that are found are all")
        demand(max(own) <= len(found.zeros), f"there are {len(found.zeros)} cusps")
        with ctx.workprec(PIECE_BITS):
            for number, zero in enumerate(in_order(found.zeros, THETA), 1):
                centre = self.space.on(
                    [*zero.within(PIECE_BITS // 2), ball(self.length("from") / self.unit)], 0
                )
                turns = self._turns([centre.square(leg).value for leg in self.mechanism.free])
                demand(
                    turns == (winding if number in own else 0), f"it goes round cusp {number} {turns} times"
                )
        return "by half planes that hold the images of pieces"

    def _turns(self, centre: Sequence[arb]) -> int:
        """How often the image of the arcs goes round a point: pieces lie in open half planes beside it."""

        def image(piece: Piece, leg: int) -> arb:
            return piece.values(lambda poses: poses.square(leg)).whole

        def side(piece: Piece) -> int | None:
            images = [image(piece, leg) for leg in self.mechanism.free]
            offs = [x - c for x, c in zip(images, centre, strict=True)]
            quarters = [offs[0] > 0, offs[1] > 0, offs[0] < 0, offs[1] < 0]
            return quarters.index(True) if any(quarters) else None

        decided = leaves(self.pieces, lambda piece: None if side(piece) is None else True)
        found = [quarter for piece, _ in decided if (quarter := side(piece)) is not None]
        steps = [(y - x + 1) % 4 - 1 for x, y in zip(found, [*found[1:], found[0]], strict=True)]
        return sum(steps) // 4

    def _sample_claims(self) -> Iterator[Claim]:
        samples: Sequence[Record] = self.members["samples"]
        yield self.claim_by("/samples", "the times ascend from 0 to the duration, as asked for", self._times)
        yield self.claim_by("/samples", "the places ascend from end to end", self._places)
        for n, sample in enumerate(samples):
            here, at, nearer = _Sample(self, sample), f"/samples/{n}", "no singular pose is nearer than this"
            yield self.claim_by(at, "a point of the arcs at its place", here.has_digits)
            yield self.claim_by(f"{at}/clearance_deg", nearer, here.is_clear)
            if "condition" in self.members:
                yield self.claim_by(f"{at}/condition", "its condition number", here.has_condition)

    def _times(self) -> str:
        samples, duration = self.members["samples"], self.members["duration"]
        times, last, step = [x["time"] for x in samples], len(samples) - 1, self.members.get("sampling")
        if "deviation" not in self.members:
            even = [duration * Fraction(n, last) for n in range(last + 1)]
            return demand(times == even, "they are not equally spaced", "they are equally spaced")
        if step is not None and "step" in step:
            steps = [*(n * step["step"] for n in range(last)), duration]
            demand(times == steps and last * step["step"] >= duration, "they are not so many steps")
        demand((times[0], times[-1]) == (0, duration), "they are not from 0 to the duration")
        return demand(all(x < y for x, y in pairwise(times)), "they do not ascend", "as they are")

    def _places(self) -> str:
        places, count = [x["place"] for x in self.members["samples"]], len(self.exact_arcs)
        demand((places[0], places[-1]) == (0, count), "they are not from end to end")
        return demand(all(x <= y for x, y in pairwise(places)), "they do not ascend", "as they are")

    def _clearance_claims(self, clearance: Record) -> Iterator[Claim]:
        asked, proved = clearance["asked"], clearance["proved"]
        if asked != "best":
            enough = partial(demand, proved >= asked, "it is less")
            yield self.claim_by("/clearance/asked", "it is as clear as was asked for", enough)

        def clear() -> str:
            return keeps_clear(self.space, self.coarse, self.members["sign"], proved, self.work)

        yield self.claim_by("/clearance/proved", "no singular pose is nearer to any of its poses", clear)
        claims = {
            "bound": "no path between these poses has a greater clearance",
            "legs": "no fold is met while legs change by less",
            "radius": "its radius of curvature is nowhere less",
        }
        for name, claim in claims.items():
            if name != "bound" or clearance[name] is not None:
                yield open_claim(f"/clearance/{name}", claim, "this is not verified")


@dataclass(frozen=True)
class _Sample:
    """A sample of a path, and the point of the arcs at its place."""

    path: _Path
    sample: Record

    @cached_property
    def _at(self) -> Box:
        arcs = self.path.arcs()
        arc = min(int(self.sample["place"]), len(arcs) - 1)
        self.path.work.spend(1, ctx.prec)
        return point_at(arcs[arc], self.sample["place"] - arc)

    @cached_property
    def _singular(self) -> Jets:
        return self.path.space.on(self._at, 1).singular

    def has_digits(self) -> str:
        """Proves that the numbers are those of the point."""
        path, legs = self.path, self.path.legs(self._at)
        first, second = (legs[f"l{leg}"] for leg in path.mechanism.free)
        degrees = (x * 180 / arb.pi() for x in self._at[:2])
        # J / (4 √f √g) in units, f and g being the squared lengths of the free legs
        determinant = self._singular.value * ball(path.unit**3) / (4 * first * second)
        values = {**dict(zip(path.angles, degrees, strict=True)), **legs, "determinant": determinant}
        found = {name: self.sample[name].rounds(x) for name, x in values.items()}
        wrong = next((name for name, right in found.items() if right is False), None)
        if wrong is not None and any(map(path.is_given, ENDS)):
            raise Open(f"{wrong} is not that of the arcs, if the angles at the ends are exact")
        demand(wrong is None, f"{wrong} has other digits")
        if not all(found.values()):
            raise Open("a number is half way between two decimals, or exactly 0, as far as balls tell")
        return "the point is evaluated by balls"

    def has_condition(self) -> str:
        """Proves its condition number."""
        path = self.path
        number = self.sample.get("condition")
        if number is None:
            raise Refused("it has none")

        def at(_bits: int) -> arb:
            arcs = path.arcs()
            arc = min(int(self.sample["place"]), len(arcs) - 1)
            place = point_at(arcs[arc], self.sample["place"] - arc)
            return path.rates.condition(place, place[2] * ball(path.unit))

        return has_condition(number, at, path.work)

    def is_clear(self) -> str:
        """Proves that no singular pose is nearer."""
        radius = ball(self.sample["clearance_deg"].value) * arb.pi() / 180
        if not is_clear(self._singular, bend_bound(self.path.space, self._at[2]), radius):
            raise Open("it is greater than what J and its slope there prove")
        return "by J and its slope there, and a bound of its second derivatives"
