"""Cusp curves: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, InputError, SolverError, cusp_curves, verify_document
from tests.rpr_solver.long_run import manipulator
from tests.support.families import FAMILIES, family
from tests.support.mutations import OF_CURVES, mutated
from tests.support.shared import curves_of


def test_a_part_of_the_curves_and_its_mutations() -> None:
    document = curves_of(EXAMPLES["zein-flat"]).part(36, 38, lengths=["36.5"]).to_json()
    verification = verify_document(document)
    assert verification.accepted
    open_claims = [claim.at for claim in verification.claims if claim.status is ClaimStatus.NOT_CHECKED]
    assert open_claims == ["/curves"]
    for done, wrong in mutated(document, OF_CURVES, 2, seed=4):
        assert not verify_document(wrong).accepted, done


@pytest.mark.parametrize(
    "change", [{"curves": 1}, {"curves": [{}]}, {"fixed_leg": 0}, {"curves": [{"points": [{}]}]}]
)
def test_what_are_no_curves_is_bad_input(change: dict[str, object]) -> None:
    document = curves_of(EXAMPLES["zein-flat"]).part(36, 38, lengths=[37]).to_json()
    with pytest.raises(InputError):
        verify_document({**document, **change})


@pytest.mark.long
@pytest.mark.timeout(480)
def test_random_curves() -> None:
    rng = random.Random(12)
    for n in range(25):
        m = family(rng.choice(list(FAMILIES))) if n % 5 == 0 else manipulator(rng)
        try:
            document = cusp_curves(m, digits=15, fixed_leg=n % 3 + 1).to_json()
        except SolverError:
            continue
        assert verify_document(document).accepted, document["geometry"]
        for done, wrong in mutated(document, OF_CURVES, 2, n):
            assert not verify_document(wrong).accepted, (done, document["geometry"])
