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

IN_GIVEN_FRAME = ("x", "y", "phi_deg")
"""The members of poses in documents that tell them in the given frame."""
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
    with ctx.workprec(working_bits(digits)):
        alpha, b1x, b1y = map(enclosed, pose)
        x, y, phi = placed(frame, (alpha * arb.pi() / 180, b1x, b1y), digits)
        return x, y, angle_text(settled(phi, arb(1), digits))


def working_bits(digits: int) -> int:
    """The precision at which poses are placed."""
    return digit_bits(digits_before(digits)) + 64


def placed(frame: UserFrame, pose: tuple[arb, arb, arb], digits: int) -> tuple[str, str, arb]:
    """x and y to so many digits, and φ in degrees, in (−180, 180].

    Args:
        frame: the frames in which base and platform were given.
        pose: α in radians, and x and y of B1, at :func:`working_bits`.
        digits: significant digits.
    """
    alpha, b1x, b1y = pose
    sin, cos = alpha.sin_cos()
    x, y, c, s = frame.pose(cos, sin, b1x, b1y, lambda surd: surd.ball())
    places = (*frame.base.origin, *frame.platform.origin)
    unit = sum((abs(surd.ball()) for surd in places), abs(b1x) + abs(b1y))
    # where the direction meets the negative x-axis its angle is that of the opposite one, plus 180
    phi = direction(c, s) if not (s.contains(0) and c < 0) else 180 + direction(-c, -s)
    return settled(x, unit, digits), settled(y, unit, digits), phi


class Course:
    """Poses of a path, one after the other: φ begins in (−180, 180] and changes as α does."""

    def __init__(self, frame: UserFrame, digits: int) -> None:
        self._frame, self._digits = frame, digits
        self._ahead: float | None = None

    def placed(self, alpha: arb, b1: tuple[arb, arb]) -> tuple[str, str, str]:
        """x, y and φ in degrees; α in radians, at :func:`working_bits`."""
        x, y, phi = placed(self._frame, (alpha, *b1), self._digits)
        degrees = float(alpha * 180 / arb.pi())
        if self._ahead is None:
            self._ahead = float(phi) - degrees
            return x, y, angle_text(settled(phi, arb(1), self._digits))
        # a whole number of turns, nearly
        phi += 360 * round((degrees + self._ahead - float(phi)) / 360)
        return x, y, settled(phi, arb(1), self._digits)


def enclosed(text: str) -> arb:
    """A ball round a number of which this is the decimal; 0 is printed only where it is exact."""
    exponent = Decimal(text).as_tuple().exponent
    return arb(0) if text == "0" else arb(f"{text} +/- 1e{exponent}")


def settled(x: arb, unit: arb, digits: int) -> str:
    """A number with so many digits, as this module's first lines say; ``unit`` is the size of its terms."""
    if text := round_ball(x, digits):
        return text
    if abs(x) < unit * arb(10) ** (-2 * digits):
        return "0"
    return round_ball(arb(x.mid()), digits) or "0"
