"""The strands of singular curves, read from their document and refined until they are smooth where drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rpr_solver.contract import letter
from rpr_solver.figures.mechanism import Triangles
from rpr_solver.figures.words import number

_DEPTH = 12
_FINE, _LONG = 0.06, 15.0
"""The deviation of a drawn curve, and a chord that is halved in any case, in points."""

Places = Any
"""An array of points, one in a row."""


@dataclass(frozen=True)
class SliceFloats:
    """The map of a slice, (α, θ) → the lengths of the free legs, in floats; points are complex numbers.

    Attributes:
        length: of the fixed leg, in the unit of the triangles.
        moving: for each free leg its platform point and its base point, both seen from the fixed leg.
        unit: the unit of the triangles in the user's.
    """

    length: float
    moving: tuple[tuple[complex, complex], tuple[complex, complex]]
    unit: float

    @classmethod
    def of(cls, geometry: Mapping[str, Any], fixed_leg: int, length: str) -> SliceFloats:
        """The slice of a geometry with this leg at this length."""
        shape = Triangles.of(geometry)
        held = fixed_leg - 1
        first, second = (
            (shape.platform[k] - shape.platform[held], shape.base[k] - shape.base[held])
            for k in range(3)
            if k != held
        )
        return cls(shape.length(length), (first, second), float(shape.unit))

    def lengths(self, poses: Places) -> Places:
        """The lengths of the free legs at poses, in the user's unit."""
        return np.abs(np.stack([v for _, v in self._legs(poses)], axis=1)) * self.unit

    def singular(self, poses: Places) -> tuple[Any, Any, Any]:
        """J at poses, up to a constant factor, and its slopes by α and θ, in radians."""
        p = self.length * np.exp(1j * np.radians(poses[:, 1]))
        slopes = []
        for r, v in self._legs(poses):
            by_a, by_t = (v.conj() * 1j * r).real, (v.conj() * 1j * p).real
            twice_a = abs(r) ** 2 - (v.conj() * r).real
            twice_t = abs(p) ** 2 - (v.conj() * p).real
            slopes.append((by_a, by_t, twice_a, (p.conj() * r).real, twice_t))
        (f_a, f_t, f_aa, f_at, f_tt), (g_a, g_t, g_aa, g_at, g_tt) = slopes
        by_alpha = f_aa * g_t + f_a * g_at - f_at * g_a - f_t * g_aa
        by_theta = f_at * g_t + f_a * g_tt - f_tt * g_a - f_t * g_at
        return f_a * g_t - f_t * g_a, by_alpha, by_theta

    def onto_curve(self, poses: Places) -> Places:
        """The points of the singular curve near points that are almost on it."""
        for _ in range(2):
            value, a, t = self.singular(poses)
            square = a * a + t * t
            step = np.degrees(value / np.where(square == 0, np.inf, square))
            poses = poses - np.stack((step * a, step * t), axis=1)
        return poses

    def _legs(self, poses: Places) -> list[tuple[Any, Any]]:
        """For each free leg its turned platform point and its vector."""
        turn, p = np.exp(1j * np.radians(poses[:, 0])), self.length * np.exp(1j * np.radians(poses[:, 1]))
        return [(turn * platform, p + turn * platform - base) for platform, base in self.moving]


@dataclass(frozen=True)
class Strand:
    """A piece of a singular curve.

    Attributes:
        poses: α and θ at its samples, in degrees, continuous.
        sense: 1 if J > 0 on its left in the plane of α and θ, −1 if on its right.
    """

    poses: Places
    sense: int


