"""The sieve removes no box with a zero, and narrows none beside one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.boxes import Balls, Boxes, Functions, Jet, monomials, search, sieved
from rpr_solver.boxes.sieve import Expansion

NUMBERS = st.floats(-2, 2)
SHARES = st.floats(0, 1)


class Conics:
    """Quadratic functions of some variables that are 0 at a given point, and waves of them: sin of each."""

    def __init__(
        self, zero: Sequence[float], coefficients: Sequence[Sequence[float]], *, waves: bool
    ) -> None:
        self.zero, self.coefficients, self.waves = zero, coefficients, waves

    @property
    def stages(self) -> Sequence[Functions]:
        return (self._functions,)

    def square(self, _box: object) -> Functions:
        return lambda box, order: self._functions(box, order)[: len(self.zero)]

    def _functions(self, box: Sequence[Any], order: int) -> Sequence[Jet[Any]]:
        n = len(self.zero)
        steps = [self._variable(box, k, order) for k in range(n)]
        found = []
        for row in self.coefficients:
            total = steps[0] * self._like(box, 0.0)
            for k, c in enumerate(row[:n]):
                total = total + steps[k] * self._like(box, c)
            for k, c in enumerate(row[n:]):
                total = total + steps[k] * steps[(k + 1) % n] * self._like(box, c)
            found.append(total)
        return found

    def _like(self, box: Sequence[Any], number: float) -> Any:
        if isinstance(box[0], Balls):
            return Balls.exact(np.full_like(box[0].mid, number))
        return arb(number)

    def _variable(self, box: Sequence[Any], k: int, order: int) -> Jet[Any]:
        """xₖ less that of the zero, or the sine of it."""
        n = len(box)
        step = box[k] - self._like(box, self.zero[k])
        zero = step * self._like(box, 0.0)
        if self.waves:
            sin, cos = step.sin_cos()
            powers = [sin, cos, sin * self._like(box, -0.5), cos * self._like(box, -1 / 6)]
        else:
            powers = [step, self._like(box, 1.0), zero, zero]
        terms = [powers[m[k]] if sum(m) == m[k] and m[k] < 4 else zero for m in monomials(n, order)]
        return Jet(n, order, terms)


@st.composite
def systems(draw: st.DrawFn) -> Conics:
    n, waves = draw(st.integers(1, 3)), draw(st.booleans())
    zero = draw(st.lists(NUMBERS, min_size=n, max_size=n))
    rows = draw(st.lists(st.lists(NUMBERS, min_size=2 * n, max_size=2 * n), min_size=n, max_size=n + 2))
    return Conics(zero, rows, waves=waves)


def boxes_about(point: Sequence[float], widths: Sequence[float], shares: Sequence[float]) -> Boxes:
    """A box that holds a point, at any place of it, at a corner too."""
    low = np.array([[x - w * s] for x, w, s in zip(point, widths, shares, strict=True)])
    high = np.array([[x + w * (1 - s)] for x, w, s in zip(point, widths, shares, strict=True)])
    return Boxes(np.minimum(low, np.array(point)[:, None]), np.maximum(high, np.array(point)[:, None]))


def holds(boxes: Boxes, point: Sequence[float]) -> bool:
    x = np.array(point)[:, None]
    return bool(((boxes.low <= x) & (x <= boxes.high)).all(0).any())


@given(system=systems(), data=st.data())
def test_a_box_with_a_known_zero_is_never_removed(system: Conics, data: st.DataObject) -> None:
    n = len(system.zero)
    widths = data.draw(st.lists(st.floats(1e-12, 3), min_size=n, max_size=n))
    shares = data.draw(st.lists(SHARES, min_size=n, max_size=n))
    start = boxes_about(system.zero, widths, shares)
    expansion = Expansion.of(system.stages[-1], start)
    assert not expansion.excluded.any()
    for own in (expansion, expansion.combined()):
        parts, some = own.narrowed()
        assert some.all()
        assert holds(parts, system.zero)
    left = sieved(system, start, 2.0**-20, 2000)
    assert holds(left.boxes, system.zero)


@given(system=systems(), data=st.data())
def test_expansions_hold_all_values(system: Conics, data: st.DataObject) -> None:
    n = len(system.zero)
    numbers = st.lists(NUMBERS, min_size=n, max_size=n)
    start = boxes_about(
        data.draw(numbers), data.draw(st.lists(st.floats(0, 3), min_size=n, max_size=n)), [0.5] * n
    )
    shares = data.draw(st.lists(SHARES, min_size=n, max_size=n))
    expansion = Expansion.of(system.stages[-1], start).combined()
    expansion = Expansion(
        start, expansion.values[: len(system.coefficients)], expansion.slopes[: len(system.coefficients)]
    )
    middle = start.middle[:, 0].tolist()
    point = [
        float(np.clip(a + (b - a) * s, a, b))
        for a, b, s in zip(start.low[:, 0], start.high[:, 0], shares, strict=True)
    ]
    exact = [f.value for f in system.stages[-1]([arb(x) for x in point], 0)]
    at_middle = [f.value for f in system.stages[-1]([arb(x) for x in middle], 0)]
    for i, value in enumerate(exact):
        mid, rad = float(expansion.values.mid[i, 0]), float(expansion.values.rad[i, 0])
        assert arb(mid, rad).overlaps(at_middle[i])
        total = arb(mid, rad)
        for k in range(n):
            slope = arb(float(expansion.slopes.mid[i, k, 0]), float(expansion.slopes.rad[i, k, 0]))
            total += slope * (arb(point[k]) - arb(middle[k]))
        assert total.overlaps(value)


def test_what_is_left_at_the_end_of_the_work_are_all_boxes() -> None:
    system = Conics([0.0, 0.0], [[1.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]], waves=False)
    start = Boxes(np.array([[-1.0], [-1.0]]), np.array([[1.0], [1.0]]))
    left = sieved(system, start, 2.0**-30, 500)
    assert not left.ended
    for x in np.linspace(-1, 1, 101).tolist():
        assert holds(left.boxes, [x, -x])


@given(system=systems())
def test_a_search_finds_the_known_zero_or_doubts_it(system: Conics) -> None:
    n = len(system.zero)
    start = [arb(x + 0.1, 0.3) for x in system.zero]
    found = search(system, [start], 2.0**-20, 300)
    point = [arb(x) for x in system.zero]
    places = [*(zero.at for zero in found.zeros), *found.doubts]
    assert any(all(x.contains(y) for x, y in zip(box, point, strict=True)) for box in places), n


def line(low: float, high: float, narrow: float) -> int:
    """How many boxes are left of an interval about the zero of x."""
    system = Conics([0.0], [[1.0, 0.0]], waves=False)
    return len(sieved(system, Boxes(np.array([[low]]), np.array([[high]])), narrow, 1000).boxes)


@pytest.mark.parametrize("ends", [(-np.inf, np.inf), (-1.0, np.inf), (np.nan, 1.0)])
def test_boxes_without_finite_ends_are_refused(ends: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="finite"):
        line(*ends, 0.1)


@pytest.mark.parametrize("narrow", [np.nan, 0.0, np.inf])
def test_no_size_loses_a_zero(narrow: float) -> None:
    assert line(-1.0, 2.0, narrow)


def test_a_ball_of_all_numbers_becomes_a_box_of_all_numbers() -> None:
    boxes = Boxes.of([[arb("nan")], [arb(0, arb(2) ** 2000)], [arb(1)]])
    assert boxes.low[0, :2].tolist() == [-np.inf, -np.inf]
    assert boxes.high[0, :2].tolist() == [np.inf, np.inf]
