"""First-order estimates: the least change of the geometry that moves transitions so that something breaks.

To first order in the change δ of the lengths g a transition moves from L* to L* + ∂L*/∂g · δ. A range gets
a number of cusps that it should not have if one or two transitions pass to the other side of one of its
lengths; of all these ways the one with the least max |δ_j|/w_j counts. This is no bound: transitions that are
not yet born are not seen, and L* is not linear.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from rpr_solver.margins.questions import LENGTHS
from rpr_solver.margins.sensitivities import sensitivity
from rpr_solver.model.lengths import Bounds
from rpr_solver.transitions.census import Census

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
            slopes = sensitivity(
                table.manipulator, table.fixed_leg, transition.length, document, table.digits
            )
            if slopes is not None and jump and _within(document, limits or {}):
                values = tuple(0.0 if slopes[g].is_nan() else float(slopes[g]) for g in LENGTHS)
                part = jump // len(transition.events)
                found.append(Mover(float(transition.length), event.kind.value, values, part))
    return found


def _within(point: Mapping[str, str], limits: Mapping[int, Bounds]) -> bool:
    lengths = ((Fraction(point[f"l{leg}"]), *bounds) for leg, bounds in limits.items())
    return all((low is None or x > low) and (high is None or x < high) for x, low, high in lengths)


def breaking(
    intervals: Sequence[tuple[float, float, int]],
    found: Sequence[Mover],
    admits: Callable[[int], bool],
    weights: Sequence[float],
) -> Estimate | None:
    """The least change, to first order, that gives a length a number of cusps that is not admitted.

    The arguments are those of :func:`ways`.
    """
    return min(ways(intervals, found, admits, weights), key=lambda way: way.radius, default=None)


def ways(
    intervals: Sequence[tuple[float, float, int]],
    found: Sequence[Mover],
    admits: Callable[[int], bool],
    weights: Sequence[float],
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


def _passing(chosen: Sequence[Mover], low: float, high: float, weights: Sequence[float]) -> Estimate | None:
    """The least change by which all chosen transitions pass a length of an interval; None if none does.

    It is the maximum of the dual linear programme: the shares are the multipliers of the two conditions, and
    for given ones the length and the change that suit them best are known.
    """
    shares = np.ones((1, 1)) if len(chosen) == 1 else np.array([_SHARES, 1 - _SHARES]).T
    sides = np.array([1.0 if mover.length <= low else -1.0 for mover in chosen])
    pulls = (shares * sides) @ np.array([mover.slopes for mover in chosen])
    balance = shares @ sides
    way = balance * np.where(balance >= 0, low, high) - (shares * sides) @ [mover.length for mover in chosen]
    reach = abs(pulls) @ np.array(weights)
    if not (reach > 0).all():
        return None
    best = int(np.argmax(way / reach))
    return Estimate(float((way / reach)[best]), _direction(pulls[best], weights), tuple(chosen))


def closing(lower: Mover, upper: Mover, weights: Sequence[float]) -> Estimate | None:
    """The least change, to first order, that lets two transitions meet."""
    pull = np.array(lower.slopes) - np.array(upper.slopes)
    reach = float(abs(pull) @ np.array(weights))
    if not reach > 0:
        return None
    return Estimate((upper.length - lower.length) / reach, _direction(pull, weights), (lower, upper))


def _direction(pull: NDArray[np.float64], weights: Sequence[float]) -> tuple[float, ...]:
    return tuple(float(x) if w else 0.0 for x, w in zip(np.sign(pull), weights, strict=True))
