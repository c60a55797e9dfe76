"""Censuses: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, InputError, SolverError, census, verify_document
from tests.rpr_solver.long_run import manipulator
from tests.support.families import FAMILIES, family
from tests.support.mutations import OF_CENSUSES, mutated


def test_a_part_of_a_census_and_its_mutations() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start=37, stop=38).to_json()
    verification = verify_document(document)
    assert verification.accepted
    assert [claim.at for claim in verification.claims if claim.status is ClaimStatus.NOT_CHECKED] == [
        "/intervals"
    ]
    for done, wrong in mutated(document, OF_CENSUSES, 2, seed=4):
        assert not verify_document(wrong).accepted, done


@pytest.mark.parametrize("name", ["both flat", "congruent"])
def test_degenerate_families(name: str) -> None:
    document = census(family(name), digits=15).to_json()
    assert verify_document(document).accepted


@pytest.mark.parametrize(
    "change",
    [{"transitions": 1}, {"intervals": [1]}, {"range": {}}, {"digits": 1}, {"fixed_leg": 7}],
)
def test_what_is_no_census_is_bad_input(change: dict[str, object]) -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start=39, stop=40).to_json()
    with pytest.raises(InputError):
        verify_document({**document, **change})


@pytest.mark.long
@pytest.mark.timeout(480)
def test_random_censuses() -> None:
    rng = random.Random(11)
    for n in range(25):
        m = family(rng.choice(list(FAMILIES))) if n % 5 == 0 else manipulator(rng)
        try:
            document = census(m, digits=15, fixed_leg=n % 3 + 1).to_json()
        except SolverError:
            continue
        assert verify_document(document).accepted, document["geometry"]
        for done, wrong in mutated(document, OF_CENSUSES, 2, n):
            assert not verify_document(wrong).accepted, (done, document["geometry"])
