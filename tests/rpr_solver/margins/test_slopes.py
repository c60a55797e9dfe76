"""The arithmetic of boxes: what it bounds holds at every point, against balls."""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES
from rpr_solver.contract import LENGTHS
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.exact.turns import TURN, cos_sin
from rpr_solver.margins.problems import BoxRing, Problem, Span
from rpr_solver.margins.slopes import UNIT
from rpr_solver.margins.systems import Systems, moving_legs, orientation_of

if TYPE_CHECKING:
    from rpr_solver.margins.slopes import Doubles

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
    legs = moving_legs(balls[1:], box.orientation, box.fixed_leg)
    return functions(Systems(numbers, (balls[0], 1), legs))


def boxes_of_examples(rng: random.Random) -> Iterator[tuple[Problem, Doubles, Doubles]]:
    """Problems of three examples, each with the lower and upper ends of some boxes, wide and narrow ones."""
    for name, leg, length, radius, drift in (
        ("innocenti", 1, "17", "0.3", False),
        ("sixteen-cusps", 2, "14", "0.01", True),
        ("twelve-cusps", 3, "8.3", "0.2", True),
    ):
        box = problem(name, leg, length, radius, drift=drift)
        low, high = (x[:, ::37].copy() for x in box.grid(32))
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


def test_slopes_hold_at_random_points_of_random_boxes() -> None:
    rng = random.Random(1)
    for box, low, high in boxes_of_examples(rng):
        ring = BoxRing(box, low, high)
        with np.errstate(all="ignore"):
            computed = functions(box.systems(ring, 2))
            bounds = [function.expanded(ring.half) for function in computed]
        for column in range(low.shape[1]):
            _, values = random_point(rng, box, low[:, column], high[:, column])
            for function, (first, second, error), value in zip(computed, bounds, values, strict=True):
                middle = function.middle[0, column]
                if np.isnan(middle):
                    continue
                bound = abs(first[:, column]).sum() + second[:, column].sum() / 2 + error[column]
                assert abs(value - float(middle)) < bound
                assert abs(value - float(middle)) <= function.radius[0, column] + function.error.value
                assert error[column] < 1e-9


def test_slopes_at_the_middle_are_derivatives() -> None:
    box = problem("innocenti", 1, "17", "0.3")
    low, high = (x[:, 5:6] for x in box.grid(32))
    ring = BoxRing(box, low, high)
    computed = functions(box.systems(ring, 2))
    middle = [Fraction(x) for x in ring.middle[:, 0]]
    step = Fraction(1, 10**12)
    for variable in range(box.size):
        unit = Fraction(TURN) / Fraction(str(2 * np.pi)) if variable < 2 else 1
        with ctx.workprec(300):
            below, above = (
                exact(box, [x + side * step * unit * (k == variable) for k, x in enumerate(middle)])
                for side in (-1, 1)
            )
            rates = [float((y - x) / 2 / arb(1) * 10**12) for x, y in zip(below, above, strict=True)]
        slopes = [float(function.middle[1 + variable, 0]) for function in computed]
        assert np.allclose(rates, slopes, rtol=1e-8, atol=1e-9)


def test_angles_have_their_cosines_and_sines() -> None:
    rng = random.Random(2)
    angles = [0, 1, TURN - 1, TURN // 4, TURN // 2, *(rng.randrange(-TURN, TURN) for _ in range(2000))]
    cos, sin = cos_sin(np.array(angles))
    with ctx.workprec(120):
        for angle, x, y in zip(angles, cos, sin, strict=True):
            turn = arb(2 * angle) / TURN
            assert abs(turn.cos_pi() - float(x)) < 16 * UNIT
            assert abs(turn.sin_pi() - float(y)) < 16 * UNIT
