"""J of a slice, or of many, in doubles: its values, and a proof that it has no zero in a tube round a path.

J / L is a sum of six sinusoids, in θ, α, α ± θ, α − 2θ and 2α − θ (legs.py). So its derivatives of any order
are known, and bounded everywhere. In a disc of radius ρ (radians) round a pose,

    |J| ≥ |J(middle)| − |∇J| ρ − |H| ρ² / 2 − M ρ³ / 6,

where H has the second derivatives at the middle and M bounds the third ones in all directions. Boxes that
cover the tube are cut until this shows the sign of J on each, or the box is farther from the path than the
radius of the tube (mathematics.md#paths-without-a-singularity). Where the fixed leg varies, this is asked for
the least and the greatest length on the pieces near the box, since J / L is linear in L.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from flint import arb, ctx

from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.exact.turns import RADIANS, TURN, UP, cos_sin
from rpr_solver.legs import SINGULAR_WAVES, Waves, gradient_in_doubles, singular_waves
from rpr_solver.model.slice_map import SliceMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles: TypeAlias = NDArray[np.float64]
    Integers: TypeAlias = NDArray[np.int64]
    Truths: TypeAlias = NDArray[np.bool_]

_BITS = 128
"""The precision of what becomes doubles: far beyond their 53 bits, whatever cancels."""
_WITH_LENGTH = 4
"""The first one whose amplitude has the factor L."""
ROUNDING = 2.0**-40
"""More than what all roundings make of J or a derivative, if the amplitudes sum to 1: a sinusoid is a product
of at most three cosines and sines that are right to 16 units of 2⁻⁵³, times at most 5."""
SLACK = 2.0**-6
"""In units of angles, more than the rounding of distances between poses less than 2⁵ turns apart."""
DEGREE = TURN / 360
_NEWTON_STEPS = 6
"""Steps from a pose nearby; each doubles the digits, and nothing is proved from the result."""
_POLISHINGS = 4
"""Steps to the nearest zero of J."""
_NEAR = 0.2
"""What curvature leaves of the length of such a step, at least."""
_LONGEST = 2.5
"""Degrees along J = 0 in such a step."""
_ZERO = 1e-9
"""What the field is at most where these steps are said to have arrived."""
_CLOSE = 1e-9
"""In units of the field: leg lengths that differ by more are not those of the goal."""
OUTWARDS = 2.0**-48
"""In units of the field, more than the rounding of a length."""


@dataclass(frozen=True)
class SingularField:
    """sign · J of a slice, divided so that the amplitudes of its sinusoids sum to 1.

    Attributes:
        amplitudes: of the sinusoids, complex, by the order of their waves, and perhaps by places.
        size: J / L is ``size`` times as large (scaled lengths).
        sign: the sign of J where the field is positive.
        legs: the free legs, m and a, in units of ``unit``.
        length: the fixed length in these units, or those of the places.
    """

    amplitudes: NDArray[np.complex128]
    size: float
    sign: int
    legs: tuple[tuple[complex, complex], ...]
    length: float | Doubles
    unit: Fraction

    @classmethod
    def of(cls, slice_map: SliceMap, length: Fraction, sign: int) -> SingularField:
        """The field of the slice of a scaled length, for one sign of J."""
        legs = slice_map.f, slice_map.g
        unit = length + sum(leg.size for leg in legs)
        with ctx.workprec(_BITS):
            omega, size = omega_ball(slice_map.radicand, ctx.prec), 1 / ball_of(unit)
            points = [(m * size, a * size) for m, a in (leg.points(omega) for leg in legs)]
            tip = ball_of(length / unit)
            # half the coefficients of the waves (mathematics.md#paths-without-a-singularity)
            f, g = (Waves.of(m, a) for m, a in points)
            balls = singular_waves(f, g, tip)
            total = sum((abs(x) for x in balls), arb(0))
            waves = [complex(x / total) * sign for x in balls]
            floats = [(complex(m), complex(a)) for m, a in points]
            return cls(np.array(waves), float(total / 2), sign, tuple(floats), float(tip), unit)

    def at(self, lengths: Doubles) -> SingularField:
        """The same field where the fixed leg has other lengths, at most that of this slice, place by place;
        J / L is ``size`` times as large there, too."""
        share = np.ones((len(SINGULAR_WAVES), *lengths.shape))
        share[_WITH_LENGTH:] = lengths / self.length
        return replace(self, amplitudes=self.amplitudes[:, None] * share, length=lengths)

    def slice_at(self, length: float) -> SingularField:
        """That of the slice of one of these lengths."""
        own = self.at(np.array([length]))
        return replace(own, amplitudes=own.amplitudes[:, 0], length=length)

    def waves(self, alpha: Doubles, theta: Doubles) -> NDArray[np.complex128]:
        """The sinusoids, as complex numbers, at angles in degrees; of these no rounding is bounded."""
        x, y = np.exp(1j * np.deg2rad(alpha)), np.exp(1j * np.deg2rad(theta))
        return self._waves(x, y)

    def value(self, spots: Doubles) -> Doubles:
        """The field at spots in degrees, about."""
        found: Doubles = np.einsum("w...->...", self.waves(spots[..., 0], spots[..., 1]).real)
        return found

    def _waves(self, x: NDArray[np.complex128], y: NDArray[np.complex128]) -> NDArray[np.complex128]:
        back = np.conj(y)
        parts = [y, x * x * back, x * back, x * y, x * back * back, x]
        count, *places = self.amplitudes.shape
        shape = count, *(1,) * (np.ndim(x * y) - len(places)), *places
        found: NDArray[np.complex128] = self.amplitudes.reshape(shape) * np.array(np.broadcast_arrays(*parts))
        return found

    def bounds(self, alpha: Integers, theta: Integers, radius: float | Doubles) -> tuple[Doubles, Doubles]:
        """The field in the middles of discs, and by how much it may be more or less in them; all in units."""
        c, s = cos_sin(alpha)
        d, t = cos_sin(theta)
        waves = self._waves(c + 1j * s, d + 1j * t)
        value, *slopes = (np.einsum("w,w...->...", k, part) for k, part in orders(waves))
        reach = radius * RADIANS
        steep = np.hypot(slopes[0], slopes[1]) * reach
        bend = np.sqrt(slopes[2] ** 2 + 2 * slopes[3] ** 2 + slopes[4] ** 2) * reach**2 / 2
        rest = abs(self.amplitudes).T @ np.array([np.hypot(*w) ** 3 for w in SINGULAR_WAVES]) * reach**3 / 6
        return value, (steep + bend + rest) * UP + ROUNDING * (1 + reach) ** 2

    def leg_rate(
        self,
        alpha: Integers,
        theta: Integers,
        radius: float,
        least: Doubles,
        shortest: float | Doubles | None = None,
    ) -> Doubles:
        """A lower bound of the smallest singular value of the derivative of both free legs by α and θ, in
        discs of a radius (units) in which the field is at least so large; in ``unit`` of lengths a radian.
        It is one for all lengths of the fixed leg from ``shortest`` to that of the field.

        It is the determinant J / (L2 L3) over the greatest one, for which the sum of the squares of all
        derivatives stands: |∂Lᵢ/∂α| ≤ |m|, |∂Lᵢ/∂θ| ≤ L.
        """
        c, s = cos_sin(alpha)
        d, t = cos_sin(theta)
        turned, tip = c + 1j * s, self.length * (d + 1j * t)
        low = self.length if shortest is None else shortest
        lengths: Doubles = np.ones(alpha.shape)
        squares: float | Doubles = 0.0
        for m, a in self.legs:
            square = abs(m) ** 2 + self.length**2
            squares = squares + square
            shorter = self.length - low
            lengths = lengths * (abs(tip + turned * m - a) + square**0.5 * radius * RADIANS + shorter)
        rate: Doubles = least * self.size * low / (lengths * squares**0.5 * UP)
        return rate / UP


def units(spots: Doubles) -> tuple[Integers, Integers]:
    """The nearest units of angles to spots in degrees."""
    alpha, theta = np.rint(spots * DEGREE).astype(np.int64).T
    return alpha, theta


def orders(waves: NDArray[np.complex128]) -> list[tuple[Doubles, Doubles]]:
    """Factors and parts of the waves, whose sums are the field, and its derivatives by α, θ, αα, αθ, θθ."""
    a, b = np.array(SINGULAR_WAVES, dtype=np.float64).T
    one = np.ones(len(a))
    first, second = -waves.imag, -waves.real
    return [(one, waves.real), (a, first), (b, first), (a * a, second), (a * b, second), (b * b, second)]


def values(field: SingularField, spots: Doubles) -> tuple[Doubles, Doubles, Doubles]:
    """The field, its gradient and its second derivatives (αα, αθ, θθ) by degrees, at spots in degrees."""
    waves = field.waves(spots[..., 0], spots[..., 1])
    parts = [np.einsum("w,w...->...", k, part) for k, part in orders(waves)]
    degree = np.pi / 180
    return parts[0], np.stack(parts[1:3], -1) * degree, np.stack(parts[3:], -1) * degree**2


def polished(field: SingularField, spots: Doubles, feet: Doubles) -> tuple[Doubles, Truths]:
    """The points of J = 0 nearest to spots, from points near them, by Newton's method; and which of its steps
    ended at a zero."""
    for _ in range(_POLISHINGS):
        value, slope, bend = values(field, feet)
        square = (slope**2).sum(-1) + 1e-300
        onto = feet - slope * (value / square)[..., None]
        tangent = np.stack([-slope[..., 1], slope[..., 0]], -1) / np.sqrt(square)[..., None]
        away = spots - onto
        x, y = tangent[..., 0], tangent[..., 1]
        curved = bend[..., 0] * x * x + 2 * bend[..., 1] * x * y + bend[..., 2] * y * y
        factor = np.maximum(1 + (away * slope).sum(-1) / square * curved, _NEAR)
        step = np.clip((away * tangent).sum(-1) / factor, -_LONGEST, _LONGEST)
        feet = onto + tangent * step[..., None]
    value, slope, _ = values(field, feet)
    found: Doubles = feet - slope * (value / ((slope**2).sum(-1) + 1e-300))[..., None]
    return found, abs(field.value(found)) < _ZERO


def half_squares(field: SingularField, spots: Doubles) -> list[Doubles]:
    """Half the squared lengths of both free legs at α and θ in degrees and lengths in units of the field."""
    turned, tip = (np.exp(1j * np.deg2rad(spots[..., n])) for n in (0, 1))
    return [abs(spots[..., 2] * tip + turned * m - a) ** 2 / 2 for m, a in field.legs]


def leg_lengths(field: SingularField, spots: Doubles) -> Doubles:
    """The lengths of both free legs at poses in degrees, in the unit of the slice."""
    return _legs(field, spots)[0]


def _legs(field: SingularField, spots: Doubles) -> tuple[Doubles, Doubles]:
    """The lengths, and their derivatives by degrees (by poses, legs, angles)."""
    turned, tip = (np.exp(1j * np.deg2rad(spots[:, n])) for n in (0, 1))
    tip = field.length * tip
    lengths, slopes = [], []
    for m, a in field.legs:
        vector = tip + turned * m - a
        size = abs(vector)
        lengths.append(size)
        gradient = gradient_in_doubles(vector, turned * m, tip)
        slopes.append(np.stack([slope / size for slope in gradient], -1) * np.pi / 180)
    return np.stack(lengths, -1), np.stack(slopes, 1)


def followed(field: SingularField, spots: Doubles, goals: Doubles) -> Doubles:
    """The poses near others that have these leg lengths, by Newton's method; not finite where it fails."""
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            lengths, slopes = _legs(field, spots)
            missing = goals - lengths
            det = slopes[:, 0, 0] * slopes[:, 1, 1] - slopes[:, 0, 1] * slopes[:, 1, 0]
            alpha = (missing[:, 0] * slopes[:, 1, 1] - missing[:, 1] * slopes[:, 0, 1]) / det
            theta = (missing[:, 1] * slopes[:, 0, 0] - missing[:, 0] * slopes[:, 1, 0]) / det
            spots = spots + np.stack([alpha, theta], -1)
        missing = goals - leg_lengths(field, spots)
        spots[abs(missing).max(axis=1) > _CLOSE] = np.nan
    return spots


