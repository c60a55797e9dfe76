"""Curves, components and regions against a raster of J, contoured by contourpy, without the solver.

Slices of all families and of random manipulators; a few run by default.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any

import contourpy
import numpy as np
import pytest
from numpy.typing import NDArray

from rpr_solver import EXAMPLES, Manipulator, PoseKind, SingularCurves, trace_slice
from tests.support.families import FAMILIES, family
from tests.support.oracle import free_legs_of, singularity
from tests.support.shared import eliminant_of

Array = NDArray[np.float64]

CASES = 200
DEFAULT = (5, 104)
NODES = {PoseKind.NODE, PoseKind.BEAK_TO_BEAK, PoseKind.QUADRUPLE, PoseKind.HIGHER, PoseKind.ISOLATED_POINT}
TOLERANCE = Fraction(1, 1000)


def case(number: int) -> tuple[Manipulator, int, Fraction]:
    """A manipulator, a leg and a length: each family and example in turn, and random manipulators."""
    random = Random(number)
    names = [*FAMILIES, *EXAMPLES]
    leg, length = random.choice((1, 2, 3)), Fraction(random.randint(20, 400), 10)
    if number < 100:
        name = names[number % len(names)]
        return (family(name) if name in FAMILIES else EXAMPLES[name]), leg, length
    a, b, c = (random.randint(-300, 300) for _ in range(3))
    d1, d2 = random.randint(50, 400), random.randint(50, 400)
    d3 = random.randint(abs(d1 - d2) + 1, d1 + d2 - 1)
    sides = [Fraction(x, 10) for x in (random.randint(50, 300), a, b or c or 1, d1, d2, d3)]
    return Manipulator(*sides, random.choice(("ccw", "cw"))), leg, length


class Raster:
    """A slice on a grid of α and θ, by the definition of the leg lengths alone."""

    def __init__(self, manipulator: Manipulator, leg: int, length: Fraction, size: int) -> None:
        self.legs = free_legs_of(manipulator, leg)
        self.length = float(length)
        # an odd offset, so that nothing special lies on the grid
        self.angles = -np.pi + 0.1234567 + np.arange(size + 1) * (2 * np.pi / size)
        self.j = self.at(*np.meshgrid(self.angles, self.angles))

    def at(self, alpha: Any, theta: Any) -> Any:
        """J / L at angles or arrays of them."""
        return singularity(self.legs, self.length, alpha, theta)

    def contours(self) -> list[Array]:
        """The lines J = 0 as arrays of (α, θ) in the square of the grid."""
        lines = contourpy.contour_generator(self.angles, self.angles, self.j).lines(0.0)
        return [np.asarray(line, dtype=np.float64) for line in lines]

    def joints(self, points: Array) -> Array:
        """The lengths of the free legs at poses."""
        bodies = [
            np.abs(self.length * np.exp(1j * points[:, 1]) + x * np.exp(1j * points[:, 0]) - a)
            for x, a in self.legs
        ]
        return np.stack(bodies, axis=1)

    def components(self) -> int:
        """The number of components of the contours on the torus: ends at opposite sides belong together."""
        lines = self.contours()
        above = list(range(len(lines)))

        def root(k: int) -> int:
            while above[k] != k:
                k = above[k]
            return k

        low, high = self.angles[0], self.angles[-1]
        ends = {}
        for k, line in enumerate(lines):
            for x, y in (line[0], line[-1]):
                name = tuple(low if abs(c - high) < 1e-12 else c for c in (x, y))
                key = round(float(name[0]), 9), round(float(name[1]), 9)
                if min(abs(name[0] - low), abs(name[1] - low)) < 1e-12:
                    if key in ends:
                        above[root(k)] = root(ends[key])
                    ends[key] = k
        return len({root(k) for k in range(len(lines))})


@pytest.mark.parametrize(
    "number", [pytest.param(n, marks=[] if n in DEFAULT else [pytest.mark.long]) for n in range(CASES)]
)
def test_curves_components_and_regions_are_those_of_a_raster(number: int) -> None:
    manipulator, leg, length = case(number)
    curves = trace_slice(eliminant_of(manipulator, leg), length, tolerance=TOLERANCE)
    raster = Raster(manipulator, leg, length, 400)
    lines = raster.contours()
    near = np.concatenate([distances(line[::5], curves) for line in lines]) if lines else np.zeros(1)
    assert np.quantile(near, 0.99) < 0.02
    if not {vertex.kind for vertex in curves.vertices} & NODES:
        wanted = len(curves.components)
        fine = (Raster(manipulator, leg, length, size).components() for size in (400, 1200, 3000))
        assert any(found == wanted for found in fine)
    regions_agree(curves, raster, lines, Random(number))


def distances(points: Array, curves: SingularCurves) -> Array:
    """The distances on the torus of points from the chords of the curves."""
    starts, ends = [], []
    for strand in curves.strands:
        angles = np.radians(np.stack([strand.alpha_deg, strand.theta_deg], axis=1))
        starts.append(angles[:-1])
        ends.append(angles[1:])
    a, b = np.concatenate(starts), np.concatenate(ends)
    chord = b - a
    square = np.maximum((chord**2).sum(axis=1), 1e-30)
    result = []
    for p in points:
        offset = (p - a + np.pi) % (2 * np.pi) - np.pi
        part = np.clip((offset * chord).sum(axis=1) / square, 0, 1)
        result.append(np.sqrt(((offset - part[:, None] * chord) ** 2).sum(axis=1)).min())
    return np.array(result)


def regions_agree(curves: SingularCurves, raster: Raster, lines: list[Array], random: Random) -> None:
    """At random joint vectors the region's number is twice the winding number of the contours about them."""
    images = [raster.joints(line) for line in lines]
    if not images:
        return
    everything = np.concatenate(images)
    high, extent = everything.max(axis=0), np.ptp(everything, axis=0).max()
    signs = [left_is_positive(line, raster) for line in lines]
    checked = 0
    for _ in range(40):
        p = np.array([random.uniform(0, high[0]), random.uniform(0, high[1])])
        if np.hypot(*(everything - p).T).min() < 0.03 * extent:
            continue
        winding = sum(sign * turns(image - p) for sign, image in zip(signs, images, strict=True))
        assert abs(winding - round(winding)) < 0.05
        holding = [r.poses for r in curves.regions if r.bounded and inside(r.rings, p)]
        assert sum(holding) == 2 * round(winding)
        checked += 1
    assert checked


