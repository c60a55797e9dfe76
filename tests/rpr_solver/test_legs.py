"""f, g, J and E in several arithmetics, against the vector V of a leg and its derivatives by FLINT."""

from __future__ import annotations

from fractions import Fraction
from math import cos, isclose, sin

import numpy as np
import pytest
from flint import acb, arb, ctx, fmpq_mpoly, fmpq_mpoly_ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.legs import (
    SINGULAR_WAVES,
    PoseDerivatives,
    Sinusoids,
    Waves,
    cross,
    free_points,
    singular_waves,
    singularity,
    slopes_by_vector,
    turns,
)
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import Leg, SliceMap
from tests.support.shared import plain_leg
from tests.support.strategies import examples

RING = fmpq_mpoly_ctx.get(("C", "S", "c", "s", "L", "w"), "lex")
"""Cosine and sine of α and of θ, L, and ω."""
C, S, COS, SIN, LENGTH, OMEGA = RING.gens()
ORDER = 5

coordinates = st.integers(-30, 30)
legs = st.builds(plain_leg, coordinates, coordinates, coordinates, coordinates, st.sampled_from([2, 3, 15]))


def half_square(leg: Leg) -> fmpq_mpoly:
    """|V|²/2 by the coordinates of V."""
    x = LENGTH * COS + C * leg.m - S * OMEGA * leg.n - leg.ax
    y = LENGTH * SIN + S * leg.m + C * OMEGA * leg.n - leg.ay
    return (x * x + y * y) / 2


def reduced(p: fmpq_mpoly) -> fmpq_mpoly:
    return p % (C**2 + S**2 - 1) % (COS**2 + SIN**2 - 1)


def d_alpha(p: fmpq_mpoly) -> fmpq_mpoly:
    return C * p.derivative("S") - S * p.derivative("C")


def d_theta(p: fmpq_mpoly) -> fmpq_mpoly:
    return COS * p.derivative("s") - SIN * p.derivative("c")


def symbolic(leg: Leg) -> tuple[Sinusoids, Sinusoids]:
    """The sinusoids with L as a factor, and those without."""
    turn, tip = PlaneNumber(C, S), PlaneNumber(COS, SIN)
    waves = leg.waves(OMEGA)
    return waves.turned(*turns(turn, tip * LENGTH)), waves.turned(*turns(turn, tip))


@given(legs)
@examples(20)
def test_all_derivatives_of_a_squared_length(leg: Leg) -> None:
    derivative, f = symbolic(leg)[0].derivatives(), half_square(leg)
    alpha, phi = symbolic(leg)[1].slope_derivatives(LENGTH)
    for i in range(ORDER + 1):
        slope = f
        for j in range(ORDER + 1 - i):
            if i or j:
                assert reduced(slope - derivative(i, j)) == 0, (i, j)
            if i:
                assert reduced(slope - alpha(i - 1, j)) == 0, (i, j)
            if j:
                assert reduced(slope - LENGTH * phi(i, j - 1)) == 0, (i, j)
            slope = d_theta(slope)
        f = d_alpha(f)


@given(legs)
@examples(20)
def test_values_and_slopes_with_l_and_without(leg: Leg) -> None:
    (long, own), f = symbolic(leg), half_square(leg)
    constant = (leg.m**2 + leg.n**2 * OMEGA**2 + leg.base2 + LENGTH**2) / 2
    for value in (long.value(), own.value(LENGTH)):
        assert reduced(f - constant - value) == 0
    f_alpha, f_theta = d_alpha(f), d_theta(f)
    for at, length, scale in ((long, None, 1), (own, LENGTH, LENGTH)):
        expected = (f_alpha, f_theta), *((d(f_alpha), d(f_theta)) for d in (d_alpha, d_theta))
        for pair, slopes in zip(at.slopes(length), expected, strict=True):
            assert reduced(pair[0] - slopes[0]) == 0
            assert reduced(pair[1] * scale - slopes[1]) == 0
        assert at.gradient(length) == at.slopes(length)[0]


@given(legs)
@examples(20)
def test_slopes_by_the_vector_are_those_by_the_waves(leg: Leg) -> None:
    turned = leg.rotated(C, S, OMEGA)
    tip = LENGTH * COS, LENGTH * SIN
    x, y = (t + u - a for t, u, a in zip(tip, turned, (leg.ax, leg.ay), strict=True))
    found, expected = slopes_by_vector((x, y), turned, tip, LENGTH**2), symbolic(leg)[0].slopes()
    for pair, slopes in zip(found, expected, strict=True):
        for p, q in zip(pair, slopes, strict=True):
            assert reduced(p - q) % (OMEGA**2 - leg.radicand) == 0


@given(legs)
@examples(20)
def test_derivatives_by_the_length(leg: Leg) -> None:
    (_, own), f = symbolic(leg), half_square(leg)
    assert reduced(f.derivative("L") - LENGTH - own.by_length) == 0
    assert reduced(d_alpha(f).derivative("L") - own.slopes_by_length[0]) == 0
    assert reduced(d_theta(f) - LENGTH * own.slopes_by_length[1]) == 0


