"""Tubes: the equations about an origin are those of the surface, and only proved tubes pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import product
from math import prod

import pytest

from rpr_solver import EXAMPLES
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, value
from rpr_solver.verify.core.system import Surface
from rpr_solver.verify.tubes import DEGREE, Forms, Index, Local, Pose, Tube
from tests.support.chains import PAST, surface, tubes
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
        assert tube.holds(middle)
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

    def holds(x: Fraction, y: Fraction, z: Fraction) -> bool | None:
        return tube.holds([Interval.of(w, BITS) for w in (x, y, z)])

    r = tube.reach * Fraction(99, 100)
    p, q = (r * (s + r * b) for s, b in zip(tube.slopes, tube.bends, strict=True))
    near, far = tube.radii[0] * Fraction(99, 100), tube.radii[0] * Fraction(101, 100)
    assert holds(p, q, r)
    assert holds(p + near, q, r)
    assert holds(p + tube.radii[0], q, r) is None
    assert holds(p + far, q, r) is False
    assert holds(p, q, tube.reach * Fraction(101, 100)) is False


def test_bounds_of_slopes_hold_on_the_whole_tube() -> None:
    forms = Forms(surface())
    local = Local(forms, tubes(PAST)[0])
    half = 1 << (local.bits - 4)
    bounds = [local._steepness(n, local._powers(half, half, half)) for n in (0, 1)]
    for n, k in product((0, 1), (0, 1)):
        for x, y, z in product((-half, 0, half), repeat=3):
            point = [Fraction(w, 1 << local.bits) for w in (x, y, z)]
            linear = n == k
            assert abs(_slope(local.forms[n], point, k) - linear * 2**local.bits) <= bounds[n][k]


def _slope(form: Mapping[Index, int], point: list[Fraction], axis: int) -> Fraction:
    total = Fraction(0)
    for key, c in form.items():
        if key[axis]:
            powers = [n - (k == axis) for k, n in enumerate(key)]
            total += c * key[axis] * prod(x**n for x, n in zip(point, powers, strict=True))
    return total


def test_a_tube_with_dependent_gradients_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing = [[[0] * (DEGREE + 1)] * (DEGREE + 1)] * 3
    monkeypatch.setattr(Forms, "about", lambda *_: [(nothing, 0), (nothing, 0)])
    with pytest.raises(ArithmeticError):
        Local(Forms(surface()), tubes(PAST)[0])
