"""Chains of tubes: each begins on the curve in the one before, the first and the last hold given poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.core.angles import cos_sin
from rpr_solver.verify.core.boxes import Directions, Pair
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.surface import Surface, value
from rpr_solver.verify.tubes import Forms, Local, Tube
from rpr_solver.verify.turns import turns

Coordinates = list[Interval]
"""A box of (x, y, z)."""


@dataclass(frozen=True)
class Pose:
    """A box of poses: α and θ in radians, and the scaled length."""

    alpha: Interval
    theta: Interval
    length: Interval

    def about(self, tube: Tube) -> Coordinates:
        """The box in the coordinates of a tube.

        Raises:
            ZeroDivisionError: it is too large, or half a turn away.
        """
        box = []
        for angle, origin in zip((self.alpha, self.theta), tube.origins, strict=True):
            half = Interval(angle.lower >> 1, -(-angle.upper >> 1), angle.bits)
            cos, sin = cos_sin(half)
            s, c = _direction(origin, angle.bits)
            box.append((sin * c - cos * s).over(sin * s + cos * c))
        one = Interval.of(1, self.length.bits)
        return [*box, self.length.over(Interval.of(tube.length, self.length.bits)) - one]


def moved(box: Sequence[Interval], start: Tube, stop: Tube) -> Coordinates:
    """A box from the coordinates of one tube to those of another.

    Raises:
        ZeroDivisionError: it is too large, or half a turn away.
    """
    bits = max(start.bits, stop.bits)
    one = Interval.of(1, bits)
    result = []
    for x, (s, c), (n, d) in zip(box, start.origins, stop.origins, strict=False):
        between, w = Interval.of(Fraction(s * d - c * n, s * n + c * d), bits), with_bits(x, bits)
        result.append((between + w).over(one - between * w))  # the tangent of a sum
    ratio = Interval.of(start.length / stop.length, bits)
    return [*result, ratio * (one + with_bits(box[2], bits)) - one]


def with_bits(x: Interval, bits: int) -> Interval:
    """An interval at another precision, rounded outwards."""
    if bits >= x.bits:
        return Interval(x.lower << (bits - x.bits), x.upper << (bits - x.bits), bits)
    return Interval(x.lower >> (x.bits - bits), -(-x.upper >> (x.bits - bits)), bits)


def _direction(origin: tuple[int, int], bits: int) -> Pair:
    size = max(map(abs, origin))
    return Interval.of(Fraction(origin[0], size), bits), Interval.of(Fraction(origin[1], size), bits)


@dataclass(frozen=True)
class Chain:
    """What is found about a chain of tubes.

    Attributes:
        fault: why it proves nothing, empty if it joins the two points.
        turning: the numbers of the tubes in which the length turns back once; None if that is open in one.
    """

    fault: str
    turning: tuple[int, ...] | None = None


def chain_of(surface: Surface, forms: Forms, tubes: Sequence[Tube], start: Pose, stop: Pose) -> Chain:
    """Whether each tube holds one curve, that of the tube before, and the outer ones the two points."""
    turning: list[int] | None = []
    before: _Entered | None = None
    try:
        for k, tube in enumerate(tubes):
            local = Local(forms, tube)
            if not local.passes():
                return Chain(f"tube {k} is not proved to hold one point for each value of its parameter")
            middle = local.middle()
            if middle is None or not _is_regular(surface, tube, middle):
                return Chain(f"the point at the origin of tube {k} is not proved to be a triple pose")
            if before is None:
                box = start.about(tube)
                if not tube.contains(box):
                    return Chain("the first tube does not hold the first point")
                entry = with_bits(box[tube.parameter], local.bits)
            else:
                box = moved(middle, tube, before.local.tube)
                if not before.local.tube.contains(box):
                    return Chain(f"tube {k} does not begin in the tube before")
                turning = before.added_to(turning, k - 1, box)
                entry = Interval(0, 0, local.bits)
            before = _Entered(local, entry)
        if before is None:
            return Chain("it has no tubes")
        box = stop.about(before.local.tube)
        if not before.local.tube.contains(box):
            return Chain("the last tube does not hold the last point")
        turning = before.added_to(turning, len(tubes) - 1, box)
    except ArithmeticError:
        return Chain("two of its tubes, or a point and its tube, are far apart")
    return Chain("", None if turning is None else tuple(turning))


@dataclass(frozen=True)
class _Entered:
    """A tube, and the parameter at which the chain enters it."""

    local: Local
    entry: Interval

    def added_to(self, turning: list[int] | None, k: int, out: Coordinates) -> list[int] | None:
        """The tubes in which the length turns back, and this one as often as it does on the way out."""
        if turning is None:
            return None
        times = turns(self.local, self.entry, with_bits(out[self.local.tube.parameter], self.local.bits))
        return None if times is None else turning + [k] * times


def _is_regular(surface: Surface, tube: Tube, box: Sequence[Interval]) -> bool:
    """Whether the gradient of the leg along which E is taken is not zero: else E = 0 says nothing there."""
    bits = box[0].bits
    one = Interval.of(1, bits)
    pairs = []
    for x, origin in zip(box, tube.origins, strict=False):
        s, c = _direction(origin, bits)
        sin, cos = c * x + s, c - s * x
        norm = sin * sin + cos * cos
        pairs.append(((cos * cos - sin * sin).over(norm), (sin * cos).scaled(2).over(norm)))
    here = Directions(pairs[0], pairs[1], surface.ring.radicand)
    length = Interval.of(tube.length, bits) * (one + box[2])
    [leg] = [leg for leg in surface.legs if leg.number == tube.leg]
    return any(value(here, slope, length).sign for slope in (leg.alpha, leg.theta))
