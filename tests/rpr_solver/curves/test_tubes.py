"""A tube holds the curve and nothing else: Newton's points, Krawczyk's inequality, curves in closed form."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cache
from itertools import product

import mpmath as mp
import pytest
from flint import arb, arb_mat, ctx
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.curves.neighbourhood import (
    ALONG_L,
    ORDER,
    Expansion,
    Frame,
    Neighbourhood,
    PoseBox,
    Three,
)
from rpr_solver.curves.tubes import Tube, build
from tests.support.definitions import Point, Slices
from tests.support.places import cusps_of, neighbourhood, number, place, scaled
from tests.support.shared import eliminant_of
from tests.support.strategies import examples

BITS, DIGITS = 192, 45
FLAT = EXAMPLES["zein-flat"]
SLICES = ((1, "9"), (3, "28.11839"))
"""Legs and lengths."""
WHOLE = (-1, -0.2, 1)
"""Shares of a tube's reach."""


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    with ctx.workprec(BITS), mp.workdps(DIGITS):
        yield


@cache
def tubes_of_cusps() -> list[tuple[Slices, Point, Tube]]:
    """Tubes along each coordinate that will do, from cusps of the flat manipulator's slices."""
    tubes = []
    for fixed_leg, length in SLICES:
        slices = Slices.of(FLAT, fixed_leg)
        for cusp in cusps_of(eliminant_of(FLAT, fixed_leg), Fraction(length), 40):
            around = neighbourhood(FLAT, cusp, BITS, fixed_leg)
            for axis in range(3):
                tube = build(around, axis, True)
                if tube is not None:
                    tubes.append((slices, cusp, tube))
    return tubes


def origin(tube: Tube, slices: Slices) -> Point:
    """Where the local coordinates of a tube begin, in radians and in the user's unit."""
    slice_map = eliminant_of(slices.manipulator, slices.fixed_leg).slice_map
    (s, c), (s2, c2) = tube.frame.alpha, tube.frame.theta
    angles = (2 * mp.atan2(number(x), number(y)) for x, y in ((s, c), (s2, c2)))
    length = number(tube.frame.length) * slice_map.scale.denominator / slice_map.scale.numerator
    return *angles, length  # type: ignore[return-value]


def outside(base: Point, local: list[mp.mpf]) -> Point:
    x, y, z = local
    return base[0] + 2 * mp.atan(x), base[1] + 2 * mp.atan(y), base[2] * (1 + z) / (1 - z)


def inside(base: Point, point: Point) -> list[mp.mpf]:
    return [
        mp.tan((point[0] - base[0]) / 2),
        mp.tan((point[1] - base[1]) / 2),
        (point[2] - base[2]) / (point[2] + base[2]),
    ]


def middle(tube: Tube, r: mp.mpf) -> list[mp.mpf]:
    """The point of the path, in the order x, y, z."""
    local = [mp.polyval([number(c) for c in reversed(x.coeffs())], r) for x in tube.path]
    local.insert(tube.axis, r)
    return local


def on_curve(tube: Tube, slices: Slices, share: float) -> tuple[Point, list[mp.mpf]]:
    """The zero of J and E at a share of the tube's reach: as it is, and in local coordinates."""
    base = origin(tube, slices)
    start = outside(base, middle(tube, number(tube.reach) * share))
    point = slices.newton(start, held=tube.axis)
    assert point is not None
    return point, inside(base, point)


def holds(box: PoseBox, point: Point) -> bool:
    return not place(point[0], point[1], 1e-36).apart(box)


def test_a_cusp_at_one_pose_in_every_slice_has_a_tube() -> None:
    """Mirrored congruent isosceles triangles: with leg 2 fixed, α = θ = 0 is a cusp of nearly every slice.

    There the curve is a straight line in L, which the path meets exactly.
    """
    mirrored = Manipulator(6, 3, 4, 6, 5, 5, "cw")
    around = neighbourhood(mirrored, (mp.mpf(0), mp.mpf(0), mp.mpf("0.08")), BITS, 2, radius=0.0)
    tube = build(around, ALONG_L, True)
    assert tube is not None
    assert all(radius > 0 for radius in tube.radii)
    end, _ = tube.end()
    assert end.alpha.numerator.contains(0)
    assert end.theta.numerator.contains(0)


