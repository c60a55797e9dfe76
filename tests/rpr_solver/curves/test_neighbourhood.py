"""Local expansions and turned half angles, against J, E and their gradients by definition."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product

import mpmath as mp
import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.curves.neighbourhood import (
    ALONG_L,
    CuspForms,
    Frame,
    at_parameter,
    value_of_each,
)
from rpr_solver.model.jets import HalfTangent
from rpr_solver.model.slice_map import SliceMap
from tests.support.definitions import Slices
from tests.support.families import family
from tests.support.places import angle_of, cusps_of, neighbourhood, number, place, scaled
from tests.support.shared import census_of, eliminant_of

BITS, DIGITS = 192, 50
FLAT = EXAMPLES["zein-flat"]
ANGLES = (-179, -90, -31, 0, 45, 150, 180)


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    with ctx.workprec(BITS), mp.workdps(DIGITS):
        yield


def same_angle(a: mp.mpf, b: mp.mpf) -> bool:
    return abs(mp.sin((a - b) / 2)) < mp.mpf(10) ** (10 - DIGITS)


class TestExpansions:
    """J and E in local coordinates are the functions, times (1+x²)³(1+y²)³(1−z)² and one constant."""

    OFFSETS = ((0.1, 0.0, 0.0), (0.3, -0.2, 0.1), (-1.5, 0.7, -0.4), (2.0, 3.0, 0.9))

    @pytest.mark.parametrize(
        ("m", "fixed_leg"),
        [(FLAT, 1), (FLAT, 2), (EXAMPLES["twelve-cusps"], 3), (family("isosceles, irrational"), 1)],
        ids=["flat", "flat, leg 2", "irrational, leg 3", "isosceles"],
    )
    def test_everywhere_and_about_any_pose(self, m: Manipulator, fixed_leg: int) -> None:
        slices, slice_map = Slices.of(m, fixed_leg), SliceMap.of(m, fixed_leg)
        singular, coalescence = CuspForms(slice_map).at(BITS)
        ratios: list[list[mp.mpf]] = [[], [], []]
        for alpha, theta in zip(ANGLES, ANGLES[::-1], strict=True):
            alpha, theta, length = mp.radians(alpha), mp.radians(theta), mp.mpf(7)
            frame = Frame.about(place(alpha, theta), scaled(slice_map, length))
            for x, y, z in self.OFFSETS:
                point = (
                    alpha + 2 * mp.atan(x),
                    theta + 2 * mp.atan(y),
                    length * (1 + mp.mpf(z)) / (1 - mp.mpf(z)),
                )
                j, *e = vars(slices.values(point, "j", "e_f", "e_g")).values()
                # J and E hold a factor L, which their forms lack
                weight = ((1 + mp.mpf(x) ** 2) * (1 + mp.mpf(y) ** 2)) ** 3 / point[2] * (1 - mp.mpf(z)) ** 2
                expected = j * weight, *(w * weight for w in e)
                for ratio, form, truth in zip(ratios, (singular, *coalescence), expected, strict=True):
                    [local] = value_of_each([at_parameter(*frame.expanded(form), arb(z))], arb(x), arb(y))
                    ratio.append(number(local) / truth)
        for ratio in ratios:
            assert len(ratio) == 28
            assert all(mp.almosteq(r, ratio[0], mp.mpf(10) ** (12 - DIGITS)) for r in ratio)


class TestFrames:
    @pytest.mark.parametrize("alpha", ANGLES)
    def test_local_coordinates_turn_half_angles(self, alpha: int) -> None:
        origin, theta = mp.radians(alpha), mp.radians(20)
        frame = Frame.about(place(origin, theta), arb(3))
        for x, y in ((0.0, 0.0), (0.5, -2.0), (-30.0, 1.0)):
            moved = frame.outside(arb(x), arb(y))
            assert same_angle(angle_of(moved.alpha), origin + 2 * mp.atan(x))
            assert same_angle(angle_of(moved.theta), theta + 2 * mp.atan(y))
            back = frame.inside(moved, arb(6))
            assert all(abs(b - w) < 1e-40 for b, w in zip(back, (x, y, arb(1) / 3), strict=True))


class TestPlaces:
    def test_a_half_angle_and_its_opposite_are_one_place(self) -> None:
        """tan has the period of half a turn: (n, d) and (−n, −d) are the same angle."""
        here = place(mp.mpf(1), mp.mpf(2), 1e-9)
        t = here.alpha
        turned = replace(here, alpha=HalfTangent(-t.numerator, -t.denominator))
        assert not here.apart(turned)
        assert here.apart(replace(here, alpha=HalfTangent(-t.numerator, t.denominator)))


class TestSteeperLeg:
    """Where a leg and its platform side lie along its base line, the gradient of its square vanishes."""

    def test_a_leg_without_gradient_is_not_taken(self) -> None:
        forms = CuspForms(SliceMap.of(FLAT))  # base points (30, 0) and (11, 27), a flat platform
        to_a3 = mp.atan2(27, 11)
        along_f, along_g = place(mp.pi, mp.mpf(0)), place(to_a3, to_a3 + mp.pi)
        length = scaled(forms.slice_map, mp.mpf(10))
        assert forms.steeper(along_f, length, BITS) == 1
        assert forms.steeper(along_g, length, BITS) == 0


@pytest.mark.quick
class TestHeading:
    """The way of a curve, against the tangent ∇J × ∇E in (α, θ, L) by definition."""

    @pytest.mark.parametrize("fixed_leg", [1, 3])
    def test_parameter_and_directions_are_the_tangents(self, fixed_leg: int) -> None:
        slices = Slices.of(FLAT, fixed_leg)
        bests = set()
        for length in ("9", "26.39", "31.86338", "34.6"):
            for cusp in cusps_of(eliminant_of(FLAT, fixed_leg), Fraction(length), 40):
                alpha, theta, log_length = slices.tangent(cusp)
                tangent = alpha / 2, theta / 2, log_length / 2
                best = max(range(3), key=lambda i: abs(tangent[i]))
                around = neighbourhood(FLAT, cusp, BITS, fixed_leg)
                for axis, forwards in product(range(3), (True, False)):
                    way = 1 if (tangent[axis] > 0) == forwards else -1
                    expected = best, way * tangent[best] > 0, way * tangent[ALONG_L] > 0
                    assert around.heading(axis, forwards) == expected
                bests.add(best)
        assert len(bests) > 1

    def test_where_the_curve_turns_back_the_way_in_l_is_not_told(self) -> None:
        transition = census_of(FLAT).to_json()["transitions"][3]
        event = transition["events"][0]
        alpha, theta = (mp.radians(mp.mpf(event[name])) for name in ("alpha_deg", "theta1_deg"))
        around = neighbourhood(FLAT, (alpha, theta, mp.mpf(transition["l1"])), BITS, radius=1e-20)
        way = around.heading(0, True)
        assert way is not None
        assert way[0] != ALONG_L
        assert way[2] is None
        assert around.heading(ALONG_L, True) is None
