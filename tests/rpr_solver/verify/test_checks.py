"""Reports of checks: right ones are accepted, wrong ones refused."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

import rpr_solver
from rpr_solver import (
    EXAMPLES,
    ClaimStatus,
    InputError,
    Manipulator,
    Requirement,
    census,
    check,
    verify_document,
)
from tests.support.mutations import OF_REPORTS, digit_of_an_example, moved_cut
from tests.support.sampling import long
from tests.support.verified import accepted, accepted_but_no_mutation, random_documents

FLAT = EXAMPLES["zein-flat"]
pytestmark = pytest.mark.usefixtures("events_are_found_once")


def test_a_report_and_its_mutations() -> None:
    document = check(FLAT, Requirement(1, 36, 38, max_cusps=5), digits=15).to_json()
    assert not document["passed"]
    verification = accepted_but_no_mutation(document, (moved_cut, digit_of_an_example), 2, seed=2)
    assert verification.established
    assert verification.claims[-1].claim == "the requirement is not met"
    assert verification.claims[-1].status is ClaimStatus.PROVED


def test_a_requirement_that_is_met_is_established() -> None:
    document = check(FLAT, Requirement(1, 36, 38, max_cusps=8), digits=15).to_json()
    assert document["passed"]
    verification = verify_document(document)
    assert verification.established
    assert verification.claims[-1].claim == "the requirement is met"


def test_within_joint_limits() -> None:
    requirement = Requirement(1, 39, 40, max_cusps=1, limits={3: (20, None)})
    document = check(FLAT, requirement, digits=15).to_json()
    assert [row["count"] for row in document["intervals"]] == [2]
    assert accepted(document).established
    document["requirement"]["limits"]["l3"]["min"] = "60"
    document["requirement"]["limits"]["l2"] = {"min": None, "max": "48"}
    refused = [claim.at for claim in verify_document(document).refused]
    assert refused == ["/intervals/0/count", "/violations/0/example"]


def test_a_requirement_within_joint_limits_is_established() -> None:
    requirement = Requirement(1, "34.5", 35, max_cusps=5, limits={3: (30, 60)})
    document = check(FLAT, requirement, digits=15).to_json()
    assert [row["count"] for row in document["intervals"]] == [5, 4]
    verification = accepted(document)
    assert verification.established
    assert verification.claims[-1].claim == "the requirement is met"


@pytest.mark.parametrize("limits", [{2: (None, 40), 3: (30, 60)}, long({3: (1, 10**6)}), long({2: (60, 61)})])
def test_limits_of_both_legs_and_beyond_all_cusps(limits: dict[int, tuple[int | None, int]]) -> None:
    requirement = Requirement(1, "34.5", 35, min_cusps=1, limits=limits)
    assert accepted(check(FLAT, requirement, digits=15).to_json()).established


@pytest.mark.parametrize(
    ("m", "leg", "start", "limits"),
    [
        (Manipulator(10, 5, -6, 10, 5, 5), 3, 5, {}),  # two events each, and one whose kind is not found
        # cusps at α = 0 of all slices, at limits
        long(Manipulator(21, -5, -12, 21, 20, 13, orientation="cw"), 2, 5, {3: (None, 11)}),
        long(Manipulator("4/3", -1, 4, "4/3", "13/3", 5), 1, 15, {2: (None, Fraction(39, 2))}),
    ],
)
def test_events_of_one_length_beside_one_that_is_not_known(
    m: Manipulator, leg: int, start: int, limits: dict[int, tuple[int | None, Fraction]]
) -> None:
    requirement = Requirement(leg, start, start + 7, max_cusps=2, limits=limits)
    assert accepted(check(m, requirement, digits=15).to_json()).established


@pytest.mark.parametrize(("start", "counts"), [("34.8459032876257", [5, 4]), long("34.8459032876259", [4])])
def test_a_crossing_close_to_an_end_of_the_range(start: str, counts: list[int]) -> None:
    requirement = Requirement(1, start, 35, max_cusps=5, limits={3: (30, 60)})
    document = check(FLAT, requirement, digits=15).to_json()
    assert [row["count"] for row in document["intervals"]] == counts
    assert accepted(document).established


@pytest.mark.parametrize(
    "change",
    [
        {"passed": True},
        {"max_cusps_found": 5},
        {"violations": []},
    ],
)
def test_what_does_not_follow_is_refused(change: dict[str, object]) -> None:
    document = check(FLAT, Requirement(1, 39, 40, max_cusps=3), digits=15).to_json()
    assert document["intervals"][0]["count"] == 4
    refused = verify_document({**document, **change}).refused
    assert [claim.at.split("/")[1] for claim in refused] == list(change)
    assert not verify_document(document).refused


@pytest.mark.parametrize(("verdict", "passed"), [("proved", True), ("refuted", False), ("open", False)])
def test_what_is_said_of_a_tolerance_is_not_verified_but_fits(verdict: str, passed: bool) -> None:
    document = check(FLAT, Requirement(1, 39, 40, max_cusps=4), digits=15).to_json()
    names = ("tolerance", "reason", "validity", "first_order", "counterexample", "certificate")
    margin = {"verdict": verdict, **dict.fromkeys(names)}
    verified = verify_document({**document, "passed": passed, "margin": margin})
    assert not verified.refused
    assert not verified.established
    assert "/margin/counterexample" in verified.unread
    [claim] = verify_document({**document, "passed": not passed, "margin": margin}).refused
    assert claim.at == "/passed"


@pytest.mark.parametrize("change", [{"intervals": []}, {"requirement": {}}, {"digits": 1}])
def test_what_is_no_report_is_bad_input(change: dict[str, object]) -> None:
    document = check(FLAT, Requirement(1, 39, 40, max_cusps=4), digits=15).to_json()
    with pytest.raises(InputError):
        verify_document({**document, **change})


@pytest.mark.long
@pytest.mark.timeout(480)
def test_random_reports() -> None:
    def made(m: Manipulator, n: int, rng: random.Random) -> rpr_solver.CheckReport:
        limits = {3 if n % 3 == 1 else 2: (rng.randint(0, 5), rng.randint(20, 40))} if n % 2 else {}
        start = rng.randint(5, 15)
        return check(m, Requirement(n % 3 + 1, start, start + 5, max_cusps=4, limits=limits), digits=15)

    for n, document in random_documents(13, 8, made, degenerate_every=4):
        accepted_but_no_mutation(document, OF_REPORTS, 2, n)


def test_an_example_between_the_end_of_a_range_and_an_event_beside_it() -> None:
    m = EXAMPLES["innocenti"]
    place = Fraction(census(m, start=20, stop=40, digits=60).transitions[0].length)
    start = place * (1 - Fraction(1, 10**30))
    document = check(m, Requirement(1, start, start + 1, max_cusps=0), digits=15).to_json()
    assert document["intervals"][0]["count"] != document["intervals"][1]["count"]
    assert not verify_document(document).refused