class TestOnCuspCurves:
    def test_newtons_points_lie_in_the_tube(self) -> None:
        axes = set()
        for slices, _, tube in tubes_of_cusps():
            axes.add(tube.axis)
            for share in WHOLE:
                local = on_curve(tube, slices, share)[1]
                away = [abs(a - b) for a, b in zip(local, middle(tube, local[tube.axis]), strict=True)]
                del away[tube.axis]
                assert all(d < number(radius) for d, radius in zip(away, tube.radii, strict=True))
        assert axes == {0, 1, 2}

    def test_the_box_of_a_slice_holds_its_cusp_and_no_other(self) -> None:
        eliminant, slices = eliminant_of(FLAT), Slices.of(FLAT)
        length = Fraction("26.3901")
        target = scaled(eliminant.slice_map, mp.mpf("26.3901"))
        others = cusps_of(eliminant, length, 40)
        met = []
        for cusp in cusps_of(eliminant, Fraction("26.39"), 40):
            tube = build(neighbourhood(FLAT, cusp, BITS), ALONG_L, True)
            assert tube is not None
            box = tube.box_at(target)
            _, point = slices.trace(cusp, mp.mpf(26), mp.mpf("26.3901"), upwards=True, step=0.001)
            assert holds(box, point)
            [only] = [i for i, other in enumerate(others) if holds(box, other)]
            met.append(only)
        assert sorted(met) == list(range(len(others)))

    def test_the_end_is_a_box_round_the_curve_near_the_end(self) -> None:
        """No wider than the tube, and nearly always much smaller."""
        widths = []
        for slices, cusp, _ in tubes_of_cusps():
            if slices.fixed_leg != 1:
                continue
            slice_map = eliminant_of(FLAT).slice_map
            for axis, forwards in product(range(3), (True, False)):
                tube = build(neighbourhood(FLAT, cusp, BITS), axis, forwards)
                if tube is None:
                    continue
                point, local = on_curve(tube, slices, 0.999 if forwards else -0.999)
                box, length = tube.end()
                assert holds(box, point)
                assert abs(length.mid() - scaled(slice_map, point[2]).mid()) < length.rad() + 1e-36
                x, y, _ = tube.frame.inside(box, length)
                widths.append(max(x.rad(), y.rad()))
                assert widths[-1] <= max(tube.radii) * 1.001
                assert (local[axis] > 0) == forwards
        assert sum(width < 1e-30 for width in widths) > len(widths) * 0.9


Terms = Mapping[tuple[int, int, int], Fraction | int | arb]


def expansion(terms: Terms) -> Expansion:
    """Σ c xⁱ yʲ zᵏ."""
    return [
        arb_mat([[ball_of(terms.get((i, j, k), 0)) for j in range(ORDER + 1)] for i in range(ORDER + 1)])
        for k in range(3)
    ]


def ball_of(x: Fraction | int | arb) -> arb:
    return x if isinstance(x, arb) else arb(Fraction(x).numerator) / Fraction(x).denominator


def artificial(
    j: Terms,
    e: Terms,
    box: Three | None = None,
) -> Neighbourhood:
    """Any two polynomials in x, y, z in the place of J and E; the length at the origin is 1."""
    small = arb(0, 1e-50)
    frame = Frame.about(place(mp.mpf(1), mp.mpf(2)), arb(1))
    return Neighbourhood(frame, (expansion(j), expansion(e)), box or (small, small, small), BITS)


X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


