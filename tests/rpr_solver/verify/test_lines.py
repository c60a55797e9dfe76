"""Lines on which no pose is degenerate, and one with a cusp."""

from fractions import Fraction

from rpr_solver import EXAMPLES, cusp_table
from rpr_solver.verify.core.angles import cos_sin, radians
from rpr_solver.verify.core.roots import Root
from rpr_solver.verify.core.surds import Ring, rational
from rpr_solver.verify.core.system import System
from rpr_solver.verify.lines import direction, nearby, opposite, unlisted
from tests.support.verified import geometry_of

BITS = 160


def test_a_line_through_a_cusp_is_clear_once_the_cusp_is_listed() -> None:
    [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=30)
    system = System.of(geometry_of(EXAMPLES["zein-flat"]), 1, Fraction(10))
    alpha, theta = (radians(Fraction(x), BITS) for x in (table.cusps[0].alpha_deg, table.cusps[0].theta1_deg))
    line = cos_sin(theta)
    found = unlisted(system, line, [])
    assert found is not None
    assert abs(found - alpha.middle) < Fraction(1, 10**6)
    assert unlisted(system, line, [nearby(alpha)]) is None
    assert unlisted(system, opposite(BITS), []) is None


def test_the_direction_of_a_line() -> None:
    # u² = 3, θ = ±120°, by u and by 1/u
    for root in (Root(Fraction(1), Fraction(2), False), Root(Fraction(1, 2), Fraction(1), True)):
        cos, sin = direction(Ring(1), rational([-3, 0, 1]), root, 60)
        assert cos.contains(Fraction(-1, 2))
        assert sin.contains(Fraction(866025403784438647, 10**18)) or sin.sign == 1
