"""Where a degenerate cusp is, for all geometries of a box: there is one, and no other.

This is Theorem 37 (a) and (b), mathematics.md#census-of-a-tolerance.

A transition's pose is a zero of three functions T of x = (α, θ, L), which depend on the lengths g. With a
matrix Y near T_x⁻¹, the map x − Y T(x, g) takes a box of x into itself for every g of the box, so that each
geometry has a zero there; in a wider box, the zone, it contracts, so that there is no other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rpr_solver.boxes.jets import Jet as Taylor
from rpr_solver.boxes.krawczyk import contracts
from rpr_solver.boxes.sieve import Boxes
from rpr_solver.exact.numerals import double
from rpr_solver.exact.turns import TURN
from rpr_solver.margins.expansions import ANGLES, UP, Expansion, combined, where
from rpr_solver.margins.problems import BoxRing
from rpr_solver.model.joint_points import PoseKind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rpr_solver.margins.expansions import Doubles
    from rpr_solver.margins.problems import Problem
    from rpr_solver.margins.systems import Systems
    from rpr_solver.model.jets import Jet

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
_ZONE_ROUNDS = 2
_FACTORS, _WIDEST = 8, 20.0
"""Zones that are tried at once, the widest of them 2²⁰ times as wide as the box of a pose."""


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

    def farthest(self, other: Located) -> Fraction:
        """An upper bound of how far the other's length is above its own, for every geometry."""
        change = sum((abs(a - b) for a, b in zip(self.rates, other.rates, strict=True)), Fraction(0))
        return other.at - self.at + change + self.rest + other.rest


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
        image = search.image(np.full((POSE, len(starts)), _LEAST))
        reaches: Doubles = abs(image.linear[ANGLES]).sum(axis=0) * double(problem.unit)
        return list(zip(search.located(), map(float, reaches), strict=True))


