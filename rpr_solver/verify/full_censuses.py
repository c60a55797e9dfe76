"""Full certificates of censuses: the eliminants, their real roots, and the boxes of all events.

The events are the real common zeros of two systems, and above each simple real root of an eliminant there is
one (mathematics.md#the-eliminants-of-the-census, mathematics.md#completeness-of-the-events). So a census is
complete if its eliminants are right, each real root has its event, and no pose that is singular for every
length is ever degenerate. That the eliminants are right is checked at random places, not proved.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from random import Random
from typing import Any

from rpr_solver.verify.boxes import Pair
from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.event_boxes import EventBox, ProvedEvent, proved_event
from rpr_solver.verify.events import GENERIC, kind_finding
from rpr_solver.verify.full import form_of, isolation_claim, own_omega
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.lines import common_zero
from rpr_solver.verify.manipulator import exact
from rpr_solver.verify.modular import proves_simple
from rpr_solver.verify.permanent import never_degenerate
from rpr_solver.verify.roots import Root, refined
from rpr_solver.verify.specialisations import Identity, Place, agree
from rpr_solver.verify.surds import Poly, primitive
from rpr_solver.verify.surface import CRITICAL, SWALLOWTAIL, Surface
from rpr_solver.verify.system import Trig, derivative

AT = "/certificate/full"
PRIMES = 12
"""At two values of v each, the eliminants are compared with resultants."""
_LINE_BITS = 160
_SYSTEMS: Mapping[str, tuple[str, Identity, int]] = {
    "swallowtails": (SWALLOWTAIL, Place.swallowtails, 32),
    "critical poses": (CRITICAL, Place.critical, 18),
}
"""Name → the equations of its events, the identity of its eliminant, and the degree of this."""


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
    full: Mapping[str, Any]

    @cached_property
    def events(self) -> list[ListedEvent]:
        """All boxes, each with its proof.

        Raises:
            InputError: naming a member that cannot be read.
        """
        found = []
        for n, entry in enumerate(self.full["events"]):
            box = EventBox.of(entry, self.surface.fixed, f"{AT}/events/{n}")
            found.append(ListedEvent(f"{AT}/events/{n}", box, proved_event(self.surface, box)))
        return found

    def boxes(self) -> Finding:
        """Each box holds one zero of the equations of its kind."""
        claims, still_open = [], set()
        for event in self.events:
            kind, status = event.box.kind, ClaimStatus.REFUSED
            if event.proof is None:
                reason = "no zero of the equations of its kind is proved in it"
                if kind not in GENERIC:
                    status, reason = ClaimStatus.NOT_CHECKED, "no regular system of equations is known for it"
            else:
                status, reason = kind_finding(self.surface, kind, event.proof.system, event.proof.zero)
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
        """The findings of all systems.

        Raises:
            InputError: naming a member that cannot be read.
        """
        listed = self.full["systems"]
        for n, system in enumerate(listed):
            yield self._system(system, f"{AT}/systems/{n}")
        names = [system["name"] for system in listed]
        if names[:2] != list(_SYSTEMS):
            status = ClaimStatus.REFUSED if names else ClaimStatus.NOT_CHECKED
            reason = "both systems are needed" if names else "the certificate has no eliminants"
            claim = Claim(f"{AT}/systems", "the systems of all events", status, reason)
            yield Finding((claim,), ("the events are not isolated",))

    def _system(self, system: Mapping[str, Any], at: str) -> Finding:
        if system["name"] not in _SYSTEMS:
            reason = "it counts where the two systems share angles, which is not repeated here"
            claim = Claim(at, f"the system {system['name']}", ClaimStatus.NOT_CHECKED, reason)
            return Finding((claim,), ("the two systems share angles",))
        equations, identity, degree = _SYSTEMS[system["name"]]
        ring, polynomial = self.surface.ring, system["polynomial"]
        form = form_of(ring, polynomial, f"{at}/polynomial")
        named = f"the eliminant of {system['name']}"
        if form is None or not any(map(any, form)):
            reason = "it is 0, or has another square root"
            return Finding((Claim(f"{at}/polynomial", named, ClaimStatus.REFUSED, reason),))
        same = agree(self.surface, form, identity, _draw(polynomial), PRIMES)
        if same is None:
            reason = "the two equations share angles, so their resultant is 0"
            claim = Claim(f"{at}/polynomial", named, ClaimStatus.NOT_CHECKED, reason)
            return Finding((claim,), ("the two equations of a system share angles",))
        if not same or len(form) != degree + 1:
            reason = "it is no factor of the resultant that is derived here"
            return Finding((Claim(f"{at}/polynomial", named, ClaimStatus.REFUSED, reason),))
        reason = f"checked on {2 * PRIMES} random specialisations: it is a factor of the resultant there"
        claims = [Claim(f"{at}/polynomial", named, ClaimStatus.CHECKED, reason)]
        still_open = []
        finite = primitive(form)
        if len(finite) < len(form):
            still_open.append("an eliminant has an infinite root")
        parts, simple = self._parts(system, finite, f"{at}/squarefree")
        claims += simple
        claims.append(isolation_claim(ring, parts, system["real_roots"], f"{at}/real_roots"))
        if any(claim.status is ClaimStatus.REFUSED for claim in claims):
            return Finding(tuple(claims))
        above = self._above(system["real_roots"], parts, equations, f"{at}/real_roots")
        return Finding((*claims, *above.claims), (*still_open, *above.open))

    def _parts(
        self, system: Mapping[str, Any], form: Poly, at: str
    ) -> tuple[Mapping[int, Poly], list[Claim]]:
        place, ring = system["squarefree"], self.surface.ring
        if place is None:
            return ring.squarefree_parts(form), []
        prime, omega = (int(exact(place[name], f"{at}/{name}")) for name in ("prime", "omega"))
        right = proves_simple(ring, form, prime, own_omega(ring, system["polynomial"], omega, prime))
        status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
        reason = "computed modulo it" if right else "it does not hold"
        return {1: form}, [Claim(at, "a prime proves the eliminant squarefree", status, reason)]

    def _above(
        self, roots: Sequence[Mapping[str, Any]], parts: Mapping[int, Poly], equations: str, at: str
    ) -> Finding:
        """Each simple root has one event, and each event of the system is above a root."""
        claim, still_open = "one event above each simple real root", set()
        tangents = [
            (event, event.proof.tangent(self.surface))
            for event in self.events
            if event.proof is not None and event.proof.system == equations and event.box.kind in GENERIC
        ]
        placed = 0
        for root in roots:
            low, high = (exact(root[end], f"{at}/{end}") for end in ("lower", "upper"))
            here = [event.at for event, v in tangents if v is not None and v.inside(low, high)]
            placed += len(here)
            if root["multiplicity"] > 1:
                still_open.add("an eliminant has multiple real roots")
            elif len(here) > 1:
                reason = f"{' and '.join(here)} are above one root"
                return Finding((Claim(at, claim, ClaimStatus.REFUSED, reason),))
            elif not here and self._has_event(parts[1], Root(low, high, inverted=False), equations):
                reason = f"no event is listed above the root between {root['lower']} and {root['upper']}"
                return Finding((Claim(at, claim, ClaimStatus.REFUSED, reason),))
            elif not here:
                still_open.add("above a root the length is 0 or infinite, as far as intervals tell")
        if placed < len(tangents):
            still_open.add("an event is above no real root")
        status = ClaimStatus.CHECKED if still_open else ClaimStatus.PROVED
        reason = "; ".join(sorted(still_open)) or "tan theta of its box is in the interval of the root"
        return Finding((Claim(at, claim, status, reason),), tuple(still_open))

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


def _draw(polynomial: Mapping[str, Any]) -> Random:
    """Random numbers that depend on the polynomial, so that it cannot be made for them."""
    return Random(hashlib.sha256(json.dumps(polynomial, sort_keys=True).encode()).digest())
