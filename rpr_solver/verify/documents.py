"""A document of any kind, and what an independent verification says of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rpr_solver.contract import Progress, silent
from rpr_solver.errors import InputError, shown
from rpr_solver.verify.censuses import census_claims
from rpr_solver.verify.checks import check_claims
from rpr_solver.verify.claims import Claim, ClaimStatus, Verification
from rpr_solver.verify.curves import curve_claims
from rpr_solver.verify.manipulator import Geometry
from rpr_solver.verify.poses import pose_claims
from rpr_solver.verify.tables import table_claims
from rpr_solver.verify.texts import check_texts
from rpr_solver.verify.unread import unread_claims

Claims = Callable[[Geometry, Mapping[str, Any], Progress], Iterator[Claim]]

CLAIMS: Mapping[str, Claims] = {
    "cusp-table": table_claims,
    "poses": pose_claims,
    "census": census_claims,
    "cusp-curves": curve_claims,
    "check": check_claims,
}
"""Kind of a document → its claims."""

_MEMBERS: Mapping[str, str] = {
    "slices": "cusp-table",
    "poses": "poses",
    "transitions": "census",
    "curves": "cusp-curves",
    "violations": "check",
}
"""The member by which a kind is known; poses have curves too."""


_OTHERS: Mapping[str, str] = {
    "samples": "a path",
    "regions": "a document of singular curves",
    "aspects": "a document of aspects",
    "checks": "a list of reports of checks",
    "verdict": "a verification",
}
"""A member by which another document is known, and what to call that."""


def kind_of(document: Mapping[str, Any]) -> tuple[str, Geometry]:
    """The kind of a document that can be verified, and its manipulator.

    Raises:
        InputError: it is none; the member is named.
    """
    if not isinstance(document, Mapping):
        raise InputError.of("document", f"{shown(document)} is not an object")
    kinds = [kind for member, kind in _MEMBERS.items() if member in document][:1]
    if len(kinds) != 1:
        other = next((f", {name}," for member, name in _OTHERS.items() if member in document), "")
        raise InputError.of(
            "document", f"is{other} of no kind that can be verified; known are {', '.join(CLAIMS)}"
        )
    return kinds[0], Geometry.of(document)


def verify_document(document: Mapping[str, Any], *, progress: Progress = silent) -> Verification:
    """Checks a document of any solver by independent means: SymPy, exact integers and intervals.

    The equations are derived from the closure of the legs, α is eliminated by Sylvester's determinant, real
    roots are counted by Descartes' rule of signs, and a pose is proved by Krawczyk's test in intervals.
    Nothing of the solver is used, and none of its libraries.

    Args:
        document: a cusp table, a table of poses, a census, cusp curves or a report of a check, as JSON reads
            it, with its texts.
        progress: callback ``progress(done, total)``.

    Raises:
        InputError: this is no such document; the member is named.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> document = table_document(EXAMPLES["zein-flat"], 10, digits=15)
    >>> verify_document(document)
    <Verification of cusp-table: accepted; 10 proved, 1 not checked>
    >>> document["slices"][0]["cusps"].pop()["l2"]
    '...'
    >>> verify_document(document).refused[0].at
    '/slices/0/count'
    """
    if isinstance(document, Mapping):
        check_texts(document)
    kind, geometry = kind_of(document)
    claims_of = CLAIMS[kind]
    try:
        claims = (
            _hash_claim(geometry, document),
            *unread_claims(kind, document),
            *claims_of(geometry, document, progress),
        )
    except (KeyError, TypeError, AttributeError, IndexError) as error:  # a member that has another form
        raise InputError.of("document", f"is no {kind} of rpr-cusps: {error!r}") from None
    return Verification(kind, geometry.hash, str(document.get("solver_version", "")), claims)


def _hash_claim(geometry: Geometry, document: Mapping[str, Any]) -> Claim:
    right = document.get("geometry_hash") == geometry.hash
    reason = "it is the SHA-256 of the geometry as printed" if right else f"it is {geometry.hash}"
    status = ClaimStatus.PROVED if right else ClaimStatus.REFUSED
    return Claim("/geometry_hash", "the hash of the geometry", status, reason)
