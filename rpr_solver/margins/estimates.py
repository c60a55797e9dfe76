"""Estimates, in floats, of the least change of the geometry that breaks something; nothing is proved here.

To first order in the change δ of the lengths g a transition moves from L* to L* + ∂L*/∂g · δ. A range gets
a number of cusps that it should not have if one or two transitions pass to the other side of one of its
lengths; of all these ways the one with the least max |δ_j|/w_j counts. This is no bound: transitions that are
not yet born are not seen, and L* is not linear.

Both are mended by :func:`nearest`: a degenerate cusp is a zero of three functions T of pose and geometry
(mathematics.md#margins). Among the geometries g₀ + r σ w, where σ has a sign for each length, two unknown
angles and r belong to a zero. With the left null vector l of ∂T/∂(α, θ), σ = −sign(l · T_g) reduces l · T
fastest, so Newton's method is run from many poses, first with the signs that suit it, then with those that
it has.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from functools import partial
from itertools import combinations, groupby
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.contract import LENGTHS
from rpr_solver.exact.numerals import double, fraction
from rpr_solver.exact.plane import PlaneNumber
from rpr_solver.margins.systems import Systems, moving_legs, orientation_of, slopes_in_floats, third_corner
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.transitions.census import Census

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Flags = NDArray[np.bool_]

_STARTS = 24
_FREE, _FIXED = 14, 11
"""Newton steps while the signs may still change, and steps with the signs that were found."""
_FIRST_RADIUS, _FARTHEST_TURN = 0.05, 0.3
_PRECISE, _SAME = 1e-9, 1e-6
_STATIONARY = 0.25
"""A leg is not used where its squared gradient is less than this share of the other's."""
_TINY = 1e-300
_SWALLOWTAIL, _FOLD, _LIMIT = range(3)
_FEW_SHARES = np.linspace(0, 1, 17)
_SHARES = np.linspace(0, 1, 257)
"""How the weight is shared between two transitions: multipliers of a linear programme."""


@dataclass(frozen=True)
class Mover:
    """A transition that moves with the geometry: its length, kind, ∂L*/∂g, and the change of the count."""

    length: float
    kind: str
    slopes: tuple[float, ...]
    jump: int


@dataclass(frozen=True)
class Estimate:
    """A change of the geometry that should break a requirement.

    Attributes:
        radius: the least max |δ_j|/w_j.
        change: δ/(radius·w), at most 1 in absolute value.
        movers: the transitions that bind it.
    """

    radius: float
    change: tuple[float, ...]
    movers: tuple[Mover, ...]


def movers(table: Census, limits: Mapping[int, Bounds] | None = None) -> list[Mover]:
    """The transitions of a census that have sensitivities, those with a pose within joint limits."""
    found = []
    for transition in table.transitions:
        jump = transition.count_after - transition.count_before
        for event in transition.events:
            document = event.to_json()
            slopes = slopes_in_floats(
                table.manipulator, table.fixed_leg, transition.length, document, table.digits
            )
            if slopes is not None and jump and within(document, limits or {}):
                part = jump // len(transition.events)
                found.append(Mover(double(fraction(transition.length)), event.kind.value, slopes, part))
    return found


def within(point: Mapping[str, str], limits: Mapping[int, Bounds]) -> bool:
    """Whether a pose, as a document has it, is strictly within joint limits."""
    lengths = ((Fraction(point[f"l{leg}"]), *bounds) for leg, bounds in limits.items())
    return all((low is None or x > low) and (high is None or x < high) for x, low, high in lengths)


def breaking(
    intervals: Sequence[tuple[float, float, int]],
    found: Sequence[Mover],
    admits: Callable[[int], bool],
    weights: Sequence[float | Fraction],
) -> Estimate | None:
    """The least change, to first order, that gives a length a number of cusps that is not admitted.

    The arguments are those of :func:`ways`.
    """
    return min(ways(intervals, found, admits, weights), key=lambda way: way.radius, default=None)


def ways(
    intervals: Sequence[tuple[float, float, int]],
    found: Sequence[Mover],
    admits: Callable[[int], bool],
    weights: Sequence[float | Fraction],
) -> Iterator[Estimate]:
    """The changes, to first order, that give a length a number of cusps that is not admitted.

    Args:
        intervals: the lengths as intervals between neighbouring transitions, each with its number of cusps.
        found: the transitions that move.
        admits: whether a number of cusps is allowed.
        weights: w, for each of the slopes of the transitions.
    """
    for low, high, count in intervals:
        for number in (1, 2):
            for chosen in combinations(found, number):
                if not admits(count + sum(_change(mover, low) for mover in chosen)):
                    way = _passing(chosen, low, high, weights)
                    if way is not None:
                        yield way


