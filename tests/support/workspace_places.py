"""Places of a document of a workspace, by its regions alone; and the same from the legs, in floats."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import atan2, cos, pi, radians, sin
from random import Random
from typing import Any

import numpy as np

from rpr_solver import InputError, Manipulator, Workspace
from rpr_solver.model.lengths import Bounds
from rpr_solver.triangles import read_geometry
from tests.support.triangle_spellings import drawn

SPECIAL = (0, 30, 45, 60, 90, -90, 120, 180, "36", "22.5")
BORDER = 1e-9
"""Places nearer to a border are not compared."""


def case(number: int, seed: int) -> tuple[Manipulator, Fraction, dict[int, Bounds]]:
    """A machine, an orientation and limits; every third one has roots, every fifth one is symmetric."""
    rng = Random(f"{seed} {number}")
    found = symmetric(rng) if number % 5 == 4 else exact(rng) if number % 3 == 1 else plain(rng)
    phi = Fraction(rng.choice(SPECIAL)) if rng.random() < 0.5 else Fraction(rng.randint(-18000, 18000), 100)
    size = max(map(float, (*found.geometry.base.squares, *found.geometry.platform.squares))) ** 0.5
    same = rng.random() < 0.3
    bounds: dict[int, Bounds] = {}
    for leg in (1, 2, 3):
        low, high = rng.uniform(0.1, 0.6), rng.uniform(0.7, 1.8)
        ends = Fraction(round(low * size * 4), 4), Fraction(round(high * size * 4) + 1, 4)
        bounds[leg] = (
            (ends[0] or None, ends[1]) if rng.random() < 0.9 or leg == 1 else (ends[0] or None, None)
        )
        if same:
            bounds[leg] = bounds[1]
    return found, phi, bounds


def plain(rng: Random) -> Manipulator:
    """One with six decimals."""
    while True:
        numbers = [rng.randint(1, 200) / 10 for _ in range(6)]
        names = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
        try:
            return Manipulator.from_json(
                {
                    **{k: str(x) for k, x in zip(names, numbers, strict=True)},
                    "orientation": rng.choice(("ccw", "cw")),
                }
            )
        except InputError:
            continue


def exact(rng: Random) -> Manipulator:
    """One by points, sides or roots."""
    while True:
        try:
            return Manipulator.of(read_geometry(drawn(rng)))
        except InputError:
            continue


def symmetric(rng: Random) -> Manipulator:
    """Equilateral or isosceles triangles, or a square grid of points."""
    kind = rng.randrange(4)
    if kind == 0:
        return Manipulator(base={"equilateral": 10}, platform={"equilateral": rng.randint(2, 9)})
    if kind == 1:
        base = {"points": [[-4, 0], [4, 0], [0, rng.randint(3, 8)]]}
        return Manipulator(base=base, platform={"points": [[-2, 0], [2, 0], [0, rng.choice((2, -2, 1))]]})
    if kind == 2:
        return Manipulator(base={"sides": [8, 5, 5]}, platform={"sides": [4, 3, 3]}, orientation="cw")
    return Manipulator(6, 3, 4, 4, "sqrt(5)", "sqrt(5)")


def drawn_places(found: Workspace, count: int, seed: int) -> np.ndarray[Any, Any]:
    """Random places over all regions and a margin beside them."""
    document = found.to_json()
    centres = legs_of(found)[0]
    leg, reach = min(
        ((leg, float(high)) for leg, (_, high) in found.limits.items() if high is not None),
        key=lambda x: x[1],
    )
    middle = complex(centres[leg - 1])
    xs = [float(vertex["x"]) for vertex in document["vertices"]] or [middle.real - reach, middle.real + reach]
    ys = [float(vertex["y"]) for vertex in document["vertices"]] or [middle.imag - reach, middle.imag + reach]
    rng = np.random.default_rng(seed)
    wide = rng.uniform(-1.05, 1.05, (count // 2, 2)) * reach + [middle.real, middle.imag]
    rest = count - count // 2
    near = np.column_stack([rng.uniform(min(xs), max(xs), rest), rng.uniform(min(ys), max(ys), rest)])
    return np.concatenate([wide, near])


def corners(found: Workspace) -> tuple[list[complex], list[complex]]:
    """The points of base and platform, each in its frame, in floats."""
    geometry = found.manipulator.geometry
    a2x, a3x, a3y, d1, d2, d3 = found.manipulator.doubles()
    x = (d1 * d1 + d3 * d3 - d2 * d2) / (2 * d1) if d1 else d3
    y = max(d3 * d3 - x * x, 0.0) ** 0.5 * (-1 if geometry.platform.sense == "cw" else 1)
    base, platform = [0j, complex(a2x), complex(a3x, a3y)], [0j, complex(d1), complex(x, y)]
    for triangle, own in ((geometry.base, base), (geometry.platform, platform)):
        if triangle.points is not None:
            own[:] = [complex(*(float(z.decimal(17)) for z in point)) for point in triangle.points]
    return base, platform


def legs_of(found: Workspace) -> tuple[list[complex], list[complex]]:
    """The places at which each leg has length 0, and the platform's points, turned."""
    base, platform = corners(found)
    turn = complex(cos(radians(found.phi)), sin(radians(found.phi)))
    turned = [turn * b for b in platform]
    return [a - b for a, b in zip(base, turned, strict=True)], turned