@dataclass(frozen=True)
class Pieces:
    """A path as chords, in units of angles, from which it strays by at most ``sag``.

    ``low`` and ``high`` are bounds of the fixed length on them, in units of the field; None if it is held.
    """

    first: Doubles
    last: Doubles
    sag: Doubles
    low: Doubles | None = None
    high: Doubles | None = None

    @classmethod
    def of(cls, first: Doubles, last: Doubles, strays: Doubles) -> Pieces:
        """The pieces between points in degrees, from which each coordinate strays by at most so much; where
        the fixed length varies, it is the third one."""
        sag = np.hypot(strays[:, 0], strays[:, 1]) * (1 + 1e-9) * DEGREE
        chords = cls(first[:, :2] * DEGREE, last[:, :2] * DEGREE, sag)
        if first.shape[1] == 2:
            return chords
        low = np.minimum(first[:, 2], last[:, 2]) - strays[:, 2] - OUTWARDS
        high = np.maximum(first[:, 2], last[:, 2]) + strays[:, 2] + OUTWARDS
        return replace(chords, low=low, high=high)

    def fields(self, field: SingularField, near: Truths) -> tuple[SingularField, ...]:
        """That of the slice; or, for places that are near pieces (rows, columns), those of the least and of
        the greatest length on them."""
        if self.low is None or self.high is None:
            return (field,)
        low = np.where(near, self.low, np.inf).min(axis=1)
        high = np.where(near, self.high, 0.0).max(axis=1)
        return field.at(low), field.at(high)

    def distances(self, alpha: Integers, theta: Integers) -> Doubles:
        """Lower bounds, up to :data:`SLACK`, of the distances of poses (rows) from the pieces (columns)."""
        along = self.last - self.first
        square = np.maximum((along**2).sum(1), 1e-30)
        x = alpha[:, None] - self.first[:, 0]
        y = theta[:, None] - self.first[:, 1]
        share = np.clip((x * along[:, 0] + y * along[:, 1]) / square, 0.0, 1.0)
        found: Doubles = np.hypot(x - share * along[:, 0], y - share * along[:, 1]) - self.sag
        return found


