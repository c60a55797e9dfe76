"""What number may stand behind a printed decimal."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest

from rpr_solver import EXAMPLES
from rpr_solver.errors import InputError
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.numbers import Geometry, Printed
from tests.support.families import FAMILIES, family
from tests.support.verified import printed

BITS = 60


def test_rounding() -> None:
    x = printed("14.98")
    assert x.rounds(Interval.of(Fraction("14.984"), BITS)) is True
    assert x.rounds(Interval.of(Fraction("14.986"), BITS)) is False
    assert x.rounds(Interval.of(Fraction("14.985"), BITS)) is None
    assert printed("179.9").rounds(Interval.of(Fraction("-180.1"), BITS), 360) is True


def test_a_text_stands_for_all_numbers_that_round_to_it() -> None:
    x = printed("14.98")
    assert (x.lower, x.upper) == (Fraction("14.975"), Fraction("14.985"))
    for text, below, above in (
        ("14.974", False, True),
        ("14.975", None, None),
        ("14.985", None, None),
        ("14.986", True, False),
    ):
        assert (x.below(Fraction(text)), x.above(Fraction(text))) == (below, above), text
    zero = Printed.exact_zero()
    assert (zero.below(Fraction(0)), zero.above(Fraction(0)), zero.below(Fraction(1, 10**9))) == (
        False,
        False,
        True,
    )


@pytest.mark.parametrize("name", [*FAMILIES, *EXAMPLES])
def test_the_same_manipulator(name: str) -> None:
    manipulator = EXAMPLES.get(name) or family(name)
    geometry = Geometry.read(manipulator.to_json(), "/geometry")
    factor, radicand = geometry.height
    assert geometry.hash == manipulator.geometry_hash
    assert factor**2 * radicand == geometry.height_squared
    assert 4 * manipulator.d1**2 * geometry.height_squared == manipulator.area16
    assert geometry.clockwise == (manipulator.orientation == "cw")
    assert geometry.side_squared(2, 3) == manipulator.d2**2
    assert geometry.free_legs(2) == (1, 3)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"a2x": 1.5}, "/geometry/a2x"),
        ({"a2x": "1e99999"}, "/geometry/a2x"),
        ({"d3": "99"}, "/geometry/d1"),
        ({"d2": "-1"}, "/geometry/d2"),
        ({"a3x": "15.91", "a3y": "0"}, "/geometry/a2x"),
        ({"orientation": "up"}, "/geometry/orientation"),
    ],
)
def test_an_impossible_geometry_names_its_field(change: dict[str, Any], field: str) -> None:
    value = {**EXAMPLES["innocenti"].to_json(), **change}
    with pytest.raises(InputError) as error:
        Geometry.read(value, "/geometry")
    assert error.value.problems[0].field == field
