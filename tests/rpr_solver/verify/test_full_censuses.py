"""Full certificates of censuses: each part is verified, and each wrong one refused."""

from __future__ import annotations

import random
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

import rpr_solver
from rpr_solver import ClaimStatus, Manipulator, census
from rpr_solver.verify import full_censuses
from rpr_solver.verify.core.schema import read_document
from rpr_solver.verify.events import EventBox, ProvedEvent, proved_event
from rpr_solver.verify.full_censuses import CHANCE, COMPLETE, Completeness, completeness
from rpr_solver.verify.surface import Surface
from tests.support.mutations import OF_FULL_CENSUSES
from tests.support.verified import accepted, accepted_but_no_mutation, random_documents

Document = dict[str, Any]
DOCUMENT = census(Manipulator(9, 4, 11, 14, 15, 13), digits=15, start=24, certificate="full").to_json()
GEOMETRY = read_document(DOCUMENT).geometry
SURFACE = Surface.of(GEOMETRY, 1)
FULL = "/certificate/full"
PROVED: dict[EventBox, ProvedEvent | None] = {}


def of_changed(monkeypatch: pytest.MonkeyPatch, change: Callable[[Document], object]) -> Completeness:
    """What the changed certificate says; each box is proved once for all tests."""

    def proved(surface: Surface, box: EventBox) -> ProvedEvent | None:
        if box not in PROVED:
            PROVED[box] = proved_event(surface, box)
        return PROVED[box]

    monkeypatch.setattr(full_censuses, "proved_event", proved)
    document = deepcopy(DOCUMENT)
    change(document)
    members = read_document(document).members
    rows = [(row["l1"], row["events"]) for row in members["transitions"]]
    span, full = members["range"], members["certificate"]["full"]
    return completeness(SURFACE, full, rows, span["from"], span["to"])


def test_with_it_no_transition_is_missing() -> None:
    verification = accepted(DOCUMENT)
    assert 0 < len(DOCUMENT["transitions"]) < len(DOCUMENT["certificate"]["full"]["events"])
    rest = {claim.at: claim for claim in verification.claims if claim.status is not ClaimStatus.PROVED}
    assert verification.established
    assert {claim.error_probability for claim in rest.values()} == {CHANCE}
    systems = {f"{FULL}/systems/{n}/{name}" for n in (0, 1) for name in ("polynomial", "real_roots")}
    counts = {f"/intervals/{n}/count" for n in range(len(DOCUMENT["intervals"]))}
    assert set(rest) == {*systems, *counts, "/transitions", "/degenerate"}
    assert rest["/transitions"].reason == COMPLETE


def no_event(document: Document) -> None:
    """Above one root."""
    document["certificate"]["full"]["events"].pop(0)


def no_root(document: Document) -> None:
    document["certificate"]["full"]["systems"][1]["real_roots"].pop()


def twice_an_event(document: Document) -> None:
    events = document["certificate"]["full"]["events"]
    events.insert(1, deepcopy(events[0]))


def a_moved_box(document: Document) -> None:
    side = document["certificate"]["full"]["events"][2]["alpha_deg"]
    side["centre"] = side["centre"][:-5] + "99999"


def another_kind(document: Document) -> None:
    event = document["certificate"]["full"]["events"][0]
    event["kind"] = "lips" if event["kind"] == "swallowtail" else "swallowtail"


def another_coefficient(document: Document) -> None:
    coefficients = document["certificate"]["full"]["systems"][0]["polynomial"]["coefficients"]
    coefficients[7] = str(int(coefficients[7]) + 1)


def another_prime(document: Document) -> None:
    document["certificate"]["full"]["systems"][0]["squarefree"]["prime"] = "1000005"


def no_second_system(document: Document) -> None:
    document["certificate"]["full"]["systems"].pop()


def no_transition(document: Document) -> None:
    document["transitions"].pop()


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (no_event, "/systems/0/real_roots"),
        pytest.param(no_root, "/systems/1/real_roots", marks=pytest.mark.long),
        pytest.param(twice_an_event, "/systems/0/real_roots", marks=pytest.mark.long),
        (a_moved_box, "/events/2"),
        (another_kind, "/events/0"),
        (another_coefficient, "/systems/0/polynomial"),
        pytest.param(another_prime, "/systems/0/squarefree", marks=pytest.mark.long),
        pytest.param(no_second_system, "/systems", marks=pytest.mark.long),
        (no_transition, "/events/15"),
    ],
)
def test_a_wrong_part_is_named(
    monkeypatch: pytest.MonkeyPatch, change: Callable[[Document], None], where: str
) -> None:
    found = of_changed(monkeypatch, change)
    assert found.open is None
    assert f"{FULL}{where}" in [c.at for c in found.claims if c.status is ClaimStatus.REFUSED]


@pytest.mark.long
@pytest.mark.timeout(480)
def test_random_censuses_with_full_certificates() -> None:
    def made(m: Manipulator, n: int, _: random.Random) -> rpr_solver.Census:
        return census(m, digits=15, fixed_leg=n % 3 + 1, certificate="full")

    closed = 0
    for n, document in random_documents(12, 9, made, degenerate_every=6):
        verification = accepted_but_no_mutation(document, OF_FULL_CENSUSES, 2, n)
        closed += COMPLETE in [claim.reason for claim in verification.claims]
    assert closed > 5