def _change(mover: Mover, low: float) -> int:
    """How the number of cusps changes at lengths above ``low`` when a transition passes them."""
    return -mover.jump if mover.length <= low else mover.jump


def _passing(
    chosen: Sequence[Mover], low: float, high: float, weights: Sequence[float | Fraction]
) -> Estimate | None:
    """The least change by which all chosen transitions pass a length of an interval; None if none does.

    It is the maximum of the dual linear programme: the shares are the multipliers of the two conditions, and
    for given ones the length and the change that suit them best are known.
    """
    shares = np.ones((1, 1)) if len(chosen) == 1 else np.array([_SHARES, 1 - _SHARES]).T
    sides = np.array([1.0 if mover.length <= low else -1.0 for mover in chosen])
    pulls = (shares * sides) @ np.array([mover.slopes for mover in chosen])
    balance = shares @ sides
    way = balance * np.where(balance >= 0, low, high) - (shares * sides) @ [mover.length for mover in chosen]
    reach = abs(pulls) @ np.array(weights, dtype=float)
    if not (reach > 0).all():
        return None
    best = int(np.argmax(way / reach))
    return Estimate(float((way / reach)[best]), _direction(pulls[best], weights), tuple(chosen))


def widening(
    table: Census,
    ends: tuple[float, float],
    admits: Callable[[int], bool],
    least: float,
    weights: Sequence[float | Fraction],
) -> Estimate | None:
    """The least change, to first order, that makes a window of a range as wide as ``least``.

    Windows that are not yet born, and those that merge, are not seen.

    Args:
        table: the census of all lengths.
        ends: the range.
        admits: whether a number of cusps is allowed; a window is a stretch of others.
        least: the width.
        weights: w.
    """
    known = {mover.length: mover for mover in movers(table)}
    lengths = [double(fraction(transition.length)) for transition in table.transitions]
    places = range(len(table.counts))
    found = []
    for is_admitted, run in groupby(places, key=lambda k: admits(table.counts[k])):
        if not is_admitted:
            inside = list(run)
            around = lengths[max(inside[0] - 1, 0) : inside[0]], lengths[inside[-1] : inside[-1] + 1]
            below, above = ([known[x] for x in side if x in known] for side in around)
            if len(below) + len(above) == len(around[0]) + len(around[1]):
                found.append(_widening(below, above, ends, least, weights))
    return min((one for one in found if one), key=lambda one: one.radius, default=None)


def _widening(
    below: Sequence[Mover],
    above: Sequence[Mover],
    ends: tuple[float, float],
    least: float,
    weights: Sequence[float | Fraction],
) -> Estimate | None:
    """The same for the window between two transitions; without one it has no end there.

    The window, cut to the range, is as wide if rows · δ ≥ missing, for each row.
    """
    start, stop = ends
    rows: list[Doubles] = []
    missing: list[float] = []
    if below and above:
        rows.append(np.array(above[0].slopes) - np.array(below[0].slopes))
        missing.append(least - (above[0].length - below[0].length))
    rows += [np.array(mover.slopes) for mover in above] + [-np.array(mover.slopes) for mover in below]
    missing += [start + least - mover.length for mover in above]
    missing += [mover.length - (stop - least) for mover in below]
    kept = [k for k, far in enumerate(missing) if far > -np.inf]
    if not kept:
        return None
    rows, missing = [rows[k] for k in kept], [missing[k] for k in kept]
    # multipliers of the rows, as in the dual of :func:`_passing`
    grid = np.stack(np.meshgrid(*[_FEW_SHARES] * len(rows)), axis=-1).reshape(-1, len(rows))
    shares = grid[grid.any(axis=1)]
    pulls, far = shares @ np.array(rows), shares @ np.array(missing)
    reach = abs(pulls) @ np.array(weights, dtype=float)
    if not (reach > 0).all():
        return None
    best = int(np.argmax(far / reach))
    if not far[best] > 0:
        return None
    return Estimate(float(far[best] / reach[best]), _direction(pulls[best], weights), (*below, *above))


def closing(lower: Mover, upper: Mover, weights: Sequence[float | Fraction]) -> Estimate | None:
    """The least change, to first order, that lets two transitions meet."""
    pull = np.array(lower.slopes) - np.array(upper.slopes)
    reach = float(abs(pull) @ np.array(weights, dtype=float))
    if not reach > 0:
        return None
    return Estimate((upper.length - lower.length) / reach, _direction(pull, weights), (lower, upper))


def _direction(pull: Doubles, weights: Sequence[float | Fraction]) -> tuple[float, ...]:
    return tuple(float(x) if w else 0.0 for x, w in zip(np.sign(pull), weights, strict=True))


