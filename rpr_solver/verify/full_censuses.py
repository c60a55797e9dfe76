"""Full certificates of censuses: the eliminants, their real roots, the boxes of all events, the transitions.

The events are the real common zeros of two systems, and above each simple real root of an eliminant there is
one with a length > 0 (mathematics.md#the-eliminants-of-the-census,
mathematics.md#completeness-of-the-events). So a census is complete if its eliminants are right, each real
root has its event, and no pose that is singular for every length is ever degenerate. That the eliminants are
right is checked at places drawn by the operating system; all that rests on it has the same error probability.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from random import SystemRandom

from rpr_solver.verify.claims import Claim, ClaimStatus, status_of
from rpr_solver.verify.core.boxes import Pair
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.roots import Root, refined
from rpr_solver.verify.core.surds import Poly, primitive
from rpr_solver.verify.core.system import Trig, derivative
from rpr_solver.verify.events import GENERIC, EventBox, ProvedEvent, kind_finding, matched, proved_event
from rpr_solver.verify.full import form_of, isolation_claim, squarefree
from rpr_solver.verify.lines import common_zero
from rpr_solver.verify.permanent import never_degenerate
from rpr_solver.verify.specialisations import Identity, Place, agree
from rpr_solver.verify.surface import CRITICAL, SWALLOWTAIL, Surface

AT = "/certificate/full"
PRIMES = 12
"""At two values of v each, the eliminants are compared with resultants."""
CHANCE = "2^-200"
"""Bounds the probability that a wrong eliminant passes (docs/verify.md#randomness)."""
_LINE_BITS = 160
_SYSTEMS: Mapping[str, tuple[str, Identity]] = {
    "swallowtails": (SWALLOWTAIL, Place.swallowtails),
    "critical poses": (CRITICAL, Place.critical),
}
"""Name → the equations of its events, and the identity of its eliminant."""
COMPLETE = f"the eliminants agree at {2 * PRIMES} random places, and each real root has its event"
Row = tuple[Printed, Sequence[Record]]
"""The length of a transition, and its events."""
Span = tuple[Fraction, Fraction]
"""Two numbers between which the length of a transition is."""


@dataclass(frozen=True)
class Finding:
    """How a part of the certificate stands: its claims, and what it leaves open about completeness."""

    claims: tuple[Claim, ...]
    open: tuple[str, ...] = ()

    @property
    def refused(self) -> bool:
        """Whether a claim is refused."""
        return any(claim.status is ClaimStatus.REFUSED for claim in self.claims)


@dataclass(frozen=True)
class ListedEvent:
    """A box of the certificate, with its proof, or None."""

    at: str
    box: EventBox
    proof: ProvedEvent | None


@dataclass(frozen=True)
class FullCensus:
    """The full certificate of a census."""

    surface: Surface
    full: Record

    @cached_property
    def events(self) -> list[ListedEvent]:
        """All boxes, each with its proof."""
        found = []
        for n, entry in enumerate(self.full["events"]):
            box = EventBox.of(entry, self.surface.fixed)
            found.append(ListedEvent(f"{AT}/events/{n}", box, proved_event(self.surface, box)))
        return found

    def boxes(self) -> Finding:
        """Each box holds one zero of the equations of its kind."""
        claims, still_open = [], set()
        for event in self.events:
            kind, status = event.box.kind, ClaimStatus.REFUSED
            if event.proof is not None:
                status, reason = kind_finding(self.surface, kind, event.proof)
            elif event.box.fault or kind in GENERIC:
                reason = event.box.fault or "no zero of the equations of its kind is proved in it"
            else:
                status, reason = ClaimStatus.NOT_CHECKED, "no regular system of equations is known for it"
            if kind not in GENERIC:
                still_open.add(f"a {kind} is no regular zero of the two systems")
            claims.append(Claim(event.at, f"one {kind} in this box", status, reason))
        return Finding(tuple(claims), tuple(sorted(still_open)))

    def permanent(self) -> Finding:
        """No pose that is singular for every length is degenerate for any."""
        claim = "no pose that is singular for every length is among the events"
        if never_degenerate(self.surface):
            reason = "at each, intervals exclude a common root of the conditions in the length"
            return Finding((Claim(f"{AT}/events", claim, ClaimStatus.PROVED, reason),))
        reason = "intervals do not exclude it"
        claims = (Claim(f"{AT}/events", claim, ClaimStatus.NOT_CHECKED, reason),)
        return Finding(claims, ("poses that are singular for every length",))

    def systems(self) -> Iterator[Finding]:
        """The findings of all systems."""
        listed = self.full["systems"]
        for n, system in enumerate(listed):
            yield self._system(system, f"{AT}/systems/{n}")
        names = [system["name"] for system in listed]
        if names[:2] != list(_SYSTEMS) or len(names) != len(set(names)):
            status = ClaimStatus.REFUSED if names else ClaimStatus.NOT_CHECKED
            reason = "both systems are needed, each once" if names else "the certificate has no eliminants"
            claim = Claim(f"{AT}/systems", "the systems of all events", status, reason)
            yield Finding((claim,), ("the events are not isolated",))

    def _system(self, system: Record, at: str) -> Finding:
        if system["name"] not in _SYSTEMS:
            reason = "it counts where the two systems share angles, which is not repeated here"
            claim = Claim(at, f"the system {system['name']}", ClaimStatus.NOT_CHECKED, reason)
            return Finding((claim,), ("the two systems share angles",))
        equations, identity = _SYSTEMS[system["name"]]
        ring, polynomial = self.surface.ring, system["polynomial"]
        form = form_of(ring, polynomial)
        named = f"the eliminant of {system['name']}"
        if form is None or not any(map(any, form)):
            reason = "it is 0, or has another square root"
            return Finding((Claim(f"{at}/polynomial", named, ClaimStatus.REFUSED, reason),))
        same = agree(self.surface, form, identity, SystemRandom(), PRIMES)
        if same is None:
            reason = "the two equations share angles, so their resultant is 0"
            claim = Claim(f"{at}/polynomial", named, ClaimStatus.NOT_CHECKED, reason)
            return Finding((claim,), ("the two equations of a system share angles",))
        if not same:
            reason = "it is no factor of the resultant that is derived here"
            return Finding((Claim(f"{at}/polynomial", named, ClaimStatus.REFUSED, reason),))
        reason = f"at {2 * PRIMES} places drawn by the operating system it is a factor of the resultant"
        claims = [Claim(f"{at}/polynomial", named, ClaimStatus.CHECKED, reason, CHANCE)]
        still_open = []
        finite = primitive(form)
        if len(finite) < len(form):
            still_open.append("an eliminant has an infinite root")
        place = system["squarefree"]
        parts: Mapping[int, Poly] = {1: finite}
        if place is None:
            parts = ring.squarefree_parts(finite)
        else:
            right = squarefree(ring, polynomial, finite, place)
            reason = "computed modulo it" if right else "it does not hold"
            claim = Claim(f"{at}/squarefree", "a prime proves it squarefree", status_of(right), reason)
            claims.append(claim)
        claims.append(isolation_claim(ring, parts, system["real_roots"], f"{at}/real_roots"))
        if any(claim.status is ClaimStatus.REFUSED for claim in claims):
            return Finding(tuple(claims))
        above = self._above(system["real_roots"], parts, equations, f"{at}/real_roots")
        return Finding((*claims, *above.claims), (*still_open, *above.open))

    def _above(self, roots: Sequence[Record], parts: Mapping[int, Poly], equations: str, at: str) -> Finding:
        """Each simple root has one event, and each event of the system is above a root."""
        claim, still_open = "one event above each simple real root", set()
        tangents = [
            (event, event.proof.tangent(self.surface))
            for event in self.events
            if event.proof is not None and event.proof.system == equations and event.box.kind in GENERIC
        ]
        placed = 0
        for root in roots:
            low, high = root["lower"], root["upper"]
            here = [event.at for event, v in tangents if v is not None and v.inside(low, high)]
            placed += len(here)
            if root["multiplicity"] > 1:
                still_open.add("an eliminant has multiple real roots")
            elif len(here) > 1:
                reason = f"{' and '.join(here)} are above one root"
                return Finding((Claim(at, claim, ClaimStatus.REFUSED, reason),))
            elif not here and self._has_event(parts[1], Root(low, high, inverted=False), equations):
                reason = f"no event is listed above the root between {float(low):.9g} and {float(high):.9g}"
                return Finding((Claim(at, claim, ClaimStatus.REFUSED, reason),))
            elif not here:
                still_open.add("above a root the length is 0 or infinite, as far as intervals tell")
        if placed < len(tangents):
            still_open.add("an event is above no real root")
        reason = "; ".join(sorted(still_open)) or "tan theta of its box is in the interval of the root"
        chance = None if still_open else CHANCE
        return Finding((Claim(at, claim, ClaimStatus.CHECKED, reason, chance),), tuple(still_open))

    def _has_event(self, part: Poly, root: Root, equations: str) -> bool:
        """Whether intervals exclude that the zero above a root has the length 0, or an infinite one."""
        radicand, leg = self.surface.ring.radicand, self.surface.legs[0]
        line = _line(refined(self.surface.ring, part, root, Fraction(1, 1 << _LINE_BITS)))
        if equations == CRITICAL:
            ends: list[list[Trig]] = [
                [p, derivative(p, theta=False), derivative(p, theta=True)] for p in self.surface.singular
            ]
        else:
            graded = self.surface.singular, leg.kernel, leg.kernel2
            degrees = 1, 2, 3
            ends = [
                [p[0] for p in graded],
                [p[k] if k < len(p) else {} for p, k in zip(graded, degrees, strict=True)],
            ]
        return all(common_zero(functions, radicand, line) is None for functions in ends)


def _line(root: Root) -> Pair:
    """Cosine and sine of a direction with tan θ in an interval."""
    middle, radius = (root.lower + root.upper) / 2, root.width / 2
    v, one = Interval.of(middle, _LINE_BITS, radius), Interval.of(1, _LINE_BITS)
    size = (one + v * v).root()
    return one.over(size), v.over(size)


@dataclass(frozen=True)
class Completeness:
    """The claims of a full certificate about a census.

    Attributes:
        claims: about the certificate.
        open: what it leaves open; None if a claim is refused.
        spans: for each transition between which two numbers its length is.
    """

    claims: tuple[Claim, ...]
    open: tuple[str, ...] | None
    spans: tuple[Span, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether nothing is refused or left open, but for the error probability."""
        return self.open == ()

    def claim(self, at: str, claim: str) -> Claim:
        """A claim that rests on the whole certificate."""
        if self.open is None:
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, "the certificate is refused")
        if self.open:
            return Claim(at, claim, ClaimStatus.CHECKED, f"left open: {'; '.join(self.open)}")
        return Claim(at, claim, ClaimStatus.CHECKED, COMPLETE, CHANCE)


def completeness(
    surface: Surface, full: Record, rows: Sequence[Row], start: Fraction, stop: Fraction | None
) -> Completeness:
    """Verifies a full certificate, and compares its boxes with the transitions.

    Args:
        surface: the equations.
        full: the member ``full`` of the certificate.
        rows: the transitions.
        start, stop: the range; None is an open end.
    """
    certificate = FullCensus(surface, full)
    matching, spans = _matching(surface, certificate.events, rows, start, stop)
    findings = [certificate.boxes(), certificate.permanent(), *certificate.systems(), matching]
    claims = tuple(claim for finding in findings for claim in finding.claims)
    if any(finding.refused for finding in findings):
        return Completeness(claims, None)
    still_open = sorted({text for finding in findings for text in finding.open})
    return Completeness(claims, tuple(still_open), spans)


def _matching(
    surface: Surface,
    events: Sequence[ListedEvent],
    rows: Sequence[Row],
    start: Fraction,
    stop: Fraction | None,
) -> tuple[Finding, tuple[Span, ...]]:
    """Whether each event in the range is one of a transition, and the other way round; and their order."""
    claim = "the boxes in the range are the events of the transitions"

    def refused(at: str, reason: str) -> tuple[Finding, tuple[Span, ...]]:
        return Finding((Claim(at, claim, ClaimStatus.REFUSED, reason),)), ()

    still_open: set[str] = set()
    left = [event for event in events if event.proof is not None]
    if len(left) < len(events):
        still_open.add("an event has no proved box")
    spans: list[Span] = []
    for n, (length, listed) in enumerate(rows):
        proofs = [(event.box.kind, event.proof) for event in left if event.proof is not None]
        places = list(matched(surface, length, listed, proofs))
        if None in places and len(left) == len(events):
            at = f"/transitions/{n}/events/{places.index(None)}"
            return refused(at, "no box of the certificate holds it")
        group = [left[k] for k in places if k is not None]
        left = [event for event in left if event not in group]
        ends = [_ends(surface, event) for event in group] or [(length.lower, length.upper)]
        low, high = min(low for low, _ in ends), max(high for _, high in ends)
        if max(low for low, _ in ends) > min(high for _, high in ends):
            return refused(f"/transitions/{n}", "the boxes of one transition have different lengths")
        spans.append((low, high))
        if len(listed) > 1:
            still_open.add("events of one transition have one length as far as boxes tell")
        if not listed:
            still_open.add("a transition has no pose")
    if any(later[0] <= earlier[1] for earlier, later in pairwise(spans)):
        n = next(n for n, (a, b) in enumerate(pairwise(spans), 1) if b[0] <= a[1])
        return refused(f"/transitions/{n}", "its box is not above that of the transition before")
    for event in left:
        low, high = _ends(surface, event)
        if start < low and (stop is None or high < stop):
            return refused(event.at, "it is in the range, but of no transition")
        if high >= start and (stop is None or low <= stop):
            still_open.add("an event is at an end of the range")
    if any(low <= start or (stop is not None and stop <= high) for low, high in spans):
        still_open.add("a transition is at an end of the range")
    status = ClaimStatus.CHECKED if still_open else ClaimStatus.PROVED
    reason = "each box is that of one event, and the boxes of different transitions ascend"
    reason = "; ".join([reason, *sorted(still_open)])
    return Finding((Claim(f"{AT}/events", claim, status, reason),), tuple(still_open)), tuple(spans)


def _ends(surface: Surface, event: ListedEvent) -> Span:
    """The least and the greatest length of a proved event."""
    assert event.proof is not None
    length = event.proof.length(surface)
    return Fraction(length.lower, 1 << length.bits), Fraction(length.upper, 1 << length.bits)
