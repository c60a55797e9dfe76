"""Laws of time: which share of the arc length in joint space is covered after which share of the time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import cos, pi
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.boxes import Balls
from rpr_solver.verify_by_boxes.arcs import Controls, along
from rpr_solver.verify_by_boxes.claims import OpenError, demand
from rpr_solver.verify_by_boxes.equations import Lengths
from rpr_solver.verify_by_boxes.reader import Record
from rpr_solver.verify_by_boxes.work import Work

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


def _trapezoid(time: float) -> float:
    """Constant acceleration for a third of the time, then constant speed, then constant deceleration."""
    if time > 1 / 2:
        return 1 - _trapezoid(1 - time)
    return 9 / 4 * time**2 if time < 1 / 3 else 3 / 2 * (time - 1 / 6)


LAWS: Mapping[str, Callable[[float], float]] = {
    "cosine": lambda time: (1 - cos(pi * time)) / 2,
    "trapezoid": _trapezoid,
    "constant": lambda time: time,
}
"""The share of the length by that of the time."""
TOLERANCE = 1e-3
"""So much of the length of the path, a sample may be before or behind its law."""
_STEPS, _LEAST_STEPS = 1024, 32
"""Of a path, and of an arc at least."""
_ROUNDINGS = 1e-7
"""Far more than all roundings of sums in doubles."""


def keeps_time(space: Lengths, arcs: Sequence[Controls], members: Record, work: Work) -> str:
    """Proves that the samples of a path are where its law of time says.

    Raises:
        OpenError: it is not decided.
        RefusedError: one is elsewhere.
    """
    samples, law, duration = members["samples"], LAWS[members["timing"]], members["duration"]
    numbers = np.array([min(int(sample["place"]), len(arcs) - 1) for sample in samples])
    taus = np.array([float(x["place"] - int(n)) for x, n in zip(samples, numbers, strict=True)])
    before, covered = np.zeros(2), np.zeros((2, len(samples)))
    for n, controls in enumerate(arcs):
        own = numbers == n
        even = np.linspace(0, 1, max(_STEPS // len(arcs), _LEAST_STEPS) + 1)
        nodes = np.unique(np.concatenate([even, taus[own]]))
        work.spend(len(nodes) // 8)
        sums = before[:, None] + np.cumsum(np.hstack([np.zeros((2, 1)), _lengths(space, controls, nodes)]), 1)
        covered[:, own], before = sums[:, np.searchsorted(nodes, taus[own])], sums[:, -1]
    if not before[0] > 0:
        raise OpenError("the path may have no length")
    rest = before[:, None] - covered
    low, high = covered[0] / (covered[0] + rest[1]), covered[1] / (covered[1] + rest[0])
    goal = np.array([law(float(sample["time"] / duration)) for sample in samples])
    late, early = goal - low + _ROUNDINGS, high - goal + _ROUNDINGS
    demand(not ((high < goal - TOLERANCE) | (low > goal + TOLERANCE)).any(), "a sample is elsewhere")
    if not ((late < TOLERANCE) & (early < TOLERANCE)).all():
        raise OpenError("it is not decided for a sample")
    return "the arc length between samples is bounded on steps of the arcs"


def _lengths(space: Lengths, controls: Controls, nodes: Doubles) -> Doubles:
    """Bounds of the arc length of an arc between parameters, which ascend, in units; of shape (2, steps).

    The mean of the derivative v of the leg lengths over a step is the chord over the step. If all v are within
    r of it, |v| is at most its component along the chord and r² over twice the least of these components.

    Raises:
        OpenError: a leg may have the length 0.
    """
    step = np.diff(nodes)
    ends, _ = _legs(space, controls, Balls(nodes, np.full_like(nodes, 2.0**-50)), 0)
    _, speed = _legs(space, controls, Balls(nodes[:-1] + step / 2, step / 2 + 2.0**-50), 1)
    chord, error = np.diff(ends.mid), ends.rad[:, 1:] + ends.rad[:, :-1]
    length, error = np.linalg.norm(chord, axis=0), np.linalg.norm(error, axis=0)
    spread = 2 * np.linalg.norm(speed.rad, axis=0)
    least = (length - error) / step - spread
    with np.errstate(all="ignore"):
        bent = np.where(least > 0, length + error + step * spread**2 / (2 * least), np.inf)
    most = step * (np.linalg.norm(speed.mid, axis=0) + spread / 2)
    return np.array([np.maximum(length - error, 0), np.minimum(bent, most)])


def _legs(space: Lengths, controls: Controls, tau: Balls, order: int) -> tuple[Balls, Balls]:
    """The leg lengths at parameters of an arc; to order 1 their derivatives, too; of shape (3, …)."""
    point, slope = along(controls, tau)
    poses, lengths, speeds = space.on(point, order), [point[2]], [slope[2]]
    for leg in space.mechanism.free:
        square = poses.square(leg)
        low, high = square.value.ends()
        if not (low > 0).all():
            raise OpenError("a leg may have the length 0")
        low, high = np.sqrt(low) * (1 - 2.0**-50), np.sqrt(high) * (1 + 2.0**-50)
        lengths.append(Balls((low + high) / 2, (high - low) / 2 * (1 + 2.0**-50)))
        if order:
            change = (
                square.gradient[0] * slope[0] + square.gradient[1] * slope[1] + square.gradient[2] * slope[2]
            )
            speeds.append(change / (lengths[-1] * 2.0))
    size = np.zeros_like(tau.mid)
    return tuple(Balls.stacked([Balls(x.mid + size, x.rad + size) for x in row]) for row in (lengths, speeds))
