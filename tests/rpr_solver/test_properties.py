"""Invariants of every manipulator and every slice."""

import math
from collections import Counter
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import mpmath as mp
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rpr_solver import (
    EXAMPLES,
    Manipulator,
    SliceTable,
    eliminate,
    exact_str,
    parse_exact,
    shorten_slice,
    solve_slice,
)
from tests.support.article import coalescence, number, pose, singularity
from tests.support.newton import count_cusps, distance
from tests.support.sampling import long
from tests.support.strategies import examples, lengths, manipulators

LEGS = st.sampled_from([1, 2, 3])
ANY_MANIPULATOR = st.one_of(manipulators(), manipulators(size=4, denominators=(1,)))
ANY_LENGTH = st.one_of(lengths(), lengths(size=8, denominators=(1, 2)))


def solve(m: Manipulator, length: Fraction, leg: int = 1, digits: int = 30) -> SliceTable:
    return solve_slice(eliminate(m, leg), length, digits)


def kinds(table: SliceTable) -> Counter[str]:
    return Counter(p["kind"] for p in table.degenerate_points)


def scaled(m: Manipulator, factor: Fraction) -> Manipulator:
    names = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
    return replace(m, **{name: getattr(m, name) * factor for name in names})


def mirrored(m: Manipulator) -> Manipulator:
    return replace(m, a3y=-m.a3y, orientation="cw" if m.orientation == "ccw" else "ccw")


def swapped_legs_2_and_3(m: Manipulator, side: Fraction) -> Manipulator:
    """Legs 2 and 3 exchanged, and everything rotated so that A1A3, of length `side`, lies on the x-axis."""
    cos, sin = m.a3x / side, m.a3y / side
    orientation = "cw" if m.orientation == "ccw" else "ccw"
    return Manipulator(side, m.a2x * cos, -m.a2x * sin, m.d3, m.d2, m.d1, orientation)


@pytest.mark.slow
@given(ANY_MANIPULATOR, ANY_LENGTH, LEGS, st.sampled_from([Fraction(3), Fraction(1, 7), Fraction(10) ** 12]))
@examples(12)
def test_scale(m: Manipulator, length: Fraction, leg: int, factor: Fraction) -> None:
    table, other = solve(m, length, leg), solve(scaled(m, factor), length * factor, leg)
    assert [c.coordinates[:2] for c in other.cusps] == [c.coordinates[:2] for c in table.cusps]
    assert kinds(other) == kinds(table)
    for a, b in zip(table.cusps, other.cusps, strict=True):
        ratio = Fraction(Decimal(b.coordinates[2])) / Fraction(Decimal(a.coordinates[2])) / factor
        assert abs(ratio - 1) < Fraction(1, 10**28)


@pytest.mark.slow
@given(ANY_MANIPULATOR, ANY_LENGTH, LEGS)
@examples(12)
def test_mirror(m: Manipulator, length: Fraction, leg: int) -> None:
    def turned(angle: str) -> str:
        return (
            angle[1:]
            if angle.startswith("-")
            else angle
            if angle == "0" or angle.startswith("180")
            else f"-{angle}"
        )

    table, other = solve(m, length, leg), solve(mirrored(m), length, leg)
    assert sorted((*map(turned, c.coordinates[:2]), *c.coordinates[2:]) for c in table.cusps) == sorted(
        c.coordinates for c in other.cusps
    )
    assert kinds(other) == kinds(table)