@dataclass(frozen=True)
class SliceCurves:
    """The singular curves of a document, with their slice in floats.

    Attributes:
        leg: the fixed leg.
        floats: the slice.
        strands: of all components.
        cusps: their poses, in the order of the table.
        homes: for each cusp the number of its strand, and that of its sample.
        corners: the poses of other points where curves meet or turn sharply.
    """

    leg: int
    floats: SliceFloats
    strands: tuple[Strand, ...]
    cusps: Places
    homes: tuple[tuple[int, int], ...]
    corners: Places

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> SliceCurves:
        """The curves of a document of singular curves."""
        leg = document["fixed_leg"]
        theta = f"theta{leg}_deg"
        floats = SliceFloats.of(document["geometry"], leg, document[f"l{leg}"])
        strands: list[Strand] = []
        found: dict[int, tuple[int, int, list[float]]] = {}
        corners: list[list[float]] = []
        for strand in (strand for part in document["components"] for strand in part["strands"]):
            for vertex in strand["vertices"]:
                pose = [number(vertex["alpha_deg"]), number(vertex[theta])]
                if vertex["kind"] == "cusp":
                    found[vertex["cusp"]] = len(strands), vertex["index"], pose
                elif vertex["kind"] != "turning":
                    corners.append(pose)
            poses = np.column_stack((strand["alpha_deg"], strand[theta])).astype(float)
            strands.append(Strand(poses, _sense(floats, poses)))
        known = [found[name] for name in sorted(found)]
        return cls(
            leg,
            floats,
            tuple(strands),
            np.reshape([pose for *_, pose in known], (-1, 2)),
            tuple((k, index) for k, index, _ in known),
            np.reshape(corners, (-1, 2)),
        )

    @property
    def letters(self) -> list[str]:
        """The names of the cusps."""
        return [letter(k) for k in range(1, len(self.cusps) + 1)]

    def lines(
        self, place: Callable[[Places], Places], window: tuple[float, float, float, float] | None = None
    ) -> list[Places]:
        """The poses of strands, so many that polylines through them are smooth.

        Args:
            place: the places of poses in the picture, in points.
            window: left, below, right and above, in points; far outside it samples suffice. None: no limits.
        """
        return [self._refined(strand.poses, place, window) for strand in self.strands]

    def _refined(
        self,
        poses: Places,
        place: Callable[[Places], Places],
        window: tuple[float, float, float, float] | None,
    ) -> Places:
        """Chords that leave the curve are halved; it ends, since the depth is bounded."""
        for depth in range(_DEPTH):
            at = place(poses)
            p, q, a, b = poses[:-1], poses[1:], at[:-1], at[1:]
            chord = np.hypot(*(b - a).T)
            near = np.ones(len(p), dtype=bool)
            if window is not None:
                reach = (2 + 0.3 * chord)[:, None]
                low, high = np.minimum(a, b) - reach, np.maximum(a, b) + reach
                near = ((low < window[2:]) & (high > window[:2])).all(axis=1)
            k = np.flatnonzero(near)
            if not len(k):
                break
            middle = (p[k] + q[k]) / 2
            pose = self.floats.onto_curve(middle)
            sound = np.hypot(*(pose - middle).T) <= 0.5 * np.hypot(*(q[k] - p[k]).T)
            off = _off_chord(place(pose), a[k], b[k])
            split = sound & ((off > _FINE) | ((depth == 0) & (chord[k] > _LONG)))
            if not split.any():
                break
            poses = np.insert(poses, k[split] + 1, pose[split], axis=0)
        return poses


def _sense(floats: SliceFloats, poses: Places) -> int:
    """On which side of a strand J > 0; where its slope is largest, it is least in doubt."""
    if len(poses) < 2:  # an isolated point
        return 1
    step = np.diff(poses, axis=0)
    _, a, t = floats.singular((poses[1:] + poses[:-1]) / 2)
    size = np.hypot(*step.T)
    left = (step[:, 0] * t - step[:, 1] * a) / np.where(size == 0, 1.0, size)
    return 1 if left[np.argmax(np.abs(left))] > 0 else -1


def _off_chord(points: Places, a: Places, b: Places) -> Any:
    """The distances of points from segments."""
    d = b - a
    square = (d * d).sum(axis=1)
    share = ((points - a) * d).sum(axis=1) / np.where(square == 0, 1.0, square)
    return np.hypot(*(points - a - np.clip(share, 0, 1)[:, None] * d).T)