def by_legs(found: Workspace, places: np.ndarray[Any, Any]) -> tuple[Any, Any, Any]:
    """Whether places are allowed, the sign of J there, and whether they are too near to a border, by legs."""
    centres, turned = legs_of(found)
    p = places[:, 0] + 1j * places[:, 1]
    vectors = [p - c for c in centres]
    allowed, near = np.ones(len(p), dtype=bool), np.zeros(len(p), dtype=bool)
    for leg, (low, high) in found.limits.items():
        length = np.abs(vectors[leg - 1])
        for end, sign in ((low, 1), (high, -1)):
            if end is not None:
                allowed &= sign * (length - float(end)) >= 0
                near |= np.abs(length - float(end)) < BORDER
    rows = [np.stack([v.real, v.imag, (np.conj(r) * v).imag]) for v, r in zip(vectors, turned, strict=True)]
    matrix = np.stack(rows).transpose(2, 0, 1)
    size = np.prod(np.linalg.norm(matrix, axis=2), axis=1)
    det = -np.linalg.det(matrix)
    near |= np.abs(det) < BORDER * size
    return allowed, np.sign(det).astype(int), near


def by_regions(document: Mapping[str, Any], places: np.ndarray[Any, Any]) -> tuple[Any, Any]:
    """In how many regions places are, and the sign of J of the region, by rays to the right."""
    count, signs = np.zeros(len(places), dtype=int), np.zeros(len(places), dtype=int)
    for region in document["regions"]:
        crossed = np.zeros(len(places), dtype=int)
        for loop in region["boundary"]:
            for arc in loop:
                crossed += crossings(document, arc, places)
        inside = crossed % 2 == 1
        count += inside
        signs[inside] = region["sign"]
    return count, signs


def crossings(document: Mapping[str, Any], arc: Mapping[str, Any], places: np.ndarray[Any, Any]) -> Any:
    """How often the ray to the right of each place crosses an arc."""
    ends = [
        None
        if arc[name] is None
        else np.array([float(document["vertices"][arc[name] - 1][axis]) for axis in "xy"])
        for name in ("from", "to")
    ]
    if arc["on"] == "singular":
        return _of_conic(document, arc, ends, places)
    centre, radius = _circle(document, arc["on"].split()[0])
    above = places[:, 1] - centre.imag
    half = np.sqrt(np.maximum(radius**2 - above**2, 0.0))
    total = np.zeros(len(places), dtype=int)
    for side in (-1, 1):
        hit = (np.abs(above) < radius) & (centre.real + side * half > places[:, 0])
        if ends[0] is not None:
            first, last = ends if arc["ccw"] else ends[::-1]
            start = atan2(first[1] - centre.imag, first[0] - centre.real)
            sweep = (atan2(last[1] - centre.imag, last[0] - centre.real) - start) % (2 * pi)
            sweep = sweep or 2 * pi
            hit &= (np.arctan2(above, side * half) - start) % (2 * pi) < sweep
        total += hit
    return total


