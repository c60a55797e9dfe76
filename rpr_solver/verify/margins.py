"""Margins: the count, the proof for all geometries within a radius, the counter-example, and what follows."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cached_property, partial

from rpr_solver.contract import Progress
from rpr_solver.verify.censuses import Range
from rpr_solver.verify.claims import Claim, ClaimStatus, Finding, OpenError, judged, worked
from rpr_solver.verify.core.numbers import LENGTHS, Geometry
from rpr_solver.verify.core.reader import Record, refusal
from rpr_solver.verify.core.schema import Document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import Bounds, Limits
from rpr_solver.verify.events import Crossings, Events
from rpr_solver.verify.margin_proofs import FULL, Proof, Scope, compared

_EVENT_BITS = 128
_VALIDITY_DIGITS = 6
_SUBJECTS = ("window", "requirement")
_ASK = "the proof is in the full certificate: ask for --certificate full"
_LOCATED = "no certificate has the proof where transitions lie in the range"


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
    def scope(self) -> Scope:
        """What is asked for."""
        if self.subject != "requirement":
            length = self.asked[self.subject]
            return Scope(self.subject, self.fixed, length, length, Limits({}))
        requirement: Record = self.asked["requirement"]
        span, limits = requirement["range"], (requirement.get("limits") or {})
        bounds: dict[int, Bounds] = {int(x[1]): (y.get("min"), y.get("max")) for x, y in limits.items()}
        ends, counts = (span["from"], span["to"]), (requirement["min_cusps"], requirement["max_cusps"])
        return Scope(self.subject, self.fixed, *ends, Limits(bounds), *counts)

    def claims(self, progress: Progress) -> Iterator[Claim]:
        """All claims; those that cost work only if the others fit together."""
        fit = list(self._fitting())
        yield from fit
        if any(claim.status is ClaimStatus.REFUSED for claim in fit):
            return
        full: Record | None = self.members["certificate"].get("full")
        proof = None
        if full is not None and self.proved:
            proof = Proof(self.geometry, self.weights, self.proved, self.scope, self.count, full)
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
        if proof is None:
            raise OpenError(_ASK if self.count is not None else _LOCATED)
        return proof.finding()

    def _fitting(self) -> Iterator[Claim]:
        """That the members follow from each other."""

        def claim(at: str, text: str, right: bool, wrong: str = "they contradict each other") -> Claim:
            return judged(at, text, right, "as printed", wrong)

        tolerance = self.asked.get("tolerance")
        right = any(self.weights) and (tolerance is None or dict(tolerance) == dict(self.members["weights"]))
        yield claim("/weights", "what radii multiply", right)
        own = _validity(self.geometry, self.weights)
        right = self.members["validity"] == (None if own is None else _rounded_down(own))
        yield claim("/validity", "from this radius on a geometry may be flat", right, f"it is {own}")
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
            scope = self.scope
            right = (scope.stop is None or scope.start < scope.stop) and scope.is_bounded
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
        yield judged(at, claim, right, "as printed", f"it is {radius}")
        length, number, scope = example[f"l{self.fixed}"], example["count"], self.scope
        if self.subject == "window":
            right = length is None and number is None
        elif length is None or number is None:
            right = False
        elif self.subject == "requirement":
            inside = scope.start <= length and (scope.stop is None or length <= scope.stop)
            right = inside and not scope.admits(number)
        else:
            right = length == scope.start and number != self.count
        claim = "a slice without the property"
        yield judged("/counterexample", claim, right, "as printed", "it would have the property")

    @property
    def of_example(self) -> tuple[str, str]:
        """The member that says what a counter-example has, and what it says."""
        if self.subject == "window":
            return "/counterexample/geometry", f"no slice of it has {self.count} cusps"
        number = None if self.example is None else self.example["count"]
        return "/counterexample/count", f"{number} cusps in this slice of the counter-example"

    @property
    def of_count(self) -> tuple[str, str]:
        """The member that says what the given geometry has, and what it says."""
        where = "every slice of the range" if self.subject == "requirement" else "this slice"
        return "/count", f"{self.count} cusps in {where}"

    def _refuted(self, example: Record) -> Finding:
        """Whether a counter-example is one."""
        geometry = example["geometry"]
        if self.subject == "window":
            return self._has_no_window(geometry)
        number, length = example["count"], example[f"l{self.fixed}"]
        return compared(number, self.scope.counted(geometry, length))

    def _has_no_window(self, geometry: Geometry) -> Finding:
        """Whether no slice of a geometry has the number of cusps, by one in each interval between events."""
        events = Events(Surface(geometry, self.fixed), _EVENT_BITS)
        whole = Range(events, [], Fraction(0), None)
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
        if self.subject != "requirement":
            return compared(count, self.scope.counted(self.geometry, self.asked[self.subject]))
        if proof is not None:
            return proof.finding(count)
        scope = self.scope
        events = Events(Surface(self.geometry, self.fixed), _EVENT_BITS)
        crossings = Crossings(events, scope.limits.each, _EVENT_BITS)
        whole = Range(events, [], scope.start, scope.stop, crossings)
        return whole.counted(0, count, scope.limits.counted)


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
