"""A manipulator moved by its leg lengths, in floats and from the geometry alone, as a witness of paths."""

from __future__ import annotations

import cmath
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import hypot, pi, radians

from rpr_solver import FoldPoint, Manipulator, Path, PathPose, PathSample
from tests.support.triangle_oracle import corners_of

Two = tuple[float, float]
_STEP = 1e-6


@dataclass(frozen=True)
class Mover:
    """The corners of base and platform, with one leg fixed."""

    base: tuple[complex, complex, complex]
    platform: tuple[complex, complex, complex]
    fixed_leg: int

    @classmethod
    def of(cls, m: Manipulator, fixed_leg: int = 1) -> Mover:
        (a1, a2, a3), (b1, b2, b3) = (map(complex, corners) for corners in corners_of(m.geometry))
        return cls((a1, a2, a3), (b1, b2, b3), fixed_leg)

    def legs(self, alpha: float, theta: float, length: float) -> tuple[float, float, float]:
        """L1, L2, L3 at angles in radians."""
        fixed = self.fixed_leg - 1
        joint = self.base[fixed] + cmath.rect(length, theta)
        turn = cmath.rect(1, alpha)
        return tuple(  # type: ignore[return-value]
            abs(joint + turn * (b - self.platform[fixed]) - a)
            for a, b in zip(self.base, self.platform, strict=True)
        )

    def free(self, alpha: float, theta: float, length: float) -> Two:
        """The lengths of the two legs that are not fixed."""
        first, second = (x for i, x in enumerate(self.legs(alpha, theta, length), 1) if i != self.fixed_leg)
        return first, second

    def slopes(self, alpha: float, theta: float, length: float) -> tuple[Two, Two]:
        """∂/∂α and ∂/∂θ of the free legs, by differences."""
        rows = []
        for da, dt in ((_STEP, 0.0), (0.0, _STEP)):
            (a, b), (c, d) = (self.free(alpha + s * da, theta + s * dt, length) for s in (1, -1))
            rows.append(((a - c) / (2 * _STEP), (b - d) / (2 * _STEP)))
        return rows[0], rows[1]

    def determinant(self, alpha: float, theta: float, length: float) -> float:
        """∂(free legs)/∂(α, θ), divided by the fixed length."""
        (fa, ga), (ft, gt) = self.slopes(alpha, theta, length)
        return (fa * gt - ft * ga) / length

    def followed(self, start: Two, legs: Iterable[Sequence[float]]) -> Two:
        """Where Newton's method leads a pose while the legs take these lengths in turn."""
        alpha, theta = start
        others = [i for i in range(3) if i != self.fixed_leg - 1]
        for row in legs:
            length, goal = row[self.fixed_leg - 1], [row[i] for i in others]
            for _ in range(8):
                f, g = self.free(alpha, theta, length)
                (fa, ga), (ft, gt) = self.slopes(alpha, theta, length)
                det = fa * gt - ft * ga
                x, y = goal[0] - f, goal[1] - g
                alpha, theta = alpha + (x * gt - y * ft) / det, theta + (y * fa - x * ga) / det
                if hypot(x, y) < 1e-12 * length:
                    break
        return alpha, theta


def legs_of(sample: PathSample) -> tuple[float, float, float]:
    l1, l2, l3 = map(float, sample.lengths)
    return l1, l2, l3


def angles_of(pose: PathPose | PathSample | FoldPoint) -> Two:
    """α and θ in radians."""
    return radians(float(pose.alpha_deg)), radians(float(pose.theta_deg))


def apart(x: Two, y: Two) -> float:
    """The greater of two differences of angles."""
    return max(abs((a - b + pi) % (2 * pi) - pi) for a, b in zip(x, y, strict=True))


def turns(path: Path, centre: Two) -> float:
    """How often the free legs turn round a point, by the samples."""
    mover = Mover.of(path.manipulator, path.fixed_leg)
    plane = []
    for sample in path.samples:
        first, second = (x for i, x in enumerate(legs_of(sample), 1) if i != mover.fixed_leg)
        plane.append(complex(first, second) - complex(*centre))
    return sum(cmath.phase(b / a) for a, b in pairwise(plane)) / (2 * pi)


def arrives(path: Path, samples: int) -> float:
    """How far from its end a path leads that is followed by its leg lengths alone, in radians."""
    rows = [legs_of(sample) for sample in path.resampled(samples).samples]
    reached = Mover.of(path.manipulator, path.fixed_leg).followed(angles_of(path.start), rows)
    return apart(reached, angles_of(path.stop))
