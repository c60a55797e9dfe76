"""Angles by the tangents of their halves, as balls and as floats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import atan, pi

from flint import arb, arb_mat, arb_poly

from rpr_solver.exact.modular import sylvester
from rpr_solver.model.jets import Pose


@dataclass(frozen=True)
class HalfTangent:
    """tan(angle/2) = numerator / denominator as balls; the denominator is 0 at 180°."""

    numerator: arb
    denominator: arb

    def cos_sin(self) -> tuple[arb, arb]:
        """Cosine and sine of the angle."""
        n, d = self.numerator, self.denominator
        nn, dd = n * n, d * d
        norm = nn + dd
        return (dd - nn) / norm, 2 * n * d / norm

    def degrees(self, offset: int = 0) -> arb:
        """The angle in degrees, in (−180, 180] for the exact value; ``offset`` is 0 or 180."""
        n, d = self.numerator, self.denominator
        if abs(n) < abs(d):
            return (n / d).atan() * 360 / arb.pi() + offset
        side = -180 if n * d < 0 else 180
        return side - (d / n).atan() * 360 / arb.pi() + offset


def whole_angle(half_tangent: Fraction) -> float:
    """The angle in radians, about; half a turn where the tangent is beyond the range of floats."""
    try:
        return 2 * atan(half_tangent)
    except OverflowError:
        return pi if half_tangent > 0 else -pi


def direction(x: arb, y: arb) -> arb:
    """The angle of (x, y) in degrees; a ball that meets the negative x-axis has a valid but wide result."""
    return arb.atan2(y, x) * 180 / arb.pi()


def pose_of(alpha: HalfTangent, theta: HalfTangent, length: arb, omega: arb) -> Pose[arb]:
    """The pose with these angles of a slice (scaled units)."""
    (cos_a, sin_a), (cos_t, sin_t) = alpha.cos_sin(), theta.cos_sin()
    return Pose(cos_a, sin_a, cos_t, sin_t, length, omega)


def common_root(j: Sequence[arb], e: Sequence[arb]) -> HalfTangent | None:
    """The common root t of two forms that share exactly one; None if the precision is insufficient."""
    found = _by_remainders(j, e) or _finite_common_root(j, e)
    return found or _inverse(_finite_common_root(j[::-1], e[::-1]))


def _by_remainders(j: Sequence[arb], e: Sequence[arb]) -> HalfTangent | None:
    """From the last remainder but one of Euclid's algorithm, if it has degree 1; else None.

    The forms have no common root at infinity if a leading coefficient is not 0.
    """
    longer, shorter = (j, e) if len(j) >= len(e) else (e, j)
    first, second, degree = arb_poly(list(longer)), arb_poly(list(shorter)), len(shorter) - 1
    while degree >= 1:
        lead = second[degree]
        if not lead.is_finite() or lead.contains(0):
            return None
        if degree == 1:
            return HalfTangent(-second[0], lead)
        first, second, degree = second, first % second, degree - 1
    return None


def _finite_common_root(j: Sequence[arb], e: Sequence[arb]) -> HalfTangent | None:
    """t = −s0/s1 from the first subresultant s1 t + s0, if s1 ≠ 0 is proved."""
    size = len(j) + len(e) - 4
    full = sylvester(j, e, arb(0))
    # t^(n−2)J … J, t^(m−2)E … E: one row less of each, and the columns t^(m+n−2) … 1
    rows = [row[1:] for i, row in enumerate(full) if i not in (0, len(e) - 1)]
    s1 = arb_mat([row[:size] for row in rows]).det()
    s0 = arb_mat([[*row[: size - 1], row[size]] for row in rows]).det()
    return None if s1.contains(0) else HalfTangent(-s0, s1)


def _inverse(t: HalfTangent | None) -> HalfTangent | None:
    return HalfTangent(t.denominator, t.numerator) if t else None
