"""Censuses of manipulators with roots, against Newton's iteration on a slice that knows no ρ."""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest

from rpr_solver import Manipulator, census, eliminate, solve_slice
from tests.support.sampling import long, sample
from tests.support.triangle_oracle import corners_of, cusps

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]
CLOSE = Fraction(1, 100)
"""Of a length: near a transition the witness may lose cusps."""


@pytest.mark.parametrize("row", sample(ROWS[1:3] + ROWS[10::7], 0))
def test_the_counts_between_transitions(row: dict[str, Any]) -> None:
    manipulator = Manipulator.from_json(row["geometry"])
    found = census(manipulator, digits=20)
    assert found.to_json()["degenerate"] == []
    wide = [
        (Fraction(part["from"]) + Fraction(part["to"]), part["count"])
        for part in found.to_json()["intervals"][1:-1]
        if Fraction(part["to"]) - Fraction(part["from"]) > CLOSE * Fraction(part["to"])
    ]
    with mp.workdps(40):
        base, platform = corners_of(manipulator.geometry)
        for twice, count in wide[:: max(len(wide) // 2, 1)]:
            length = mp.mpf(twice.numerator) / twice.denominator / 2
            assert len(cusps(base, platform, length, starts=24)) == count


@pytest.mark.parametrize("leg", [1, long(2), long(3)])
@pytest.mark.parametrize("sense", ["ccw", "cw"])
def test_equilateral_triangles(sense: str, leg: int) -> None:
    """Of one sense they are similar, and no slice has a cusp; else all legs are alike."""
    manipulator = Manipulator(
        base={"equilateral": "5*sqrt(3)"}, platform={"equilateral": "4.25"}, orientation=sense
    )
    found = census(manipulator, fixed_leg=leg, digits=20)
    assert max(part["count"] for part in found.to_json()["intervals"]) == (0 if sense == "ccw" else 10)


@pytest.mark.parametrize(
    ("base", "platform"),
    [
        ({"equilateral": 10}, {"equilateral": "sqrt(3)"}),
        long({"sides": ["sqrt(2)", "sqrt(3)", 2]}, {"sides": ["sqrt(5)", "sqrt(7.5)", "sqrt(10)"]}),
    ],
)
def test_similar_triangles_lose_their_nodes_at_known_lengths(base: Any, platform: Any) -> None:
    """2 R |κ ± 1|, as the slices tell."""
    manipulator = Manipulator(base=base, platform=platform)
    found = census(manipulator, digits=20).to_json()
    assert [part["count"] for part in found["degenerate"]] == [4, 2]
    assert {part["count"] for part in found["intervals"]} == {0}
    eliminant = eliminate(manipulator)
    for part in found["degenerate"]:
        end = Fraction(part["to"])
        sides = [len(solve_slice(eliminant, end * f, 20).degenerate_points) for f in (BELOW, 2 - BELOW)]
        assert sides == [part["count"], part["count"] - 2]


BELOW = Fraction(99, 100)