_LARGEST_HALF = 1 << 24
"""In units of angles: half the width of the first boxes, 64 of which make a turn."""
_FINEST = 1 / 512
"""Boxes are not cut below this share of the radius: a tube that needs it is given up."""
_MOST_BOXES = 20_000
"""The boxes after which a tube is given up."""
_RINGS = 8
"""Rings of equal width round a path, in each of which the least rate of the legs counts."""
_ROOT = 2**0.5 * UP
"""Half the diagonal of a square over half its width."""
_TIGHT = 0.5
"""A box is cut until the bound of the field is this share of its value, so that rates are not too small."""


@dataclass(frozen=True)
class Tube:
    """All poses within a radius (units) of a path, in which the field is proved to be positive.

    Attributes:
        radius: in units of angles.
        rate: the least change of both free legs, together, before a fold can be met from anywhere on the
            path; in ``unit`` of lengths.
    """

    radius: float
    rate: float

    @classmethod
    def proved(cls, field: SingularField, pieces: Pieces, radius: float) -> Tube | None:
        """The tube, if boxes prove that the field has no zero in it."""
        half = _LARGEST_HALF
        # Invariant: each pose of the tube is in a waiting box, or in one in which the field is positive by
        # proof. It ends as boxes become smaller; if there are too many, or they are too small, nothing is
        # proved.
        alpha, theta = _cover(pieces, radius + 2 * SLACK, half)
        boxes, near, rates = 0, [], []
        while len(alpha):
            boxes += len(alpha)
            if boxes > _MOST_BOXES or half < radius * _FINEST or half < 2:
                return None
            away = pieces.distances(alpha, theta) - _ROOT * half - SLACK
            inside = away.min(axis=1) <= radius
            alpha, theta, away = alpha[inside], theta[inside], away[inside]
            if not len(alpha):
                break
            own = pieces.fields(field, away <= radius)
            found = [x.bounds(alpha, theta, _ROOT * half) for x in own]
            value = np.minimum.reduce([x for x, _ in found])
            least = np.minimum.reduce([x - slack for x, slack in found])
            if ((value < -ROUNDING) & (away.min(axis=1) + 2 * _ROOT * half < radius)).any():
                return None
            done = least > np.maximum(0.0, _TIGHT * value)
            near.append(away[done])
            rates.append(_rates(own, done, (alpha, theta), _ROOT * half, least))
            half //= 2
            alpha, theta = _quarters(alpha[~done], theta[~done], half)
        return cls(radius, _rate(np.concatenate(near), np.concatenate(rates), radius))


