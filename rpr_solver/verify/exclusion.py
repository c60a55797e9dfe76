"""That no cusp degenerates for any geometry and length of a region: a proof by cutting, told by a document.

The torus of α and θ and the region are cut in two again and again, until each part is decided
(degeneracy.py). The document tells how, by a sign for each cut and each part; the parts fill the region
whatever it says. A part that is not decided here is cut a few times more.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.core.intervals import Expansion, Interval, TooWideError, constant, cos_sin, pi
from rpr_solver.verify.core.numbers import LENGTHS
from rpr_solver.verify.core.reader import spend
from rpr_solver.verify.degeneracy import Bound, MovingLeg, Pair, Part

PART = "."
VARIABLES = ("alpha", "theta", "the fixed leg", *LENGTHS)
"""What the signs 0 to 8 cut in two."""
_ANGLES = 2
_SPARE_BITS, _DEGREE = 96, 4
_DEEPEST = 400
_MORE_CUTS = 8
_TRIG_ERROR = 16
"""Of a cosine or a sine of α − θ, in units."""
Place = tuple[int, int]
"""Depth and number of a part of a variable's interval."""
Places = tuple[Place | None, ...]
"""Of all variables; None for one that does not vary."""
Span = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Region:
    """Geometries, and lengths of the fixed leg.

    Attributes:
        fixed_leg: 1, 2 or 3.
        orientation: 1, −1, or 0 for a platform that is flat throughout.
        lengths: bounds of each of LENGTHS.
        fixed: bounds of the fixed leg's length, of its inverse, or of that at the middle of ``lengths``.
        inverse: whether it is the inverse.
        rates: how fast the fixed leg's length changes with each of LENGTHS.
        limits: of the moving legs.
    """

    fixed_leg: int
    orientation: int
    lengths: tuple[Span, ...]
    fixed: Span
    inverse: bool = False
    rates: tuple[Fraction, ...] = (Fraction(0),) * len(LENGTHS)
    limits: tuple[Bound, ...] = ()

    @property
    def spans(self) -> tuple[Span, ...]:
        """Those of the fixed leg and of LENGTHS."""
        return self.fixed, *self.lengths


def flaw(region: Region, cuts: str) -> str | None:
    """Why cuts do not prove that no cusp degenerates or passes a limit; None if they do.

    Args:
        region: the geometries and lengths.
        cuts: what is done with the whole, then with its lower half, then with the upper: a digit cuts a
            variable in two, a dot says that a part is decided.
    """
    parts = _Parts(region)
    waiting = [(parts.whole, 0)]
    for n, sign in enumerate(cuts):
        spend(2)
        if not waiting:
            return f"nothing is left to cut at sign {n}"
        places, depth = waiting.pop()
        if sign == PART:
            if not parts.are_decided(places):
                return f"the part at sign {n} is not decided"
            continue
        variable = int(sign)
        place = places[variable]
        if place is None or depth >= _DEEPEST:
            return f"sign {n} cuts {VARIABLES[variable]}, which does not vary, or is cut too often"
        waiting += [(half, depth + 1) for half in _halved(places, variable)]
    return "parts are left over" if waiting else None


