"""The cusps of a slice, all found anew: digits, counts, limits, and those that are printed alike."""

from __future__ import annotations

import random
from copy import deepcopy
from fractions import Fraction
from functools import cache
from typing import Any

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, Manipulator, census, cusp_table, table_document, verify_document
from rpr_solver.verify.core.numbers import Printed
from rpr_solver.verify.core.system import System
from rpr_solver.verify.cusps import Limits, Located, Point, Slice
from rpr_solver.verify.ranges import drawn_within
from tests.support.families import FAMILIES, family
from tests.support.sampling import long
from tests.support.shared import curves_of
from tests.support.verified import accepted, geometry_of, is_refused, typed

FLAT = EXAMPLES["zein-flat"]
pytestmark = pytest.mark.usefixtures("events_are_found_once")


@cache
def _beside(exponent: int) -> dict[str, Any]:
    """The slice 10^−exponent above the length at which the first two cusps are born."""
    [born] = census(FLAT, digits=exponent + 20, start="0.8", stop="0.9").transitions
    return table_document(FLAT, Fraction(born.length) + Fraction(1, 10**exponent), digits=15)


@pytest.mark.parametrize("exponent", [long(30), 60])
def test_two_cusps_printed_alike(exponent: int) -> None:
    document = _beside(exponent)
    first, second = document["slices"][0]["cusps"]
    assert first["theta1_deg"] == second["theta1_deg"]
    verification = accepted(document)
    assert verification.claims[-1].claim == "these 2 cusps are all"
    assert verification.claims[-1].reason == (
        "Q has 2 simple real roots, one cusp above each; on special lines are no others"
    )


@pytest.mark.parametrize(("copies", "places"), [(1, ["count"]), (3, ["cusps/2", "count"])])
def test_one_cusp_less_or_more_than_round_to_a_text(copies: int, places: list[str]) -> None:
    document = deepcopy(_beside(60))
    [part] = document["slices"]
    first, second = part["cusps"]
    assert first == second
    part.update(count=copies, cusps=[first] * copies)
    refused = [claim.at.removeprefix("/slices/0/") for claim in verify_document(document).refused]
    assert refused == places


def test_a_wrong_digit_of_one_of_two_cusps_printed_alike() -> None:
    document = deepcopy(_beside(60))
    second = document["slices"][0]["cusps"][1]
    second["l2"] = second["l2"][:-1] + str((int(second["l2"][-1]) + 1) % 10)
    assert "/slices/0/cusps/1" in [claim.at for claim in verify_document(document).refused]


def test_points_of_two_curves_right_after_their_birth() -> None:
    length = _beside(60)["slices"][0]["l1"]
    document = curves_of(FLAT).part("0.8", "0.9", lengths=[length]).to_json()
    first, second = (curve["points"][0] for curve in document["curves"])
    assert first["theta1_deg"] == second["theta1_deg"]
    accepted(document)
    second["l2"] = second["l2"][:-1] + str((int(second["l2"][-1]) + 1) % 10)
    assert is_refused(document)


@pytest.mark.long
@pytest.mark.timeout(480)
@pytest.mark.parametrize(
    ("name", "exponent"),
    [
        *((name, exponent) for name in (*FAMILIES, "innocenti", "zein-flat") for exponent in (30, 100)),
        *((name, 200) for name in ("zein-flat", "isosceles", "similar, mirrored")),
    ],
)
def test_both_sides_of_transitions(name: str, exponent: int) -> None:
    m: Manipulator = EXAMPLES[name] if name in EXAMPLES else family(name)
    whole = census(m, digits=exponent + 20)
    rows = [row for row in whole.transitions if row.count_before != row.count_after]
    draw = random.Random(f"{name} {exponent}")
    for row in draw.sample(rows, min(2, len(rows))):
        for side, count in ((-1, row.count_before), (1, row.count_after)):
            length = Fraction(row.length) + side * Fraction(1, 10**exponent)
            document = table_document(m, length, digits=15)
            assert document["slices"][0]["count"] == count
            accepted(document)
            if count:
                document["slices"][0]["cusps"].pop()
                document["slices"][0]["count"] -= 1
                assert is_refused(document)


def slice_of(manipulator: Manipulator, length: object, leg: int = 1) -> Slice:
    return Slice(System.of(geometry_of(manipulator), leg, Fraction(length)))  # type: ignore[arg-type]


