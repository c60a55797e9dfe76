"""Whether the transitions of a census are all events of its full certificate, no more and no fewer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from rpr_solver.verify.angles import degrees
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.full_censuses import AT, PRIMES, Finding, FullCensus, ListedEvent
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.surface import Surface

COMPLETE = f"the eliminants were checked on {2 * PRIMES} random specialisations; each real root has its event"
Row = tuple[Printed, Sequence[Mapping[str, Any]]]
"""The length of a transition, and its events."""
Span = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Completeness:
    """What a full certificate says about a census.

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
        """Whether nothing is refused or left open, but that the eliminants are checked, not proved."""
        return self.open == ()

    def degenerate(self, entries: Sequence[Mapping[str, Any]]) -> Claim:
        """That nothing is degenerate throughout, where nothing is left open."""
        claim = "what is degenerate throughout an interval, or along a curve"
        status = ClaimStatus.REFUSED if entries else ClaimStatus.CHECKED
        return Claim("/degenerate", claim, status, f"nothing is, as all events are isolated: {COMPLETE}")

    def transitions(self) -> Claim:
        """That these are all transitions."""
        claim = "these are all transitions"
        if self.open is None:
            return Claim("/transitions", claim, ClaimStatus.NOT_CHECKED, "the certificate is refused")
        reason = COMPLETE if self.holds else f"left open: {'; '.join(self.open)}"
        return Claim("/transitions", claim, ClaimStatus.CHECKED, reason)


def completeness(
    surface: Surface, full: Mapping[str, Any], rows: Sequence[Row], start: Fraction, stop: Fraction | None
) -> Completeness:
    """Verifies a full certificate, and compares its boxes with the transitions.

    Args:
        surface: the equations.
        full: the member ``full`` of the certificate.
        rows: the transitions.
        start, stop: the range; None is an open end.

    Raises:
        InputError: naming a member that cannot be read.
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

    left, still_open, shared = list(events), [], False
    spans: list[Span] = []
    for n, (length, listed) in enumerate(rows):
        group = []
        for k, entry in enumerate(listed):
            at = f"/transitions/{n}/events/{k}"
            angles = [
                Printed.of(entry.get(name), f"{at}/{name}")
                for name in ("alpha_deg", f"theta{surface.fixed}_deg")
            ]
            found = next((e for e in left if e.box.may_be(entry.get("kind"), length, *angles)), None)
            if found is None or _misprinted(surface, found, length, *angles):
                return refused(at, "no box of the certificate holds it")
            left.remove(found)
            group.append(found)
        ends = [event.box.ends for event in group] or [(length.lower, length.upper)]
        low, high = min(low for low, _ in ends), max(high for _, high in ends)
        if max(low for low, _ in ends) > min(high for _, high in ends):
            return refused(f"/transitions/{n}", "the boxes of one transition have different lengths")
        if spans and low <= spans[-1][1]:
            return refused(f"/transitions/{n}", "its box is not above that of the transition before")
        spans.append((low, high))
        shared = shared or len(listed) > 1
        if not listed:
            still_open.append("a transition has no pose")
    for event in left:
        low, high = event.box.ends
        if start < low and (stop is None or high < stop):
            return refused(event.at, "it is in the range, but of no transition")
        if high > start and (stop is None or low < stop):
            still_open.append("an event is at an end of the range")
    status = ClaimStatus.CHECKED if shared else ClaimStatus.PROVED
    reason = "each box is that of one event, and the boxes of different transitions ascend"
    if shared:
        reason += "; events of one transition have one length, as far as boxes tell"
    return Finding((Claim(f"{AT}/events", claim, status, reason),), tuple(still_open)), tuple(spans)


def _misprinted(
    surface: Surface, event: ListedEvent, length: Printed, alpha: Printed, theta: Printed
) -> bool:
    """Whether the zero in a box does not round to printed numbers."""
    if event.proof is None:
        return False
    a, t, scaled = event.proof.zero
    values = scaled.over(Interval.of(surface.unit, scaled.bits)), degrees(a), degrees(t)
    turns = 0, 360, 360
    return any(
        (not x.contains(0)) if number.is_zero else number.rounds(x, turn) is False
        for x, number, turn in zip(values, (length, alpha, theta), turns, strict=True)
    )
