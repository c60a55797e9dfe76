"""Cusps above roots of the eliminant, against floating-point derivatives and the article's equations."""

import math
from fractions import Fraction
from functools import cache

import mpmath as mp
import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.exact.real_roots import RealRoot, real_roots
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.slices.by_balls import CuspBalls, SlicePoses
from tests.support.article import coalescence, pose, singularity
from tests.support.newton import Slice
from tests.support.shared import eliminant_of

BITS = 400
IRRATIONAL = Manipulator(*map(Fraction, (7, 3, 5, 4, 5, 6)), orientation="cw")
SLICES = {"flat": (EXAMPLES["zein-flat"], "10"), "triangle": (IRRATIONAL, "5/2")}


@cache
def roots_of(name: str) -> list[RealRoot]:
    m, length = SLICES[name]
    eliminant = eliminant_of(m)
    return real_roots(eliminant.at(Fraction(length) * eliminant.slice_map.scale))


def poses_of(name: str, bits: int = BITS) -> SlicePoses:
    m, length = SLICES[name]
    slice_map = eliminant_of(m).slice_map
    return SlicePoses(slice_map, Fraction(length) * slice_map.scale, bits)


def cusps_of(name: str) -> list[tuple[arb, HalfTangent, CuspBalls]]:
    poses, result = poses_of(name), []
    with ctx.workprec(BITS):
        for root in roots_of(name):
            u = root.refined(BITS - 64)
            t = poses.alpha(u)
            assert t is not None
            cusp = poses.cusp(u, t)
            assert cusp is not None
            result.append((u, t, cusp))
    return result


def text(x: arb) -> str:
    """Its middle to forty digits."""
    return str(x.str(40, radius=False))


@pytest.mark.parametrize("name", SLICES)
def test_above_every_root_lies_a_cusp_of_the_article(name: str) -> None:
    m, length = SLICES[name]
    cusps = cusps_of(name)
    assert len(cusps) == {"flat": 4, "triangle": 6}[name]
    with mp.workdps(38):
        for _, _, cusp in cusps:
            at = pose(m, length, text(cusp.alpha_deg), text(cusp.theta_deg))
            assert abs(singularity(m, at)) < mp.mpf(10) ** -30
            assert abs(coalescence(m, at)) < mp.mpf(10) ** -30
            for own, ball in zip(at.lengths[1:], (cusp.first, cusp.second), strict=True):
                assert abs(own - mp.mpf(text(ball))) < mp.mpf(10) ** -30


@pytest.mark.parametrize("name", SLICES)
def test_angles_are_those_of_the_half_tangents(name: str) -> None:
    for u, t, cusp in cusps_of(name):
        for degrees, tangent in (
            (cusp.theta_deg, float(u)),
            (cusp.alpha_deg, float(t.numerator / t.denominator)),
        ):
            assert float(degrees) == pytest.approx(math.degrees(2 * math.atan(tangent)))


@pytest.mark.parametrize("name", SLICES)
def test_the_proof_is_made_of_the_derivatives_it_names(name: str) -> None:
    """f_α or f_θ, J_α or J_θ, v·∇E, by floating-point formulas; halves of squares, in units of its own."""
    m, length = SLICES[name]
    slice_map = eliminant_of(m).slice_map
    local = Slice(m, float(Fraction(length)))
    unit = (local.size * float(slice_map.scale)) ** 2
    for _, _, cusp in cusps_of(name):
        at = math.radians(float(cusp.alpha_deg)), math.radians(float(cusp.theta_deg))
        f = local.derivatives(0, at)
        _, (j, e) = local.system(0, at)
        larger_slope, larger_gradient = (max(pair, key=abs) for pair in ((f[1][0], f[0][1]), j))
        assert not any(x.contains(0) for x in cusp.proof.values())
        assert {name: float(x) for name, x in cusp.proof.items()} == pytest.approx(
            {
                "rank_1": larger_slope * unit,
                "grad_J": larger_gradient * unit**2,
                "v_grad_E": (f[1][0] * e[1] - f[0][1] * e[0]) * unit**4,
            }
        )


@pytest.mark.parametrize("name", SLICES)
def test_balls_are_as_thin_as_the_precision_allows(name: str) -> None:
    for _, t, cusp in cusps_of(name):
        balls = (t.numerator, t.denominator, cusp.alpha_deg, cusp.theta_deg, cusp.first, cusp.second)
        assert min(x.rel_accuracy_bits() for x in balls) > BITS // 2


def test_a_wide_root_has_no_pose() -> None:
    """Over u ± 1/10 the subresultant may vanish; over u ± 1/2 it may be no cusp."""
    poses = poses_of("flat")
    with ctx.workprec(BITS):
        for root in roots_of("flat"):
            u = root.refined(100)
            assert poses.alpha(arb(u.mid(), 0.1)) is None
            t = poses.alpha(u)
            assert t is not None
            assert poses.cusp(arb(u.mid(), 0.5), t) is None


def test_what_is_uncertain_is_no_cusp() -> None:
    """The true pose, with one half tangent or the other known too roughly, or with α about 180°."""
    poses = poses_of("triangle")
    with ctx.workprec(BITS):
        for u, t, _ in cusps_of("triangle"):
            wide = HalfTangent(arb(t.numerator.mid(), abs(t.numerator).upper()), t.denominator)
            assert poses.cusp(u, wide) is None
            assert poses.cusp(u, HalfTangent(t.numerator, arb(0, abs(t.denominator).upper()))) is None


def test_a_half_turn_of_the_platform_is_left_to_number_fields() -> None:
    """A regular pose far from all conditions: only its α = 180° speaks against it."""
    poses = poses_of("triangle")
    with ctx.workprec(BITS):
        u = arb(1) / 3
        assert poses.cusp(u, HalfTangent(arb(1), arb(1) / 1000)) is not None
        assert poses.cusp(u, HalfTangent(arb(1), arb(0))) is None