@dataclass(frozen=True)
class _Aim:
    """A system of functions: (K, E, S), (K, ∇K) or (K, E, |leg|² − bound²), with v of leg f (0) or g (1)."""

    kind: int
    leg: int
    limited: int = 0
    bound: float = 0.0


@dataclass(frozen=True)
class _Aims:
    """The members of aims, each for some poses."""

    kind: NDArray[np.int64]
    leg: NDArray[np.int64]
    limited: NDArray[np.int64]
    bound: Doubles

    @classmethod
    def of(cls, aims: Sequence[_Aim], poses: int) -> _Aims:
        """Each aim for so many poses."""
        return cls(*(np.repeat([getattr(aim, x.name) for aim in aims], poses) for x in fields(cls)))

    def __getitem__(self, poses: Flags) -> _Aims:
        return _Aims(self.kind[poses], self.leg[poses], self.limited[poses], self.bound[poses])


class _Linear:
    """A function at many points: values (row 0) and partial derivatives."""

    __slots__ = ("rows",)

    def __init__(self, rows: Doubles) -> None:
        self.rows = rows

    def __add__(self, other: _Linear) -> _Linear:
        return _Linear(self.rows + other.rows)

    def __sub__(self, other: _Linear) -> _Linear:
        return _Linear(self.rows - other.rows)

    def __neg__(self) -> _Linear:
        return _Linear(-self.rows)

    def __mul__(self, other: _Linear | int) -> _Linear:
        if isinstance(other, int):
            return _Linear(self.rows * other)
        rows = self.rows[0] * other.rows + other.rows[0] * self.rows
        rows[0] /= 2
        return _Linear(rows)

    def __truediv__(self, other: _Linear | int) -> _Linear:
        if isinstance(other, int):
            return _Linear(self.rows / other)
        value = other.rows[0]
        rows = -other.rows / value**2
        rows[0] = 1 / value
        return self * _Linear(rows)

    def sqrt(self) -> _Linear:
        """The square root."""
        root = self.rows[0] ** 0.5
        rows = self.rows / (2 * root)
        rows[0] = root
        return _Linear(rows)


@dataclass(frozen=True)
class _Slice:
    """The slices of one length of the fixed leg, in a unit that makes all lengths at most 1."""

    fixed_leg: int
    orientation: int
    length: float
    geometry: Doubles
    weights: Doubles

    def functions(self, aims: _Aims, pose: Doubles, geometry: Doubles) -> tuple[Doubles, Doubles, Flags]:
        """T, its derivatives by α, θ and the lengths, scaled, and where the leg is nearly stationary."""
        lengths = [_variable(x, 2 + k) for k, x in enumerate(geometry)]
        legs = moving_legs(lengths, third_corner(lengths[3:], self.orientation), self.fixed_leg)
        alpha, theta = pose
        angles = (alpha, (1, 0)), (theta, (0, 1)), (alpha - theta, (1, -1))
        turns = [PlaneNumber(*_turn(angle, signs)) for angle, signs in angles]
        fixed = _variable(np.full(alpha.shape, self.length))
        systems = Systems(turns, (fixed, 1), legs)
        k, *found = systems.swallowtails(partial(_where, aims.leg == 0))
        _, *slopes_of_k = systems.critical
        rows = [x.value.rows for x in (k, *found)]
        for place, slope in enumerate(slopes_of_k, 1):
            rows[place] = np.where(aims.kind == _FOLD, slope.value.rows, rows[place])
        if (aims.kind == _LIMIT).any():
            square = _variable(aims.bound**2)
            excess = _where(aims.limited == 0, *(systems.excess(leg, square) for leg in (0, 1)))
            rows[2] = np.where(aims.kind == _LIMIT, excess.rows, rows[2])
        f, g = (sum(x.rows[0] ** 2 for x in systems.tangent(leg)) for leg in (0, 1))
        own, other = np.where(aims.leg == 0, (f, g), (g, f))
        whole = np.array(rows)
        values, slopes = whole[:, 0], whole[:, 1:]
        scale = 1 / (abs(slopes).sum(axis=1) + _TINY)
        is_stationary = (own < _STATIONARY * other) & (aims.kind != _FOLD)
        return values * scale, slopes * scale[:, None], is_stationary

    def chase(self, wanted: Sequence[_Aim]) -> tuple[Doubles, Doubles]:
        """The radii and the signs that are found from a grid of poses, for some aims."""
        places = (np.arange(_STARTS) + 0.5) * (2 * np.pi / _STARTS)
        grid = np.array([np.repeat(places, _STARTS), np.tile(places, _STARTS)])
        pose, aims = np.tile(grid, len(wanted)), _Aims.of(wanted, _STARTS**2)
        start, w = self.geometry[:, None], self.weights[:, None]
        change, radius = np.zeros((len(LENGTHS), pose.shape[1])), np.zeros(pose.shape[1])
        signs, size = np.zeros_like(change), radius
        for step in range(_FREE + _FIXED):
            values, slopes, is_stationary = self.functions(aims, pose, start + change)
            by_pose, by_length = slopes[:, :2], slopes[:, 2:]
            null = np.cross(by_pose[:, 0], by_pose[:, 1], axis=0)
            null /= np.sqrt((null * null).sum(axis=0)) + _TINY
            pull = (null[:, None] * by_length).sum(axis=0)
            height = (null * values).sum(axis=0) - (pull * change).sum(axis=0)
            if step < _FREE:
                signs = -np.sign(height) * np.sign(pull)
            farther = -height / (signs * pull * w).sum(axis=0)
            if step < _FREE:
                farther = np.minimum(farther, np.maximum(2 * radius, _FIRST_RADIUS))
            moved = signs * w * farther
            turn = _solved(by_pose, -values - (by_length * (moved - change)).sum(axis=1))
            size = np.maximum(abs(turn).max(axis=0), abs(moved - change).max(axis=0))
            size[is_stationary] = np.inf
            pose = pose + turn * np.minimum(1, _FARTHEST_TURN / abs(turn).max(axis=0))
            change, radius = moved, farther
            kept = np.isfinite(radius) & np.isfinite(pose).all(axis=0)
            pose, change, signs = pose[:, kept], change[:, kept], signs[:, kept]
            radius, size, aims = radius[kept], size[kept], aims[kept]
        good = (size < _PRECISE) & (radius > 0)
        return radius[good], signs[:, good] * (w > 0)


