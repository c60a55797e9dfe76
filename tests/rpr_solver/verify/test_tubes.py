"""Tubes: the equations about an origin are those of the surface, and only proved tubes pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.verify.chains import chain_of
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, value
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.tubes import DEGREE, LENGTH, Expansion, Forms, Index, P, Pose, Q, Tube
from rpr_solver.verify.turns import Local, turns
from tests.support.chains import PAST, poses, surface, tubes
from tests.support.strategies import examples
from tests.support.verified import geometry_of

BITS = 300
_SIZES = Fraction(1), (Fraction(1), Fraction(1))


@pytest.mark.parametrize(("name", "fixed"), [("innocenti", 1), ("zein-flat", 3)])
def test_the_forms_are_those_of_the_surface(name: str, fixed: int) -> None:
    one = Surface(geometry_of(EXAMPLES[name]), fixed)
    leg = one.legs[1]
    origin = Tube(
        0, leg.number, ((-3, 5), (7, 2)), Fraction(27), (Fraction(0),) * 2, (Fraction(0),) * 2, *_SIZES
    )
    forms = Forms(one).about(origin, BITS)
    ratios: list[list[Fraction]] = [[], []]
    for alpha, theta, length in ((Fraction(1, 3), Fraction(-2), 25), (Fraction(2), Fraction(1, 7), 31)):
        pose = Pose(*(Interval.of(x, BITS) for x in (alpha, theta, length)))
        x, y, z = (w.middle for w in pose.about(origin))
        here = Directions.of(pose.alpha, pose.theta, one.ring.radicand)
        for n, p in enumerate((one.singular, leg.kernel)):
            layers, _ = forms[n]
            mine = sum(
                layer[i][k] * x**i * y**k * z**power
                for power, layer in enumerate(layers)
                for i in range(DEGREE + 1)
                for k in range(DEGREE + 1)
            )
            norm = ((1 + x * x) * (1 + y * y)) ** 3
            ratios[n].append(mine / norm / value(here, p, pose.length).middle)
    for first, second in ratios:
        assert abs(first / second - 1) < Fraction(1, 10**30)


def test_only_proved_tubes_pass() -> None:
    forms = Forms(surface())
    for tube in tubes(PAST)[::3]:
        local = Local(forms, tube)
        assert local.passes()
        middle = local.middle()
        assert middle is not None
        assert tube.contains(middle)
        p, q = tube.radii
        for wrong in (
            replace(tube, radii=(p / 50, q / 50)),
            replace(tube, slopes=(tube.slopes[0] + Fraction(1, 3), tube.slopes[1])),
            replace(tube, reach=100 * tube.reach),
            replace(tube, length=tube.length * Fraction(11, 10)),
        ):
            assert not Local(forms, wrong).passes()


def test_what_lies_in_a_tube() -> None:
    [tube, *_] = tubes(0)

    def holds(x: Fraction, y: Fraction, z: Fraction) -> bool:
        return tube.contains([Interval.of(w, BITS) for w in (x, y, z)])

    r = tube.reach
    p, q = (r * (s + r * b) for s, b in zip(tube.slopes, tube.bends, strict=True))
    near, far = tube.radii[0] * Fraction(99, 100), tube.radii[0] * Fraction(101, 100)
    assert holds(p, q, r)
    assert holds(p + near, q, r)
    assert not holds(p + far, q, r)
    assert not holds(p, q, r * Fraction(101, 100))


BITS_EXPANSIONS = 120
UNIT = 1 << BITS_EXPANSIONS
POINTS = st.tuples(*[st.integers(-UNIT, UNIT)] * 3)
KEYS: list[Index] = [
    (0, 0, 0),
    P,
    Q,
    (0, 0, 1),
    (2, 0, 0),
    (1, 1, 0),
    (0, 1, 1),
    (0, 0, 2),
    (3, 0, 2),
    (0, 2, 6),
]
FORMS = st.lists(st.integers(-9, 9), min_size=len(KEYS), max_size=len(KEYS))


def whole(values: list[int], linear: Index) -> dict[Index, int]:
    form = {(i, j, k): 0 for i in range(7) for j in range(7) for k in range(7) if i + j + k < 9}
    return form | dict(zip(KEYS, values, strict=True)) | {linear: 50}


def value_of_form(form: Mapping[Index, int], point: list[Fraction]) -> Fraction:
    total = Fraction(0)
    for key, c in form.items():
        term = Fraction(c)
        for x, n in zip(point, key, strict=True):
            term *= x**n
        total += term
    return total


@given(FORMS, FORMS, POINTS, POINTS, st.none() | st.tuples(*[st.integers(-UNIT, UNIT)] * 2))
@examples(20)
def test_about_another_point_or_a_line_it_is_a_constant_matrix_times_the_same(
    first: list[int],
    second: list[int],
    middle: tuple[int, int, int],
    away: tuple[int, int, int],
    line: tuple[int, int] | None,
) -> None:
    forms = whole(first, P), whole(second, Q)
    expansion = Expansion.of(*forms, (0, 0), BITS_EXPANSIONS)
    assert expansion is not None
    shifted = expansion.about(middle, line or ())
    if shifted is None:
        return
    step = [Fraction(x, UNIT) / 8 for x in away]
    moved = [d + Fraction(s, UNIT) * step[2] for d, s in zip(step, (*(line or (0, 0)), 0), strict=True)]
    there = [Fraction(x, UNIT) + d for x, d in zip(middle, moved, strict=True)]
    values = [value_of_form(form, there) for form in forms]
    mine = [value_of_form(form, step) / UNIT for form in shifted.forms]
    # by the derivatives at the point, which the matrix makes 1
    slopes = [[_slope(form, middle, k) for k in (0, 1)] for form in forms]
    for n in (0, 1):
        total = sum(slopes[n][k] * mine[k] for k in (0, 1))
        off = 400 * sum(map(abs, slopes[n])) * Fraction(shifted.error, UNIT)
        assert abs(total - values[n]) <= off
    assert shifted.error < 1 << 100


def _slope(form: Mapping[Index, int], middle: tuple[int, int, int], axis: int) -> Fraction:
    point = [Fraction(x, UNIT) for x in middle]
    derived: dict[Index, int] = {}
    for key, c in form.items():
        if key[axis]:
            row = list(key)
            row[axis] -= 1
            derived[row[0], row[1], row[2]] = c * key[axis]
    return value_of_form(derived, point)


def test_bounds_of_derivatives_and_dependent_gradients() -> None:
    form = whole([1] * len(KEYS), P)
    expansion = Expansion.of(form, whole([0] * len(KEYS), Q), (0, 0), BITS_EXPANSIONS)
    assert expansion is not None
    half = UNIT // 2
    bound = expansion.derivative(expansion.sizes[1], expansion.powers(half, half, half), (0, 0, 2))
    assert 0 <= bound <= 1000 * expansion.error
    assert Expansion.of(form, form, (0, 0), BITS_EXPANSIONS) is None
    assert expansion.about([2 * UNIT, 0, 0]) is None


def test_a_turn_is_found_once_however_the_arc_is_cut() -> None:
    forms, chain = Forms(surface()), tubes(PAST)
    found = chain_of(
        surface(), forms, chain, (poses()["C1", Fraction(1)], poses()["C2", Fraction(1)]), lambda *_: False
    )
    assert found.turning
    [k] = found.turning
    assert chain[k].parameter != LENGTH
    local = Local(forms, chain[k])
    ends = [chain[k].reach * n / 4 for n in range(-4, 5)]
    for parts in (ends, ends[::-1], ends[::8]):
        found_in = [
            turns(local, Interval.of(low, local.bits), Interval.of(high, local.bits))
            for low, high in pairwise(parts)
        ]
        assert sorted(map(str, found_in)) == ["0"] * (len(parts) - 2) + ["1"]


def test_a_turn_in_a_tube_that_is_far_narrower_in_one_coordinate_is_found() -> None:
    one = Surface(geometry_of(Manipulator(-4, 4, -1, 3, 1, 3, orientation="cw")), 3)
    tube = Tube(
        1,
        2,
        ((-176459, 99999844), (-37566131, 32996754)),
        Fraction("166168924e-12") * one.unit,
        (Fraction("0.000153"), Fraction("0.6917928")),
        (Fraction("-0.000052"), Fraction("6.323114")),
        Fraction("0.125"),
        (Fraction("255e-8"), Fraction("0.0404")),
    )
    local = Local(Forms(one), tube)
    assert local.passes()
    assert turns(local, Interval.of(0, local.bits), Interval.of(Fraction(-1, 9), local.bits)) == 1


def test_where_the_length_is_the_parameter_it_never_turns() -> None:
    [tube, *_] = tubes(0)
    local = Local(Forms(surface()), tube)
    assert tube.parameter == LENGTH
    assert turns(local, Interval.of(0, local.bits), Interval.of(tube.reach, local.bits)) == 0
