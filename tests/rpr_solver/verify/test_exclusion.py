"""Proofs of margins: functions on boxes hold all their values, and cuts prove what they should."""

import math
import random
import re
from dataclasses import replace
from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.margins import LENGTHS
from rpr_solver.margins.slope_search import cuts
from rpr_solver.margins.subjects import SliceCount
from rpr_solver.verify.core.intervals import Expansion, Terms, TooWideError, constant, have_no_common_zero
from rpr_solver.verify.degeneracy import Bound, good_factors
from rpr_solver.verify.exclusion import Region, _Parts, flaw
from tests.support.verified import geometry_of

BITS = 60
UNIT = 1 << BITS
INNOCENTI = EXAMPLES["innocenti"]


def variable(row: int, middle: float, half: float) -> Expansion:
    """One of two variables, on a box."""
    rows, changes = [int(middle * UNIT), 0, 0], [int(half * UNIT), 0, 0]
    rows[row] = UNIT
    return Expansion(BITS, rows, changes, 0)


def test_functions_hold_their_values_and_slopes() -> None:
    """Against floats, at random points of boxes and between these and the middle."""
    draw = random.Random(1)
    for _ in range(60):
        (x, y), half = (
            [draw.uniform(1, 3), draw.uniform(1, 3)],
            [draw.choice([0.3, 1e-3]) * draw.random() for _ in range(2)],
        )
        halves = [int(h * UNIT) for h in half]
        a, b = (variable(k + 1, m, h) for k, m, h in zip(range(2), (x, y), half, strict=True))
        found = [
            (a * b - b, lambda p, q: (p * q - q, q, p - 1)),
            (a.root() * b, lambda p, q: (p**0.5 * q, q / p**0.5 / 2, p**0.5)),
            ((a + b).inverse(), lambda p, q: (1 / (p + q), -1 / (p + q) ** 2, -1 / (p + q) ** 2)),
            ((a.doubled() * b).halved().tightened(halves), lambda p, q: (p * q, q, p)),
        ]  # fmt: skip
        for function, exact in found:
            for _ in range(5):
                share = draw.choice([0.01, 0.5, 1])
                point = [m + share * h * draw.uniform(-1, 1) for m, h in zip((x, y), half, strict=True)]
                for row, value in enumerate(exact(*point)):  # type: ignore[no-untyped-call]
                    change = share * function.radius[row] + function.error
                    assert abs(value - function.middle[row] / UNIT) <= change / UNIT + 1e-13
            terms = Terms.of(function, halves)
            reach = (sum(map(abs, terms.change)) + terms.rest) / UNIT**2
            assert abs(exact(*point)[0] - terms.value / UNIT**2) <= reach + 1e-13  # type: ignore[no-untyped-call]


def test_nothing_is_divided_by_what_may_be_0() -> None:
    wide = variable(1, 0.1, 0.2)
    for method in (wide.inverse, wide.root):
        with pytest.raises(TooWideError):
            method()


