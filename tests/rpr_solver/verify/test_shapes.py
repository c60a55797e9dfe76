"""Similar, doubly flat and mirrored congruent triangles: their cusps and events in closed form."""

from __future__ import annotations

import json
import random
from collections.abc import Mapping
from fractions import Fraction
from math import isqrt
from typing import Any

import pytest

from rpr_solver import EXAMPLES, Manipulator, Requirement, census, check, cusp_table, verify_document
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.cusps import UNLIMITED, Limits
from rpr_solver.verify.landmarks import Shape
from rpr_solver.verify.mirrored import Mirrored, shape_of
from tests.support.families import CONGRUENT_FLAT, MIRRORED_ISOSCELES, MIRRORED_RIGHT_BASE, family
from tests.support.sampling import long
from tests.support.verified import geometry_of

SHAPES: Mapping[str, Manipulator] = {
    **{name: family(name) for name in ("both flat", "similar", "congruent", "congruent, mirrored")},
    "congruent flat": CONGRUENT_FLAT,
    "similar flat": Manipulator(7, -4, 0, 14, 22, 8),
    "mirrored isosceles": MIRRORED_ISOSCELES,
    "mirrored right base": MIRRORED_RIGHT_BASE,
}
TRIANGLES = [(13, 14, 15), (3, 4, 5), (5, 5, 6), (10, 13, 13), (4, 13, 15), (5, 29, 30), (9, 10, 17)]


def shape(manipulator: Manipulator, leg: int) -> Shape | None:
    return shape_of(Surface(geometry_of(manipulator), leg))


def mirrored(draw: random.Random) -> Manipulator:
    """Mirrored congruent triangles with rational sides and area."""
    scale = Fraction(draw.randint(1, 30), draw.randint(1, 10))
    c, a, b = (x * scale for x in draw.sample(draw.choice(TRIANGLES), 3))
    x = (c * c + b * b - a * a) / (2 * c)
    square = b * b - x * x
    y = Fraction(isqrt(square.numerator), isqrt(square.denominator)) * draw.choice([1, -1])
    sign = draw.choice([1, -1])
    both = (Manipulator(sign * c, sign * x, y, c, a, b, orientation=o) for o in ("cw", "ccw"))
    return next(m for m in both if isinstance(shape(m, 1), Mirrored))


SHORT = {("similar", 2), ("congruent", 3), ("congruent flat", 1), ("mirrored right base", 1)}
CASES = [(name, leg) for name in SHAPES for leg in (1, 2, 3)]


@pytest.mark.parametrize(("name", "leg"), [case if case in SHORT else long(*case) for case in CASES])
def test_a_census_is_established(name: str, leg: int) -> None:
    document = census(SHAPES[name], digits=15, fixed_leg=leg).to_json()
    verification = verify_document(json.loads(json.dumps(document)))
    assert verification.established, verification.summary


@pytest.mark.parametrize("n", [0, *(long(n) for n in range(1, 40))])
def test_a_census_of_random_ones_is_established(n: int) -> None:
    draw = random.Random(n)
    leg, digits = draw.choice([1, 2, 3]), draw.choice([15, 30, 50])
    document = census(mirrored(draw), digits=digits, fixed_leg=leg).to_json()
    verification = verify_document(json.loads(json.dumps(document)))
    assert verification.established, verification.summary


@pytest.mark.parametrize("leg", [1, 2, 3])
def test_numbers_of_cusps_are_those_of_slices(leg: int) -> None:
    own = shape(MIRRORED_RIGHT_BASE, leg)
    assert own is not None
    lengths = [Fraction(k * k, 10) for k in range(1, 30, 3)]
    tables = cusp_table(MIRRORED_RIGHT_BASE, lengths, digits=15, fixed_leg=leg)
    for length, table in zip(lengths, tables, strict=True):
        assert own.counted(length, UNLIMITED) == (table.count, True)
        within = [cusp for cusp in table.cusps if 5 < Fraction(cusp.coordinates[2]) < 30]
        limits = Limits({own.surface.free[0]: (Fraction(5), Fraction(30))})
        assert own.counted(length, limits) == (len(within), True)


@pytest.mark.parametrize("limit", [long(5), 12])
def test_a_report_with_limits_is_established(limit: int) -> None:
    limits = {1: (Fraction(limit), None), 2: (None, Fraction(45))}
    requirement = Requirement(3, Fraction(1), Fraction(60), max_cusps=2, min_cusps=1, limits=limits)
    report = json.loads(json.dumps(check(MIRRORED_ISOSCELES, requirement, digits=15).to_json()))
    verification = verify_document(report)
    assert verification.established, verification.summary


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_is_exact(name: str) -> None:
    assert shape(SHAPES[name], 2) is not None
    sides: dict[str, Any] = SHAPES[name].to_json()
    sign = -1 if name == "both flat" else 1
    sides["d3"] = str(Fraction(sides["d3"]) + Fraction(sign, 10**12))
    assert shape(Manipulator.from_json(sides), 2) is None


def test_others_have_no_shape() -> None:
    assert all(shape(m, leg) is None for m in EXAMPLES.values() for leg in (1, 3))
