"""Where a degenerate cusp is, for all geometries of a box: there is one, and no other.

This is Theorem 37 (a) and (b), mathematics.md#census-of-a-tolerance.

A transition's pose is a zero of three functions T of x = (α, θ, L), which depend on the lengths g. With a
matrix Y near T_x⁻¹, the map x − Y T(x, g) takes a box of x into itself for every g of the box, so that each
geometry has a zero there; in a wider box, the zone, it contracts, so that there is no other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rpr_solver.exact.numerals import double
from rpr_solver.exact.turns import TURN
from rpr_solver.margins.problems import ANGLES, BoxRing
from rpr_solver.margins.slopes import UP, Slopes, moves
from rpr_solver.model.joint_points import PoseKind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.margins.problems import Problem
    from rpr_solver.margins.slopes import Doubles
    from rpr_solver.margins.systems import Systems

    Flags = NDArray[np.bool_]

POSE = 3
"""α, θ and the fixed leg's length come first among the variables of a box."""
SWALLOWTAILS, CRITICAL = 0, 1
"""The systems (K, E, S) and (K, K_α, K_θ)."""
_RADIAN = TURN / (2 * np.pi)
_LEAST, _MOST = 1e-8, 0.0625
_INSIDE = 0.99
_ROUNDS = 12
_WIDER = 1.1
_ZONE_ROUNDS = 14
_WIDEST = 2.0**20


class Start(NamedTuple):
    """A degenerate pose of the given geometry: its kind, angles in degrees and length, as printed."""

    kind: str
    alpha: str
    theta: str
    length: str


@dataclass(frozen=True)
class Located:
    """A degenerate pose that every geometry of a box has, once. Lengths are in the user's unit.

    Attributes:
        system: the functions whose zero it is, SWALLOWTAILS or CRITICAL.
        low, high: the ends of α, θ and the length of a box in which there is no other; angles are in units
            of a turn over TURN.
        at: the length for the middle geometry, nearly.
        rates: how it changes when one of those lengths that vary changes by its half width, nearly.
        rest: how far, at most, the length is from where ``rates`` put it.
    """

    system: int
    low: tuple[Fraction, ...]
    high: tuple[Fraction, ...]
    at: Fraction
    rates: tuple[Fraction, ...]
    rest: Fraction

    @cached_property
    def span(self) -> tuple[Fraction, Fraction]:
        """Bounds of the length, for all geometries."""
        reach = self.rest + sum(abs(rate) for rate in self.rates)
        return self.at - reach, self.at + reach

    def is_below(self, other: Located) -> bool:
        """Whether for every geometry its length is less than the other's."""
        change = sum(abs(a - b) for a, b in zip(self.rates, other.rates, strict=True))
        return self.at + self.rest + change < other.at - other.rest


def locate(problem: Problem, starts: Sequence[Start]) -> list[tuple[Located | None, float]]:
    """Where all geometries of a box have the degenerate poses that the middle geometry has.

    Args:
        problem: the box of geometries; its unit should not be much greater than their lengths.
        starts: the poses.

    Returns:
        For each pose, what is proved, None if nothing is; and how far its length moves with the geometry to
        first order, an estimate in the user's unit, NaN or infinite for a pose that is not simple.
    """
    if not starts:
        return []
    with np.errstate(all="ignore"):
        search = _Search(problem, starts)
        terms = search.terms(np.full((POSE, len(starts)), _LEAST))
        reaches: Doubles = abs(terms.linear[ANGLES]).sum(axis=0) * double(problem.unit)
        return list(zip(search.located(), map(float, reaches), strict=True))


