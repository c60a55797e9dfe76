"""Censuses: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise

import pytest

import rpr_solver
from rpr_solver import EXAMPLES, ClaimStatus, InputError, Manipulator, census, verify_document
from rpr_solver.contract import document_head
from rpr_solver.verify.censuses import Cuts
from tests.support.families import family
from tests.support.mutations import OF_CENSUSES
from tests.support.verified import accepted, accepted_but_no_mutation, geometry_of, printed, random_documents


def test_a_part_of_a_census_and_its_mutations() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start=37, stop=38).to_json()
    verification = accepted_but_no_mutation(document, OF_CENSUSES, 2, seed=4)
    assert [claim.at for claim in verification.open] == [
        "/intervals/0/count",
        "/intervals/1/count",
        "/degenerate",
        "/transitions",
    ]
    assert verification.unread[-1] == "/solver_version"
    assert "/intervals/*/aspects" in verification.unread


@pytest.mark.parametrize("name", [pytest.param("both flat", marks=pytest.mark.long), "congruent"])
def test_degenerate_families(name: str) -> None:
    accepted(census(family(name), digits=15).to_json())


def test_an_end_of_the_range_between_a_transition_and_its_printed_digits() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start="31.86357389393821", stop="31.9").to_json()
    assert document["transitions"][0]["l1"] == "31.8635738939382"
    accepted(document)
    for start, stop, status in (
        ("31.8", "31.9", ClaimStatus.PROVED),
        ("31.8", "31.86357389393816", ClaimStatus.CHECKED),
        ("31.86357389393826", "31.9", ClaimStatus.REFUSED),
        ("31.8", "31.86357389393814", ClaimStatus.REFUSED),
    ):
        lengths = [printed(document["transitions"][0]["l1"])]
        geometry = geometry_of(EXAMPLES["zein-flat"])
        found = Cuts(geometry, lengths, Fraction(start), Fraction(stop)).ascending("/x")
        assert found.status is status, (start, stop)


def test_neighbours_closer_than_their_digits() -> None:
    m = Manipulator("24.1", "5.8", "-15.4", "19.5", "0.5", "19.1", orientation="cw")
    texts, counts = ["2.61199642060043", "2.61199642060044"], [4, 6, 4]
    rows = [
        {"l2": text, "kind": "unclassified", "events": [], "count_before": before, "count_after": after}
        for text, (before, after) in zip(texts, pairwise(counts), strict=True)
    ]
    parts = [
        {"from": start, "to": stop, "count": count}
        for (start, stop), count in zip(pairwise(["2.61", *texts, "2.612"]), counts, strict=True)
    ]
    head = document_head(m, 15, 2) | {"range": {"from": "2.61", "to": "2.612"}}
    certificate = {"method": "events", "lengths_examined": 2, "counts_by": "exact slices"}
    document = {**head, "transitions": rows, "intervals": parts, "certificate": certificate}
    verification = accepted(document)
    open_claims = [claim.at for claim in verification.claims if claim.status is ClaimStatus.NOT_CHECKED]
    assert {"/transitions/0", "/transitions/1", "/intervals/1/count"} <= set(open_claims)


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
    def made(m: Manipulator, n: int, _: random.Random) -> rpr_solver.Census:
        return census(m, digits=15, fixed_leg=n % 3 + 1)

    for n, document in random_documents(11, 25, made, degenerate_every=5):
        accepted_but_no_mutation(document, OF_CENSUSES, 2, n)
