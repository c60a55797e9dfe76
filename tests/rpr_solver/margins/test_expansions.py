"""Expansions of second order on boxes: what they bound holds at every point, against balls."""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES
from rpr_solver.boxes.sieve import Boxes
from rpr_solver.contract import LENGTHS
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.turns import TURN, cos_sin
from rpr_solver.margins.expansions import UNIT, Expansion, Layout, lowest
from rpr_solver.margins.problems import BoxRing, Problem, Span
from rpr_solver.margins.systems import Systems, moving_legs, orientation_of, third_corner

if TYPE_CHECKING:
    from rpr_solver.margins.expansions import Doubles

pytestmark = pytest.mark.quick


def problem(name: str, leg: int, length: str, radius: str, *, drift: bool = False) -> Problem:
    """A box round an example, with a range of lengths."""
    manipulator, r = EXAMPLES[name], Fraction(radius)
    lengths = [getattr(manipulator, g) / 64 for g in LENGTHS]
    spans = tuple(Span.of(x - r / 64, x + r / 64) for x in lengths)
    fixed = Fraction(length) / 64
    rates = (0.5, -0.25, 0.0, 1.0, 0.125, 0.0) if drift else (0.0,) * 6
    return Problem(leg, orientation_of(manipulator), spans, Span.of(fixed, fixed + r / 64), drift=rates)


def functions(systems: Systems) -> list[object]:
    """All that is tested."""
    k = systems.singularity
    found = [k.value, k.alpha.value, k.theta.value]
    for leg in (0, 1):
        e = systems.along(leg, k)
        found += [e.value, systems.along(leg, e).value, *systems.tangent(leg)]
    return found


def exact(box: Problem, point: list[Fraction]) -> list[arb]:
    """The functions at one point, as balls; angles are in units of a turn."""
    alpha, theta, fixed, *lengths = point
    middles = [Fraction(span.middle) for span in box.lengths]
    for rate, x, middle in zip(box.drift, lengths, middles, strict=True):
        fixed += Fraction(rate) * (x - middle)
    balls = [arb(x.numerator) / x.denominator for x in (fixed, *lengths)]
    turns = [arb(x.numerator) / x.denominator * 2 / TURN for x in (alpha, theta, alpha - theta)]
    numbers = [PlaneNumber(x.cos_pi(), x.sin_pi()) for x in turns]
    legs = moving_legs(balls[1:], third_corner(balls[4:], box.orientation), box.fixed_leg)
    return functions(Systems(numbers, (balls[0], 1), legs))


def boxes_of_examples(rng: random.Random) -> Iterator[tuple[Problem, Doubles, Doubles]]:
    """Problems of three examples, each with the lower and upper ends of some boxes, wide and narrow ones."""
    for name, leg, length, radius, drift in (
        ("innocenti", 1, "17", "0.3", False),
        ("sixteen-cusps", 2, "14", "0.01", True),
        ("twelve-cusps", 3, "8.3", "0.2", True),
    ):
        box = problem(name, leg, length, radius, drift=drift)
        grid = box.grid(32)[::37]
        low, high = grid.low.copy(), grid.high.copy()
        for row in range(box.size):  # some boxes are narrow
            part = rng.choice((1, 2, 64))
            high[row] = low[row] + (high[row] - low[row]) / part
        yield box, low, high


def random_point(
    rng: random.Random, box: Problem, low: Doubles, high: Doubles
) -> tuple[list[float], list[arb]]:
    """A place in a box, by its share of each side, often at an end, and the exact functions there."""
    shares = [rng.choice((0, 1, rng.random())) for _ in range(box.size)]
    ends = [(Fraction(a), Fraction(b)) for a, b in zip(low, high, strict=True)]
    with ctx.workprec(160):
        return shares, exact(box, [a + Fraction(t) * (b - a) for t, (a, b) in zip(shares, ends, strict=True)])


def test_expansions_hold_at_random_points_of_random_boxes() -> None:
    rng = random.Random(1)
    for box, low, high in boxes_of_examples(rng):
        ring = BoxRing(box, Boxes(low, high))
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


def test_angles_have_their_cosines_and_sines() -> None:
    rng = random.Random(2)
    angles = [0, 1, TURN - 1, TURN // 4, TURN // 2, *(rng.randrange(-TURN, TURN) for _ in range(2000))]
    cos, sin = cos_sin(np.array(angles))
    with ctx.workprec(120):
        for angle, x, y in zip(angles, cos, sin, strict=True):
            turn = arb(2 * angle) / TURN
            assert abs(turn.cos_pi() - float(x)) < 16 * UNIT
            assert abs(turn.sin_pi() - float(y)) < 16 * UNIT
