"""What a verification says: claims about members of a document, and the verdict."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, TypeVar, overload

from rpr_solver.boxes import Undecided
from rpr_solver.errors import ControlFlow

_NUMBER = re.compile(r"/[0-9]+(?=/|$)")
_DIGITS = re.compile(r"[0-9.]+")


class ClaimStatus(StrEnum):
    """How a claim stands.

    >>> ClaimStatus.PROVED == "proved"
    True
    """

    PROVED = "proved"
    """Proved here: it follows whatever the document says."""
    OPEN = "open"
    """Neither proved nor refused."""
    REFUSED = "refused"
    """It contradicts what is proved here."""


class Verdict(StrEnum):
    """What a verification comes to.

    >>> Verdict.NOT_VERIFIED == "not verified"
    True
    """

    VERIFIED = "verified"
    """Every claim is proved."""
    NOT_VERIFIED = "not verified"
    """No claim is refused, but some are open; nothing may rest on these."""
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

    >>> Claim("/slices/0/count", "these 6 cusps are all", ClaimStatus.REFUSED, "there are 7").to_json()["at"]
    '/slices/0/count'
    """

    at: str
    claim: str
    status: ClaimStatus
    reason: str

    def to_json(self) -> dict[str, str]:
        """The claim as a member of the answer."""
        return {"at": self.at, "claim": self.claim, "status": self.status.value, "reason": self.reason}


class Open(ControlFlow):
    """Control flow of a proof: the claim stays open, for the reason given."""


class Refused(ControlFlow):
    """Control flow of a proof: the claim is refused, for the reason given."""


T = TypeVar("T")


class settled(Generic[T]):  # noqa: N801 - a decorator, like ``cached_property``
    """A property that is computed once, and if it is open or refused, not a second time."""

    def __init__(self, find: Callable[[Any], T]) -> None:
        self._find, self.__doc__ = find, find.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = f"settled {name}"

    @overload
    def __get__(self, instance: None, owner: type) -> settled[T]: ...
    @overload
    def __get__(self, instance: object, owner: type) -> T: ...
    def __get__(self, instance: object | None, owner: type) -> settled[T] | T:
        if instance is None:
            return self
        known = instance.__dict__
        if self._name not in known:
            try:
                known[self._name] = self._find(instance), None
            except (Open, Refused) as error:
                known[self._name] = None, error
        value, why = known[self._name]
        if why is not None:
            raise why
        return value  # type: ignore[no-any-return]


def claim_by(at: str, claim: str, proof: Callable[[], str]) -> Claim:
    """A claim, as its proof decides.

    Args:
        at: the member that makes it.
        claim: what is claimed.
        proof: returns the reason why the claim holds, or raises :class:`Open` or :class:`Refused`
            with the reason why it is open or refused.
    """
    try:
        return Claim(at, claim, ClaimStatus.PROVED, proof())
    except Open as error:
        return open_claim(at, claim, str(error))
    except Undecided:
        return open_claim(at, claim, "it is not decided by balls as small as are looked at")
    except ArithmeticError:
        return open_claim(at, claim, "a number is too large, or too small, for what is computed here")
    except Refused as error:
        return Claim(at, claim, ClaimStatus.REFUSED, str(error))


def demand(holds: object, wrong: str, reason: str = "as it is") -> str:
    """The reason why a claim holds, by a comparison.

    Raises:
        Refused: it does not hold.
    """
    if not holds:
        raise Refused(wrong)
    return reason


def compared(at: str, claim: str, *, holds: bool, reason: str, wrong: str) -> Claim:
    """A claim that is proved or refused by a comparison."""
    return claim_by(at, claim, lambda: demand(holds, wrong, reason))


def open_claim(at: str, claim: str, reason: str) -> Claim:
    """A claim that nothing here decides."""
    return Claim(at, claim, ClaimStatus.OPEN, reason)


@dataclass(frozen=True)
class Verification:
    """The answer to a verification: the claims, in the order of the document. It is true if all are proved.

    Attributes:
        kind: the kind of document, such as ``"cusp-table"``.
        geometry_hash: of its manipulator.
        solver_version: of the solver that made it, as the document says.
        claims: all claims.
        no_claims: the members of the document that claim nothing, with * for places in lists.

    >>> bool(Verification("poses", "sha256:…", "4", (), ()))
    True
    """

    kind: str
    geometry_hash: str
    solver_version: str
    claims: tuple[Claim, ...]
    no_claims: tuple[str, ...]

    def __bool__(self) -> bool:
        return self.verdict is Verdict.VERIFIED

    def with_status(self, status: ClaimStatus) -> tuple[Claim, ...]:
        """The claims of a status."""
        return tuple(claim for claim in self.claims if claim.status is status)

    @property
    def refused(self) -> tuple[Claim, ...]:
        """The claims that are refused."""
        return self.with_status(ClaimStatus.REFUSED)

    @property
    def open(self) -> tuple[Claim, ...]:
        """The claims that are neither proved nor refused."""
        return self.with_status(ClaimStatus.OPEN)

    @property
    def verdict(self) -> Verdict:
        """What it comes to."""
        if self.refused:
            return Verdict.REFUSED
        return Verdict.NOT_VERIFIED if self.open else Verdict.VERIFIED

    @property
    def summary(self) -> str:
        """The verdict in one line, with all claims that are refused or open."""
        if self.refused:
            return f"REFUSED: {_named(self.refused)}"
        if self.open:
            return f"NOT VERIFIED: {_named(self.open)}"
        return f"VERIFIED: {len(self.claims)} claims"

    def __repr__(self) -> str:
        numbers = (f"{len(self.with_status(status))} {status}" for status in ClaimStatus)
        return f"<Verification of {self.kind}: {self.verdict}; {', '.join(numbers)}>"

    def to_json(self) -> dict[str, Any]:
        """The document of the verification."""
        return {
            "verdict": self.verdict.value,
            "summary": self.summary,
            "document": {
                "kind": self.kind,
                "geometry_hash": self.geometry_hash,
                "solver_version": self.solver_version,
            },
            "claims": [claim.to_json() for claim in self.claims],
            "open": [claim.at for claim in self.open],
            "refused": [claim.at for claim in self.refused],
            "no_claims": list(self.no_claims),
        }


def _named(claims: Iterable[Claim]) -> str:
    """Claims in a line; those of one kind of member that differ in numbers only are one."""
    groups: dict[tuple[str, str], list[Claim]] = {}
    for claim in claims:
        groups.setdefault((_NUMBER.sub("/*", claim.at), _DIGITS.sub("*", claim.claim)), []).append(claim)
    parts = []
    for (at, _), group in groups.items():
        more = ", …" if any(claim.claim != group[0].claim for claim in group) else ""
        where = group[0].at if len({claim.at for claim in group}) == 1 else f"{at}, {len(group)} times"
        parts.append(f"{group[0].claim}{more} ({where or 'the document'})")
    return "; ".join(parts)
