"""Singular curves of degenerate families, and beside transitions: they come, with the right numbers."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, SingularCurves, singular_curves, trace_slice
from tests.rpr_solver.singular.long_run import Case, case, failures
from tests.support.degenerate import MAKERS
from tests.support.sampling import sample
from tests.support.shared import census_of, eliminant_of

CONGRUENT = Manipulator(30, 0, 40, 30, 50, 40)
ISOSCELES = Manipulator(14, 5, 12, 14, 15, 13)
MIRRORED = Manipulator(7, 16, 12, 7, 15, 20, orientation="cw")
FLAT = Manipulator(-8, -4, 0, 8, 4, 4)


def numbers(curves: SingularCurves) -> tuple[list[int], list[int]]:
    return [region.poses for region in curves.regions], [aspect.sign for aspect in curves.aspects]


@pytest.mark.parametrize(
    ("manipulator", "leg", "length", "regions", "aspects"),
    sample(
        [
            # the image of α = 0 is a point in a region, or near one of its nodes
            (CONGRUENT, 1, "14", [4, 2, 0], [1, 1, -1, -1]),
            (CONGRUENT, 3, "4", [4, 2, 0], [1, 1, -1, -1]),
            (ISOSCELES, 1, "26", [4, 2, 0], [1, 1, -1, -1]),
            (ISOSCELES, 2, "12", [4, 2, 0], [1, 1, -1, -1]),
            (Manipulator("7.2", 0, "13.5", "7.2", "15.3", "13.5"), 3, "990", [2, 0], [1, -1]),
            # cusps at α = 180°, and at the angle that is infinite in the first chart
            (MIRRORED, 3, "10", [6, 6, 4, 4, 2, 2, 2, 0, 0], [1, -1]),
            (MIRRORED, 2, "20", [6, 2, 0], [1, -1]),
            (Manipulator(20, "28/5", "-21/5", 20, 15, 7), 2, "15", [6, 4, 4, 4, 2, 2, 2, 0], [1, -1]),
            # α = 180° is a double component
            (FLAT, 3, "18/5", [4, 0], [1, 1, -1, -1]),
            (FLAT, 2, "26/5", [4, 0], [1, 1, -1, -1]),
            # a region that is a thin strip for the most part
            (Manipulator("-6.2", "-140", 0, "10.7", "11.8", 11), 2, "225.07386", [4, 2, 0], [1, -1]),
        ],
        0,
        4,
        9,
    ),
)
def test_slices_with_special_components(
    manipulator: Manipulator, leg: int, length: str, regions: list[int], aspects: list[int]
) -> None:
    curves = singular_curves(manipulator, length, fixed_leg=leg)
    assert numbers(curves) == (regions, aspects)
    assert list(failures(Case(0, "", manipulator, leg, Fraction(length), ""), Counter())) == []
    assert sum(vertex.kind == "cusp" for vertex in curves.vertices) == curves.table.count


@pytest.mark.parametrize(("number", "digits"), sample(product([2, 7, 16], [15, 40, 100]), 0))
def test_at_the_printed_length_of_a_transition(number: int, digits: int) -> None:
    """As at 1e-6 of it, on one of its sides, but for regions too thin to be drawn."""
    transition = census_of(EXAMPLES["innocenti"], digits=100).transitions[number]
    text = transition.length[: digits + 1 + transition.length.startswith("0.")]
    eliminant = eliminant_of(EXAMPLES["innocenti"])
    curves = trace_slice(eliminant, text)
    sides = [trace_slice(eliminant, Fraction(text) * (1 + Fraction(s, 10**6))) for s in (1, -1)]
    assert curves.table.count in {side.table.count for side in sides}
    assert len(curves.aspects) in {len(side.aspects) for side in sides}
    assert set(numbers(curves)[0]) <= {poses for side in sides for poses in numbers(side)[0]}


SAMPLE = (22, 27, 34, 41, 43, 51, 115)
"""Slices of the long run that were difficult."""


@pytest.mark.parametrize("number", sample(SAMPLE, 3))
def test_slices_of_the_long_run(number: int) -> None:
    seen: Counter[str] = Counter()
    assert list(failures(case(number, 1), seen)) == []
    assert seen["regions"] + seen["regions left open"]


@settings(max_examples=2)
@given(st.integers(0, 10**6), st.integers(1, 3))
def test_scale_and_mirror_change_no_number(number: int, leg: int) -> None:
    """Of regions and aspects, for random manipulators of degenerate families."""
    given_case = case(13 * (number % 1000) + number % len(MAKERS), number)
    m, length = given_case.manipulator, min(given_case.length, Fraction(10**4))
    expected = numbers(singular_curves(m, length, fixed_leg=leg))
    factor = Fraction(7, 3)
    sides = {name: getattr(m, name) * factor for name in ("a2x", "a3x", "a3y", "d1", "d2", "d3")}
    sides["a3y"] = -sides["a3y"]
    image = Manipulator(**sides, orientation="cw" if m.orientation == "ccw" else "ccw")
    assert numbers(singular_curves(image, length * factor, fixed_leg=leg)) == expected


@settings(max_examples=2)
@given(st.integers(0, 10**6), st.integers(1, 3))
def test_exchanging_two_legs_changes_no_number(number: int, leg: int) -> None:
    """Legs 1 and 2 change places when the manipulator is turned by half a turn; J may change its sign."""
    given_case = case(13 * (number % 1000) + number % len(MAKERS), number)
    m, length = given_case.manipulator, min(given_case.length, Fraction(10**4))
    turned = Manipulator(
        m.a2x, m.a2x - m.a3x, -m.a3y, m.d1, m.d3, m.d2, orientation="cw" if m.orientation == "ccw" else "ccw"
    )
    regions, signs = numbers(singular_curves(m, length, fixed_leg=leg))
    others, other_signs = numbers(singular_curves(turned, length, fixed_leg={1: 2, 2: 1, 3: 3}[leg]))
    assert sorted(others) == sorted(regions)
    assert sorted(other_signs) in (sorted(signs), sorted(-sign for sign in signs))
