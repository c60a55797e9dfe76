"""Whole documents: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, table_document, verify_document
from tests.rpr_solver.long_run import manipulator
from tests.support.mutations import OF_TABLES, mutated
from tests.support.reference import CASES
from tests.support.verified import accepted_but_no_mutation


def table_of(case: dict[str, Any], digits: int = 15) -> dict[str, Any]:
    """A cusp table of the reference vectors, in the form of a document."""
    lengths = [part["l1"] for part in case["slices"]]
    return table_document(Manipulator.from_json(case["geometry"]), lengths, digits=digits)


def test_a_reference_vector_is_accepted_and_its_mutations_are_refused() -> None:
    document = table_of({**CASES[2], "slices": CASES[2]["slices"][1:2]})
    accepted_but_no_mutation(document, OF_TABLES, 7, seed=1)


@pytest.mark.long
@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_every_reference_vector_is_accepted(case: dict[str, Any]) -> None:
    assert verify_document(table_of(case, 90)).accepted


@pytest.mark.long
@pytest.mark.timeout(480)
def test_mutations_of_every_reference_vector_are_refused() -> None:
    count = 0
    for seed, case in enumerate(CASES):
        document = table_of({**case, "slices": case["slices"][1:3]})
        for done, wrong in mutated(document, OF_TABLES, 21, seed):
            assert not verify_document(wrong).accepted, (case["name"], done)
            count += 1
    assert count > 200


@pytest.mark.long
@pytest.mark.timeout(480)
def test_random_tables_are_accepted_and_their_mutations_refused() -> None:
    rng = random.Random(20)
    for n in range(100):
        lengths = [Fraction(rng.randint(1, 400), 10) for _ in range(2)]
        document = table_document(
            manipulator(rng), lengths, digits=rng.choice([15, 30, 90]), fixed_leg=n % 3 + 1
        )
        accepted_but_no_mutation(document, OF_TABLES, 7, n)


def test_other_documents_and_wrong_hashes() -> None:
    document = table_document(EXAMPLES["zein-flat"], [], digits=15)
    wrong = verify_document({**document, "geometry_hash": "sha256:" + "0" * 64})
    assert [claim.at for claim in wrong.refused] == ["/geometry_hash"]
    for other in ([], {}, {**document, "slices": None}, {"slices": []}, {"geometry": document["geometry"]}):
        with pytest.raises(InputError):
            verify_document(other)  # type: ignore[arg-type]
