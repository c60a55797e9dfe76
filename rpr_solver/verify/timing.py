"""Laws of time: which share of the arc length in joint space is covered after which share of the time
(mathematics.md#arc-lengths).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import cos, pi
from typing import TYPE_CHECKING

import numpy as np

from rpr_solver.boxes import Balls
from rpr_solver.verify.arcs import Controls, along
from rpr_solver.verify.claims import Open, demand
from rpr_solver.verify.equations import Lengths
from rpr_solver.verify.reader import Record
from rpr_solver.verify.work import Work

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
_STEPS, _ROUNDS = 16, 12
"""Each arc is cut in so many steps at first; steps of uncertain length are halved so many times at most."""
_ROUNDINGS = 1e-7
"""Far more than all roundings of sums in doubles."""


def keeps_time(space: Lengths, arcs: Sequence[Controls], members: Record, work: Work) -> str:
    """Proves that the samples of a path are where its law of time says.

    Raises:
        Open: it is not decided.
        Refused: one is elsewhere.
    """
    samples, law, duration = members["samples"], LAWS[members["timing"]], members["duration"]
    numbers = np.array([min(int(sample["place"]), len(arcs) - 1) for sample in samples])
    taus = np.array([float(x["place"] - int(n)) for x, n in zip(samples, numbers, strict=True)])
    goal = np.array([law(float(sample["time"] / duration)) for sample in samples])
    parts = [_Steps.of(space, controls, taus[numbers == n], work) for n, controls in enumerate(arcs)]
    for _ in range(_ROUNDS):
        before, covered = np.zeros(2), np.zeros((2, len(samples)))
        for n, part in enumerate(parts):
            own = numbers == n
            covered[:, own], before = (
                part.until(taus[own]) + before[:, None],
                part.until(np.ones(1))[:, 0] + before,
            )
        with np.errstate(all="ignore"):
            rest = before[:, None] - covered
            low, high = covered[0] / (covered[0] + rest[1]), covered[1] / (covered[1] + rest[0])
        demand(not ((high < goal - TOLERANCE) | (low > goal + TOLERANCE)).any(), "a sample is elsewhere")
        if (np.maximum(goal - low, high - goal) + _ROUNDINGS < TOLERANCE).all():
            return "the arc length between samples is bounded on steps of the arcs"
        steps = sum(len(part.nodes) for part in parts)
        parts = [part.refined(TOLERANCE * before[0] / (2 * steps), work) for part in parts]
    raise Open("it is not decided for a sample")


@dataclass(frozen=True)
class _Steps:
    """Steps of an arc with bounds of their lengths in joint space.

    Attributes:
        nodes: the parameters between them, from 0 to 1.
        bounds: the least and the greatest length of each, in units; of shape (2, steps).
    """

    space: Lengths
    controls: Controls
    nodes: Doubles
    bounds: Doubles

    @classmethod
    def of(cls, space: Lengths, controls: Controls, marks: Doubles, work: Work) -> _Steps:
        """Those of an arc, some marks being between steps."""
        nodes = np.unique(np.concatenate([np.linspace(0, 1, _STEPS + 1), marks]))
        work.spend(1 + len(nodes) // 8)
        return cls(space, controls, nodes, _lengths(space, controls, nodes))

    def until(self, marks: Doubles) -> Doubles:
        """Bounds of the length until some of the marks."""
        sums = np.cumsum(np.hstack([np.zeros((2, 1)), self.bounds]), 1)
        return sums[:, np.searchsorted(self.nodes, marks)]

    def refined(self, least: float, work: Work) -> _Steps:
        """The steps, those halved whose length is uncertain by more than this."""
        wide = self.bounds[1] - self.bounds[0] > least
        halves = (self.nodes[:-1] + self.nodes[1:])[wide] / 2
        return _Steps.of(self.space, self.controls, np.concatenate([self.nodes, halves]), work)


def _lengths(space: Lengths, controls: Controls, nodes: Doubles) -> Doubles:
    """Bounds of the arc length of an arc between parameters, which ascend.

    The mean of the derivative v of the leg lengths over a step is the chord over the step. If all v are
    within r of it, |v| is at most its component along the chord and r² over twice the least of these
    components.
    """
    step = np.diff(nodes)
    ends, _ = _legs(space, controls, Balls(nodes, np.full_like(nodes, 2.0**-50)), 0)
    _, speed = _legs(space, controls, Balls(nodes[:-1] + step / 2, step / 2 + 2.0**-50), 1)
    chord, error = np.diff(ends.mid), ends.rad[:, 1:] + ends.rad[:, :-1]
    length, error = np.linalg.norm(chord, axis=0), np.linalg.norm(error, axis=0)
    with np.errstate(all="ignore"):
        spread = 2 * np.linalg.norm(speed.rad, axis=0)
        least = (length - error) / step - spread
        bent = np.where(least > 0, length + error + step * spread**2 / (2 * least), np.inf)
        most = step * (np.linalg.norm(speed.mid, axis=0) + spread / 2)
    return np.array([np.maximum(length - error, 0), np.minimum(bent, most)])


def _legs(space: Lengths, controls: Controls, tau: Balls, order: int) -> tuple[Balls, Balls]:
    """The leg lengths at parameters of an arc; to order 1 their derivatives, too, of shape (3, …).

    The derivative of a leg that may have the length 0 is a ball with an infinite radius.
    """
    point, slope = along(controls, tau)
    poses, lengths, speeds = space.on(point, order), [point[2]], [slope[2]]
    for leg in space.mechanism.free:
        square = poses.square(leg)
        low, high = (
            np.sqrt(np.maximum(x, 0)) * (1 + e)
            for x, e in zip(square.value.ends(), (-(2.0**-50), 2.0**-50), strict=True)
        )
        lengths.append(Balls((low + high) / 2, (high - low) / 2 * (1 + 2.0**-50)))
        if order:
            first, second, third = (x * v for x, v in zip(square.gradient, slope, strict=True))
            speeds.append((first + second + third) / (lengths[-1] * 2.0))
    size = np.zeros_like(tau.mid)
    spread = [Balls.stacked([Balls(x.mid + size, x.rad + size) for x in row]) for row in (lengths, speeds)]
    return spread[0], spread[1]