def _circle(document: Mapping[str, Any], name: str) -> tuple[complex, float]:
    """Centre and radius of the circle of a limit, from the document's geometry."""
    leg, end = name.split("_")
    geometry = document.get("points", {})
    machine = Manipulator.from_json(document["geometry"])
    if geometry:
        machine = Manipulator.of(machine.geometry.with_points(_points(geometry)))
    found = _Frame(machine, float(Fraction(document["phi_deg"])))
    return found.centre(int(leg[1]) - 1), float(Fraction(document["limits"][leg][end]))


def _points(given: Mapping[str, Any]) -> Any:
    return {name: tuple(tuple(point) for point in points) for name, points in given.items()}


class _Frame:
    """What :func:`legs_of` needs of a workspace."""

    def __init__(self, manipulator: Manipulator, phi: float) -> None:
        self.manipulator, self.phi = manipulator, phi

    def centre(self, number: int) -> complex:
        """Where a leg has length 0."""
        return legs_of(self)[0][number]  # type: ignore[arg-type]


def _of_conic(
    document: Mapping[str, Any], arc: Mapping[str, Any], ends: list[Any], places: np.ndarray[Any, Any]
) -> Any:
    a, b, c, d, e, f = (float(x) for x in document["conic"]["coefficients"].values())
    kind = document["conic"]["kind"]
    if "line" in kind:
        (x0, y0), (x1, y1) = ends
        between = (places[:, 1] > min(y0, y1)) & (places[:, 1] < max(y0, y1))
        slope = (x1 - x0) / ((y1 - y0) or 1.0)
        return (between & (x0 + (places[:, 1] - y0) * slope > places[:, 0])).astype(int)
    y = places[:, 1]
    square, middle, rest = a * np.ones(len(y)), b * y + d, c * y * y + e * y + f
    disc = middle**2 - 4 * square * rest
    root = np.sqrt(np.maximum(disc, 0.0))
    total = np.zeros(len(places), dtype=int)
    with np.errstate(divide="ignore", invalid="ignore"):
        if abs(a) < 1e-12 * max(map(abs, (b, c))):
            roots = [-rest / middle]
        else:
            far = -(middle + np.where(middle < 0, -root, root)) / 2
            roots = [far / square, rest / far]
    for x in roots:
        hit = (disc > 0) & np.isfinite(x) & (x > places[:, 0])
        if ends[0] is not None:
            through = np.array([float(arc["through"][axis]) for axis in "xy"])
            hit &= _side(ends, x, y) * _side(ends, *through) > 0
            if kind == "hyperbola":
                over = 4 * a * c - b * b
                m = np.array([(b * e - 2 * c * d) / over, (b * d - 2 * a * e) / over])
                u, v = through - m, np.stack([x - m[0], y - m[1]])
                own = a * u[0] ** 2 + b * u[0] * u[1] + c * u[1] ** 2
                form = a * u[0] * v[0] + b * (u[0] * v[1] + u[1] * v[0]) / 2 + c * u[1] * v[1]
                hit &= form * own > 0
        total += hit
    return total


def _side(ends: list[Any], x: Any, y: Any) -> Any:
    (x0, y0), (x1, y1) = ends
    return (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)


def failures(found: Workspace, count: int, seed: int) -> list[str]:
    """What differs between the regions of a workspace and its legs, at random places."""
    document = found.to_json()
    places = drawn_places(found, count, seed)
    allowed, sign, near = by_legs(found, places)
    inside, signs = by_regions(document, places)
    clear = ~near
    wrong = []
    for text, bad in (
        ("allowed, but in no region or in several", clear & allowed & (inside != 1)),
        ("in a region, but not allowed", clear & ~allowed & (inside > 0)),
        ("of another sign", clear & allowed & (inside == 1) & (signs != 0) & (signs != sign)),
    ):
        if bad.any():
            x, y = places[np.flatnonzero(bad)[0]]
            wrong.append(f"{bad.sum()} places {text}, such as {x}, {y}")
    areas = [float(region["area"]) for region in document["regions"]]
    if not np.isclose(sum(areas), sum(float(x) for x in document["area"].values()), rtol=1e-12):
        wrong.append("areas do not add up")
    return wrong
