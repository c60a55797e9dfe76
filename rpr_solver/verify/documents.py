"""A document of any kind, and the result of its independent verification."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rpr_solver.contract import Progress, check_integer, silent
from rpr_solver.verify.censuses import census_claims, check_claims
from rpr_solver.verify.claims import SPENT, Claim, ClaimStatus, OpenError, Verification, judged
from rpr_solver.verify.core.reader import (
    LEAST_CHARACTERS,
    UNITS_OF_A_CHARACTER,
    ExhaustedError,
    bounded,
    check_texts,
    names_of_unread,
    parsed,
)
from rpr_solver.verify.core.schema import Document, read_document
from rpr_solver.verify.curves import curve_claims
from rpr_solver.verify.margins import margin_claims
from rpr_solver.verify.paths import path_claims
from rpr_solver.verify.poses import pose_claims
from rpr_solver.verify.singular_curves import singular_claims
from rpr_solver.verify.tables import table_claims

CLAIMS: Mapping[str, Callable[[Document, Progress], Iterator[Claim]]] = {
    "cusp-table": table_claims,
    "poses": pose_claims,
    "census": census_claims,
    "cusp-curves": curve_claims,
    "check": check_claims,
    "margin": margin_claims,
    "singular-curves": singular_claims,
    "path": path_claims,
}
"""Kind of a document → its claims."""


def verify_document(
    document: Mapping[str, Any] | str | bytes, *, effort: int = 1, progress: Progress = silent
) -> Verification:
    """Checks a document of any solver by independent means: SymPy, exact integers and intervals.

    The document is read once, by a closed schema; the equations are derived from the closure of the legs, α
    is eliminated by Sylvester's determinant, real roots are counted by Descartes' rule of signs, and a pose
    is proved by Krawczyk's test in intervals. Nothing of the solver is used, and none of its libraries.

    Args:
        document: a cusp table, a table of poses, a census, cusp curves, a report of a check, a margin,
            singular curves or a path: the bytes or the text of its JSON, or what JSON made of them, with its
            texts. Only of bytes or a text is it seen that a key is there twice.
        effort: how many times the work is done that the length of the document allows: for ``1`` about
            ten seconds for each 100 kB. Each claim that is left then is open.
        progress: callback ``progress(done, total)``.

    Raises:
        InputError: this is no such document; the member is named by its JSON pointer.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> document = table_document(EXAMPLES["zein-flat"], 10, digits=15)
    >>> verify_document(document)
    <Verification of cusp-table: established; 10 proved>
    >>> document["slices"][0]["cusps"].pop()["l2"]
    '...'
    >>> verify_document(document).refused[0].at
    '/slices/0/count'
    """
    check_integer(effort, "effort", "1 to 1000", 1, 1000)
    value = parsed(document) if isinstance(document, str | bytes) else document
    size = check_texts(value) if isinstance(value, Mapping) else 0
    read = read_document(value)
    units = UNITS_OF_A_CHARACTER * max(LEAST_CHARACTERS, size) * effort
    claims = (_hash_claim(read), *_within(units, CLAIMS[read.kind](read, progress)))
    unread = tuple(sorted(names_of_unread(read.members)))
    return Verification(read.kind, read.geometry.hash, str(value["solver_version"]), claims, unread)


def _within(units: int, claims: Iterator[Claim]) -> list[Claim]:
    """The claims; those for which there is not enough work are open."""
    found: list[Claim] = []
    with bounded(units):
        try:
            found.extend(claims)
        except (ExhaustedError, OpenError, ArithmeticError) as error:  # most claims name themselves
            reason = str(error) if isinstance(error, OpenError) else SPENT
            found.append(Claim("", "all that is left", ClaimStatus.NOT_CHECKED, reason))
    return found


def _hash_claim(document: Document) -> Claim:
    right, own = document.members["geometry_hash"] == document.geometry.hash, document.geometry.hash
    reason = "it is the SHA-256 of the geometry as printed"
    return judged("/geometry_hash", "the hash of the geometry", right, reason, f"it is {own}")
