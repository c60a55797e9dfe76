"""J and E, derived by SymPy, against floating point derivatives of the legs."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES
from rpr_solver.verify.core.surds import Surd
from rpr_solver.verify.core.system import System, Trig, at_half_tangent, derivative
from tests.support.families import family
from tests.support.verified import geometry_of

ALPHA, THETA = 0.7, -1.3


def value(p: Trig, system: System, alpha: float = ALPHA, theta: float = THETA) -> float:
    w = math.sqrt(system.ring.radicand)
    basis = math.cos(alpha), math.sin(alpha), math.cos(theta), math.sin(theta)
    return sum(
        (a + b * w) * math.prod(x**n for x, n in zip(basis, key, strict=True)) for key, (a, b) in p.items()
    )


@pytest.mark.parametrize("fixed", [1, 2, 3])
def test_squared_lengths_and_their_derivatives(fixed: int) -> None:
    system = System.of(geometry_of(EXAMPLES["innocenti"]), fixed, Fraction(12))
    (bx, by), h = system.geometry.base[fixed - 1], 1e-6
    factor, radicand = system.geometry.height
    corners = [
        0,
        float(system.geometry.d1),
        complex(float(system.geometry.foot), float(factor) * math.sqrt(radicand)),
    ]
    turn = complex(math.cos(ALPHA), math.sin(ALPHA))
    here = complex(float(bx), float(by)) + 12 * complex(math.cos(THETA), math.sin(THETA))
    for leg in system.legs:
        ax, ay = system.geometry.base[leg.number - 1]
        there = here + turn * (corners[leg.number - 1] - corners[fixed - 1])
        squared = abs(there - complex(float(ax), float(ay))) ** 2
        assert value(leg.squared, system) == pytest.approx(squared * system.unit**2)
        for p in (leg.squared, leg.kernel, system.singular):
            slope = (value(p, system, ALPHA + h) - value(p, system, ALPHA - h)) / (2 * h)
            assert value(derivative(p, theta=False), system) == pytest.approx(slope, rel=1e-4)
            slope = (value(p, system, ALPHA, THETA + h) - value(p, system, ALPHA, THETA - h)) / (2 * h)
            assert value(derivative(p, theta=True), system) == pytest.approx(slope, rel=1e-4)
        j = [value(derivative(system.singular, theta=side), system) for side in (False, True)]
        e = value(leg.alpha, system) * j[1] - value(leg.theta, system) * j[0]
        assert value(leg.kernel, system) == pytest.approx(e)


def test_the_jacobian_determinant_and_half_tangents() -> None:
    system = System.of(geometry_of(family("flat platform")), 1, Fraction(5, 2))
    f, g = system.legs
    j = value(f.alpha, system) * value(g.theta, system) - value(f.theta, system) * value(g.alpha, system)
    ratio = j / value(system.singular, system)
    assert ratio == pytest.approx(round(ratio))
    u, t = Fraction(1, 3), Fraction(-2, 5)
    row: tuple[Surd, ...] = at_half_tangent(system.singular, 2, 2, u)
    alpha, theta = (2 * math.atan(x) for x in (t, u))
    expected = value(system.singular, system, alpha, theta) * float((1 + t * t) ** 2) * (9 + 1) ** 2
    assert sum(a * float(t) ** k for k, (a, _) in enumerate(row)) == pytest.approx(expected)
    assert [len(system.along), len(system.closed)] == [2, 3]
