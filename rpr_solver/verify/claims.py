"""What a verification says: claims about members of a document, each with its status and the reason."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any


class ClaimStatus(StrEnum):
    """How a claim stands.

    >>> ClaimStatus.PROVED == "proved"
    True
    """

    PROVED = "proved"
    """Proved here, by exact arithmetic or intervals."""
    CHECKED = "checked"
    """Confirmed by computation that falls short of a proof; the reason says how far."""
    NOT_CHECKED = "not checked"
    """Nothing is said about it."""
    REFUSED = "refused"
    """It contradicts what is proved here, or is not borne out where a right document would be."""


@dataclass(frozen=True)
class Claim:
    """One claim of a document, and how it stands.

    Attributes:
        at: the member that makes it, a JSON pointer (RFC 6901) such as ``/slices/0/cusps/2``.
        claim: what is claimed.
        status: how it stands.
        reason: why, in one sentence.

    >>> claim = Claim("/slices/0/count", "these 6 cusps are all", ClaimStatus.REFUSED, "there are 7")
    >>> claim.to_json()["status"]
    'refused'
    """

    at: str
    claim: str
    status: ClaimStatus
    reason: str

    def to_json(self) -> dict[str, str]:
        """The claim as a member of the document."""
        return {**asdict(self), "status": self.status.value}


@dataclass(frozen=True)
class Verification:
    """The answer to a verification: the claims, in the order of the document.

    Attributes:
        kind: the kind of document, such as ``"cusp-table"``.
        geometry_hash: of its manipulator.
        solver_version: of the solver that made it.
        claims: all claims.

    >>> Verification("poses", "sha256:…", "4", ()).accepted
    True
    """

    kind: str
    geometry_hash: str
    solver_version: str
    claims: tuple[Claim, ...]

    @property
    def accepted(self) -> bool:
        """Whether no claim is refused."""
        return not self.refused

    @property
    def refused(self) -> tuple[Claim, ...]:
        """The claims that are refused."""
        return tuple(claim for claim in self.claims if claim.status is ClaimStatus.REFUSED)

    def count(self, status: ClaimStatus) -> int:
        """The number of claims with a status."""
        return Counter(claim.status for claim in self.claims)[status]

    def __repr__(self) -> str:
        numbers = ", ".join(f"{n} {status.value}" for status in ClaimStatus if (n := self.count(status)))
        return f"<Verification of {self.kind}: {self.verdict}; {numbers or 'no claims'}>"

    @property
    def verdict(self) -> str:
        """``"accepted"`` or ``"refused"``."""
        return "accepted" if self.accepted else "refused"

    def to_json(self) -> dict[str, Any]:
        """The document of the verification."""
        return {
            "verdict": self.verdict,
            "document": {
                "kind": self.kind,
                "geometry_hash": self.geometry_hash,
                "solver_version": self.solver_version,
            },
            "counts": {status.value.replace(" ", "_"): self.count(status) for status in ClaimStatus},
            "claims": [claim.to_json() for claim in self.claims],
        }
