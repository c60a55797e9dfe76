"""One event: its digits and its kind."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, Manipulator, census
from rpr_solver.verify.core.schema import POSE_KINDS, read_document
from rpr_solver.verify.events import EventBox, event_finding, proved_event
from rpr_solver.verify.surface import CRITICAL, Surface
from tests.support.families import family
from tests.support.mutations import other_digit
from tests.support.verified import printed, typed


def test_an_event_and_what_is_wrong_with_others() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start=37, stop=38).to_json()
    surface = Surface.of(read_document(document).geometry, 1)
    [row] = document["transitions"]
    [event] = row["events"]

    def found(length: str = row["l1"], **change: str) -> tuple[ClaimStatus, str]:
        return event_finding(surface, printed(length), typed({**event, **change}))

    assert found()[0] is ClaimStatus.PROVED
    assert found(l2=event["l2"][:-1] + "0")[1] == "a digit of l2 is wrong" or event["l2"].endswith("0")
    assert found("37.5000000000000")[0] is ClaimStatus.REFUSED
    assert found(alpha_deg="12.3456789012345")[0] is ClaimStatus.REFUSED
    for kind in POSE_KINDS:
        assert found(kind=kind)[0] is (ClaimStatus.PROVED if kind == event["kind"] else ClaimStatus.REFUSED)


@pytest.mark.parametrize("digits", [15, 60])
def test_lips_and_beaks_are_told_apart(digits: int) -> None:
    document = census(EXAMPLES["zein-flat"], digits=digits, start="26.39", stop="26.45").to_json()
    surface = Surface.of(read_document(document).geometry, 1)
    [row] = document["transitions"]
    [event] = row["events"]
    length = printed(row["l1"])
    assert event["kind"] == "beak-to-beak"
    assert event_finding(surface, length, typed(event))[0] is ClaimStatus.PROVED
    wrong = event_finding(surface, length, typed({**event, "kind": "lips"}))
    assert wrong == (ClaimStatus.REFUSED, "the Hessian of J is not that of lips")


def test_an_event_where_inputs_have_as_many_digits_as_it_is_printed_with() -> None:
    sides = ("10.50574108981997", "-12.01173661051592", "-5.30692247377106")
    m = Manipulator(*sides, "13.26111964865003", "11.59790153732381", "9.30259012975855")
    document = census(m, digits=15, fixed_leg=3, start="4.26", stop="4.27").to_json()
    [row] = document["transitions"]
    [event] = row["events"]
    surface = Surface.of(read_document(document).geometry, 3)
    assert event["kind"] == "beak-to-beak"
    assert event_finding(surface, printed(row["l3"]), typed(event))[0] is ClaimStatus.PROVED


def test_the_digits_of_a_node_that_cusps_leave() -> None:
    document = census(family("similar, mirrored"), digits=15, fixed_leg=2).to_json()
    surface = Surface.of(read_document(document).geometry, 2)
    [row, *_] = [row for row in document["transitions"] if row["kind"] == "node"]
    [event] = row["events"]
    length = printed(row["l2"])
    status, reason = event_finding(surface, length, typed(event))
    assert status is ClaimStatus.CHECKED
    assert "grad J = 0" in reason
    digit = "1" if event["l1"].endswith("0") else "0"
    wrong = {**event, "l1": event["l1"][:-1] + digit}
    assert event_finding(surface, length, typed(wrong)) == (ClaimStatus.REFUSED, "a digit of l1 is wrong")


def test_an_event_without_a_regular_system() -> None:
    document = census(family("congruent, mirrored"), digits=15).to_json()
    surface = Surface.of(read_document(document).geometry, 1)
    row = document["transitions"][0]
    [event] = row["events"]
    length = printed(row["l1"])
    assert event_finding(surface, length, typed(event))[0] is ClaimStatus.NOT_CHECKED
    for name in ("alpha_deg", "theta1_deg", "l2", "l3"):
        wrong = {**event, name: other_digit(random.Random(1), event[name])}
        assert event_finding(surface, length, typed(wrong))[0] is ClaimStatus.REFUSED


def test_the_zero_of_a_box_and_boxes_that_are_none() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start=38, certificate="full").to_json()
    read = read_document(document)
    surface, entries = Surface.of(read.geometry, 1), read.members["certificate"]["full"]["events"]
    box = next(EventBox.of(entry, 1) for entry in entries if entry["kind"] == "beak-to-beak")
    found = proved_event(surface, box)
    assert found is not None
    assert found.system == CRITICAL
    assert found.length(surface).contains(box.length[0]) or found.length(surface).radius < box.length[1]
    tangent = found.tangent(surface)
    assert tangent is not None
    assert tangent.radius < Fraction(1, 10**30)
    for name in ("length", "alpha", "theta"):
        centre, radius = getattr(box, name)
        for side in ((centre + 3 * radius, radius), (centre + 400, radius), (centre, Fraction(9))):
            assert proved_event(surface, replace(box, **{name: side})) is None
    turned = replace(box, length=(-box.length[0], box.length[1]), theta=(box.theta[0] - 180, box.theta[1]))
    assert "> 0" in turned.fault
    assert proved_event(surface, turned) is None
