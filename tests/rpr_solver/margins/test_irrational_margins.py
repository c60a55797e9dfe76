"""Margins and sensitivities of manipulators with roots, against rational ones that are very near."""

import json
from pathlib import Path
from typing import Any

import pytest

from rpr_solver import (
    InputError,
    Manipulator,
    census,
    cusp_table,
    margin,
    tolerance_census,
    with_sensitivities,
)
from rpr_solver.contract import LENGTHS
from tests.support.sampling import sample
from tests.support.triangle_spellings import rational_near

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]
EQUILATERAL = Manipulator(base={"equilateral": 10}, platform={"sides": [7, 8, 9]})


def sensitivities(m: Manipulator) -> list[dict[str, str]]:
    document = with_sensitivities(census(m, digits=20).to_json())
    return [event["sensitivity"] for part in document["transitions"] for event in part["events"]]


@pytest.mark.parametrize("row", ROWS[4:5])
def test_sensitivities(row: dict[str, Any]) -> None:
    m = Manipulator.from_json(row["geometry"])
    found, known = sensitivities(m), sensitivities(rational_near(m))
    assert len(found) == len(known) > 0
    for own, other in zip(found, known, strict=True):
        for name in LENGTHS:
            assert float(own[name]) == pytest.approx(float(other[name]), rel=1e-10)


@pytest.mark.parametrize("row", sample(ROWS[4::16], 1))
def test_a_margin_is_that_of_lengths_about_exact_values(row: dict[str, Any]) -> None:
    m = Manipulator.from_json(row["geometry"])
    found, known = (margin(x, row["l1"], most_boxes=10_000) for x in (m, rational_near(m)))
    assert found.count == known.count == row["count"]
    assert float(found.validity or 0) == pytest.approx(float(known.validity or 0), rel=1e-12)
    assert found.first_order is not None
    assert known.first_order is not None
    assert found.first_order.radius == pytest.approx(known.first_order.radius, rel=1e-6)
    assert float(found.proved or 0) == pytest.approx(float(known.proved or 0), rel=0.1)


def test_a_counterexample_is_rational_and_within_the_radius() -> None:
    found = margin(EQUILATERAL, 8).counterexample
    assert found is not None
    assert found.manipulator.is_rational
    for (low, high), length in zip(EQUILATERAL.bounds(), found.manipulator.lengths, strict=True):
        assert high - found.radius <= length <= low + found.radius
    [table] = cusp_table(found.manipulator, 8, digits=15)
    assert table.count == found.found.cusps != 6


def test_a_flat_platform_with_roots_has_no_margin() -> None:
    """√2 + √8 = √18, which no enclosure proves."""
    flat = Manipulator(base={"equilateral": 10}, platform={"sides": ["sqrt(2)", "sqrt(8)", "sqrt(18)"]})
    assert margin(flat, 8).validity == 0
    assert margin(flat, 8, weights={"d1": 0, "d2": 0, "d3": 0}).validity != 0


@pytest.mark.long
def test_transitions_move_as_those_of_a_rational_manipulator() -> None:
    found, known = (
        tolerance_census(x, "0.0001", start=10, stop=20, digits=15)
        for x in (EQUILATERAL, rational_near(EQUILATERAL))
    )
    assert len(found.spans) == len(known.spans) > 0
    for own, other in zip(found.spans, known.spans, strict=True):
        assert (own is None) == (other is None)
        if own is not None and other is not None:
            assert own.start == pytest.approx(other.start, rel=1e-6)
            assert own.stop == pytest.approx(other.stop, rel=1e-6)


def test_a_length_beyond_doubles_is_named() -> None:
    large = Manipulator(base={"equilateral": f"1{200 * '0'}"}, platform={"sides": [7, 8, 9]})
    with pytest.raises(InputError, match=r"geometry\.a3y: is 8"):
        margin(large, 8)
