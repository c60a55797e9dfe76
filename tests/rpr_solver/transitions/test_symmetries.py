"""Symmetries of slice maps, against the squared legs themselves."""

from cmath import exp, phase
from fractions import Fraction
from random import Random

import numpy as np
import pytest
from flint import acb

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.symmetries import symmetries
from tests.support.definitions import Slices
from tests.support.families import family

SYMMETRIC = {
    "isosceles": (family("isosceles"), 3, {(True, False)}),
    "isosceles, irrational": (family("isosceles, irrational"), 3, {(True, False)}),
    "mirror-similar": (Manipulator(*map(Fraction, ("22.5", "-6.3", "-8.4", 15, 20, 7))), 1, {(True, False)}),
    "base and platform": (
        Manipulator(*map(Fraction, (5, 0, 12, 5, 12, 13)), orientation="cw"),
        3,
        {(True, True)},
    ),
    "the same, at one angle": (
        Manipulator(*map(Fraction, (15, "-4.2", "-5.6", 15, 7, 20)), orientation="cw"),
        3,
        {(False, True)},
    ),
    "both flat": (family("both flat"), 2, {(True, False)}),
}


@pytest.mark.parametrize("name", SYMMETRIC)
def test_symmetries_map_legs_to_combinations_of_legs(name: str) -> None:
    m, leg, types = SYMMETRIC[name]
    found = symmetries(SliceMap.of(m, leg))
    assert types <= {(symmetry.flips, symmetry.swaps) for symmetry in found}
    slices, random = Slices.of(m, leg), Random(1)
    for symmetry in found:
        here, there = [], []
        for _ in range(9):
            alpha, theta = random.uniform(-3, 3), random.uniform(-3, 3)
            image = symmetry.image(*(_unit(x) for x in (alpha, theta)), 64)
            turned = [phase(complex(x)) for x in image]
            here.append([1.0, *_squares(slices, alpha, theta)])
            there.append(_squares(slices, *turned))
        matrix, *_ = np.linalg.lstsq(np.array(here), np.array(there), rcond=None)
        assert np.allclose(np.array(here) @ matrix, np.array(there), atol=1e-8)
        assert abs(np.linalg.det(matrix[1:])) > 1e-6


def _unit(angle: float) -> acb:
    return acb(exp(1j * angle))


def _squares(slices: Slices, alpha: float, theta: float) -> list[float]:
    return [float(x) ** 2 for x in slices.free_legs((alpha, theta, 7))]


def test_ordinary_manipulators_have_none() -> None:
    assert symmetries(SliceMap.of(EXAMPLES["zein-flat"])) == ()
    assert symmetries(SliceMap.of(family("isosceles"))) == ()
