"""The geometry of a document."""

from typing import Any

import pytest

from rpr_solver import EXAMPLES
from rpr_solver.errors import InputError
from rpr_solver.verify.core.manipulator import Geometry
from tests.support.families import FAMILIES, family


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
