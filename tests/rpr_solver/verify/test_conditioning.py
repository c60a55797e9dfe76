"""Condition numbers and clearances of documents: right ones are proved, wrong ones refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rpr_solver import EXAMPLES, Manipulator, joint_path, poses, poses_of_squares, with_condition
from rpr_solver.verify.claims import Verdict
from rpr_solver.verify.documents import verify_document

INNOCENTI = EXAMPLES["innocenti"]
ROOTED = Manipulator(base={"equilateral": 10}, platform={"circumradius": 1})


@pytest.mark.parametrize("digits", [15, 60])
@pytest.mark.parametrize("scale", [None, "1/3"])
@pytest.mark.parametrize(("machine", "lengths"), [(INNOCENTI, (27, 20, 20)), (ROOTED, (5, 6, 7))])
def test_those_of_poses_are_proved(
    machine: Manipulator, lengths: tuple[int, ...], scale: str | None, digits: int
) -> None:
    table = with_condition(poses(machine, *lengths, digits=digits), scale)
    assert verify_document(table.to_json()).verdict is Verdict.VERIFIED


def test_what_is_said_of_a_pose_that_is_singular_is_open() -> None:
    squares = poses_of_squares(Manipulator(4, 0, 3, 2, "2.5", "1.5"), 2, 2, "1.25", digits=15)
    assert verify_document(with_condition(squares).to_json()).verdict is Verdict.NOT_VERIFIED


def put(document: dict[str, Any], *steps: str | int, value: object) -> None:
    *before, last = steps
    place: Any = document
    for step in before:
        place = place[step]
    place[last] = value


FORGED: dict[str, tuple[Callable[[dict[str, Any]], None], str]] = {
    "a digit": (lambda d: put(d, "poses", 0, "condition", value="5.04505619090718"), "/poses/0/condition"),
    "infinite": (lambda d: put(d, "poses", 1, "condition", value=None), "/poses/1/condition"),
    "clearance": (lambda d: put(d, "poses", 0, "clearance_deg", value="29.0519"), "/poses/0/clearance_deg"),
    "scale": (lambda d: put(d, "condition", "length_scale", value="10"), "/poses/0/condition"),
}


@pytest.mark.parametrize("name", FORGED)
def test_wrong_ones_of_poses_are_refused(name: str) -> None:
    document = with_condition(poses(INNOCENTI, 27, 20, 20, digits=15)).to_json()
    forge, place = FORGED[name]
    forge(document)
    assert place in [claim.at for claim in verify_document(document).claims if claim.status == "refused"]


def test_those_along_a_path_are_proved_or_refused() -> None:
    document = joint_path(INNOCENTI, 27, 20, 20, 1, 2, max_condition=12, samples=5).to_json()
    assert verify_document(document).verdict is Verdict.VERIFIED
    put(document, "samples", 2, "condition", value="7.83664709290306")
    put(document, "condition", "asked", value="9")
    put(document, "condition", "min", value="3.5")
    refused = [claim.at for claim in verify_document(document).claims if claim.status == "refused"]
    assert refused == ["/samples/2/condition", "/condition/asked", "/condition"]
    put(document, "condition", "min", value="3.3")
    put(document, "condition", "max", value="9.6")
    refused = [claim.at for claim in verify_document(document).claims if claim.status == "refused"]
    assert refused == ["/samples/2/condition", "/condition/asked", "/condition"]


def test_that_an_end_is_ill_conditioned_is_proved_or_refused() -> None:
    document = joint_path(INNOCENTI, 27, 20, 20, 1, 2, max_condition=7).to_json()
    states = {claim.at: claim.status for claim in verify_document(document).claims}
    assert (states["/obstacle"], states["/condition"]) == ("proved", "open")
    put(document, "condition", "asked", value="7.1")
    states = {claim.at: claim.status for claim in verify_document(document).claims}
    assert states["/obstacle"] == "refused"
