"""Margins: the count, the proof of a full certificate, the counter-example, and what follows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial

from rpr_solver.contract import MOST_CUSPS, Progress
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, brief, judged, worked
from rpr_solver.verify.core.numbers import LENGTHS, Geometry
from rpr_solver.verify.core.reader import Record, refusal
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Slice
from rpr_solver.verify.degeneracy import Bound
from rpr_solver.verify.events import Crossings, Events
from rpr_solver.verify.exclusion import Region, Span, flaw
from rpr_solver.verify.ranges import Range, Requirement
from rpr_solver.verify.tables import count_of_shape

FULL = "/certificate/full"


@dataclass(frozen=True)
class Proof:
    """The proof of a full certificate, of all geometries within the radius of a margin."""

    margin: _Margin
    radius: Fraction
    full: Record

    @property
    def _asked(self) -> Requirement:
        return self.margin.requirement

    @cached_property
    def _spans(self) -> tuple[Span, ...]:
        lengths = (getattr(self.margin.geometry, g) for g in LENGTHS)
        pairs = zip(lengths, self.margin.weights, strict=True)
        return tuple((x - self.radius * w, x + self.radius * w) for x, w in pairs)

    @cached_property
    def _most(self) -> list[Fraction]:
        return [max(map(abs, span)) for span in self._spans]

    def finding(self, number: int | None = None) -> Finding:
        """Whether all geometries within the radius have the property, or as many cusps as given."""
        length, flaws = self._sample, self._flaw
        if flaws is not None:
            return ClaimStatus.REFUSED, flaws
        found = self._found
        wanted = self.margin.count if number is None else number
        if wanted is None and found is not None:
            wanted = found[0]
        status, reason = compared(wanted or 0, found)
        if status is ClaimStatus.PROVED and not self._asked.admits(wanted or 0):
            return ClaimStatus.REFUSED, f"the slice at {brief(length)} has {wanted}, which is not admitted"
        if status is not ClaimStatus.PROVED:
            return status, f"in the slice at {brief(length)}: {reason}"
        parts = sum(cuts.count(".") for cuts in self.full["cuts"])
        reason = f"no cusp degenerates, in {parts} parts; the slice at {brief(length)} has {wanted}"
        return ClaimStatus.PROVED, reason

    @cached_property
    def _found(self) -> tuple[int, bool] | None:
        return self.margin.number(self.margin.geometry, self._sample)

    @cached_property
    def _sample(self) -> Fraction:
        """A length of the fixed leg for the given geometry, within the regions of the proof."""
        if self.margin.subject == "window":
            length: Fraction = self.full.get("length", Fraction(1))
            return length
        start, stop = self._asked.start, self._asked.stop
        return (start + (2 * start + 1 if stop is None else stop)) / 2

    @cached_property
    def _flaw(self) -> str | None:
        """Why the certificate is no proof; None if it is one."""
        named = {"window": {"length", "rates"}, "requirement": {"turn"}}.get(self.margin.subject, set())
        named = set() if named == {"turn"} and self._asked.stop is not None else named
        if set(self.full) != {"cuts", *named}:
            return f"it should have the members cuts, {', '.join(sorted(named))}"
        regions = list(self._regions())
        if len(regions) != len(self.full["cuts"]):
            return f"{len(regions)} regions are to be cut"
        for n, (region, cuts) in enumerate(zip(regions, self.full["cuts"], strict=True)):
            reason = region if isinstance(region, str) else flaw(region, cuts)
            if reason is not None:
                return f"{FULL}/cuts/{n}: {reason}"
        return None

    def _regions(self) -> Iterator[Region | str]:
        """What is to be proved, with the reason where it cannot be."""
        if self.margin.subject == "window":
            length, rates = self.full["length"], tuple(self.full["rates"][g] for g in LENGTHS)
            change = sum(abs(rate) * (b - a) / 2 for rate, (a, b) in zip(rates, self._spans, strict=True))
            yield self._region((length, length), rates) if change < length else "a length is not > 0"
            return
        start, stop = self._asked.start, self._asked.stop
        if stop is not None:
            yield self._region((start, stop))
            return
        turn: Fraction = self.full["turn"]
        bounds = [bound for both in self._asked.limits.of_legs.values() for bound in both]
        if turn <= sum(self._most) + max([bound for bound in bounds if bound is not None], default=0):
            yield "turn is not far beyond all lengths"
            return
        if start < turn:
            yield self._region((start, turn))
        # beyond, all legs are longer than any limit
        if not any(most is not None for _, most in self._asked.limits.of_legs.values()):
            yield self._region((Fraction(0), 1 / max(turn, start)), inverse=True)

    def _region(
        self,
        fixed: Span,
        rates: tuple[Fraction, ...] = (Fraction(0),) * len(LENGTHS),
        *,
        inverse: bool = False,
    ) -> Region:
        geometry = self.margin.geometry
        n, d = max(*self._most, 1 / fixed[1] if inverse else fixed[1]).as_integer_ratio()
        # a power of two near the longest length
        unit = Fraction(2) ** (n.bit_length() - d.bit_length())
        first, second = geometry.free_legs(self.margin.fixed)
        limits = (
            ()
            if inverse
            else tuple(
                Bound((first, second).index(leg), side, bound / unit)
                for leg, both in self._asked.limits.of_legs.items()
                for side, bound in zip((-1, 1), both, strict=True)
                if bound is not None
            )
        )
        flat = geometry.height_squared == 0
        return Region(
            self.margin.fixed,
            0 if flat else -1 if geometry.clockwise else 1,
            tuple((low / unit, high / unit) for low, high in self._spans),
            (fixed[0] * unit, fixed[1] * unit) if inverse else (fixed[0] / unit, fixed[1] / unit),
            inverse,
            rates,
            limits,
        )


def compared(number: int, found: tuple[int, bool] | None) -> Finding:
    """A number of cusps against what was counted."""
    if found is None:
        return ClaimStatus.NOT_CHECKED, "its cusps are not counted"
    if found[0] != number:
        return ClaimStatus.REFUSED, f"it has {found[0]}"
    if not found[1]:
        return ClaimStatus.CHECKED, "as many are found; that there are no others is not proved"
    return ClaimStatus.PROVED, "all its cusps are found anew"


_EVENT_BITS = 128
_VALIDITY_DIGITS = 6
_SUBJECTS = ("window", "requirement")
_ASK = "the proof is in the full certificate: ask for --certificate full"
_LOCATED = "no certificate has the proof where transitions lie in the range"
_BEYOND = "that nothing is degenerate beyond the joint limits is not shown"
_WITHIN = "all geometries within this radius have the property"


def margin_claims(document: Document, progress: Progress) -> Iterator[Claim]:
    """The claims of a margin."""
    yield from _Margin(document).claims(progress)


class _Margin:
    def __init__(self, document: Document) -> None:
        self.members, self.geometry, self.fixed = document.members, document.geometry, document.fixed
        self.asked: Record = self.members["asked"]
        self.weights = tuple(self.members["weights"][name] for name in LENGTHS)
        self.proved: Fraction | None = self.members["proved"]
        self.example: Record | None = self.members["counterexample"]
        self.count: int | None = self.members["count"]
        names = [name for name in (f"l{self.fixed}", *_SUBJECTS) if name in self.asked]
        if len(names) != 1:
            raise refusal("/asked", "has not exactly one of a length, a window and a requirement")
        [self.subject] = names
        if self.count is None and self.subject != "requirement":
            raise refusal("/count", "is missing")

    @cached_property
    def requirement(self) -> Requirement:
        """What is asked for; of a slice, or one in a window, both ends of the range are its length."""
        if self.subject == "requirement":
            return Requirement.of(self.asked["requirement"])
        return Requirement(self.asked[self.subject], self.asked[self.subject])

    def number(self, geometry: Geometry, length: Fraction) -> tuple[int, bool] | None:
        """The number of cusps of a slice within the limits, and whether it is proved; None if it is open."""
        surface, limits = Surface(geometry, self.fixed), self.requirement.limits
        return count_of_shape(surface, length, limits) or limits.counted(Slice(surface.at(length)))

    def claims(self, progress: Progress) -> Iterator[Claim]:
        """All claims; those that cost work only if the others fit together."""
        fit = list(self._fitting())
        yield from fit
        if any(claim.status is ClaimStatus.REFUSED for claim in fit):
            return
        full: Record | None = self.members["certificate"].get("full")
        proof = None
        if full is not None and self.proved:
            proof = Proof(self, self.proved, full)
        progress(0, 3)
        if self.example is not None:
            yield worked(*self.of_example, partial(self._refuted, self.example))
        progress(1, 3)
        if self.count is not None:
            yield worked(*self.of_count, partial(self._counted, self.count, proof))
        progress(2, 3)
        if self.proved:
            yield worked("/proved", _WITHIN, partial(self._within, proof))
        progress(3, 3)

    def _within(self, proof: Proof | None) -> Finding:
        refused = "requirement" in self.asked and self.asked["requirement"]["degenerate"] == "refused"
        if proof is not None:
            found = proof.finding()
            if found[0] is ClaimStatus.PROVED and refused and self.requirement.limits.each:
                raise OpenError(_BEYOND)
            return found
        if self.subject == "requirement" and not refused and self.requirement.admits_all(MOST_CUSPS):
            # the degree of the eliminant (mathematics.md#simple-roots)
            return ClaimStatus.PROVED, f"no slice of any geometry has more than {MOST_CUSPS} cusps"
        raise OpenError(_ASK if self.count is not None else _LOCATED)

    def _fitting(self) -> Iterator[Claim]:
        """That the members follow from each other."""

        def claim(at: str, text: str, right: bool, wrong: str = "they contradict each other") -> Claim:
            return judged(at, text, right, "as printed", wrong)

        tolerance = self.asked.get("tolerance")
        right = any(self.weights) and (tolerance is None or dict(tolerance) == dict(self.members["weights"]))
        yield claim("/weights", "what radii multiply", right)
        own = _validity(self.geometry, self.weights)
        right = self.members["validity"] == (None if own is None else _rounded_down(own))
        yield claim("/validity", "from this radius on a geometry may be flat", right, f"it is {brief(own)}")
        example, proved = self.example, self.proved
        if proved is not None:
            right = (own is None or proved < own) or not proved
            right = right and (example is None or proved < example["radius"])
            right = right and (tolerance is None or proved == 1)
            yield claim("/proved", "below validity and counter-example, 1 for a tolerance", right)
        verdict = None
        if tolerance is not None:
            verdict = "proved" if proved else "refuted" if example and example["radius"] <= 1 else "open"
        right = self.members["verdict"] == verdict
        yield claim("/verdict", "it follows from what is proved and refuted", right, f"it is {verdict}")
        if "full" in self.members["certificate"]:
            yield claim(FULL, "a proof of what is proved", bool(proved))
        if example is not None:
            yield from self._example_fits(example)
        if self.subject == "requirement":
            asked = self.requirement
            right = (asked.stop is None or asked.start < asked.stop) and asked.is_bounded
            yield claim("/asked", "a range of lengths, and a bound of the number of cusps", right)

    def _example_fits(self, example: Record) -> Iterator[Claim]:
        """That a counter-example is as far away as it says, and not as the property wants it."""
        other: Geometry = example["geometry"]
        pairs = zip(LENGTHS, self.weights, strict=True)
        changes = [(abs(getattr(other, g) - getattr(self.geometry, g)), w) for g, w in pairs]
        radius = max((d / w for d, w in changes if w), default=Fraction(0))
        right = radius == example["radius"] and not any(d for d, w in changes if not w)
        right = right and other.clockwise == self.geometry.clockwise
        at, claim = "/counterexample/radius", "the distance of the counter-example"
        yield judged(at, claim, right, "as printed", f"it is {brief(radius)}")
        length, number, asked = example[f"l{self.fixed}"], example["count"], self.requirement
        if self.subject == "window":
            right = length is None and number is None
        elif length is None or number is None:
            right = False
        elif self.subject == "requirement":
            inside = asked.start <= length and (asked.stop is None or length <= asked.stop)
            right = inside and not asked.admits(number)
        else:
            right = length == asked.start and number != self.count
        claim = "a slice without the property"
        yield judged("/counterexample", claim, right, "as printed", "it would have the property")

    @property
    def of_example(self) -> tuple[str, str]:
        """The member that says what a counter-example has, and what it says."""
        if self.subject == "window":
            return "/counterexample/geometry", f"no window of it has {self.count} cusps"
        number = None if self.example is None else self.example["count"]
        return "/counterexample/count", f"{number} cusps in this slice of the counter-example"

    @property
    def of_count(self) -> tuple[str, str]:
        """The member that says what the given geometry has, and what it says."""
        subjects = {"requirement": "every slice of the range", "window": "the window at this length"}
        return "/count", f"{self.count} cusps in {subjects.get(self.subject, 'this slice')}"

    def _refuted(self, example: Record) -> Finding:
        """Whether a counter-example is one."""
        geometry = example["geometry"]
        if self.subject == "window":
            return self._has_no_window(geometry)
        number, length = example["count"], example[f"l{self.fixed}"]
        return compared(number, self.number(geometry, length))

    def _has_no_window(self, geometry: Geometry) -> Finding:
        """Whether no window of a geometry has the number of cusps, by a slice between each two events."""
        whole = self._range(geometry, Fraction(0), None)
        gaps = whole.gaps(0)
        found = [whole.slice_in(gap)[1] for gap in gaps]
        if any(x is not None and x[0] == self.count for x in found):
            return ClaimStatus.REFUSED, "one has as many"
        if whole.open or not gaps or not all(x is not None and x[1] for x in found):
            reason = f"no slice at random has as many; left open: {'; '.join(whole.open) or 'some numbers'}"
            return ClaimStatus.CHECKED, reason
        return ClaimStatus.PROVED, "all its events are found, and a slice between each two has another number"

    def _counted(self, count: int, proof: Proof | None) -> Finding:
        """Whether the given geometry has the number of cusps."""
        asked = self.requirement
        if self.subject == "requirement":
            if proof is not None:
                return proof.finding(count)
            return self._range(self.geometry, asked.start, asked.stop).counted(0, count, asked.limits)
        found = self.number(self.geometry, asked.start)
        if self.subject == "window" and not (found and found[1]):
            return self._in_window(count)
        return compared(count, found)

    def _in_window(self, count: int) -> Finding:
        """Whether slices just above the length that is asked for, which may be a transition, have so many."""
        above = self._range(self.geometry, self.requirement.start, None)
        if above.open or not (gaps := above.gaps(0)):
            raise OpenError(f"left open: {'; '.join(above.open) or 'the window'}")
        return compared(count, above.slice_in(gaps[0])[1])

    def _range(self, geometry: Geometry, start: Fraction, stop: Fraction | None) -> Range:
        """All events of a geometry, with the crossings of the limits, and a range."""
        events = Events(Surface(geometry, self.fixed), _EVENT_BITS)
        crossings = Crossings(events, self.requirement.limits.each, _EVENT_BITS)
        return Range(events, [], start, stop, crossings)


def _validity(geometry: Geometry, weights: tuple[Fraction, ...]) -> Fraction | None:
    """The radius at which the first platform is flat, or two base points coincide; None if there is none."""
    g, w = geometry, dict(zip(LENGTHS, weights, strict=True))
    change = w["d1"] + w["d2"] + w["d3"]
    radii = [(g.d1 + g.d2 + g.d3 - 2 * side) / change for side in (g.d1, g.d2, g.d3) if change]
    if w["a2x"]:
        radii.append(abs(g.a2x) / w["a2x"])
    for along, by in ((g.a3x, w["a3x"]), (g.a3x - g.a2x, w["a3x"] + w["a2x"])):
        ways = [(along, by), (g.a3y, w["a3y"])]
        if all(step or not distance for distance, step in ways):
            radii.append(max((abs(distance) / step for distance, step in ways if step), default=Fraction(0)))
    return min(radii, default=None)


def _rounded_down(x: Fraction) -> Fraction:
    """The greatest number of six digits that is not greater."""
    unit = Fraction(1)
    while x >= unit * 10**_VALIDITY_DIGITS:
        unit *= 10
    while x and x < unit * 10 ** (_VALIDITY_DIGITS - 1):
        unit /= 10
    return x // unit * unit
