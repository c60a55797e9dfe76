"""Exact geometries without a property of the given one, near that which a first-order estimate names."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_DOWN, ROUND_UP
from fractions import Fraction
from math import ceil, log10

from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.decimals import quotient
from rpr_solver.margins.estimates import Estimate
from rpr_solver.margins.questions import LENGTHS
from rpr_solver.margins.subjects import Found, SliceCount, Subject
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.transitions.census import census

_FACTORS = ("1.001", "1.002", "1.004", "1.008", "1.016", "1.032", "1.064", "1.128", "1.256", "1.512", "2")
_DIGITS = 4
_CLOSE = (Fraction(1), Fraction(1001, 1000))
_BISECTIONS = 6
_SECANTS = 6
_NEAR = Fraction(1, 20)


@dataclass(frozen=True)
class Counterexample:
    """A geometry, exact, in few decimals, that does not have the property.

    Attributes:
        radius: max |δ_j|/w_j of its difference from the given geometry.
        manipulator: the geometry.
        found: where it fails: ``length`` of the fixed leg and number of ``cusps`` there; None for a window,
            where no length has the number.

    >>> from rpr_solver import EXAMPLES, margin
    >>> example = margin(EXAMPLES["innocenti"], "28.1", tolerance="0.0007").counterexample
    >>> example.manipulator.d1, example.found.cusps
    (Fraction(170407, 10000), 8)
    """

    radius: Fraction
    manipulator: Manipulator
    found: Found


@dataclass(frozen=True)
class Ray:
    """Geometries on the ray of an estimate."""

    subject: Subject
    manipulator: Manipulator
    weights: tuple[Fraction, ...]
    estimate: Estimate
    validity: Fraction | None

    def at(self, radius: Fraction) -> Manipulator:
        """The geometry at a radius."""
        steps = zip(LENGTHS, self.weights, self.estimate.change, strict=True)
        moved = {g: getattr(self.manipulator, g) + radius * w * int(sign) for g, w, sign in steps}
        return Manipulator(**{**self.manipulator.to_dict(), **moved})

    def shows(self, radius: Fraction) -> Counterexample | None:
        """The counter-example at a radius, if it is one; None as well if it has no answer."""
        if radius <= 0 or (self.validity is not None and radius >= self.validity):
            return None
        try:
            manipulator = self.at(radius)
            found = self.subject.broken(manipulator)
        except (InputError, SolverError):
            return None
        return None if found is None else Counterexample(radius, manipulator, found)

    def nearest(self) -> Counterexample | None:
        """A counter-example, the nearest that a short search finds."""
        return self._by_steps() or self._in_a_narrow_window()

    def _by_steps(self) -> Counterexample | None:
        whole = Fraction(self.estimate.radius)
        sound = whole * 9 / 10
        while best := self.shows(rounded_up(sound, _DIGITS)):
            sound = sound * 4 / 5
            if sound < whole / 10:
                return best
        for factor in map(Fraction, _FACTORS):
            if best := self.shows(rounded_up(whole * factor, _DIGITS)):
                return self._between(sound, best)
            sound = whole * factor
        return None

    def _between(self, sound: Fraction, best: Counterexample) -> Counterexample:
        """One that is nearer, by a few bisections."""
        for _ in range(_BISECTIONS):
            middle = rounded_up((sound + best.radius) / 2, _DIGITS)
            if middle >= best.radius:
                break
            if nearer := self.shows(middle):
                best = nearer
            else:
                sound = middle
        return best

    def _in_a_narrow_window(self) -> Counterexample | None:
        """Where the count differs only between two transitions, which pass the slice one after the other."""
        subject = self.subject
        if not isinstance(subject, SliceCount):
            return None
        first, second = (rounded_up(Fraction(self.estimate.radius) * f, 2 * _DIGITS) for f in _CLOSE)
        gap = self._window(subject, first)
        for _ in range(_SECANTS):
            other = self._window(subject, second)
            if gap is None or other is None or other[0] == gap[0]:
                return None
            rate = (other[0] - gap[0]) / (second - first)
            aim = second - other[0] / rate
            if aim <= 0:
                return None
            digits = max(ceil(log10(aim * abs(rate) * 16 / other[1])), _DIGITS)
            first, gap, second = second, other, rounded_up(aim, digits)
            if best := self.shows(second):
                return best
        return None

    def _window(self, subject: SliceCount, radius: Fraction) -> tuple[Fraction, Fraction] | None:
        """How far above the slice the middle of the nearest window with another count is, and its width."""
        length, near = subject.length, subject.length * _NEAR
        try:
            table = census(
                self.at(radius),
                fixed_leg=subject.fixed_leg,
                digits=30,
                start=length - near,
                stop=length + near,
            )
        except (InputError, SolverError):
            return None
        ends = [Fraction(transition.length) for transition in table.transitions]
        windows = (
            ((low + high) / 2 - length, high - low)
            for low, high, count in zip(ends, ends[1:], table.counts[1:], strict=False)
            if count != subject.count()
        )
        return min(windows, key=lambda window: abs(window[0]), default=None)


def rounded_up(x: Fraction, digits: int) -> Fraction:
    """The least number of ``digits`` significant digits that is not less."""
    return Fraction(quotient(x, digits, ROUND_UP))


def rounded_down(x: Fraction, digits: int) -> Fraction:
    """The greatest number of ``digits`` significant digits that is not greater."""
    return Fraction(quotient(x, digits, ROUND_DOWN))
