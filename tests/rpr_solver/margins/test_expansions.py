"""Expansions of second order on boxes: what they bound holds at every point, against balls."""

import random

import numpy as np
import pytest

from rpr_solver.margins.expansions import Expansion, Layout, lowest
from rpr_solver.margins.problems import ExpansionRing
from tests.rpr_solver.margins.test_slopes import boxes_of_examples, functions, random_point

pytestmark = pytest.mark.quick


def test_expansions_hold_at_random_points_of_random_boxes() -> None:
    rng = random.Random(1)
    for box, low, high in boxes_of_examples(rng):
        ring = ExpansionRing(box, low, high)
        with np.errstate(all="ignore"):
            computed = functions(box.systems(ring, 2))
            least = [lowest(function) for function in computed]
        for column in range(low.shape[1]):
            shares, values = random_point(rng, box, low[:, column], high[:, column])
            for function, least_value, value in zip(computed, least, values, strict=True):
                if not np.isnan(function.rest[column]):
                    middle, polynomial, loss = at_point(function, column, [2 * t - 1 for t in shares])
                    assert abs(value - polynomial) <= loss
                    assert abs(value - middle) <= function.change[column]
                    assert abs(value) <= function.size[column]
                    assert (value if middle >= 0 else -value) > least_value[column]


def at_point(function: Expansion, column: int, place: list[float]) -> tuple[float, float, float]:
    """The value at the middle, the polynomial at a place in the box, and how far the function may be off."""
    terms, at = function.terms[:, column], function.layout
    t = np.array(place)
    j, k = at.pairs
    bent = terms[at.bends] @ (t[j] * t[k])
    loss = abs(terms[at.symbols]).sum() + function.rest[column]
    return terms[0], terms[0] + terms[at.slopes] @ t + bent, loss + 1e-14


@pytest.mark.parametrize("symbol", [0, 1])
def test_symbols_stand_for_the_same_number_in_all_functions(symbol: int) -> None:
    """A rest that is named cancels in a difference, and one that is not does not."""
    layout = Layout(2)
    terms = np.zeros((layout.rows, 1))
    terms[0] = 3
    function = Expansion(terms, np.array([0.25]), layout)
    named = function.named(symbol)
    assert (named - named).size < 1e-12 < 0.49 < (function - function).size
    assert named.size == pytest.approx(function.size)
    product = named * named
    # (3 + η/4)² is at most 3.25² and at least 2.75²
    assert product.size >= 3.25**2
    assert 9 - product.change <= 2.75**2
    assert 0 < lowest(function) <= 2.75


def test_the_least_value_of_a_polynomial_is_bounded_and_often_attained() -> None:
    rng = np.random.default_rng(5)
    layout, boxes = Layout(3), 400
    terms = rng.uniform(-1, 1, (layout.rows, boxes))
    terms[0] += np.sign(terms[0])
    terms[layout.symbols] = 0
    terms[layout.bends] *= 0.2
    function = Expansion(terms, np.zeros(boxes), layout)
    least, ends = lowest(function), np.linspace(-1, 1, 9)
    points = np.array(np.meshgrid(ends, ends, ends)).reshape(3, -1)
    j, k = layout.pairs
    values = terms[0] + points.T @ terms[layout.slopes] + (points[j] * points[k]).T @ terms[layout.bends]
    attained = (values * np.sign(terms[0])).min(axis=0)
    assert (least <= attained + 1e-12).all()
    assert np.isclose(least, attained).mean() > 0.2
    crude = abs(terms[0]) - abs(terms[1:]).sum(axis=0)
    assert (least >= crude - 1e-12).all()


def test_many_boxes_are_multiplied_as_few_are() -> None:
    box, low, high = next(boxes_of_examples(random.Random(3)))
    many, few = (
        box.systems(ExpansionRing(box, np.tile(low, (1, n)), np.tile(high, (1, n))), 0).singularity.value
        for n in (20, 1)
    )
    columns = low.shape[1]
    assert columns < 256 < 20 * columns
    assert (many.terms[:, -columns:] == few.terms).all()
    assert (many.rest[-columns:] == few.rest).all()
