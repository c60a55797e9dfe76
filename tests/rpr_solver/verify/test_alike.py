"""Slices right beside transitions: cusps printed alike are told apart, and counted as many as they are."""

from __future__ import annotations

import random
from copy import deepcopy
from fractions import Fraction
from functools import cache
from typing import Any

import pytest

from rpr_solver import EXAMPLES, Manipulator, census, table_document, verify_document
from tests.support.families import FAMILIES, family
from tests.support.shared import curves_of
from tests.support.verified import accepted, is_refused

FLAT = EXAMPLES["zein-flat"]


@cache
def _beside(exponent: int) -> dict[str, Any]:
    """The slice 10^−exponent above the length at which the first two cusps are born."""
    [born] = census(FLAT, digits=exponent + 20, start="0.8", stop="0.9").transitions
    return table_document(FLAT, Fraction(born.length) + Fraction(1, 10**exponent), digits=15)


@pytest.mark.parametrize("exponent", [30, 60])
def test_two_cusps_printed_alike(exponent: int) -> None:
    document = _beside(exponent)
    first, second = document["slices"][0]["cusps"]
    assert first["theta1_deg"] == second["theta1_deg"]
    verification = accepted(document)
    assert verification.claims[-1].claim == "these 2 cusps are all"
    assert verification.claims[-1].reason == (
        "Q has 2 simple real roots, one cusp above each; spurious roots have none"
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
