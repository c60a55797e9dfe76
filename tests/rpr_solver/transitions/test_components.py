"""The curves that hold all cusps, and their events, for manipulators whose events are not isolated."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from itertools import pairwise

import pytest

from rpr_solver import Census, Manipulator, SolverError, census, solve_slice
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.components import Components
from tests.support.discriminant import candidate_lengths
from tests.support.families import CONGRUENT_FLAT, MIRRORED_ISOSCELES, MIRRORED_RIGHT_BASE, family
from tests.support.sampling import sample
from tests.support.shared import census_of, eliminant_of


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


def test_an_irrational_height_is_refused() -> None:
    irrational = Manipulator.from_json({"a2x": 30, "a3x": 0, "a3y": 40, "d1": 15, "d2": 25, "d3": 21})
    with pytest.raises(SolverError, match="irrational height"):
        components(irrational)


REFUSED_ONCE = [
    (MIRRORED_ISOSCELES, 2),
    (MIRRORED_ISOSCELES, 3),
    (MIRRORED_RIGHT_BASE, 1),
    (family("congruent, mirrored"), 1),
]


@pytest.mark.parametrize(("m", "fixed_leg"), sample(REFUSED_ONCE, 1))
def test_a_census_by_components_agrees_with_slices(m: Manipulator, fixed_leg: int) -> None:
    document = census_of(m, fixed_leg)
    assert document.certificate["method"] == "components"
    assert max(document.counts) >= 4
    assert all(t.events and t.kind != "unclassified" for t in document.transitions)
    ends = [Fraction(0), *(Fraction(t.length) for t in document.transitions)]
    places = [(a + b) / 2 for a, b in pairwise(ends)] + [ends[-1] * n for n in (2, 7)]
    eliminant = eliminant_of(m, fixed_leg)
    assert [solve_slice(eliminant, x, 15).count for x in places] == [*document.counts, document.counts[-1]]


def changes(document: Census) -> list[str]:
    return [t.length for t in document.transitions if t.count_before != t.count_after]


@pytest.mark.parametrize("name", ["congruent, mirrored", "similar", "both flat"])
def test_the_number_changes_at_roots_of_the_discriminant_only(name: str) -> None:
    document = census_of(family(name), 1)
    lengths = [x.scaled_length(200) for x in candidate_lengths(eliminant_of(family(name)))]
    scale = SliceMap.of(family(name)).scale
    for length in changes(document):
        scaled = Fraction(length) * scale
        assert any(abs(x - scaled.numerator / scaled.denominator) < 1e-9 * abs(x) for x in lengths)
    assert bool(changes(document)) == (name == "congruent, mirrored")


def test_each_pose_of_a_transition_is_named_once() -> None:
    for m, leg in REFUSED_ONCE[1::2]:
        for transition in census_of(m, leg).transitions:
            points = [event.point for event in transition.events]
            assert len(set(points)) == len(points)


def test_a_census_of_a_range_and_its_joint_limits() -> None:
    part = census(MIRRORED_ISOSCELES, fixed_leg=2, start=8, stop=11, digits=20)
    assert [t.kind for t in part.transitions] == ["quadruple", "node"]
    assert len(part.counts) == 3