class TestCurvesInClosedForm:
    coefficients = st.tuples(*(st.integers(-4, 4) for _ in range(6)))

    @given(coefficients, st.integers(0, 2))
    @examples(60)
    def test_the_curve_stays_inside_along_any_coordinate(self, c: tuple[int, ...], axis: int) -> None:
        """p = a r + b r², q = c r + d r², with factors 1 + e q and 1 + f p that vanish elsewhere."""
        a, b, slope, bend, e, f = c
        others = [i for i in range(3) if i != axis]

        def power(p: int, q: int, r: int) -> tuple[int, int, int]:
            of = {others[0]: p, others[1]: q, axis: r}
            return of[0], of[1], of[2]

        first = {
            (1, 0, 0): 1,
            (0, 0, 1): -a,
            (0, 0, 2): -b,
            (1, 1, 0): e,
            (0, 1, 1): -a * e,
            (0, 1, 2): -b * e,
        }
        second = {
            (0, 1, 0): 1, (0, 0, 1): -slope, (0, 0, 2): -bend,
            (1, 1, 0): f, (1, 0, 1): -slope * f, (1, 0, 2): -bend * f,
        }  # fmt: skip
        j, e_ = ({power(*k): v for k, v in form.items()} for form in (first, second))
        tube = build(artificial(j, e_), axis, True)
        assert tube is not None
        for share in WHOLE:
            r = tube.reach * share
            for x, (u, v), radius in zip(tube.path, ((a, b), (slope, bend)), tube.radii, strict=True):
                assert abs(x(r) - r * u - r * r * v) < radius

    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_where_two_branches_cross_there_is_no_tube(self, axis: int) -> None:
        """y² = z², x = 0: at the origin no coordinate tells the branches apart."""
        assert build(artificial({X: 1}, {(0, 2, 0): 1, (0, 0, 2): -1}), axis, True) is None

    @pytest.mark.parametrize("swapped", [False, True])
    @pytest.mark.parametrize("where", [Fraction(1, 50), Fraction(1, 1000)])
    def test_a_tube_ends_before_the_curve_is_crossed(self, where: Fraction, swapped: bool) -> None:
        """On y = z, seen from a distance to the crossing with y = −2w − z; or x instead of y."""
        j, e = {X: 1}, {Y: 2 * where, Z: -2 * where, (0, 2, 0): 1, (0, 0, 2): -1}
        if swapped:
            j, e = ({(y, x, z): c for (x, y, z), c in form.items()} for form in (j, e))
        tube = build(artificial(j, e), ALONG_L, True)
        assert tube is not None
        assert tube.reach < ball_of(where)
        i = 0 if swapped else 1
        for share in WHOLE:
            r = tube.reach * share
            other = -2 * ball_of(where) - r
            assert abs(other - tube.path[i](r)) > tube.radii[i]

    @pytest.mark.parametrize(("first", "second"), [(0.01, 0), (0, 0.3), (0.01, 0.3)])
    def test_every_curve_of_wide_coefficients_is_held(self, first: float, second: float) -> None:
        """x = a z + b z², y = c z + d z², with a, b, c, d in balls."""
        a, b, c, d = arb(1, first), arb(-2, second), arb(0.5, first), arb(3, second)
        tube = build(artificial({X: 1, Z: -a, (0, 0, 2): -b}, {Y: 1, Z: -c, (0, 0, 2): -d}), 2, True)
        assert tube is not None
        r = tube.reach
        for s, t, x, radius in zip((a, c), (b, d), tube.path, tube.radii, strict=True):
            for corner in (r * (s.lower() + r * t.lower()), r * (s.upper() + r * t.upper())):
                assert abs(corner - x(r)) < radius

    def test_a_tube_holds_the_box_that_it_starts_from(self) -> None:
        """y (y − w) = 0: from a box on the branch y = w no tube follows y = 0."""
        w = Fraction(1, 100)
        for radius in (1e-50, 1e-3):
            box = arb(0, radius), arb(ball_of(w).mid(), radius), arb(0, radius)
            tube = build(artificial({X: 1}, {Y: -w, (0, 2, 0): 1}, box), ALONG_L, True)
            assert tube is None or tube.radii[1] > ball_of(w)


class TestBetweenTwoLengths:
    """Along x, with the length (1 + z)/(1 − z) where z = s x + b x²."""

    @staticmethod
    def along(s: Fraction | int, b: int, forwards: bool, low: float | arb, high: float) -> Tube | None:
        around = artificial({Y: 1}, {Z: 1, X: -s, (2, 0, 0): -b})
        return build(around, 0, forwards, between=(arb(low), arb(high)))

    def test_it_ends_before_the_next_slice(self) -> None:
        for forwards, low, high in ((True, 0.5, 1.01), (False, 0.99, 1.5)):
            tube = self.along(1, 0, forwards, low, high)
            assert tube is not None
            assert 0.0048 < tube.reach < 0.0051

    def test_a_turn_between_start_and_end_counts(self) -> None:
        """z = x/8 − x² is 0 at both ends and 1/256 between."""
        over = self.along(Fraction(1, 8), -1, True, 0.9, 1 + 1 / 500)
        assert over is not None
        assert over.reach < 0.02
        under = self.along(Fraction(1, 8), -1, True, 0.9, 1 + 1 / 90)
        assert under is not None
        assert under.reach > 0.1

    def test_a_turn_that_is_tiny_is_passed(self) -> None:
        """z = −w x + x² is nowhere below −w²/4: from just above a slice, a long tube leads down and up."""
        w = Fraction(1, 10**12)
        tube = self.along(-w, 1, True, 1 - arb(10) ** -23, 1.5)
        assert tube is not None
        assert tube.reach > 0.005
