"""J and E, derived by SymPy, against floating point derivatives of the legs."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES
from rpr_solver.verify.core.intervals import Interval, radians
from rpr_solver.verify.core.krawczyk import Directions, value
from rpr_solver.verify.core.surds import Surd
from rpr_solver.verify.core.system import Surface, System, Trig, at_half_tangent, derivative
from tests.support.families import family
from tests.support.verified import geometry_of

ALPHA, THETA = 0.7, -1.3


def value_at(p: Trig, system: System, alpha: float = ALPHA, theta: float = THETA) -> float:
    w = math.sqrt(system.ring.radicand)
    basis = math.cos(alpha), math.sin(alpha), math.cos(theta), math.sin(theta)
    return sum(
        (a + b * w) * math.prod(x**n for x, n in zip(basis, key, strict=True)) for key, (a, b) in p.items()
    )


@pytest.mark.parametrize("fixed", [1, 2, 3])
def test_squared_lengths_and_their_derivatives(fixed: int) -> None:
    system = System.of(geometry_of(EXAMPLES["innocenti"]), fixed, Fraction(12))
    (bx, by), h = system.surface.geometry.base[fixed - 1], 1e-6
    factor, radicand = system.surface.geometry.height
    corners = [
        0,
        float(system.surface.geometry.d1),
        complex(float(system.surface.geometry.foot), float(factor) * math.sqrt(radicand)),
    ]
    turn = complex(math.cos(ALPHA), math.sin(ALPHA))
    here = complex(float(bx), float(by)) + 12 * complex(math.cos(THETA), math.sin(THETA))
    for leg in system.legs:
        ax, ay = system.surface.geometry.base[leg.number - 1]
        there = here + turn * (corners[leg.number - 1] - corners[fixed - 1])
        squared = abs(there - complex(float(ax), float(ay))) ** 2
        assert value_at(leg.squared, system) == pytest.approx(squared * system.unit**2)
        for p in (leg.squared, leg.kernel, system.singular):
            slope = (value_at(p, system, ALPHA + h) - value_at(p, system, ALPHA - h)) / (2 * h)
            assert value_at(derivative(p, theta=False), system) == pytest.approx(slope, rel=1e-4)
            slope = (value_at(p, system, ALPHA, THETA + h) - value_at(p, system, ALPHA, THETA - h)) / (2 * h)
            assert value_at(derivative(p, theta=True), system) == pytest.approx(slope, rel=1e-4)
        j = [value_at(derivative(system.singular, theta=side), system) for side in (False, True)]
        e = value_at(leg.alpha, system) * j[1] - value_at(leg.theta, system) * j[0]
        assert value_at(leg.kernel, system) == pytest.approx(e)


def test_the_jacobian_determinant_and_half_tangents() -> None:
    system = System.of(geometry_of(family("flat platform")), 1, Fraction(5, 2))
    f, g = system.legs
    j = value_at(f.alpha, system) * value_at(g.theta, system) - value_at(f.theta, system) * value_at(
        g.alpha, system
    )
    ratio = j / value_at(system.singular, system)
    assert ratio == pytest.approx(round(ratio))
    u, t = Fraction(1, 3), Fraction(-2, 5)
    row: tuple[Surd, ...] = at_half_tangent(system.singular, 2, *u.as_integer_ratio())
    alpha, theta = (2 * math.atan(x) for x in (t, u))
    expected = value_at(system.singular, system, alpha, theta) * float((1 + t * t) ** 2) * (9 + 1) ** 2
    assert sum(a * float(t) ** k for k, (a, _) in enumerate(row)) == pytest.approx(expected)
    assert [len(system.along), len(system.closed)] == [2, 3]


BITS = 200
GEOMETRY = geometry_of(EXAMPLES["innocenti"])


@pytest.mark.parametrize("fixed", [1, 3])
def test_at_one_length_it_is_the_slice(fixed: int) -> None:
    surface, system = Surface(GEOMETRY, fixed), System.of(GEOMETRY, fixed, Fraction(12))
    here = Directions.of(radians(Fraction(40), BITS), radians(Fraction(-75), BITS), surface.ring.radicand)
    length = Interval.of(12 * surface.unit, BITS)
    for leg, mine in zip(system.legs, surface.legs, strict=True):
        assert value(here, mine.squared, length).meets(here.value(leg.squared))
    singular, other = value(here, surface.singular, length), here.value(system.singular)
    ratio = float(singular.middle / other.middle)
    assert ratio == pytest.approx(round(ratio)) or 1 / ratio == pytest.approx(round(1 / ratio))
