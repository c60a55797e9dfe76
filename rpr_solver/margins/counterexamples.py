"""Exact geometries without a property of the given one, near that which a first-order estimate names."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.decimals import rounded_up
from rpr_solver.margins import LENGTHS
from rpr_solver.margins.estimates import Estimate
from rpr_solver.margins.subjects import Found, Subject
from rpr_solver.model.manipulator import Manipulator

_FACTORS = ("1.001", "1.002", "1.004", "1.008", "1.016", "1.032", "1.064", "1.128", "1.256", "1.512", "2")
_DIGITS = 4
_PRECISIONS = (4, 7, 10)
"""Digits of radii: the count may differ only just beyond, until a second transition passes."""
_BISECTIONS = 6


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

    def beyond(self) -> Counterexample | None:
        """A counter-example just beyond the radius, that of a degenerate geometry."""
        radii = {rounded_up(Fraction(self.estimate.radius), digits): None for digits in _PRECISIONS}
        return next((example for radius in radii if (example := self.shows(radius))), None)

    def nearest(self) -> Counterexample | None:
        """A counter-example, the nearest that a short search finds."""
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
