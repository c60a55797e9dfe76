"""Censuses: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise

import pytest

import rpr_solver
from rpr_solver import (
    EXAMPLES,
    ClaimStatus,
    InputError,
    Manipulator,
    census,
    tolerance_census,
    verify_document,
    with_sensitivities,
)
from rpr_solver.contract import document_head
from rpr_solver.exact.rationals import exact_str
from rpr_solver.verify.ranges import ordered
from tests.support.families import family
from tests.support.mutations import OF_CENSUSES
from tests.support.sampling import long
from tests.support.verified import accepted, accepted_but_no_mutation, printed, random_documents, refusal

pytestmark = pytest.mark.usefixtures("events_are_found_once")


def test_a_part_of_a_census_and_its_mutations() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start=37, stop=38).to_json()
    verification = accepted_but_no_mutation(document, OF_CENSUSES, 2, seed=4)
    assert verification.established
    assert verification.unread[-1] == "/solver_version"
    numbers = [claim for claim in verification.claims if claim.at.endswith("/aspects")]
    assert [claim.claim for claim in numbers] == ["2 aspects in every slice of this interval"] * 2


@pytest.mark.parametrize("name", [pytest.param("both flat", marks=pytest.mark.long), "congruent"])
def test_degenerate_families(name: str) -> None:
    accepted(census(family(name), digits=15).to_json())


def test_an_end_of_the_range_between_a_transition_and_its_printed_digits() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start="31.86357389393821", stop="31.9").to_json()
    assert document["transitions"][0]["l1"] == "31.8635738939382"
    assert accepted(document).established
    cuts = [printed(document["transitions"][0]["l1"])]
    for start, stop, status in (
        ("31.8", "31.9", ClaimStatus.PROVED),
        ("31.8", "31.86357389393816", ClaimStatus.CHECKED),
        ("31.86357389393826", "31.9", ClaimStatus.REFUSED),
        ("31.8", "31.86357389393814", ClaimStatus.REFUSED),
    ):
        rows = [{"from": "", "to": ""}, {"from": "", "to": ""}]
        span, here = (Fraction(start), Fraction(stop)), (ClaimStatus.CHECKED, "")
        found = next(ordered("/x", cuts, span, rows, lambda _, here=here: here))  # type: ignore[misc]
        assert found.status is status, (start, stop)


@pytest.mark.parametrize(("power", "side"), [(40, 1), long(17, 1), long(17, -1), long(40, -1)])
def test_ranges_with_an_end_close_beside_a_transition(power: int, side: int) -> None:
    [transition] = census(EXAMPLES["zein-flat"], digits=80, start=36, stop=38).transitions
    end, other = (Fraction(transition.length) * (1 + Fraction(x, 10**power)) for x in (side, -side))
    for name, place, start, stop in (("to", -1, Fraction(36), end), ("from", 0, end, Fraction(38))):
        document = census(EXAMPLES["zein-flat"], digits=15, start=start, stop=stop).to_json()
        assert len(document["transitions"]) == ((side > 0) == (stop == end))
        assert accepted(document).established
        document["range"][name] = document["intervals"][place][name] = exact_str(other)
        assert refusal(document) is not None


def test_what_is_degenerate_throughout_has_all_of_its_digits() -> None:
    document = census(family("similar"), digits=200).to_json()
    assert accepted(document).established
    end = document["degenerate"][0]["to"]
    document["degenerate"][0]["to"] = document["degenerate"][1]["from"] = end[:-1] + "1"
    assert [claim.at for claim in verify_document(document).refused] == ["/degenerate"]


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
    assert accepted(document).established
    for n in (0, 2):
        parts[n]["count"] += 2
        rows[n // 2]["count_after" if n else "count_before"] += 2
        assert not verify_document(document).accepted


def test_neighbours_closer_than_their_digits_each_of_two_events() -> None:
    isosceles = Manipulator("18.8", "9.4", 7, "12.9", "13.1", "13.1")
    document = census(isosceles, digits=15, fixed_leg=3, start="10.107", stop="10.108").to_json()
    assert [row["l3"] for row in document["transitions"]] == ["10.1072362831164"] * 2
    assert [len(row["events"]) for row in document["transitions"]] == [2, 2]
    assert accepted(document).established
    first, second = document["transitions"]
    first["events"], second["events"] = second["events"], first["events"]
    assert not verify_document(document).accepted


def test_bounds_within_a_tolerance_are_not_read() -> None:
    answer = tolerance_census(EXAMPLES["zein-flat"], {"a2x": "0.0001"}, digits=15, start=35, stop=36)
    verified = verify_document(answer.to_json())
    assert {"/tolerance", "/complete", "/open", "/transitions/*/from"} <= set(verified.unread)
    assert [claim.to_json() for claim in verified.claims] == [
        claim.to_json() for claim in verify_document(answer.document).claims
    ]


def test_sensitivities_are_not_read() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start=30, stop=33).to_json()
    verified = verify_document(with_sensitivities(document))
    assert "/transitions/*/events/*/sensitivity" in verified.unread
    assert [claim.to_json() for claim in verified.claims] == [
        claim.to_json() for claim in verify_document(document).claims
    ]


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
