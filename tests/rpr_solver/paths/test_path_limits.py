"""Limits of the free legs as walls in half their squared lengths."""

from fractions import Fraction

from flint import arb

from rpr_solver import EXAMPLES
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.path_limits import NO_LIMITS, PathLimits, outside

SLICE = SliceMap.of(EXAMPLES["innocenti"])
LEVEL = arb(0), arb(0)


def half_squares(*lengths: int) -> list[arb]:
    return [(length * SLICE.scale_ball()) ** 2 / 2 for length in lengths]


def test_a_piece_keeps_the_limits_exceeds_them_or_neither() -> None:
    limits = PathLimits.of(SLICE, {2: (Fraction(5), Fraction(20)), 3: (None, Fraction(10))})
    assert limits.hold(half_squares(7, 9), LEVEL)
    for beyond in ((4, 9), (21, 9), (7, 11)):
        assert limits.exclude(half_squares(*beyond))
        assert not limits.hold(half_squares(*beyond), LEVEL)
    first, second = half_squares(7, 9)
    across = [first.union(half_squares(3, 3)[0]), second]
    assert not limits.hold(across, LEVEL)
    assert not limits.exclude(across)
    assert NO_LIMITS.hold(across, LEVEL)


def test_from_a_limit_the_way_leads_inwards() -> None:
    legs = tuple(length * SLICE.scale for length in (Fraction(27), Fraction(20), Fraction(9)))
    limits = PathLimits.of(SLICE, {2: (None, Fraction(20))}, (legs[0], legs[1], legs[2]))
    near = [x.union(y) for x, y in zip(half_squares(20, 9), half_squares(19, 9), strict=True)]
    near[0] = near[0] + arb(0, 1)
    falling, rising = (arb(-1), arb(0)), (arb(1), arb(0))
    assert limits.hold(near, falling, at_start=True)
    assert limits.hold(near, rising, at_stop=True)
    assert not limits.hold(near, rising, at_start=True)
    assert not limits.hold(near, falling, at_stop=True)
    assert not limits.hold(near, falling)
    untouched = PathLimits.of(SLICE, {2: (None, Fraction(20))})
    assert not untouched.hold(near, falling, at_start=True)


def test_limits_are_closed() -> None:
    bounds = {1: (Fraction(27), None), 3: (Fraction(5), Fraction(9))}
    assert outside(bounds, (Fraction(27), Fraction(1), Fraction(9))) == []
    assert outside(bounds, (Fraction(26), Fraction(1), Fraction(10))) == [1, 3]
