"""The curves that hold all cusps, and their events, for manipulators whose events are not isolated."""

from functools import cache

import pytest

from rpr_solver import Manipulator, SolverError, solve_slice
from rpr_solver.exact.torus_forms import divides
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.components import Components
from tests.support.families import CONGRUENT_FLAT, MIRRORED_ISOSCELES, MIRRORED_RIGHT_BASE, family
from tests.support.shared import eliminant_of


@cache
def components(m: Manipulator, fixed_leg: int = 1) -> Components:
    return Components.of(SliceMap.of(m, fixed_leg))


def names(found: Components) -> set[str]:
    return {str(component.curve.a) for component in found.components}


def test_the_cusps_of_mirrored_congruent_triangles_keep_their_angles() -> None:
    """Three platform angles, tan(α/2) = 0, ±√3, and the line on which leg 1 and the platform turn alike."""
    assert names(components(MIRRORED_ISOSCELES, 3)) == {"t", "t^2 - 3", "2*t*u - u^2 + 1"}
    table = solve_slice(eliminant_of(MIRRORED_ISOSCELES, 3), 5, 20)
    angles = {cusp.alpha_deg for cusp in table.cusps}
    assert angles <= {"0.0000000000000000000", "120.00000000000000000", "-120.00000000000000000"}
    assert angles


def test_congruent_triangles_have_walls_alone() -> None:
    assert components(CONGRUENT_FLAT).graph is None
    similar = components(family("similar"))
    assert similar.graph is not None
    assert similar.walls
    assert not components(family("both flat")).walls


@pytest.mark.parametrize("fixed_leg", [1, 2, 3])
def test_turnings_and_crossings_are_prime_to_the_curve(fixed_leg: int) -> None:
    for m in (
        MIRRORED_ISOSCELES,
        MIRRORED_RIGHT_BASE,
        CONGRUENT_FLAT,
        family("similar"),
        family("both flat"),
    ):
        for component in components(m, fixed_leg).components:
            assert not any(divides(component.curve, x) for x in (component.turning, *component.crossing))
            assert _degrees(component.zeroth) == _degrees(component.first)


def _degrees(form: object) -> tuple[int, int]:
    return form.degree_t, form.degree_u  # type: ignore[attr-defined]


def test_an_irrational_height_is_refused() -> None:
    irrational = Manipulator.from_json({"a2x": 30, "a3x": 0, "a3y": 40, "d1": 15, "d2": 25, "d3": 21})
    with pytest.raises(SolverError, match="irrational height"):
        components(irrational)
