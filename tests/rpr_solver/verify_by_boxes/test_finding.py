"""Cusps are found anew in all slices: counts, digits, and what is beside transitions."""

from __future__ import annotations

import time
from fractions import Fraction

import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator, cusp_table, poses
from rpr_solver.verify_by_boxes.equations import Mechanism
from rpr_solver.verify_by_boxes.finding import cusps_of, poses_of
from rpr_solver.verify_by_boxes.geometry import Geometry
from rpr_solver.verify_by_boxes.work import Work
from tests.support.families import FAMILIES, family

TRANSITION = Fraction("28.09489447887736824834")
"""About the length of a beak-to-beak of ``innocenti``: 8 cusps below, 10 above."""


def mechanism(manipulator: Manipulator, leg: int = 1) -> Mechanism:
    return Mechanism(Geometry.read(manipulator.to_json(), ""), leg)


@pytest.mark.parametrize("name", EXAMPLES)
@pytest.mark.parametrize("leg", [1, 2, 3])
def test_the_cusps_of_the_examples_are_those_of_the_solver(name: str, leg: int) -> None:
    lengths = [Fraction(9), Fraction("23.7")]
    listed = cusp_table(EXAMPLES[name], lengths, digits=15, fixed_leg=leg)
    for length, own in zip(lengths, listed, strict=True):
        found = cusps_of(mechanism(EXAMPLES[name], leg), length, Work(0))
        assert not found.open
        assert len(found.zeros) == len(own.cusps)


SIDES = st.fractions(3, 9, max_denominator=20)
PLACES = st.fractions(-9, 9, max_denominator=20)


@given(
    a=st.tuples(PLACES, PLACES, PLACES), d=st.tuples(SIDES, SIDES), length=st.fractions(Fraction(1, 9), 30)
)
def test_random_slices_have_as_many_cusps_as_the_solver_says(
    a: tuple[Fraction, ...], d: tuple[Fraction, ...], length: Fraction
) -> None:
    if a[0] == 0 or (a[1], a[2]) in ((0, 0), (a[0], 0)):
        return
    manipulator = Manipulator(*a, *d, (d[0] + d[1]) * Fraction(3, 5))
    found = cusps_of(mechanism(manipulator), length, Work(0))
    count = len(cusp_table(manipulator, length, digits=15)[0].cusps)
    assert len(found.zeros) <= count
    assert found.open or len(found.zeros) == count


@settings(max_examples=12)
@given(power=st.integers(3, 18), above=st.booleans())
def test_slices_beside_a_transition_have_the_right_number(power: int, above: bool) -> None:
    length = TRANSITION + (1 if above else -1) * Fraction(1, 10**power)
    found = cusps_of(mechanism(EXAMPLES["innocenti"]), length, Work(0))
    expected = len(cusp_table(EXAMPLES["innocenti"], length, digits=15)[0].cusps)
    assert not found.open
    assert len(found.zeros) == expected


@pytest.mark.parametrize("name", FAMILIES)
def test_a_slice_of_a_degenerate_family_is_answered_within_two_seconds(name: str) -> None:
    for length in (9,):
        begun = time.process_time()
        found = cusps_of(mechanism(family(name)), Fraction(length), Work(0))
        assert time.process_time() - begun < 6, "three times as long as on an idle machine"
        assert len(found.zeros) <= len(cusp_table(family(name), length, digits=15)[0].cusps)


@settings(max_examples=20)
@given(lengths=st.tuples(*[st.fractions(2, 30, max_denominator=7)] * 3))
def test_the_poses_of_joint_vectors_are_those_of_the_solver(lengths: tuple[Fraction, ...]) -> None:
    own = poses(EXAMPLES["innocenti"], *lengths, digits=15)
    found = poses_of(mechanism(EXAMPLES["innocenti"]), lengths[0], [x**2 for x in lengths[1:]], Work(0))
    assert len(found.zeros) <= own.count
    assert found.open or len(found.zeros) == own.count


def test_an_open_box_may_hold_what_is_listed_there() -> None:
    own = mechanism(family("both flat"))
    found = cusps_of(own, Fraction(9), Work(0))
    assert found.open
    assert found.may_hold([arb(0, 0.1), arb(0, 0.1)])
