"""Paths: right documents are verified, and what is not verified is named."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import pytest

from rpr_solver import EXAMPLES, Manipulator, cusp_loop, joint_path, pose_path
from rpr_solver.verify.claims import Verdict
from rpr_solver.verify.documents import verify_document
from tests.rpr_solver.verify.forgeries import base, first_line
from tests.rpr_solver.verify.true_documents import true_document
from tests.support.families import family

INNOCENTI = EXAMPLES["innocenti"]
DRAWN = Manipulator(
    base={"points": [[0, 0], [480, 30], [210, 420]]}, platform={"points": [[0, 0], [160, 0], [60, 130]]}
)
HOME = Manipulator("16.1", "6.8", "12.5", "19.5", "15.1", "18.4", "cw")
PATHS = {
    "a loop of leg 3": lambda: cusp_loop(Manipulator(9, 4, 11, 14, 15, 13), 12, "A", fixed_leg=3, samples=5),
    "in the frame of given points": lambda: cusp_loop(DRAWN, 250, "A", samples=5),
    "60 digits": lambda: cusp_loop(INNOCENTI, 27, "A", digits=60, samples=3),
    "ends on a limit": lambda: joint_path(
        HOME, "22.2", "30.2", "24.88", 3, 2, fixed_leg=3, limits={"l2": ("30.2", "43.9")}, samples=5
    ),
    "trapezoid": lambda: cusp_loop(INNOCENTI, 27, "B", timing="trapezoid", duration="7.5", samples=9),
    "another aspect of a range": lambda: joint_path(INNOCENTI, 27, "25.7", "9.2", 2, 4, between=(27, "27.5")),
    "a given pose outside limits": lambda: pose_path(
        INNOCENTI,
        {"l1": 27, "l2": 20, "l3": 20, "pose": 1},
        {"alpha_deg": -140, "theta1_deg": 140, "l1": 28},
        limits={"l2": (None, 21)},
    ),
}


@pytest.mark.parametrize("name", PATHS)
def test_a_path_or_why_there_is_none_is_verified(name: str) -> None:
    assert first_line(PATHS[name]().to_json()).startswith("VERIFIED: ")


@pytest.mark.parametrize("name", ["loop", "range", "given", "signs", "aspect", "outside"])
def test_the_documents_of_forgeries_are_verified_before(name: str) -> None:
    assert first_line(base(name)).startswith("VERIFIED: ")


def test_the_lower_bound_of_a_clearance_is_proved_and_the_rest_is_named() -> None:
    verification = verify_document(base("wide"))
    left = ["/clearance/bound", "/clearance/legs", "/clearance/radius"]
    assert [claim.at for claim in verification.open] == left
    assert "/clearance/proved" in {claim.at for claim in verification.claims}


def test_a_law_of_motion_is_named() -> None:
    assert [claim.at for claim in verify_document(base("motion")).open] == [
        "/timing",
        "/motion",
        "/deviation",
    ]


def test_that_limits_separate_is_named() -> None:
    none = joint_path(INNOCENTI, 27, 20, 20, 1, 2, limits={"l2": (5, 21)})
    assert [claim.at for claim in verify_document(none.to_json()).open] == ["/obstacle"]


def test_an_answer_that_is_undecided_claims_nothing_of_a_path() -> None:
    document = {**base("outside"), "obstacle": "undecided", "connected": None}
    near = {"alpha_deg": "1.5", "theta1_deg": "2.5", "l1": "27", "l2": "20", "l3": "21"}
    assert verify_document(document)
    assert verify_document({**document, "near_pose": near})


def test_a_given_pose_with_more_digits_than_printed_is_not_refused() -> None:
    start = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}
    stop = {"alpha_deg": "-121/3", "theta1_deg": "982/7", "l1": 28}
    verification = verify_document(pose_path(INNOCENTI, start, stop, samples=21).to_json())
    assert verification.verdict is Verdict.NOT_VERIFIED
    assert "/to" in {claim.at for claim in verification.open}


def test_a_loop_of_mirrored_triangles_is_not_verified_soon() -> None:
    document = cusp_loop(family("congruent, mirrored"), 20, 1, samples=2).to_json()
    assert verify_document(document).verdict is Verdict.NOT_VERIFIED


def test_numbers_of_any_size_are_named_and_not_computed_with() -> None:
    for name, change in (("duration", "1" + "0" * 400), ("samples", "1" + "0" * 400)):
        document = base("loop")
        if name == "samples":
            document["samples"][1]["place"] = change
        else:
            document["duration"] = change
        assert first_line(document).startswith("REFUSED: ")


@pytest.mark.long
@pytest.mark.timeout(900)
def test_of_a_hundred_random_paths_none_is_refused() -> None:
    verdicts: list[Any] = []
    for n in range(100):
        if (document := true_document("paths", n)) is not None and "clearance" not in document:
            verdicts.append(verify_document(json.dumps(document)).verdict)
    assert Verdict.REFUSED not in verdicts
    assert Fraction(verdicts.count(Verdict.VERIFIED), len(verdicts)) >= Fraction(95, 100)