@pytest.mark.slow
@given(ANY_MANIPULATOR, st.integers(-9, 9), st.integers(0, 9), ANY_LENGTH, LEGS)
@examples(12)
def test_renaming_legs(m: Manipulator, p: int, q: int, length: Fraction, leg: int) -> None:
    """Pythagorean triples give bases with a rational side A1A3, which can be rotated to the x-axis."""
    assume((p, q) != (0, 0))
    a3x, a3y, side = (Fraction(x, 4) for x in (p * p - q * q, 2 * p * q, p * p + q * q))
    assume((a3x, a3y) != (m.a2x, 0))
    m = replace(m, a3x=a3x, a3y=a3y)
    other_leg = {1: 1, 2: 3, 3: 2}[leg]
    table, other = solve(m, length, leg), solve(swapped_legs_2_and_3(m, side), length, other_leg)
    assert kinds(other) == kinds(table)
    swap = slice(None, None, -1 if leg == 1 else 1)
    theirs = [(c.coordinates[1], *c.coordinates[2:][swap]) for c in other.cusps]
    assert sorted(pair for _, *pair in theirs) == sorted([*c.coordinates[2:]] for c in table.cusps)
    with mp.workdps(40):
        turn = mp.degrees(mp.atan2(number(a3y), number(a3x)))
        for c in table.cusps:
            angles = [
                mp.mpf(theta) + turn - mp.mpf(c.coordinates[1])
                for theta, *pair in theirs
                if pair == [*c.coordinates[2:]]
            ]
            assert min(abs(mp.expjpi(angle / 180) - 1) for angle in angles) < mp.mpf(10) ** -25


@pytest.mark.slow
@pytest.mark.timeout(400)
@given(manipulators(), lengths())
@examples(7)
def test_the_three_choices_of_fixed_leg_agree(m: Manipulator, length: Fraction) -> None:
    """A cusp of the slice L1 = c at (L2, L3) is a cusp of the slice with this L2, to the digits of L2."""
    cusps = solve(m, length, 1, 60).cusps[:2]
    eliminants = {leg: eliminate(m, leg) for leg in (2, 3) if cusps}
    for cusp in cusps:
        for leg, own, other in ((2, cusp.l2, cusp.l3), (3, cusp.l3, cusp.l2)):
            nearby = solve_slice(eliminants[leg], own, 20).cusps
            assert any(
                abs(float(Fraction(c.l1) / length) - 1) < 1e-15
                and abs(float(Fraction(c.coordinates[3]) / Fraction(other)) - 1) < 1e-15
                for c in nearby
            )


@given(ANY_MANIPULATOR, ANY_LENGTH)
@examples(20)
def test_every_cusp_satisfies_the_articles_equations(m: Manipulator, length: Fraction) -> None:
    with mp.workdps(60):
        for cusp in solve(m, length, 1, 50).cusps:
            at = pose(m, exact_str(length), cusp.alpha_deg, cusp.theta1_deg)
            assert abs(singularity(m, at)) < mp.mpf(10) ** -35 * max(map(abs, at.lengths)) * 100
            assert abs(coalescence(m, at)) < mp.mpf(10) ** -25


@pytest.mark.slow
@given(manipulators(size=20), lengths(size=30))
@examples(8)
def test_nothing_that_floating_point_newton_finds_is_missing(m: Manipulator, length: Fraction) -> None:
    """Newton's method may miss cusps; every cusp that it finds must be in the table."""
    table = solve(m, length)
    ours = [(math.radians(float(c.alpha_deg)), math.radians(float(c.theta1_deg))) for c in table.cusps]
    for point in count_cusps(m, float(length), starts=10):
        assert any(distance(point, x) < 1e-4 for x in ours), (point, ours)


@pytest.mark.parametrize(
    ("name", "l1"), [("innocenti", "14.98"), long("innocenti", "28.1"), long("twelve-cusps", "8.3")]
)
def test_newton_counts_the_same_where_it_loses_nothing(name: str, l1: str) -> None:
    table = solve(EXAMPLES[name], parse_exact(l1, "l1"))
    assert len(count_cusps(EXAMPLES[name], float(l1), starts=24)) == table.count


@pytest.mark.slow
@given(ANY_MANIPULATOR, ANY_LENGTH, LEGS)
@examples(15)
def test_more_digits_only_add_digits(m: Manipulator, length: Fraction, leg: int) -> None:
    eliminant = eliminate(m, leg)
    long, short = (solve_slice(eliminant, length, digits).to_json() for digits in (70, 20))
    shortened = shorten_slice(long, 70, 20)
    assert shortened is not None
    assert (shortened["cusps"], shortened["degenerate_points"]) == (
        short["cusps"],
        short["degenerate_points"],
    )
