"""Cusp curves: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random

import pytest

from rpr_solver import (
    EXAMPLES,
    ClaimStatus,
    CuspCurves,
    InputError,
    Manipulator,
    cusp_curves,
    verify_document,
)
from tests.support.mutations import OF_CURVES
from tests.support.shared import curves_of
from tests.support.verified import accepted, accepted_but_no_mutation, random_documents

pytestmark = pytest.mark.usefixtures("events_are_found_once")


def test_a_part_of_the_curves_and_its_mutations() -> None:
    document = curves_of(EXAMPLES["zein-flat"]).part("0.9", "1.2", lengths=[1]).to_json()
    verification = accepted_but_no_mutation(document, OF_CURVES, 2, seed=4)
    assert {claim.at for claim in verification.open} == {"/curves"}


def test_a_point_between_an_end_and_its_printed_digits() -> None:
    claim = "every curve of this length has a point"
    # below and above the end itself, which was rounded up
    for length, more in ("1.247573993999232881854424244985001", 0), ("1.247573993999232881854424244988", 2):
        document = curves_of(EXAMPLES["zein-flat"]).part(1, "1.3", lengths=[length]).to_json()
        assert sum(bool(curve["points"]) for curve in document["curves"]) == 2 + more
        claims = accepted(document).claims
        assert ClaimStatus.CHECKED not in [claim.status for claim in claims]
        assert [x.established for x in claims if x.claim == claim] == [True]
    born = document["curves"][2]
    assert born["from"]["l1"] == "1.24757399399923288185442424499"
    points, born["points"] = born["points"], []
    assert claim in [x.claim for x in verify_document(document).refused]
    born["points"] = points
    born["from"]["l1"] = "1.24757399399923288185442424500"
    wrong = verify_document({**document, "curves": [born]})
    assert "/curves/0/points" in [claim.at for claim in wrong.refused]


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
    def curves(m: Manipulator, n: int, _: random.Random) -> CuspCurves:
        return cusp_curves(m, digits=15, fixed_leg=n % 3 + 1)

    for n, document in random_documents(12, 25, curves, degenerate_every=5):
        accepted_but_no_mutation(document, OF_CURVES, 2, n)
