"""Whole documents: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest

from rpr_solver import (
    EXAMPLES,
    Claim,
    ClaimStatus,
    InputError,
    Manipulator,
    Verification,
    census,
    poses_of_squares,
    table_document,
    verify_document,
)
from rpr_solver.verify.claims import Outcome
from rpr_solver.verify.core.numbers import HALF_WAY
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


def test_a_length_half_way_between_two_printed_ones_is_never_refused() -> None:
    s = Fraction("1.000000000000001")
    m = Manipulator(s, 4 * s, -4 * s, 4 * s, 5 * s, 3 * s, orientation="cw")
    document = table_document(m, 4 * s, digits=15)
    cusp = document["slices"][0]["cusps"][3]  # L2 = L3 = 5 s
    for text in ("5.00000000000000", "5.00000000000001"):
        cusp["l2"] = text
        [claim] = verify_document(document).open
        assert (claim.at, claim.status) == ("/slices/0/cusps/3", ClaimStatus.CHECKED)
    cusp["l2"] = "5.00000000000002"
    assert not verify_document(document).accepted

    s = Fraction("1.000000000000005")
    m = Manipulator(5 * s, 2 * s, -3 * s, 5 * s, 6 * s, 5 * s)
    squares = 1, 1, Fraction("0.16") + Fraction("7.8") ** 2  # of B1 = (s, 0) and α = 0
    document = poses_of_squares(m, *(x * s**2 for x in squares), digits=15).to_json()
    verification = verify_document(document)
    assert verification.accepted
    assert [claim.at for claim in verification.open if claim.reason == HALF_WAY] == ["/poses/1"]


def test_a_transition_half_way_between_two_printed_lengths_may_be_either() -> None:
    s = Fraction("1.000000000000005")
    m = Manipulator(2 * s, -4 * s, 4 * s, s, 4 * s, 3 * s)
    document = census(m, start="0.9", stop="1.1", digits=15).to_json()
    [transition] = document["transitions"]
    for text in ("1.00000000000000", "1.00000000000001"):
        transition["l1"] = document["intervals"][0]["to"] = document["intervals"][1]["from"] = text
        assert verify_document(document).established
    transition["l1"] = document["intervals"][0]["to"] = document["intervals"][1]["from"] = "1.00000000000002"
    assert not verify_document(document).accepted


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


def test_a_verification_counts_its_claims() -> None:
    claims = [Claim(f"/slices/{n}", "a claim", status, "so") for n, status in enumerate(ClaimStatus)]
    whole = Verification("cusp-table", "sha256:0", "4", tuple(claims), ("/slices/*/audit",))
    assert (whole.accepted, whole.verdict) == (False, "refused")
    assert whole.refused == (claims[-1],)
    answer = whole.to_json()
    assert answer["counts"] == {"proved": 1, "checked": 1, "not_checked": 1, "refused": 1}
    first = {"at": "/slices/0", "claim": "a claim", "status": "proved", "reason": "so", "established": True}
    assert answer["claims"][0] == first
    assert (answer["outcome"], answer["unread"]) == ("refused", ["/slices/*/audit"])
    assert answer["summary"] == "REFUSED: a claim (/slices/3)"
    assert (
        repr(whole) == "<Verification of cusp-table: refused; 1 proved, 1 checked, 1 not checked, 1 refused>"
    )


def test_the_first_line_names_what_is_open() -> None:
    proved = Claim("/poses", "these are all", ClaimStatus.PROVED, "so")
    some = [Claim(f"/intervals/{n}/count", f"{n} cusps", ClaimStatus.CHECKED, "so") for n in (0, 1)]

    def whole(*claims: Claim) -> Verification:
        return Verification("census", "sha256:0", "4", claims, ("/solver_version",))

    assert whole(proved, proved).outcome is Outcome.ESTABLISHED
    assert whole(proved, proved).summary == (
        "ESTABLISHED: all 2 claims of this census; not read, so not established: /solver_version"
    )
    assert whole(proved, *some).accepted
    assert not whole(proved, *some).established
    assert whole(proved, *some).summary.startswith(
        "NOT ESTABLISHED, though nothing is refuted: 0 cusps, … (/intervals/*/count, 2 times); not read"
    )
