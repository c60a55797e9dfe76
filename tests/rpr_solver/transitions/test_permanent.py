"""Permanent poses modulo a prime: all are found, and a degenerate one is never overlooked."""

from functools import cache
from itertools import islice

import pytest
from flint import nmod_poly

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.exact.modular import primes
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_systems import EventSystems, System
from rpr_solver.transitions.permanent import _common_roots, _coprime, _poses, _roots, never_degenerate
from tests.support.families import family

P = next(primes(1))[0]


@cache
def permanent_of(m: Manipulator, fixed_leg: int) -> System:
    return EventSystems.of(SliceMap.of(m, fixed_leg)).permanent


@pytest.mark.parametrize("fixed_leg", [1, 2, 3])
@pytest.mark.parametrize("name", ["innocenti", "twelve-cusps"])
def test_usual_manipulators_are_decided_by_a_prime(name: str, fixed_leg: int) -> None:
    assert never_degenerate(permanent_of(EXAMPLES[name], fixed_leg))


@pytest.mark.parametrize(
    ("name", "fixed_leg"),
    [
        ("flat base", 1),
        ("similar, mirrored", 2),
        ("right angles", 2),
        ("isosceles", 3),
        ("folded flat platform", 1),
        ("both flat", 1),
    ],
)
def test_degenerate_ones_are_not_denied(name: str, fixed_leg: int) -> None:
    assert not never_degenerate(permanent_of(family(name), fixed_leg))


def test_eight_poses_up_to_half_turns_of_the_fixed_leg() -> None:
    """Each is singular modulo the prime for every L, and they are different."""
    permanent = permanent_of(EXAMPLES["innocenti"], 1)
    found = [
        x
        for p, omega in islice(primes(permanent.slice_map.radicand), 200)
        if (x := _poses(permanent, p, omega))
    ]
    assert found
    for poses in found:
        assert len({tuple(map(str, (x.cos_alpha, x.sin_alpha, x.sin_theta))) for x in poses}) == 8


@pytest.mark.parametrize(
    ("coefficients", "degree", "roots"),
    [
        ([], 2, None),
        ([-2, 1], 1, [(2, 1)]),
        ([-2, 1], 2, [(2, 1), (1, 0)]),
        ([3], 1, [(1, 0)]),
        ([0, 0, 1], 2, [(0, 1)]),
        ([1, 0, 1], 2, None),
        ([-1, 1, -1, 1], 3, None),
    ],
)
def test_roots_of_a_form_all_or_none(
    coefficients: list[int], degree: int, roots: list[tuple[int, int]] | None
) -> None:
    """-1 is no square modulo these primes."""
    assert _roots(nmod_poly(coefficients, P), degree) == roots


def test_common_roots_with_those_at_infinity() -> None:
    assert _common_roots([-2, 1, 0], [-4, 0, 1, 0], P) == [(2, 1), (1, 0)]
    assert _common_roots([-2, 1], [-4, 0, 1, 0], P) == [(2, 1)]
    assert _common_roots([0, 0], [0, 0], P) is None


@pytest.mark.parametrize(
    ("forms", "coprime"),
    [
        ([([-1, 1], 1), ([-2, 1], 1)], True),
        ([([-1, 1], 1), ([-1, 1], 1)], False),
        ([([-1, 1], 2), ([-2, 1], 2)], False),  # both are 0 at infinity
        ([([-1, 1], 1), ([-2, 1], 2)], True),
        ([([], 1), ([3], 1)], False),
        ([([-1, 1], 1), ([1, -2, 1], 2), ([-1, 0, 1], 2)], False),
        ([([2, -3, 1], 2), ([3, -4, 1], 2), ([6, -5, 1], 2)], True),
    ],
)
def test_forms_without_a_common_root(forms: list[tuple[list[int], int]], coprime: bool) -> None:
    multiples = [(nmod_poly([0, *form], P), degree) for form, degree in forms]
    assert _coprime(multiples) is coprime
