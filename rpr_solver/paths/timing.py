"""When a motion is where: laws of time over the arc length in joint space.

Times choose which points of a path become samples; floats are enough for that, since every point of the path
is proved.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate, pairwise
from math import cos, dist, pi

Joint = Callable[[int, float], tuple[float, float, float]]
"""The leg lengths at a parameter of an arc, of which the number is given."""

_CHORDS = 96
_RAMP = 1 / 3


def cosine(time: float) -> float:
    """The distance covered after a share of the time: speed rises and falls as half a sine wave.

    >>> [round(cosine(time), 3) for time in (0.0, 0.1, 0.5, 1.0)]
    [0.0, 0.024, 0.5, 1.0]
    """
    return (1 - cos(pi * time)) / 2


def trapezoid(time: float) -> float:
    """As :func:`cosine`, with constant acceleration for a third of the time, then constant speed, then
    constant deceleration.

    >>> trapezoid(0.0), trapezoid(0.5), trapezoid(1.0)
    (0.0, 0.5, 1.0)
    """
    if time > 0.5:
        return 1 - trapezoid(1 - time)
    speed = 1 / (1 - _RAMP)
    return speed * (time**2 / (2 * _RAMP) if time < _RAMP else time - _RAMP / 2)


def constant(time: float) -> float:
    """As :func:`cosine`, with constant speed.

    >>> constant(0.25)
    0.25
    """
    return time


TIMINGS: Mapping[str, Callable[[float], float]] = {
    "cosine": cosine,
    "trapezoid": trapezoid,
    "constant": constant,
}
"""The laws of time by name."""


def places(joint: Joint, arcs: int, shares: Sequence[float]) -> list[tuple[int, float]]:
    """The arcs and their parameters at which these shares of the whole arc length are covered."""
    nodes = [(arc, k / _CHORDS) for arc in range(arcs) for k in range(_CHORDS + 1)]
    points = [joint(*node) for node in nodes]
    lengths = [dist(p, q) for p, q in pairwise(points)]
    covered = [0.0, *accumulate(lengths)]

    def place(share: float) -> tuple[int, float]:
        goal = share * covered[-1]
        k = min(max(bisect_right(covered, goal) - 1, 0), len(nodes) - 2)
        (arc, tau), (next_arc, next_tau) = nodes[k], nodes[k + 1]
        if arc != next_arc:
            return next_arc, next_tau
        part = (goal - covered[k]) / lengths[k] if lengths[k] else 0.0
        return arc, tau + min(max(part, 0.0), 1.0) * (next_tau - tau)

    return [place(share) for share in shares]
