"""Expansions in integers hold the polynomials that they stand for, about any point, with all their bounds."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.verify.expansions import Expansion, Index, P, Q
from tests.support.strategies import examples

BITS = 120
UNIT = 1 << BITS
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


def value(form: Mapping[Index, int], point: list[Fraction]) -> Fraction:
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
    expansion = Expansion.of(*forms, (0, 0), BITS)
    assert expansion is not None
    shifted = expansion.about(middle, line or ())
    if shifted is None:
        return
    step = [Fraction(x, UNIT) / 8 for x in away]
    moved = [d + Fraction(s, UNIT) * step[2] for d, s in zip(step, (*(line or (0, 0)), 0), strict=True)]
    there = [Fraction(x, UNIT) + d for x, d in zip(middle, moved, strict=True)]
    values = [value(form, there) for form in forms]
    mine = [value(form, step) / UNIT for form in shifted.forms]
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
    return value(derived, point)


def test_bounds_of_derivatives_and_dependent_gradients() -> None:
    form = whole([1] * len(KEYS), P)
    expansion = Expansion.of(form, whole([0] * len(KEYS), Q), (0, 0), BITS)
    assert expansion is not None
    half = UNIT // 2
    bound = expansion.derivative(expansion.sizes[1], expansion.powers(half, half, half), (0, 0, 2))
    assert 0 <= bound <= 1000 * expansion.error
    assert Expansion.of(form, form, (0, 0), BITS) is None
    assert expansion.about([2 * UNIT, 0, 0]) is None
