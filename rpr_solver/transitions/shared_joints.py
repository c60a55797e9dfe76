"""What is degenerate throughout where legs share joints: nodes, whose number changes at known lengths, and
the line of poses of one length (slices/shared_joints.py)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import arb, ctx

from rpr_solver.exact import decided
from rpr_solver.exact.decimals import digit_bits, round_ball, round_fraction
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.rationals import rational_sqrt
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.joint_points import PoseKind
from rpr_solver.model.lengths import LengthRange
from rpr_solver.model.shared_joints import Joint
from rpr_solver.model.slice_map import SliceMap, cross, dot
from rpr_solver.slices.shared_joints import line_at
from rpr_solver.transitions.degeneracies import Degeneracy

_FIRST_BITS = 64


def shared_degeneracies(slice_map: SliceMap, span: LengthRange, digits: int) -> tuple[Degeneracy, ...]:
    """What is degenerate in a range of lengths where legs share joints, as in a census.

    Args:
        slice_map: of the fixed leg.
        span: the range.
        digits: significant digits of the ends of intervals.
    """
    found = (part.within(span) for part in _all(slice_map, digits))
    return tuple(part for part in found if part)


def _all(slice_map: SliceMap, digits: int) -> Iterator[Degeneracy]:
    joint, leg = Joint.of(slice_map), slice_map.fixed_leg
    rho, unit = slice_map.rho, slice_map.scale**2
    radius2 = dot(joint.radius, joint.radius, rho).a / unit
    if radius2:
        text, root = _Sum(radius2).text(digits), rational_sqrt(radius2)
        line = None if root is None else line_at(slice_map, root * slice_map.scale)
        yield Degeneracy(leg, PoseKind.CURVE, text, text, equation=line)
    product = cross(joint.own, joint.other)
    area2 = (product * product).a * rho
    kind = PoseKind.NODE if area2 else PoseKind.QUADRUPLE
    if area2 and not joint.is_third:
        ends, counts = list[_Sum](), [4]
    else:
        ends, counts = _numbers(radius2, area2 / _side2(joint, rho) / unit if area2 else Fraction(0))
    texts = ["0", *(end.text(digits) for end in ends), None]
    for (start, stop), count in zip(pairwise(texts), counts, strict=True):
        if count:
            yield Degeneracy(leg, kind, str(start), stop, count)


def _side2(joint: Joint, rho: int) -> Fraction:
    side = joint.own[0] - joint.other[0], joint.own[1] - joint.other[1]
    return Fraction(dot(side, side, rho).a)


def _numbers(radius2: Fraction, height2: Fraction) -> tuple[list[_Sum], list[int]]:
    """Where the number of nodes changes, and the numbers between.

    Two nodes are there if |a| + L > H, and two if | |a| - L | > H, where |a| is the radius and H the distance
    of B″ from the line through B and B′ (or of what takes their place). If H = 0, they are quadruple poses,
    and others at L = |a|.
    """
    if not radius2:
        return [], [4]
    if not height2:
        return [_Sum(radius2)], [4, 4]
    greatest = _Sum(radius2, height2)
    if radius2 == height2:
        return [greatest], [2, 4]
    least = _Sum(max(radius2, height2), min(radius2, height2), -1)
    return [least, greatest], [4 if radius2 > height2 else 0, 2, 4]


@dataclass(frozen=True)
class _Sum:
    """A length √x ± √y > 0."""

    x: Fraction
    y: Fraction = Fraction(0)
    sign: int = 1

    def text(self, digits: int) -> str:
        """Correctly rounded."""
        first, second = rational_sqrt(self.x), rational_sqrt(self.y)
        if first is not None and second is not None:
            return round_fraction(first + self.sign * second, digits)

        def rounded(bits: int) -> str | None:
            with ctx.workprec(bits):
                return round_ball(self._ball(), digits)

        # irrational, or twice an irrational root, so that some precision decides
        start = digit_bits(digits) + _FIRST_BITS
        return decided(rounded, start, GREATEST_BITS, "a length could not be rounded")

    def _ball(self) -> arb:
        return ball_of(self.x).sqrt() + self.sign * ball_of(self.y).sqrt()