def nearest(
    manipulator: Manipulator,
    fixed_leg: int,
    lengths: Iterable[Fraction],
    weights: Sequence[Fraction],
    limits: Iterable[tuple[int, Fraction]] = (),
) -> list[Estimate]:
    """Geometries near the given one with a degenerate cusp, or one at a joint limit, by their radii.

    Args:
        manipulator: the given geometry.
        fixed_leg: 1, 2 or 3.
        lengths: of the fixed leg; the slices in which the cusp is sought.
        weights: w, for each of LENGTHS.
        limits: legs f (0) or g (1) with a bound of their lengths.
    """
    geometry = np.array(manipulator.doubles())
    w, most = np.array(weights, dtype=float), double(max(weights))
    aims = [_Aim(_SWALLOWTAIL, 0), _Aim(_SWALLOWTAIL, 1), _Aim(_FOLD, 0)]
    limited = list(limits)
    found = []
    for length in map(double, lengths):
        unit = max(length, *abs(geometry))
        slices = _Slice(fixed_leg, orientation_of(manipulator), length / unit, geometry / unit, w / most)
        bounded = [_Aim(_LIMIT, leg, of, double(bound) / unit) for of, bound in limited for leg in (0, 1)]
        with np.errstate(all="ignore"):
            radii, signs = slices.chase([*aims, *bounded])
        found += [(radius * unit / most, tuple(sign)) for radius, sign in zip(radii, signs.T, strict=True)]
    return _distinct(sorted(found))


def _distinct(found: Sequence[tuple[float, tuple[float, ...]]]) -> list[Estimate]:
    estimates: list[Estimate] = []
    for radius, signs in found:
        if not estimates or radius > estimates[-1].radius * (1 + _SAME):
            estimates.append(Estimate(float(radius), tuple(map(float, signs)), ()))
    return estimates


def _solved(matrix: Doubles, values: Doubles) -> Doubles:
    """Least squares of three equations in two unknowns."""
    x, y = matrix[:, 0], matrix[:, 1]
    a, b, c = (x * x).sum(axis=0), (x * y).sum(axis=0), (y * y).sum(axis=0)
    u, v = (x * values).sum(axis=0), (y * values).sum(axis=0)
    solution: Doubles = np.array([c * u - b * v, a * v - b * u]) / (a * c - b * b)
    return solution


def _where(poses: Flags, one: _Linear, other: _Linear) -> _Linear:
    return _Linear(np.where(poses, one.rows, other.rows))


def _variable(values: Doubles, place: int | None = None) -> _Linear:
    rows = np.zeros((3 + len(LENGTHS), len(values)))
    rows[0] = values
    if place is not None:
        rows[1 + place] = 1
    return _Linear(rows)


def _turn(angle: Doubles, signs: tuple[int, int]) -> tuple[_Linear, _Linear]:
    cos, sin = np.cos(angle), np.sin(angle)
    first, second = _variable(cos), _variable(sin)
    for k, sign in enumerate(signs):
        first.rows[1 + k], second.rows[1 + k] = -sign * sin, sign * cos
    return first, second
