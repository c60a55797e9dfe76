"""Slices of manipulators with roots: vectors from a program that knows no ρ."""

import json
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import Eliminant, InputError, Manipulator, eliminate, solve_slice
from rpr_solver.triangles import Geometry
from tests.support.strategies import examples
from tests.support.triangle_spellings import geometries
from tests.support.twisted import Slices

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]
DIGITS = 40


@pytest.mark.parametrize("row", ROWS, ids=[row["geometry"].get("name", str(n)) for n, row in enumerate(ROWS)])
def test_cusps_of_manipulators_with_roots(row: dict[str, Any]) -> None:
    table = solve_slice(eliminate(Manipulator.from_json(row["geometry"])), row["l1"], DIGITS)
    check([cusp.to_json() for cusp in table.cusps], row)


def check(cusps: list[dict[str, str]], row: dict[str, Any]) -> None:
    known = sorted(row["cusps"], key=lambda cusp: Decimal(cusp["theta1_deg"]))
    assert len(cusps) == row["count"]
    for found, cusp in zip(cusps, known, strict=True):
        for name, text in cusp.items():
            error = abs(Decimal(found[name]) - Decimal(text))
            assert error <= Decimal(text).scaleb(1 - DIGITS).copy_abs()


def test_an_eliminant_keeps_the_points_that_its_coordinates_need() -> None:
    """Sides of more than 128 bits are not factored, so that points decide the coordinates."""
    far = 10**40 + 7
    base = {"points": [[0, 0], [far, f"{far + 2}*sqrt(3)"], [7, "5*sqrt(3)"]]}
    platform = {"points": [[0, 0], [3 * far, f"{far}*sqrt(3)"], [1, "2*sqrt(3)"]]}
    eliminant = eliminate(Manipulator(base=base, platform=platform))
    stored = json.loads(json.dumps(eliminant.to_json()))
    again = Eliminant.from_json(stored)
    assert again.slice_map == eliminant.slice_map
    assert (again.a, again.b) == (eliminant.a, eliminant.b)
    assert stored["points"]


@given(geometries(), st.fractions(1, 20, max_denominator=20))
@examples(25)
def test_the_eliminant_is_that_of_forms_written_once_more(geometry: Geometry, length: Fraction) -> None:
    try:
        eliminant = eliminate(Manipulator.of(geometry))
    except InputError:
        assume(False)
    q = eliminant.at(length * eliminant.slice_map.scale)
    known = Slices.of(eliminant.manipulator.frame).eliminant(length).polynomial.primitive()
    assert q in (known, -known)
    if not q.is_zero:
        whole = eliminate(eliminant.manipulator).expect(1000).at(length * eliminant.slice_map.scale)
        assert whole in (q, -q)
