"""One event: its digits and its kind."""

from __future__ import annotations

import random

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, Manipulator, census
from rpr_solver.verify.events import event_finding
from rpr_solver.verify.manipulator import Geometry
from rpr_solver.verify.printed import Printed
from rpr_solver.verify.surface import Surface
from tests.support.families import family
from tests.support.mutations import other_digit


def test_an_event_and_what_is_wrong_with_others() -> None:
    document = census(EXAMPLES["zein-flat"], digits=15, start=37, stop=38).to_json()
    surface = Surface.of(Geometry.of(document), 1)
    [row] = document["transitions"]
    [event] = row["events"]

    def found(length: str = row["l1"], **change: str) -> tuple[ClaimStatus, str]:
        return event_finding(surface, 15, Printed.of(length, "l1"), {**event, **change}, "/x")

    assert found()[0] is ClaimStatus.PROVED
    assert found(l2=event["l2"][:-1] + "0")[1] == "a digit of l2 is wrong" or event["l2"].endswith("0")
    assert found("37.5")[0] is ClaimStatus.REFUSED
    assert found(alpha_deg="12.3456789012345")[0] is ClaimStatus.REFUSED
    assert "another kind" in found(kind="lips")[1]
    assert found(kind="unheard-of")[1] == "there is no such kind"


@pytest.mark.parametrize("digits", [15, 60])
def test_lips_and_beaks_are_told_apart(digits: int) -> None:
    document = census(EXAMPLES["zein-flat"], digits=digits, start="26.39", stop="26.45").to_json()
    surface = Surface.of(Geometry.of(document), 1)
    [row] = document["transitions"]
    [event] = row["events"]
    length = Printed.of(row["l1"], "l1")
    assert event["kind"] == "beak-to-beak"
    assert event_finding(surface, digits, length, event, "/x")[0] is ClaimStatus.PROVED
    wrong = event_finding(surface, digits, length, {**event, "kind": "lips"}, "/x")
    assert wrong == (ClaimStatus.REFUSED, "the Hessian of J is not that of lips")


def test_an_event_where_inputs_have_as_many_digits_as_it_is_printed_with() -> None:
    sides = ("10.50574108981997", "-12.01173661051592", "-5.30692247377106")
    m = Manipulator(*sides, "13.26111964865003", "11.59790153732381", "9.30259012975855")
    document = census(m, digits=15, fixed_leg=3, start="4.26", stop="4.27").to_json()
    [row] = document["transitions"]
    [event] = row["events"]
    surface = Surface.of(Geometry.of(document), 3)
    assert event["kind"] == "beak-to-beak"
    assert event_finding(surface, 15, Printed.of(row["l3"], "l3"), event, "/x")[0] is ClaimStatus.PROVED


def test_the_digits_of_a_node_that_cusps_leave() -> None:
    document = census(family("similar, mirrored"), digits=15, fixed_leg=2).to_json()
    surface = Surface.of(Geometry.of(document), 2)
    [row, *_] = [row for row in document["transitions"] if row["kind"] == "node"]
    [event] = row["events"]
    length = Printed.of(row["l2"], "l2")
    status, reason = event_finding(surface, 15, length, event, "/x")
    assert status is ClaimStatus.CHECKED
    assert "grad J = 0" in reason
    digit = "1" if event["l1"].endswith("0") else "0"
    wrong = {**event, "l1": event["l1"][:-1] + digit}
    assert event_finding(surface, 15, length, wrong, "/x") == (ClaimStatus.REFUSED, "a digit of l1 is wrong")


def test_an_event_without_a_regular_system() -> None:
    document = census(family("congruent, mirrored"), digits=15).to_json()
    surface = Surface.of(Geometry.of(document), 1)
    row = document["transitions"][0]
    [event] = row["events"]
    length = Printed.of(row["l1"], "l1")
    assert event_finding(surface, 15, length, event, "/x")[0] is ClaimStatus.CHECKED
    for name in ("alpha_deg", "theta1_deg", "l2", "l3"):
        wrong = {**event, name: other_digit(random.Random(1), event[name])}
        assert event_finding(surface, 15, length, wrong, "/x")[0] is ClaimStatus.REFUSED