class _Search:
    """The search for the boxes of several poses at once: a column for each."""

    def __init__(self, problem: Problem, starts: Sequence[Start]) -> None:
        self._problem = problem
        self._centre = np.array([_centre(start, problem.unit) for start in starts]).T
        self._critical = np.array([start.kind != PoseKind.SWALLOWTAIL for start in starts])
        _, systems = self._systems(np.full(self._centre.shape, _LEAST), 0)
        f, g = (sum(x.terms[0] ** 2 for x in systems.tangent(leg)) for leg in (0, 1))
        self._is_f = ~(f < g)

    def located(self) -> list[Located | None]:
        """What is proved of each pose.

        A box that its image is not within grows, at most until a bound; ``found`` are the others.
        """
        half = np.full(self._centre.shape, _LEAST)
        for _ in range(_ROUNDS):
            image = self.image(half)
            found = (image.reach <= _INSIDE * half).all(axis=0)
            wider = np.where(found, half, np.maximum(half, _WIDER * image.reach))
            fits = (wider <= _MOST).all(axis=0)
            if not (fits & ~found).any():
                break
            half = np.where(fits, wider, half)
        found &= image.is_sound
        if not found.any():
            return [None] * self._centre.shape[1]
        zone, is_alone = self._zone(half)
        found &= is_alone
        return [self._answer(image, zone[:, k], k) if found[k] else None for k in range(len(found))]

    def _answer(self, image: _Image, zone: Doubles, k: int) -> Located:
        unit = self._problem.unit
        units = (Fraction(1), Fraction(1), unit)
        centre = [Fraction(x) * u for x, u in zip(self._centre[:, k], units, strict=True)]
        widths = [*np.ceil(zone[:ANGLES] * _RADIAN), zone[ANGLES]]
        half = [Fraction(x) * u for x, u in zip(widths, units, strict=True)]
        return Located(
            CRITICAL if self._critical[k] else SWALLOWTAILS,
            tuple(x - w for x, w in zip(centre, half, strict=True)),
            tuple(x + w for x, w in zip(centre, half, strict=True)),
            (Fraction(image.middle[ANGLES, k]) + Fraction(image.shift[ANGLES, k])) * unit,
            tuple(Fraction(x) * unit for x in image.linear[ANGLES, :, k]),
            Fraction(image.rest[ANGLES, k]) * unit,
        )

    def _zone(self, half: Doubles) -> tuple[Doubles, Flags]:
        """Wide boxes, multiples of narrow ones, without a second zero, and whether there are such."""
        count = half.shape[1]
        best, low, high = np.full(count, -np.inf), np.zeros(count), np.full(count, _WIDEST)
        for _ in range(_ZONE_ROUNDS):
            powers = np.linspace(low, high, _FACTORS)
            zones = (half[:, None] * 2.0**powers).clip(max=_MOST)
            alone = self._alone(zones.reshape(POSE, -1)).reshape(powers.shape)
            best = np.maximum(best, np.where(alone, powers, -np.inf).max(axis=0))
            low = np.maximum(best, 0)
            high = np.where(powers > low, powers, np.inf).min(axis=0).clip(max=_WIDEST)
        return (half * 2.0**best).clip(max=_MOST), best >= 0

    def _systems(self, half: Doubles, order: int) -> tuple[BoxRing, Systems]:
        """The functions on boxes with these half widths, angles in radians; several for each pose."""
        centre = self._all(self._centre, half)
        low, high = (np.empty((self._problem.size, half.shape[1])) for _ in range(2))
        for place, row in self._problem.rows.items():
            low[row], high[row] = self._problem.spans[place].low, self._problem.spans[place].high
        widths = np.concatenate((np.ceil(half[:ANGLES] * _RADIAN), half[ANGLES:]))
        low[:POSE], high[:POSE] = centre - widths, centre + widths
        ring = BoxRing(self._problem, Boxes(low, high))
        return ring, self._problem.systems(ring, order)

    @staticmethod
    def _all(row: NDArray[Any], half: Doubles) -> NDArray[Any]:
        """What is given for each pose, for the columns of some boxes."""
        return np.tile(row, half.shape[1] // row.shape[-1])

    def _tests(self, systems: Systems, half: Doubles, choice: Callable[..., Any]) -> list[Jet[Any]]:
        """T, for each box those of its pose's kind, with v of the leg that is chosen for it."""
        swallowtails = systems.swallowtails(partial(choice, self._all(self._is_f, half)))
        is_critical = self._all(self._critical, half)
        return [
            one.joined(other, partial(choice, is_critical))
            for one, other in zip(systems.critical, swallowtails, strict=True)
        ]

    def image(self, half: Doubles) -> _Image:
        """The map on boxes with these half widths, angles in radians."""
        ring, systems = self._systems(half, 2)
        tests = [jet.value for jet in self._tests(systems, half, where)]
        tangent = systems.tangent(partial(where, self._is_f))
        is_sound = self._critical | np.any([abs(x.terms[0]) > x.change for x in tangent], axis=0)
        is_sound &= self._centre[ANGLES] > half[ANGLES]
        return _Image.of(tests, ring, is_sound)

    def _alone(self, half: Doubles) -> Flags:
        """Whether the map contracts on boxes with these half widths, for each geometry."""
        ring, systems = self._systems(half, 3)
        tests = self._tests(_by_length(systems, ring), half, _where)
        slopes = [[jet.alpha.value.value, jet.theta.value.value, *jet.value.gradient] for jet in tests]
        inverse = _inverse(np.array([[x.terms[0] for x in row] for row in slopes]))
        bounds = []
        for j, factors in enumerate(inverse):
            columns = [combined([row[k] for row in slopes], factors) for k in range(POSE)]
            bounds.append([(abs(x.terms[0] - (j == k)) + x.change) * UP for k, x in enumerate(columns)])
        zone: Doubles = ring.half[:POSE]
        alone: Flags = contracts(list((1 - _INSIDE) * zone), bounds, list(zone))
        return alone


def _where(boxes: Flags, one: Taylor[Expansion], other: Taylor[Expansion]) -> Taylor[Expansion]:
    return Taylor(1, 1, [where(boxes, x, y) for x, y in zip(one.terms, other.terms, strict=True)])


def _by_length(systems: Systems, ring: BoxRing) -> Systems:
    """The same functions with their derivatives by the fixed leg's length, which is one of their scales."""
    zero, one = ring.constant(0.0), ring.constant(1.0)
    whole = systems.mapped(lambda x: Taylor(1, 1, [x, zero]), systems.order)
    return replace(whole, scales=(Taylor(1, 1, [systems.scales[0], one]), 1), known=None)


@dataclass(frozen=True)
class _Image:
    """The map x − Y T(x, g) on boxes, less their middles.

    Attributes:
        middle: the middles, the poses' places nearly.
        shift: what it is there, for the geometry in the middle.
        linear: how it changes with the geometry, to first order.
        rest: bounds of what else it changes by.
        is_sound: whether lengths are positive, and v is not 0.
    """

    middle: Doubles
    shift: Doubles
    linear: Doubles
    rest: Doubles
    is_sound: Flags

    @classmethod
    def of(cls, functions: list[Expansion], ring: BoxRing, is_sound: Flags) -> _Image:
        at, half = functions[0].layout, ring.half[:POSE]
        changes = np.array([function.terms[at.slopes] for function in functions])
        inverse = _inverse(changes[:, :POSE] / half)
        moved = [combined(functions, factors) for factors in inverse]
        terms = np.array([one.terms for one in moved])
        own = terms[:, at.slopes][:, :POSE].copy()
        own[range(POSE), range(POSE)] -= half
        # what is no multiple of one of the lengths' t: terms with poses, symbols, products, and the rest
        rest = abs(own).sum(axis=1) + [one.parts[2] + one.parts[3] + one.rest for one in moved]
        return cls(ring.middle[:POSE], -terms[:, 0], -terms[:, at.slopes][:, POSE:], rest * UP, is_sound)

    @property
    def reach(self) -> Doubles:
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