def left_is_positive(line: Array, raster: Raster) -> int:
    """1 if J > 0 on the left of a contour, −1 if on its right."""
    k = int(np.argmax(np.hypot(*np.diff(line, axis=0).T)))
    (x, y), (dx, dy) = (line[k] + line[k + 1]) / 2, (line[k + 1] - line[k]) * 0.05
    values = []
    for side in (1, -1):
        alpha, theta = x - side * dy, y + side * dx
        slopes = []
        for m, a in raster.legs:
            turned = m * np.exp(1j * alpha)
            end = raster.length * np.exp(1j * theta) + turned - a
            slopes.append(((np.conj(end) * 1j * turned).real, (np.conj(end) * 1j * np.exp(1j * theta)).real))
        values.append(slopes[0][0] * slopes[1][1] - slopes[1][0] * slopes[0][1])
    return 1 if values[0] > values[1] else -1


def turns(offsets: Array) -> float:
    """The turns of a polyline about the origin; open ones meet at the sides of the square."""
    angles = np.unwrap(np.arctan2(offsets[:, 1], offsets[:, 0]))
    return float((angles[-1] - angles[0]) / (2 * np.pi))


def inside(rings: tuple[tuple[tuple[float, float], ...], ...], p: Array) -> bool:
    odd = False
    for ring in rings:
        for (ax, ay), (bx, by) in pairwise(ring):
            if (ay > p[1]) != (by > p[1]) and p[0] < ax + (p[1] - ay) / (by - ay) * (bx - ax):
                odd = not odd
    return odd
