"""Poses in the frame of the points by which a manipulator was given: x, y and φ of its moving frame.

They follow from α and B1 (:class:`~rpr_solver.triangles.UserFrame`), which are found with more digits than
are printed. No enclosure decides the digits of a number that is 0, or half-way between two decimals. It is
printed as 0 if it is proved to be nearer to 0 than 10 to the power of −2 ``digits`` times the terms of which
it is the sum, or that part of a degree; otherwise it is within a unit of its last digit.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from flint import arb, ctx

from rpr_solver.exact.decimals import angle_text, digit_bits, round_ball
from rpr_solver.model.jets import direction
from rpr_solver.triangles import UserFrame

_GUARD = 20
"""Digits beyond twice those that are printed: what sums of a few products lose, and some more."""


def digits_before(digits: int) -> int:
    """The digits of α and B1 from which x, y and φ are found to ``digits``."""
    return 2 * digits + _GUARD


def in_given_frame(frame: UserFrame, pose: Sequence[str], digits: int) -> tuple[str, str, str]:
    """x and y in the unit of the points, and φ in degrees in (−180, 180].

    Args:
        frame: the frames in which base and platform were given.
        pose: α in degrees, and x and y of B1, rounded to :func:`digits_before` digits.
        digits: significant digits.
    """
    with ctx.workprec(digit_bits(digits_before(digits)) + 64):
        alpha, b1x, b1y = map(_enclosed, pose)
        sin, cos = (alpha * arb.pi() / 180).sin_cos()
        x, y, c, s = frame.pose(cos, sin, b1x, b1y, lambda surd: surd.ball())
        places = (*frame.base.origin, *frame.platform.origin)
        unit = sum((abs(surd.ball()) for surd in places), abs(b1x) + abs(b1y))
        # where the direction meets the negative x-axis its angle is that of the opposite one, plus 180
        phi = direction(c, s) if not (s.contains(0) and c < 0) else 180 + direction(-c, -s)
        texts = [_rounded(x, unit, digits), _rounded(y, unit, digits), _rounded(phi, arb(1), digits)]
        return texts[0], texts[1], angle_text(texts[2])


def _enclosed(text: str) -> arb:
    """A ball round a number of which this is the decimal; 0 is printed only where it is exact."""
    exponent = Decimal(text).as_tuple().exponent
    return arb(0) if text == "0" else arb(f"{text} +/- 1e{exponent}")


def _rounded(x: arb, unit: arb, digits: int) -> str:
    if text := round_ball(x, digits):
        return text
    if abs(x) < unit * arb(10) ** (-2 * digits):
        return "0"
    return round_ball(arb(x.mid()), digits) or "0"