class _Parts:
    """The parts of the torus and a region."""

    def __init__(self, region: Region) -> None:
        self.region = region
        varies = [True, True, *(low < high for low, high in region.spans)]
        self._rows = [k for k, x in enumerate(varies) if x]
        """The variables, in the order of the rows of expansions."""
        self.whole: Places = tuple((0, 0) if x else None for x in varies)
        small = min(abs(x) for span in region.spans for x in span if x)
        self._bits = _SPARE_BITS + _DEGREE * (small.denominator // small.numerator).bit_length()
        self._ends = [(_below(low, self._bits), -_below(-high, self._bits)) for low, high in region.spans]
        self._angles: dict[Place, tuple[int, int]] = {}
        self._legs: dict[Places, tuple[MovingLeg, MovingLeg]] = {}

    def are_decided(self, places: Places, cuts: int = _MORE_CUTS) -> bool:
        """Whether a part is decided, or its halves are, which are cut so many times at most.

        The document's author may have decided a part by another arithmetic, just so.
        """
        with suppress(TooWideError):
            if self._part(places).decided():
                return True
        if not cuts:
            return False
        widest = max((k for k, x in enumerate(places) if x), key=lambda k: self._half(k, places[k]))
        return all(self.are_decided(half, cuts - 1) for half in _halved(places, widest))

    def _part(self, places: Places) -> Part:
        (c, s), (d, t) = (self._angle(places[k]) for k in range(_ANGLES))
        a, b = (self._half(k, places[k]) for k in range(_ANGLES))
        bits = self._bits
        return Part(
            self._halves(places),
            self._turned(c, s, a, (1, 0)),
            self._turned(d, t, b, (0, 1)),
            self._turned((c * d + s * t) >> bits, (s * d - c * t) >> bits, a + b, (1, -1)),
            self._scales(places),
            self._moving_legs(places),
            self.region.limits,
        )

    def _half(self, variable: int, place: Place | None) -> int:
        """Half the width of a part of a variable, rounded up well."""
        if place is None:
            return 0
        if variable < _ANGLES:
            return (pi(self._bits).upper >> place[0]) + 1
        low, high = self._ends[variable - _ANGLES]
        return ((high - low) >> (place[0] + 1)) + 4

    def _halves(self, places: Places) -> list[int]:
        return [self._half(k, places[k]) for k in self._rows]

    def _number(self, variable: int, place: Place | None) -> Expansion:
        """One of the lengths."""
        low, high = self._ends[variable - _ANGLES]
        if place is None:
            return self._constant(self.region.spans[variable - _ANGLES][0])
        depth, number = place
        middle, radius = self._zeros(), self._zeros()
        middle[0] = low + ((high - low) * (2 * number + 1) >> (depth + 1))
        middle[1 + self._rows.index(variable)] = 1 << self._bits
        radius[0] = self._half(variable, place)
        return Expansion(self._bits, middle, radius, 0)

    def _angle(self, place: Place | None) -> tuple[int, int]:
        """Cosine and sine of the middle of a part of the circle, right to two units."""
        assert place is not None
        if place not in self._angles:
            depth, number = place
            turn = pi(self._bits + 8).scaled(2 * number + 1)
            narrow = Interval(turn.lower >> depth, -(-turn.upper >> depth), turn.bits)
            cos, sin = (x.at(self._bits).lower for x in cos_sin(narrow))
            self._angles[place] = cos, sin
        return self._angles[place]

    def _turned(self, cos: int, sin: int, half: int, signs: tuple[int, int]) -> Pair:
        """Cosine and sine of an angle with these at the middle; the signs are those of α and θ in it."""
        result = []
        for value, slope in ((cos, -sin), (sin, cos)):
            middle, radius = self._zeros(), self._zeros()
            middle[0], radius[0] = value, self._change(slope, half)
            for row, sign in enumerate(signs, 1):
                if sign:
                    middle[row], radius[row] = sign * slope, self._change(value, half)
            result.append(Expansion(self._bits, middle, radius, _TRIG_ERROR))
        return result[0], result[1]

    def _change(self, slope: int, half: int) -> int:
        """How much cosine or sine changes at most, having this slope at the middle."""
        second = half * (2 * (abs(slope) + _TRIG_ERROR) + half) >> (self._bits + 1)
        return min(half, second + 1)

    def _scales(self, places: Places) -> tuple[Expansion | None, Expansion | None]:
        """λ and μ; None is 1."""
        fixed = self._number(_ANGLES, places[_ANGLES])
        for k, (rate, (low, high)) in enumerate(zip(self.region.rates, self.region.lengths, strict=True)):
            variable = _ANGLES + 1 + k
            if rate and places[variable] is not None:
                change = self._number(variable, places[variable]) - self._constant((low + high) / 2)
                fixed = fixed + change * self._constant(rate)
        return (None, fixed) if self.region.inverse else (fixed, None)

    def _moving_legs(self, places: Places) -> tuple[MovingLeg, MovingLeg]:
        own = places[_ANGLES + 1 :]
        if own not in self._legs:
            lengths = [self._number(_ANGLES + 1 + k, place) for k, place in enumerate(own)]
            half, here = self._halves(places), self.region.fixed_leg - 1
            base, platform = _corners(lengths, self.region.orientation)
            (ox, oy), (om, on) = base.pop(here), platform.pop(here)
            first, second = (
                MovingLeg.of((m - om, n - on), (x - ox, y - oy), half)
                for (x, y), (m, n) in zip(base, platform, strict=True)
            )
            self._legs[own] = first, second
        return self._legs[own]

    def _constant(self, x: Fraction) -> Expansion:
        return constant(x, self._bits, len(self._rows))

    def _zeros(self) -> list[int]:
        return [0] * (1 + len(self._rows))


def _halved(places: Places, variable: int) -> list[Places]:
    """The upper and the lower half of a part."""
    depth, number = places[variable] or (0, 0)
    halves = ((depth + 1, 2 * number + upper) for upper in (1, 0))
    return [(*places[:variable], half, *places[variable + 1 :]) for half in halves]


def _below(x: Fraction, bits: int) -> int:
    return (x.numerator << bits) // x.denominator


def _corners(lengths: Sequence[Expansion], orientation: int) -> tuple[list[Pair], list[Pair]]:
    """Those of base and platform."""
    a2x, a3x, a3y, d1, d2, d3 = lengths
    zero, inverse = d1 - d1, d1.inverse()
    foot = (d1 - (d2 - d3) * (d2 + d3) * inverse).halved()
    height = zero
    if orientation:
        area16 = (d1 + d2 + d3) * (d2 + d3 - d1) * (d1 + d3 - d2) * (d1 + d2 - d3)
        height = (area16.root() * inverse).halved()
    base = [(zero, zero), (a2x, zero), (a3x, a3y)]
    return base, [(zero, zero), (d1, zero), (foot, -height if orientation < 0 else height)]
