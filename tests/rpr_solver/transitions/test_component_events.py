"""Censuses by components, against slices and the discriminant of Q."""

from fractions import Fraction
from itertools import pairwise

import pytest

from rpr_solver import Census, Manipulator, census, solve_slice
from rpr_solver.model.slice_map import SliceMap
from tests.support.discriminant import candidate_lengths
from tests.support.families import MIRRORED_ISOSCELES, MIRRORED_RIGHT_BASE, family
from tests.support.shared import census_of, eliminant_of

REFUSED_ONCE = [
    (MIRRORED_ISOSCELES, 2),
    (MIRRORED_ISOSCELES, 3),
    (MIRRORED_RIGHT_BASE, 1),
    (family("congruent, mirrored"), 1),
]


@pytest.mark.parametrize(("m", "fixed_leg"), REFUSED_ONCE)
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
    document = census_of(family(name), 1, digits=20)
    lengths = [x.scaled_length(200) for x in candidate_lengths(eliminant_of(family(name)))]
    scale = SliceMap.of(family(name)).scale
    for length in changes(document):
        scaled = Fraction(length) * scale
        assert any(abs(x - scaled.numerator / scaled.denominator) < 1e-9 * abs(x) for x in lengths)
    assert bool(changes(document)) == (name == "congruent, mirrored")


def test_each_pose_of_a_transition_is_named_once() -> None:
    for m, leg in REFUSED_ONCE:
        for transition in census_of(m, leg).transitions:
            points = [event.point for event in transition.events]
            assert len(set(points)) == len(points)


def test_a_census_of_a_range_and_its_joint_limits() -> None:
    part = census(MIRRORED_ISOSCELES, fixed_leg=2, start=8, stop=11, digits=20)
    assert [t.kind for t in part.transitions] == ["quadruple", "node"]
    assert len(part.counts) == 3