@cache
def the_cusp() -> dict[str, Any]:
    return cusp_table(FLAT, 10, digits=20)[0].cusps[0].to_json()


def located(part: Slice, point: dict[str, Any]) -> Located:
    [found] = part.located([Point.of(point, part.system)])[0]
    return found


def changed(text: str) -> str:
    """The text with another last digit."""
    return text[:-1] + str((int(text[-1]) + 1) % 10)


def test_a_cusp_and_each_of_its_digits() -> None:
    part = slice_of(FLAT, 10)
    right = located(part, typed(the_cusp()))
    assert right.box is not None
    assert right.finding[0] is ClaimStatus.PROVED
    for name, text in the_cusp().items():
        status, reason = located(part, typed({**the_cusp(), name: changed(text)})).finding
        assert status is ClaimStatus.REFUSED
        assert name in reason
    for name in ("alpha_deg", "theta1_deg"):
        wrong = located(part, {**typed(the_cusp()), name: Printed.exact_zero()})
        assert wrong.finding[0] is ClaimStatus.REFUSED


def test_an_angle_that_is_0_exactly() -> None:
    m = Manipulator(5, 3, 4, 17, 10, 9)
    [table] = cusp_table(m, 5, fixed_leg=2, digits=15)
    [cusp] = [cusp.to_json() for cusp in table.cusps if cusp.to_json()["theta2_deg"] == "0"]
    assert located(slice_of(m, 5, 2), typed(cusp)).finding[0] is ClaimStatus.PROVED


@pytest.mark.parametrize(("name", "length", "kind"), [("both flat", 3, "quadruple"), ("similar", 9, "node")])
def test_degenerate_poses_are_in_doubt(name: str, length: int, kind: str) -> None:
    [table] = cusp_table(family(name), length, digits=15)
    part, poses = (
        slice_of(family(name), length),
        [dict(p) for p in table.degenerate_points if p["kind"] != "curve"],
    )
    assert kind in [pose["kind"] for pose in poses]
    doubts = part.cusps().doubts
    assert len(doubts) == len(poses)
    for pose in poses:
        area = part.area(Point.of(typed(pose), part.system))
        assert area is not None
        assert any(doubt.meets(area) for doubt in doubts)
        wrong = {**pose, "l2": changed(pose["l2"][:6]) + pose["l2"][6:]}
        assert part.area(Point.of(typed(wrong), part.system)) is None


def test_counts() -> None:
    assert slice_of(FLAT, "34.5").counted() == (8, True)
    assert slice_of(family("congruent"), 9).counted() is None
    assert len(slice_of(FLAT, "34.5").cusps().boxes) == 8


@pytest.mark.long
def test_cusps_are_searched_for_beside_multiple_roots() -> None:
    assert slice_of(family("similar"), 9).counted() == (0, False)


def test_lengths_are_drawn_anew_within_an_interval() -> None:
    span = Fraction(36), Fraction("36.00001")
    drawn = {drawn_within(span) for _ in range(20)}
    assert len(drawn) > 15
    assert all(span[0] < x < span[1] for x in drawn)
    assert max(x.denominator for x in drawn) < 10**13


def test_the_cusps_of_a_table_within_limits() -> None:
    [table] = cusp_table(FLAT, "34.5", digits=15)
    lengths = sorted(Fraction(cusp.coordinates[2]) for cusp in table.cusps)
    middle, part = (lengths[2] + lengths[3]) / 2, slice_of(FLAT, "34.5")
    below, above = (Limits({2: bounds}) for bounds in ((None, middle), (middle, None)))
    assert below.counted(part) == (3, True)
    assert above.counted(part) == (table.count - 3, True)
    assert Limits({}).counted(part) == (table.count, True)


def test_a_length_at_a_limit_is_open() -> None:
    part = slice_of(FLAT, 10)
    box = located(part, typed(the_cusp())).box
    assert box is not None
    first = part.system.legs[0]
    low, high = (Fraction(x) for x in ("25.2", "25.3"))
    at = part.length(first, box).middle
    assert Limits({2: (low, high)}).admit(part, box) is True
    assert Limits({2: (at, high)}).admit(part, box) is None
    assert Limits({2: (at, high), 3: (None, Fraction(1))}).admit(part, box) is False
