"""The decimals of numbers and points at an orientation: what is rational is found exactly, as balls cannot.

No ball decides a number that is 0, or half way between two decimals. The one such number in a small ball is
the only candidate, and whether it is the number is decided exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from flint import arb, ctx

from rpr_solver.errors import Unproved
from rpr_solver.exact.decimals import digit_bits, round_ball, round_fraction, rounded_near
from rpr_solver.exact.precision import GREATEST_BITS, TIMES_BEFORE_EXACT, precisions
from rpr_solver.exact.real_roots import fraction_of
from rpr_solver.workspaces.curves import Conic, Pair, Place, Point, Root
from rpr_solver.workspaces.orientation import Vector
from rpr_solver.workspaces.tower import Number, Open

_SPARE = 64
"""Bits beyond those of the digits, in the first trial."""


def number_text(x: Number, digits: int) -> str:
    """A number, correctly rounded."""
    return rounded(x.ball, lambda value: (x - value).is_zero, digits)


def coordinate_text(point: Point, axis: Vector, shift: Number, digits: int, conic: Conic | None) -> str:
    """A coordinate of a point, correctly rounded: along a unit vector, and shifted.

    ``conic`` is the one on which roots of quartics are.
    """

    def ball(bits: int) -> arb:
        x, y = point.ball(bits)
        return axis[0].ball(bits) * x + axis[1].ball(bits) * y + shift.ball(bits)

    def equals(value: Fraction) -> bool:
        if isinstance(point, Place):
            own = axis[0] * point.x + axis[1] * point.y
            return (own + (shift - value) * point.w).is_zero
        assert conic is not None
        return _has_coordinate(point, axis, value - shift, conic)

    return rounded(ball, equals, digits)


def rounded(ball: Callable[[int], arb], equals: Callable[[Fraction], bool], digits: int) -> str:
    """A number by its balls, correctly rounded.

    Args:
        ball: a ball round it, at a precision.
        equals: whether it is a rational number, exactly.
        digits: significant digits.

    Raises:
        Unproved: the digits could not be decided.
    """
    start = digit_bits(digits) + _SPARE
    is_tried = False
    for bits in precisions(start, GREATEST_BITS):
        with ctx.workprec(bits):
            try:
                x = ball(bits)
            except Open:
                continue
            if text := round_ball(x, digits):
                return text
        if bits >= TIMES_BEFORE_EXACT * start and not is_tried and x.is_finite():
            is_tried = True
            candidate = Fraction(0) if x.contains(0) else rounded_near(fraction_of(x), digits + 1)
            if equals(candidate):
                return round_fraction(candidate, digits)
    raise Unproved("the digits of a place could not be decided")


def _has_coordinate(point: Root, axis: Vector, value: Number, conic: Conic) -> bool:
    """Whether a coordinate of a common point of a circle and the conic, along a unit vector, is a number.

    If so, it is on a line that meets the circle twice at most, and the conic passes through one of both.
    """
    circle = point.quartic.circle
    (u, v), (x, y) = axis, circle.centre
    far = value - u * x - v * y
    square = far * far * -1 + circle.radius**2
    sign = square.sign
    if sign < 0:
        return False
    root = square.tower.with_root(square)[1] if sign else square.tower.number(0)
    for side in (1, -1):
        place = Place(x + far * u - root * v * side, y + far * v + root * u * side, square.tower.number(1))
        if conic.value(place).is_zero and _is_same(point, place):
            return True
    return False


def _is_same(point: Root, place: Place) -> bool:
    """Whether a common point of the circle and the conic is this one of all of them."""
    others = point.quartic.points
    for bits in precisions(_SPARE, GREATEST_BITS):
        try:
            near = [k for k, other in enumerate(others) if _overlap(other.ball(bits), place.ball(bits))]
        except Open:
            continue
        if len(near) == 1:
            return near[0] == point.number
    raise Unproved("common points of curves could not be told apart")


def _overlap(p: Pair, q: Pair) -> bool:
    return bool(p[0].overlaps(q[0]) and p[1].overlaps(q[1]))
