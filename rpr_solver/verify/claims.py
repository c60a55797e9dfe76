"""What a verification says: claims about members of a document, each with its status and the reason."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from fractions import Fraction
from typing import Any, TypeVar

from rpr_solver.verify.core.reader import ExhaustedError, spend

_NUMBER = re.compile(r"/[0-9]+(?=/|$)")
_DIGITS = re.compile(r"[0-9.]+")
_LONG_BITS = 128


class ClaimStatus(StrEnum):
    """How a claim stands.

    >>> ClaimStatus.PROVED == "proved"
    True
    """

    PROVED = "proved"
    """Proved here, by exact arithmetic or intervals: it follows whatever the document says."""
    CHECKED = "checked"
    """Confirmed by computation that falls short of a proof; the reason says how far."""
    NOT_CHECKED = "not checked"
    """Nothing is said about it."""
    REFUSED = "refused"
    """It contradicts what is proved here, or is not borne out where a right document would be."""


Listed = TypeVar("Listed")
Known = TypeVar("Known")
Finding = tuple[ClaimStatus, str]
"""How something stands, and why."""


class Outcome(StrEnum):
    """What a verification comes to.

    >>> Outcome.REFUSED == "refused"
    True
    """

    ESTABLISHED = "established"
    """Every claim is proved."""
    NOT_ESTABLISHED = "not established"
    """No claim is refused, but some are open: they are named, and nothing may rest on them."""
    REFUSED = "refused"
    """At least one claim is refused."""


@dataclass(frozen=True)
class Claim:
    """One claim of a document, and how it stands.

    Attributes:
        at: the member that makes it, a JSON pointer (RFC 6901) such as ``/slices/0/cusps/2``.
        claim: what is claimed.
        status: how it stands.
        reason: why, in one sentence.

    >>> claim = Claim("/slices/0/count", "these 6 cusps are all", ClaimStatus.REFUSED, "there are 7")
    >>> claim.to_json()["status"], claim.established
    ('refused', False)
    """

    at: str
    claim: str
    status: ClaimStatus
    reason: str

    @property
    def established(self) -> bool:
        """Whether it is proved."""
        return self.status is ClaimStatus.PROVED

    def to_json(self) -> dict[str, Any]:
        """The claim as a member of the document."""
        about = {"at": self.at, "claim": self.claim, "status": self.status.value, "reason": self.reason}
        return {**about, "established": self.established}


@dataclass(frozen=True)
class Verification:
    """The answer to a verification: the claims, in the order of the document. It is true if it accepts.

    Attributes:
        kind: the kind of document, such as ``"cusp-table"``.
        geometry_hash: of its manipulator.
        solver_version: of the solver that made it, as the document says.
        claims: all claims.
        unread: the members that were not read, with * for places in lists.

    >>> Verification("poses", "sha256:…", "4", (), ()).outcome
    <Outcome.ESTABLISHED: 'established'>
    """

    kind: str
    geometry_hash: str
    solver_version: str
    claims: tuple[Claim, ...]
    unread: tuple[str, ...]

    def __bool__(self) -> bool:
        return self.accepted

    @property
    def accepted(self) -> bool:
        """Whether no claim is refused; some may be open all the same (:attr:`established`)."""
        return not self.refused

    @property
    def established(self) -> bool:
        """Whether every claim is established."""
        return all(claim.established for claim in self.claims)

    @property
    def refused(self) -> tuple[Claim, ...]:
        """The claims that are refused."""
        return tuple(claim for claim in self.claims if claim.status is ClaimStatus.REFUSED)

    @property
    def open(self) -> tuple[Claim, ...]:
        """The claims that are neither refused nor established."""
        return tuple(
            claim
            for claim in self.claims
            if not claim.established and claim.status is not ClaimStatus.REFUSED
        )

    @property
    def outcome(self) -> Outcome:
        """What it comes to."""
        if not self.accepted:
            return Outcome.REFUSED
        return Outcome.ESTABLISHED if self.established else Outcome.NOT_ESTABLISHED

    def count(self, status: ClaimStatus) -> int:
        """The number of claims with a status."""
        return Counter(claim.status for claim in self.claims)[status]

    def __repr__(self) -> str:
        numbers = ", ".join(f"{n} {status.value}" for status in ClaimStatus if (n := self.count(status)))
        return f"<Verification of {self.kind}: {self.outcome.value}; {numbers or 'no claims'}>"

    @property
    def verdict(self) -> str:
        """``"accepted"`` or ``"refused"``; :attr:`outcome` has more detail."""
        return "accepted" if self.accepted else "refused"

    @property
    def summary(self) -> str:
        """The outcome in one line, with all claims that are refused or open."""
        if self.refused:
            return f"REFUSED: {_named(self.refused)}"
        rest = f"; not read, so not established: {', '.join(self.unread)}" if self.unread else ""
        if self.open:
            return f"NOT ESTABLISHED, though nothing is refuted: {_named(self.open)}{rest}"
        return f"ESTABLISHED: all {len(self.claims)} claims of this {self.kind}{rest}"

    def to_json(self) -> dict[str, Any]:
        """The document of the verification."""
        return {
            "verdict": self.verdict,
            "outcome": self.outcome.value,
            "summary": self.summary,
            "document": {
                "kind": self.kind,
                "geometry_hash": self.geometry_hash,
                "solver_version": self.solver_version,
            },
            "counts": {status.value.replace(" ", "_"): self.count(status) for status in ClaimStatus},
            "claims": [claim.to_json() for claim in self.claims],
            "unread": list(self.unread),
        }


def _named(claims: Iterable[Claim]) -> str:
    """Claims in a line; those of one kind of member that differ in numbers only are one."""
    groups: dict[tuple[str, str], list[Claim]] = {}
    for claim in claims:
        key = _NUMBER.sub("/*", claim.at), _DIGITS.sub("*", claim.claim)
        groups.setdefault(key, []).append(claim)
    parts = []
    for (at, _), group in groups.items():
        more = ", …" if any(claim.claim != group[0].claim for claim in group) else ""
        places = {claim.at: claim for claim in group}
        where = group[0].at if len(places) == 1 else f"{at}, {len(group)} times"
        parts.append(f"{group[0].claim}{more} ({where or 'the document'})")
    return "; ".join(parts)


def finding(right: bool, reason: str, wrong: str = "it does not hold") -> Finding:
    """Proved, or refused."""
    return (ClaimStatus.PROVED, reason) if right else (ClaimStatus.REFUSED, wrong)


def judged(at: str, claim: str, right: bool, reason: str, wrong: str = "it does not hold") -> Claim:
    """A claim that is proved or refused, without work."""
    return Claim(at, claim, *finding(right, reason, wrong))


def brief(x: Fraction | None) -> str:
    """A number for people: exact if it is short, else its first nine digits."""
    if x is None:
        return "none"
    n, d = x.as_integer_ratio()
    return str(x) if max(n.bit_length(), d.bit_length()) < _LONG_BITS else f"{Decimal(n) / Decimal(d):.9g}"


class OpenError(Exception):
    """Control flow inside this package: a claim stays open, for the reason given."""


SPENT = "it needs more work than its length allows; verify parts of it"


def worked(at: str, claim: str, find: Callable[[], Finding | Claim]) -> Claim:
    """A claim that costs work to judge: open if no work is left, or where ``find`` raises OpenError.

    So each claim is named, however little of a document is verified. It is open, too, where intervals do not
    exclude 0 from a divisor, or a number is too large for the floats that propose something.
    """
    try:
        spend(0)  # once it is used up, nothing more is begun
        found = find()
    except ExhaustedError:
        found = ClaimStatus.NOT_CHECKED, SPENT
    except OpenError as error:
        found = ClaimStatus.NOT_CHECKED, str(error)
    except ArithmeticError:
        found = ClaimStatus.NOT_CHECKED, "the precision of intervals, or of floats, is not enough"
    return found if isinstance(found, Claim) else Claim(at, claim, *found)


def matching(
    listed: Sequence[Listed], known: Sequence[Known], is_same: Callable[[Listed, Known], object]
) -> list[int | None]:
    """The place of another known one for each that is listed, as many as can be (augmenting paths)."""
    fits = [[k for k, y in enumerate(known) if is_same(x, y)] for x in listed]
    owner: dict[int, int] = {}

    def placed(n: int, tried: set[int]) -> bool:
        for k in fits[n]:
            if k not in tried:
                tried.add(k)
                if k not in owner or placed(owner[k], tried):
                    owner[k] = n
                    return True
        return False

    for n in range(len(fits)):
        placed(n, set())
    chosen = {n: k for k, n in owner.items()}
    return [chosen.get(n) for n in range(len(fits))]
