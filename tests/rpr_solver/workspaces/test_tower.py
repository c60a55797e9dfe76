"""Numbers of a tower: signs and zeros against known identities of cosines and roots."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.triangles.surds import Surd
from rpr_solver.workspaces.tower import Number, Tower


def turned(degrees: Fraction) -> tuple[Number, Number]:
    """Cosine and sine."""
    tower = Tower(degrees / 360 % 1)
    c = tower.cosine
    return c, tower.with_root(1 - c * c, -1 if tower.turn > Fraction(1, 2) else 1)[1]


@pytest.mark.parametrize("degrees", [Fraction(x) for x in ("0", "36", "50", "17.3", "-0.37", "1/7", "180")])
def test_multiple_angles(degrees: Fraction) -> None:
    c, s = turned(degrees)
    double, triple = turned(2 * degrees), turned(3 * degrees)
    assert (c * c + s * s - 1).is_zero
    for bits in (64, 200):
        assert (c * c - s * s).ball(bits).overlaps(double[0].ball(bits))
        assert (s * 3 - s * s * s * 4).ball(bits).overlaps(triple[1].ball(bits))


@pytest.mark.parametrize(
    ("degrees", "square", "sign"),
    [(30, 3, 0), (15, 3, -1), (45, 2, 0), (22, 2, -1), (60, 1, 0)],
)
def test_roots_that_are_cosines(degrees: int, square: int, sign: int) -> None:
    """2 cos φ against a root, with a generator that the tower has already by another name."""
    c, _ = turned(Fraction(degrees))
    tower = c.tower.with_surd(Surd.root(square))
    difference = tower.surd(Surd.root(square)) - Number(tower, c.terms) * 2
    assert difference.sign == sign


@given(st.integers(1, 30), st.integers(1, 30))
def test_a_root_of_a_sum_of_roots(a: int, b: int) -> None:
    """√(a + b + 2 √(ab)) = √a + √b, through generators that depend on each other."""
    tower = Tower(Fraction(0))
    tower, first = tower.with_root(tower.number(a))
    tower, second = tower.with_root(tower.number(b))
    tower, third = tower.with_root(tower.number(a * b))
    tower, whole = tower.with_root(third * 2 + a + b)
    assert (whole - first - second).is_zero
    assert (whole - first + second).sign == 1
