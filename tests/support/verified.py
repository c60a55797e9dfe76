"""What every verification must do: accept a right document, and refuse it with any one fault."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import Any

from rpr_solver import ClaimStatus, Manipulator, SolverError, Verification, verify_document
from rpr_solver.contract import silent
from rpr_solver.verify.documents import CLAIMS, kind_of
from tests.rpr_solver.long_run import manipulator
from tests.support.families import FAMILIES, family
from tests.support.mutations import Document, Mutation, mutated


def accepted(document: Document) -> Verification:
    """The verification of a right document."""
    verification = verify_document(document)
    assert verification.accepted, (document["geometry"], verification.refused)
    return verification


def is_refused(document: Document) -> bool:
    """Whether any claim is refused; those after the first such claim are left out, to save time."""
    kind, geometry = kind_of(document)
    if document.get("geometry_hash") != geometry.hash:
        return True
    claims = CLAIMS[kind](geometry, document, silent)
    return any(claim.status is ClaimStatus.REFUSED for claim in claims)


def accepted_but_no_mutation(
    document: Document, mutations: tuple[Mutation, ...], count: int, seed: int
) -> Verification:
    """The verification of a right document, after its mutations were refused."""
    for done, wrong in mutated(document, mutations, count, seed):
        assert is_refused(wrong), (done, document["geometry"])
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
