"""What every verification must do: accept a right document, and never be fooled by one with any one fault."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rpr_solver import ClaimStatus, InputError, Manipulator, SolverError, Verification, verify_document
from rpr_solver.contract import silent
from rpr_solver.verify.core.numbers import Geometry, Printed, decimal
from rpr_solver.verify.core.reader import ExhaustedError, bounded
from rpr_solver.verify.core.schema import Document as ReadDocument
from rpr_solver.verify.core.schema import read_document
from rpr_solver.verify.documents import CLAIMS
from tests.rpr_solver.long_run import manipulator
from tests.support.families import FAMILIES, family
from tests.support.mutations import Document, Mutation, mutated

_MOST_WORK = 50_000_000


def geometry_of(manipulator: Manipulator) -> Geometry:
    """The geometry as the verifier has it."""
    return Geometry.read(manipulator.to_json(), "/geometry")


def printed(text: str) -> Printed:
    """A printed decimal of as many digits as it has."""
    if text == "0":
        return Printed.exact_zero()
    digits = len(text.partition("e")[0].lstrip("-0.").replace(".", ""))
    number: Printed = decimal(digits)(text, "/text")
    return number


def typed(point: Mapping[str, str]) -> dict[str, Any]:
    """A point or an event of a document with its numbers."""
    return {name: text if name == "kind" else printed(text) for name, text in point.items()}


def accepted(document: Document) -> Verification:
    """The verification of a right document."""
    verification = verify_document(document)
    assert verification.accepted, (document["geometry"], verification.refused)
    return verification


def is_refused(document: Document) -> bool:
    """Whether it is no document, or any claim is refused."""
    try:
        return refusal(document) is not None
    except InputError:
        return True


def refusal(document: Document) -> str | None:
    """The place of the first claim that is refused, after which no work is done; None if none is.

    Raises:
        InputError: it is no document.
    """
    read = read_document(document)
    if document["geometry_hash"] != read.geometry.hash:
        return "/geometry_hash"
    with bounded(_MOST_WORK):
        try:
            claims = _claims(read)
            return next((claim.at for claim in claims if claim.status is ClaimStatus.REFUSED), None)
        except ExhaustedError:
            return None


def _claims(read: ReadDocument) -> Iterator[Any]:
    return CLAIMS[read.kind](read, silent)


def is_named(document: Document) -> bool:
    """Whether a false document is refused, or at least not called established."""
    return is_refused(document) or not verify_document(document).established


def accepted_but_no_mutation(
    document: Document, mutations: tuple[Mutation, ...], count: int, seed: int
) -> Verification:
    """The verification of a right document, after its mutations were refused, or not established."""
    for done, wrong in mutated(document, mutations, count, seed):
        assert is_named(wrong), (done, document["geometry"])
    return accepted(document)


def random_documents(
    seed: int, count: int, make: Callable[[Manipulator, int, random.Random], Any], *, degenerate_every: int
) -> Iterator[tuple[int, Document]]:
    """Documents of random manipulators, some of degenerate families; failures are left out."""
    rng = random.Random(seed)
    for n in range(count):
        m = family(rng.choice(list(FAMILIES))) if n % degenerate_every == 0 else manipulator(rng)
        try:
            yield n, make(m, n, rng).to_json()
        except SolverError:
            continue