@given(legs)
@examples(20)
def test_a_leg_over_l(leg: Leg) -> None:
    """For L = 1/ε: with ε in place of L in the ring."""
    shrunk, f = symbolic(leg)[1].shrunk(LENGTH), half_square(leg)
    terms = [f.subs({"L": 0}), f.derivative("L").subs({"L": 0})]
    for d, x in zip((d_alpha, d_theta), shrunk.gradient(), strict=True):
        assert reduced(d(terms[1] + LENGTH * terms[0]) - x) == 0


@given(legs, legs)
@examples(10)
def test_j_and_e_with_their_gradients(first: Leg, second: Leg) -> None:
    (f, _), (g, _) = symbolic(first), symbolic(second)
    gradients = [(d_alpha(p), d_theta(p)) for p in (half_square(first), half_square(second))]
    j = reduced(cross(*gradients))
    e = reduced(cross(gradients[0], (d_alpha(j), d_theta(j))))
    expected = (j, d_alpha(j), d_theta(j), e, d_alpha(e), d_theta(e))
    found = PoseDerivatives.of(f, g)
    for x, y in zip(found, expected, strict=True):
        assert reduced(x - y) == 0


@given(legs, legs)
@examples(10)
def test_j_over_l_with_its_gradient(first: Leg, second: Leg) -> None:
    slopes = (symbolic(leg)[1].slopes(LENGTH) for leg in (first, second))
    j = reduced(cross(*((d_alpha(p), d_theta(p)) for p in (half_square(first), half_square(second)))))
    for x, y in zip(singularity(*slopes), (j, d_alpha(j), d_theta(j)), strict=True):
        assert reduced(LENGTH * x - y) == 0


@given(legs, legs)
@examples(10)
def test_j_over_l_as_a_sum_of_six_waves(first: Leg, second: Leg) -> None:
    f, g = (leg.waves(OMEGA) for leg in (first, second))
    turn, tip = PlaneNumber(C, S), PlaneNumber(COS, SIN)
    total = RING.constant(0)
    for wave, powers in zip(singular_waves(f, g, LENGTH), SINGULAR_WAVES, strict=True):
        for base, power in zip((turn, tip), powers, strict=True):
            for _ in range(abs(power)):
                wave = wave * (base if power > 0 else base.conjugate())
        total += wave.real
    j, *_ = singularity(*(symbolic(leg)[1].slopes(LENGTH) for leg in (first, second)))
    assert reduced(total - 2 * j) == 0


# arithmetics


@pytest.mark.parametrize("fixed_leg", [1, 2, 3])
def test_six_irrational_numbers(fixed_leg: int) -> None:
    """Sides and coordinates that are √2 times those of a manipulator, as balls and as doubles."""
    manipulator = Manipulator("15", "3", "11", "17", "16", "9")
    slice_map = SliceMap.of(manipulator, fixed_leg)
    with ctx.workprec(100):
        root, d = arb(2).sqrt(), [arb(x) for x in (17, 16, 9)]
        along = (d[0] ** 2 + d[2] ** 2 - d[1] ** 2) / (2 * d[0])
        base, platform = ([x * root for x in own] for own in ((arb(15), arb(3), arb(11)), (d[0], along)))
        platform.append((d[2] ** 2 - along**2).sqrt() * root)
        scale = root / slice_map.scale_ball()
        omega = arb(slice_map.radicand).sqrt()
        for free, leg in zip(free_points(base, platform, fixed_leg), (slice_map.f, slice_map.g), strict=True):
            sizes = scale, scale, scale**2
            for found, expected, size in zip(Waves.of(*free), leg.waves(omega), sizes, strict=True):
                assert found.real.overlaps(expected.real * size)
                assert found.imag.overlaps(expected.imag * size)
        floats = free_points([float(x) for x in base], [float(x) for x in platform], fixed_leg)
        for (m, a), (p, b) in zip(floats, free_points(base, platform, fixed_leg), strict=True):
            for x, y in ((m, p), (a, b)):
                assert (x.real, x.imag) == pytest.approx((float(y.real), float(y.imag)), abs=1e-12)


LEG = plain_leg(3, -2, 7, 5, 6)


def sinusoids(alpha: float, theta: float) -> dict[str, Sinusoids]:
    """Those at a pose with L = 1.25, in each arithmetic."""
    with ctx.workprec(80):
        balls = LEG.waves(arb(6).sqrt()).turned(*turns(acb(0, alpha).exp(), acb(0, theta).exp() * arb(1.25)))
    waves = Waves.of(*LEG.doubles(Fraction(1)))
    turn, tip = complex(cos(alpha), sin(alpha)), 1.25 * complex(cos(theta), sin(theta))
    pair = PlaneNumber(turn.real, turn.imag), PlaneNumber(tip.real, tip.imag)
    return {
        "balls": balls,
        "doubles": waves.turned(*turns(turn, tip)),
        "arrays": waves.turned(*turns(np.array([turn, 1]), np.array([tip, 1]))),
        "pairs": LEG.waves(6**0.5).turned(*turns(*pair)),
    }


@pytest.mark.parametrize("name", ["balls", "arrays", "pairs"])
def test_all_arithmetics_agree(name: str) -> None:
    for alpha, theta in ((0.4, 1.1), (-2.0, 0.3), (3.0, -2.5)):
        found = sinusoids(alpha, theta)
        for x, y in zip(found[name], found["doubles"], strict=True):
            first = x[0] if name == "arrays" else x
            assert isclose(float(first), y, rel_tol=1e-12, abs_tol=1e-12)