class _Search:
    """The search for the boxes of several poses at once: a column for each."""

    def __init__(self, problem: Problem, starts: Sequence[Start]) -> None:
        self._problem = problem
        self._centre = np.array([_centre(start, problem.unit) for start in starts]).T
        self._critical = np.array([start.kind != PoseKind.SWALLOWTAIL for start in starts])
        f, g = (sum(x.middle[0] ** 2 for x in self._systems(_LEAST)[1].tangent(leg)) for leg in (0, 1))
        self._leg = np.where(f < g, 1, 0)

    def located(self) -> list[Located | None]:
        """What is proved of each pose."""
        half = np.full(self._centre.shape, _LEAST)
        for _ in range(_ROUNDS):
            terms = self.terms(half)
            image = terms.image
            found = (image <= _INSIDE * half).all(axis=0)
            if found.all():
                break
            wider = np.where(found, half, np.maximum(half, _WIDER * image))
            # errors are those of all boxes, so one that does not contract is not to grow
            fits = (wider <= _MOST).all(axis=0)
            if not (found | fits).any():
                break
            half = np.where(fits, wider, _LEAST)
        if not found.any():
            return [None] * self._centre.shape[1]
        zone, is_alone = self._zone(half)
        found &= is_alone & terms.is_sound
        return [self._answer(terms, zone[:, k], k) if found[k] else None for k in range(len(found))]

    def _answer(self, terms: _Terms, zone: Doubles, k: int) -> Located:
        unit = self._problem.unit
        units = (Fraction(1), Fraction(1), unit)
        centre = [Fraction(x) * u for x, u in zip(self._centre[:, k], units, strict=True)]
        widths = [*np.ceil(zone[:ANGLES] * _RADIAN), zone[ANGLES]]
        half = [Fraction(x) * u for x, u in zip(widths, units, strict=True)]
        return Located(
            CRITICAL if self._critical[k] else SWALLOWTAILS,
            tuple(x - w for x, w in zip(centre, half, strict=True)),
            tuple(x + w for x, w in zip(centre, half, strict=True)),
            centre[ANGLES] + Fraction(terms.shift[ANGLES, k]) * unit,
            tuple(Fraction(x) * unit for x in terms.linear[ANGLES, :, k]),
            Fraction(terms.rest[ANGLES, k]) * unit,
        )

    def _zone(self, half: Doubles) -> tuple[Doubles, Flags]:
        """Wide boxes, multiples of narrow ones, without a second zero, and whether there are such."""
        best, low, high = (np.full(half.shape[1], factor) for factor in (0.0, 1.0, _WIDEST))
        for _ in range(_ZONE_ROUNDS):
            factor = np.sqrt(low * high)
            zone = (half * factor).clip(max=_MOST)
            alone = (self.terms(zone).spread <= _INSIDE * zone).all(axis=0)
            best, low = np.where(alone, factor, best), np.where(alone, factor, low)
            high = np.where(alone, high, factor)
        return (half * best).clip(max=_MOST), best > 0

    def _systems(self, half: Doubles | float) -> tuple[BoxRing, Systems]:
        """The functions on boxes with these half widths, angles in radians."""
        wide = np.broadcast_to(half, self._centre.shape)
        low, high = (np.empty((self._problem.size, wide.shape[1])) for _ in range(2))
        for place, row in self._problem.rows.items():
            low[row], high[row] = self._problem.spans[place].low, self._problem.spans[place].high
        widths = np.concatenate((np.ceil(wide[:ANGLES] * _RADIAN), wide[ANGLES:]))
        low[:POSE], high[:POSE] = self._centre - widths, self._centre + widths
        ring = BoxRing(self._problem, low, high)
        return ring, self._problem.systems(ring, 2)

    def terms(self, half: Doubles) -> _Terms:
        """The map on boxes with these half widths, angles in radians."""
        ring, systems = self._systems(half)
        tests = [systems.critical, *(systems.swallowtails(leg) for leg in (0, 1))]
        is_sound = self._critical.copy()
        for leg in (0, 1):
            is_sound |= (self._leg == leg) & moves(systems, leg)
        which = np.where(self._critical, 0, 1 + self._leg)
        functions = [Slopes.chosen(which, options) for options in zip(*tests, strict=True)]
        return _Terms.of(functions, ring.half, is_sound & (self._centre[ANGLES] > half[ANGLES]))


@dataclass(frozen=True)
class _Terms:
    """The map x − Y T(x, g) on boxes.

    Attributes:
        shift: how far it moves the centre, for the geometry in the middle.
        linear: how its values change with the geometry, to first order, on all of the box.
        rest: bounds of what else they change by.
        spread: bounds of the differences of two values, over those of arguments, times the half widths.
        is_sound: whether lengths are positive, and v is not 0.
    """

    shift: Doubles
    linear: Doubles
    rest: Doubles
    spread: Doubles
    is_sound: Flags

    @classmethod
    def of(cls, functions: Sequence[Slopes], half: Doubles, is_sound: Flags) -> _Terms:
        parts = [function.expanded(half) for function in functions]
        value = np.array([function.middle[0] for function in functions])
        change = np.array([first for first, _, _ in parts])
        second = np.array([second for _, second, _ in parts])
        error = np.array([error for _, _, error in parts])
        inverse = _inverse(change[:, :POSE] / half[:POSE])
        moved = np.einsum("jin,ikn->jkn", inverse, change)
        moved[range(POSE), range(POSE)] -= half[:POSE]
        size = abs(inverse)
        own = abs(moved[:, :POSE]).sum(axis=1)
        rest = np.einsum("jin,in->jn", size, 0.5 * second.sum(axis=1) + error)
        spread = np.einsum("jin,in->jn", size, second[:, :POSE].sum(axis=1) + error)
        shift = -np.einsum("jin,in->jn", inverse, value)
        return cls(shift, -moved[:, POSE:], (own + rest) * UP, (own + spread) * UP, is_sound)

    @property
    def image(self) -> Doubles:
        """Bounds of the distances of the values from the centre."""
        total: Doubles = (abs(self.shift) + abs(self.linear).sum(axis=1) + self.rest) * UP
        return total


def _inverse(matrices: Doubles) -> Doubles:
    """The inverses of 3 × 3 matrices, one for each column, nearly; not finite for singular ones."""
    rows = matrices.transpose(0, 2, 1)
    columns = [np.cross(rows[k - 2], rows[k - 1]) for k in range(POSE)]
    determinant = (rows[0] * columns[0]).sum(axis=1)
    inverse: Doubles = (np.array(columns) / determinant[:, None]).transpose(2, 0, 1)
    return inverse


def _centre(start: Start, unit: Fraction) -> tuple[int, int, float]:
    alpha, theta = (round(Fraction(angle) / 360 * TURN) % TURN for angle in (start.alpha, start.theta))
    return alpha, theta, double(Fraction(start.length) / unit)