def test_functions_with_a_common_zero_are_never_told_apart() -> None:
    """x and y at a box round 0, by any factors; and beside it they are."""
    draw = random.Random(2)
    half = [UNIT // 8, UNIT // 8]
    for centre, apart in ((0.05, False), (0.3, True)):
        a, b = variable(1, centre, 0.125), variable(2, -centre / 3, 0.125)
        terms = [Terms.of(x, half) for x in (a + a * b, b + a * a)]
        factors = [*good_factors(terms), *([draw.randint(-99, 99) for _ in range(2)] for _ in range(50))]
        assert any(have_no_common_zero(terms, f) for f in factors) is apart
    assert Terms.of(constant(Fraction(1), BITS, 2), half).excludes_zero


def region(manipulator: Manipulator, length: Fraction, radius: Fraction) -> Region:
    """All geometries within a radius, and one slice."""
    middle = [getattr(manipulator, g) / 64 for g in LENGTHS]
    spans = tuple((x - radius / 64, x + radius / 64) for x in middle)
    return Region(1, 1, spans, (length / 64, length / 64))


def test_the_functions_are_those_of_the_legs() -> None:
    """K and E against differences of the squared lengths, at the middles of parts."""
    length = Fraction(27)
    parts = _Parts(region(INNOCENTI, length, Fraction(1, 10**9)))
    points = geometry_of(INNOCENTI)
    foot, height = float(points.foot), math.sqrt(points.height_squared)
    base, along = points.base, ((0.0, 0.0), (float(points.d1), 0.0), (foot, height))
    draw = random.Random(3)
    for _ in range(5):
        numbers = [draw.randrange(1 << 40) for _ in range(2)]
        places = tuple((40, n) for n in numbers) + parts.whole[2:]
        part = parts._part(places)
        _, k = part._up_to(1)
        angles = [math.tau * (n + 0.5) / 2**40 for n in numbers]

        def squares(alpha: float, theta: float) -> list[float]:
            x, y = float(length) * math.cos(theta), float(length) * math.sin(theta)
            turned = [
                (math.cos(alpha) * m - math.sin(alpha) * n, math.sin(alpha) * m + math.cos(alpha) * n)
                for m, n in along
            ]
            return [
                (x + m - float(p)) ** 2 + (y + n - float(q)) ** 2
                for (m, n), (p, q) in zip(turned[1:], base[1:], strict=True)
            ]

        (alpha, theta), h = angles, 1e-5
        ends = [(alpha + h, theta), (alpha - h, theta), (alpha, theta + h), (alpha, theta - h)]
        first, second, third, fourth = (squares(*end) for end in ends)
        f, g = ((a - b) / (2 * h) for a, b in zip(first, second, strict=True))
        p, q = ((a - b) / (2 * h) for a, b in zip(third, fourth, strict=True))
        scale = 64**3 / (1 << k[0, 0].bits)
        assert k[0, 0].middle[0] * scale == pytest.approx((f * q - p * g) / (4 * 27), abs=1e-3)


def proved() -> tuple[Fraction, str]:
    """A radius round the first manipulator's slice of 27, and its proof."""
    radius = Fraction("0.005")
    [(problem, _)] = SliceCount(INNOCENTI, 1, Fraction(27)).problems(radius, (Fraction(1),) * 6)
    text = cuts(problem, 10_000)
    assert text is not None
    return radius, text


def test_a_proof_is_one_of_its_region_alone() -> None:
    radius, text = proved()
    own = region(INNOCENTI, Fraction(27), radius)
    assert flaw(own, text) is None
    assert flaw(region(INNOCENTI, Fraction(27), Fraction("0.08")), text) is not None
    assert flaw(own, "2" + text[1:]) == "sign 0 cuts the fixed leg, which does not vary, or is cut too often"
    assert flaw(own, "0" * 1000) == "sign 400 cuts alpha, which does not vary, or is cut too often"


@pytest.mark.long
def test_a_part_that_needs_another_cut_is_cut_and_another_slice_is_not_proved() -> None:
    radius, text = proved()
    assert flaw(region(INNOCENTI, Fraction(27), radius), re.sub(r"\d\.\.", ".", text)) is None
    assert flaw(region(INNOCENTI, Fraction("28.095"), radius), text) is not None


def test_all_parts_are_wanted_and_no_more() -> None:
    """Where a leg is everywhere shorter than its least length."""
    whole = replace(region(INNOCENTI, Fraction(27), Fraction(1, 100)), limits=(Bound(0, -1, Fraction(50)),))
    assert flaw(whole, ".") is flaw(whole, "01..8..") is None
    assert flaw(whole, "0.") == flaw(whole, "") == "parts are left over"
    assert flaw(whole, "0...") == "nothing is left to cut at sign 3"


def test_no_proof_is_found_where_there_is_none() -> None:
    """The radius of a counter-example is about 0.0724."""
    [(problem, _)] = SliceCount(INNOCENTI, 1, Fraction(27)).problems(Fraction("0.0726"), (Fraction(1),) * 6)
    assert cuts(problem, 1_500) is None
