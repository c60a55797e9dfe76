"""Designs that start from a manipulator with roots."""

import pytest

from rpr_solver import InputError, Manipulator, Requirement, design
from rpr_solver.designs.space import Space

EQUILATERAL = Manipulator(base={"equilateral": 10}, platform={"sides": [7, 8, 9]})
BY_POINTS = Manipulator(base={"points": [[1, 2], [11, 3], [4, 9]]}, platform={"sides": [7, 8, 6]})
WISH = Requirement(1, "7.9", "8.1", min_cusps=6, max_cusps=6)
BASE = ["a2x", "a3x", "a3y"]


def test_lengths_that_do_not_vary_stay_exact() -> None:
    space = Space.of(EQUILATERAL, "10%", BASE, decimals=2)
    found = space.manipulator([0.3, 0.4, 0.5])
    assert found is not None
    assert found.geometry.base == EQUILATERAL.geometry.base
    assert [x.denominator for x in found.lengths[3:]] != [1, 1, 1]


def test_lengths_that_vary_are_rational() -> None:
    space = Space.of(EQUILATERAL, "10%", decimals=2)
    found = space.manipulator([0.5] * 6)
    assert found is not None
    assert found.is_rational
    assert float(found.a3y) == pytest.approx(75**0.5, abs=0.01)
    low, high = space.bounds["a3y"]
    assert low < found.a3y < high


@pytest.mark.parametrize("kept", [["a2x"], ["a3x", "a3y"]])
def test_a_corner_is_kept_whole_or_not_at_all(kept: list[str]) -> None:
    assert Space.of(BY_POINTS, "10%", BASE).manipulator([0.1, 0.2, 0.3])
    with pytest.raises(InputError, match="all of them vary, or none"):
        Space.of(BY_POINTS, "10%", kept)


def test_the_start_is_evaluated_exactly() -> None:
    found = design(EQUILATERAL, "least-change", WISH, budget=3)
    assert found.met
    assert found.best == EQUILATERAL
    document = found.to_json()
    assert document["start"]["value"] == "0"
    assert set(document["best"]["change"].values()) == {"0"}


@pytest.mark.long
def test_the_best_is_rational() -> None:
    moved = design(EQUILATERAL, "largest-margin", WISH, budget=8, seed=2).to_json()["best"]
    assert moved["geometry"].keys() >= {"a2x", "d1"}
    assert "sqrt" not in str(moved["change"])