def _rates(
    own: tuple[SingularField, ...],
    done: Truths,
    places: tuple[Integers, Integers],
    radius: float,
    least: Doubles,
) -> Doubles:
    """The rates of legs on the boxes that are done, for all lengths between those of both fields."""
    alpha, theta = (x[done] for x in places)
    if len(own) == 1:
        return own[0].leg_rate(alpha, theta, radius, least[done])
    shortest, longest = (np.asarray(x.length)[done] for x in own)
    return replace(own[1], length=longest).leg_rate(alpha, theta, radius, least[done], shortest)


def _cover(pieces: Pieces, radius: float, half: int) -> tuple[Integers, Integers]:
    """The middles of boxes that cover the tube."""
    reach = radius + pieces.sag[:, None]
    size = 2 * half
    low = np.floor((np.minimum(pieces.first, pieces.last) - reach) / size).astype(int)
    high = np.floor((np.maximum(pieces.first, pieces.last) + reach) / size).astype(int)
    cells = {
        cell
        for (i, k), (m, n) in zip(low.tolist(), high.tolist(), strict=True)
        for cell in product(range(i, m + 1), range(k, n + 1))
    }
    alpha, theta = (size * np.array(sorted(cells), dtype=np.int64) + half).T
    return alpha, theta


def _quarters(alpha: Integers, theta: Integers, half: int) -> tuple[Integers, Integers]:
    """The four quarters of boxes; ``half`` is the half width of the quarters."""
    parts = [(alpha + x * half, theta + y * half) for x, y in product((-1, 1), repeat=2)]
    first, second = zip(*parts, strict=True)
    return np.concatenate(first), np.concatenate(second)


def _rate(near: Doubles, rates: Doubles, radius: float) -> float:
    """The least of the pieces' integrals of the rate over the distance, by rings.

    Legs that change by less than this carry a pose less far than the radius, where it stays regular.
    """
    step = radius / _RINGS
    total = np.zeros(near.shape[1])
    for ring in range(1, _RINGS + 1):
        total += np.where(near <= ring * step, rates[:, None], np.inf).min(axis=0) * step
    return float(total.min()) * 2 * np.pi / TURN / UP
