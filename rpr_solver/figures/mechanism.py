"""The mechanism at a pose: base, platform and legs, other poses of the same legs behind it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from math import cos, hypot, radians, sin
from typing import Any

from rpr_solver.contract import LENGTHS
from rpr_solver.errors import InputError
from rpr_solver.figures.labels import OccupancyGrid, names_beside, near_one_of
from rpr_solver.figures.sheet import WIDTH, box_of, exact, number, sheet, short
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import (
    Box,
    Disc,
    Group,
    Paint,
    Path,
    Point,
    Scene,
    Shape,
    Text,
    between,
    distance,
    off_segment,
)
from rpr_solver.triangles import article_lengths

Triple = tuple[Point, Point, Point]


@dataclass(frozen=True)
class Triangles:
    """The two triangles of a manipulator.

    Attributes:
        base: A1, A2, A3.
        platform: B1, B2, B3 at α = 0, seen from B1.
        unit: the length that is 1 here, in the user's unit.
    """

    base: Triple
    platform: Triple
    unit: Decimal

    @classmethod
    def of(cls, geometry: Mapping[str, Any]) -> Triangles:
        """The triangles of the contract's geometry object."""
        known = article_lengths(geometry)
        lengths = [exact(known[name]) for name in LENGTHS]
        unit = Decimal(10) ** max(map(abs, lengths)).adjusted()
        a2x, a3x, a3y, d1, d2, d3 = (float(x / unit) for x in lengths)
        # where B1 and B2 are one, α is the direction of B1B3
        x = (d1 * d1 + d3 * d3 - d2 * d2) / (2 * d1) if d1 else d3
        y = max(d3 * d3 - x * x, 0.0) ** 0.5
        corner = (x, -y if known["orientation"] == "cw" else y)
        return cls(((0.0, 0.0), (a2x, 0.0), (a3x, a3y)), ((0.0, 0.0), (d1, 0.0), corner), unit)

    def length(self, text: str) -> float:
        """A length of a document in the unit of the triangles."""
        return float(exact(text) / self.unit)

    def placed(self, alpha: float, b1: Point) -> Triple:
        """The platform's points at a pose; α in degrees."""
        c, s = cos(radians(alpha)), sin(radians(alpha))
        p, q, r = ((b1[0] + c * x - s * y, b1[1] + s * x + c * y) for x, y in self.platform)
        return p, q, r

    def held(self, leg: int, length: float, alpha: float, theta: float) -> Point:
        """B1 at a pose that a leg gives: its length, and its angle; angles in degrees."""
        ax, ay = self.base[leg - 1]
        dx, dy = self.placed(alpha, (0.0, 0.0))[leg - 1]
        return ax + length * cos(radians(theta)) - dx, ay + length * sin(radians(theta)) - dy


_FRAME, _SHARE = 142.0, 0.55
_NARROW, _NARROW_SHARE = 480.0, 0.75
"""The height of the picture: that of title and caption, and a share of its width, larger if it is narrow."""
_ROD, _CYLINDER, _JOINT = 3.0, 9.0, 6.0
_SIDE = 60.0
"""The margin at the sides, for labels."""
_SHARES = (0.5, 0.4, 0.6, 0.3, 0.7)
"""Where along a leg its length is tried."""
_STEPS, _CLEAR = 12, 7.0
"""The grid of points inside a platform; how far a number in it is from all outlines, at least."""


@drawing
def geometry_figure(style: Style, geometry: Mapping[str, Any]) -> Scene:
    """Draws a manipulator without a pose: base and platform at α = 0 with a common centre."""
    shape = Triangles.of(geometry)
    (ax, ay), (bx, by) = (
        (sum(x for x, _ in ring) / 3, sum(y for _, y in ring) / 3) for ring in (shape.base, shape.platform)
    )
    platform = shape.placed(0.0, (ax - bx, ay - by))
    text = "Base A1A2A3 and platform B1B2B3 at α = 0 with a common centre, joined by three legs."
    return _sheet(style, "Manipulator at α = 0", geometry, text, (shape.base, [platform], 0, ()))


@drawing
def poses_figure(style: Style, document: Mapping[str, Any], pose: int = 1) -> Scene:
    """Draws one pose of a table of poses in full, and its other poses behind.

    Args:
        document: as :meth:`PoseTable.to_json` gives it.
        pose: the number of the pose from 1.

    Raises:
        InputError: naming ``pose``: the table has no such pose.
    """
    shape, table = Triangles.of(document["geometry"]), document["poses"]
    if not 1 <= pose <= len(table):
        there_are = f"give 1 to {len(table)}" if table else "these legs have no pose"
        raise InputError.of("pose", f"is {pose}; {there_are}")
    platforms = [
        shape.placed(number(p["alpha_deg"]), (shape.length(p["b1_x"]), shape.length(p["b1_y"])))
        for p in table
    ]
    legs = [document[f"l{k}"] for k in (1, 2, 3)]
    one = len(table) == 1
    title = "The only pose with these legs" if one else f"Pose {pose} of {len(table)} with these legs"
    others = "" if one else " The other poses with the same legs are drawn lightly, with their numbers."
    text = f"{_facts(table[pose - 1]['alpha_deg'], legs)}{others}"
    return _sheet(style, title, document["geometry"], text, (shape.base, platforms, pose - 1, legs))


@drawing
def point_figure(
    style: Style,
    geometry: Mapping[str, Any],
    fixed_leg: int,
    length: str,
    point: Mapping[str, str],
    title: str,
) -> Scene:
    """Draws a manipulator at a point of a slice, such as a cusp.

    Args:
        geometry: the contract's geometry object.
        fixed_leg: the leg with the fixed length.
        length: its length.
        point: the point with the names of documents, such as ``alpha_deg``, ``theta1_deg``, ``l2``, ``l3``.
        title: what is drawn.
    """
    shape, legs = Triangles.of(geometry), {**point, f"l{fixed_leg}": length}
    alpha, theta = number(point["alpha_deg"]), number(point[f"theta{fixed_leg}_deg"])
    platform = shape.placed(alpha, shape.held(fixed_leg, shape.length(length), alpha, theta))
    lengths = [legs[f"l{k}"] for k in (1, 2, 3)]
    facts = _facts(point["alpha_deg"], lengths)
    return _sheet(style, title, geometry, facts, (shape.base, [platform], 0, lengths))


def joint(at: Point) -> Disc:
    """A revolute joint."""
    return Disc(at, _JOINT, Paint("paper", "ink", 2))


def base_shapes(ring: Sequence[Point]) -> Iterator[Shape]:
    """Yields the base, with the ground below each joint."""
    yield Path((ring,), Paint("tint", "soft", 1.4, (6, 4)), closed=True)
    for x, y in ring:
        teeth = tuple([(x + d + 4, y + 15), (x + d - 2, y + 21)] for d in range(-9, 12, 6))
        yield Path(([(x, y), (x - 10, y + 15), (x + 10, y + 15)],), Paint("paper", "soft", 1.4), closed=True)
        yield Path(([(x - 14, y + 15), (x + 14, y + 15)], *teeth), Paint(stroke="soft", width=1.4))


def platform_shape(ring: Sequence[Point]) -> Shape:
    """The platform."""
    return Path((ring,), Paint("poses4", "line1", 2.4, opacity=0.6), closed=True)


def ghost_shapes(a: Sequence[Point], b: Sequence[Point]) -> Iterator[Shape]:
    """Yields the legs and the platform of another pose."""
    yield Path(tuple(zip(a, b, strict=True)), Paint(stroke="ghost", width=1, dash=(3, 3)))
    yield Path((b,), Paint("poses4", "ghost", 1.2, opacity=0.25), closed=True)


def leg_shapes(start: Point, stop: Point) -> Iterator[Shape]:
    """Yields a leg: the rod at the platform, and the cylinder at the base."""
    yield Path((bar(start, stop, _ROD),), Paint("ink"), closed=True)
    yield Path((bar(start, between(start, stop, 0.55), _CYLINDER),), Paint("tint", "ink", 1.4), closed=True)


def bar(start: Point, stop: Point, width: float) -> list[Point]:
    """The corners of a rectangle along a segment."""
    (x, y), (u, v) = start, stop
    length = hypot(u - x, v - y) or 1
    dx, dy = -(v - y) / length * width / 2, (u - x) / length * width / 2
    return [(x + dx, y + dy), (u + dx, v + dy), (u - dx, v - dy), (x - dx, y - dy)]


class View:
    """A map from the plane of the mechanism, with equal scales, to a box of the picture."""

    def __init__(self, points: Sequence[Point], box: Box) -> None:
        values = Box.around(points)
        self.scale = min(box.width / (values.width or 1), box.height / (values.height or 1))
        self._from, self._to = values.centre, box.centre

    def line(self, points: Sequence[Point]) -> list[Point]:
        """The places of points."""
        (x0, y0), (u0, v0), k = self._from, self._to, self.scale
        return [(u0 + k * (x - x0), v0 - k * (y - y0)) for x, y in points]


_Poses = tuple[Sequence[Point], Sequence[Sequence[Point]], int, Sequence[str]]
"""The base, the platforms of all poses, the number of the one drawn in full, the lengths of its legs."""


def _sheet(style: Style, title: str, geometry: Mapping[str, Any], text: str, poses: _Poses) -> Scene:
    wide = style.width or WIDTH
    high = _FRAME + (_SHARE if wide > _NARROW else _NARROW_SHARE) * wide
    shapes = _drawing(*poses, Box(0, 0, wide, high))
    return sheet(style, title, {"geometry": geometry}, text, shapes, (wide, high))


def _drawing(
    base: Sequence[Point],
    platforms: Sequence[Sequence[Point]],
    chosen: int,
    lengths: Sequence[str],
    whole: Box,
) -> list[Shape]:
    points = [*base, *(point for platform in platforms for point in platform)]
    side = _SIDE if whole.x1 > _NARROW else 0.6 * _SIDE
    view = View(points, Box(side, 70, whole.x1 - side, whole.y1 - 66))
    a, rings = view.line(base), [view.line(platform) for platform in platforms]
    b = rings[chosen]
    legs = list(zip(a, b, strict=True))
    return [
        *(
            Group(tuple(ghost_shapes(a, ring)), f"pose {k}")
            for k, ring in enumerate(rings, 1)
            if k != chosen + 1
        ),
        Group(tuple(base_shapes(a)), "base"),
        Group((platform_shape(b),), "platform"),
        *(Group(tuple(leg_shapes(*ends)), f"leg {k}") for k, ends in enumerate(legs, 1)),
        *(joint(point) for point in (*a, *b)),
        *_labels(a, rings, chosen, lengths, whole),
    ]


def _labels(
    a: Sequence[Point], rings: Sequence[Sequence[Point]], chosen: int, lengths: Sequence[str], whole: Box
) -> Iterator[Shape]:
    """Yields the numbers of poses, the names of joints and the lengths of legs, where they hide least."""
    b = rings[chosen]
    legs = list(zip(a, b, strict=True))
    bars = [bar(*leg, _CYLINDER + across) for leg in legs for across in (4, -4)]
    lines = (*bars, (*a, a[0]), *([*ring, ring[0]] for ring in rings))
    room = OccupancyGrid(Box(8, 44, whole.x1 - 8, whole.y1 - 28), lines)
    for x, y in a:
        room.add_box(Box(x - 14, y - 8, x + 14, y + 21))
    for point in b:
        room.add_point(point)
    for k in range(len(rings)) if len(rings) > 1 else ():
        yield from _number(k, rings, legs, room, "line1" if k == chosen else "soft")
    size = 16 if whole.x1 > _NARROW else 13
    named = [(point, f"{name}{k}") for name, ring in (("A", a), ("B", b)) for k, point in enumerate(ring, 1)]
    for (point, _), text in zip(named, names_beside(room, named, size, 13), strict=True):
        yield from _leader(point, text, 25)
        yield text
    for ring in rings:
        for line in _hatching(ring):
            room.add_line(line)
    yield from _lengths(legs, lengths, room)


def _lengths(
    legs: Sequence[tuple[Point, Point]], lengths: Sequence[str], room: OccupancyGrid
) -> Iterator[Shape]:
    """Yields the lengths of legs that are long enough, with a line to the leg if they are not beside it."""
    for k, ((p, q), length) in enumerate(zip(legs, lengths, strict=False), 1):
        if distance(p, q) > 30:
            along = [between(p, q, share) for share in _SHARES]
            text = near_one_of(room, along, f"L{k} = {short(length)}", 13, 12, "soft")
            near = min(along, key=lambda point: distance(point, text.at))
            yield from _leader(near, text, 20)
            yield text


def _number(
    k: int,
    rings: Sequence[Sequence[Point]],
    legs: Sequence[tuple[Point, Point]],
    room: OccupancyGrid,
    role: str,
) -> Iterator[Shape]:
    """Yields the number of a pose in a part of its platform that belongs to few others, or beside that."""
    edges = [*legs, *((ring[i - 1], ring[i]) for ring in rings for i in range(3))]
    others = [ring for i, ring in enumerate(rings) if i != k]
    words = f"{k + 1}"

    def worth(at: Point) -> tuple[int, bool, float]:
        shared = sum(_is_inside(at, ring) for ring in others)
        text = Text(at, words, 14, role, "middle", bold=True, halo="paper")
        is_clear = room.hidden(box_of(text)) == 0
        return -shared, is_clear, min(off_segment(at, *edge) for edge in edges)

    at = max(_grid(rings[k]), key=worth)
    text = Text(at, words, 14, role, "middle", bold=True, halo="paper")
    if worth(at)[2] < _CLEAR or room.hidden(box_of(text)):
        text = replace(room.near(at, words, 14, 14, role), halo="paper")
        yield Disc(at, 2, Paint(role))
        yield from _leader(at, text, 0)
    room.add_box(box_of(text))
    yield text


def _leader(at: Point, text: Text, least: float) -> Iterator[Shape]:
    """Yields a line from what a text is about to the text, if they are farther apart than ``least``."""
    box = box_of(text)
    end = min(max(at[0], box.x0), box.x1), min(max(at[1], box.y0), box.y1)
    if distance(at, end) > least:
        yield Path(([at, end],), Paint(stroke="soft", width=0.8))


def _grid(ring: Sequence[Point]) -> list[Point]:
    """Points inside a triangle."""
    (ax, ay), (bx, by), (cx, cy) = ring
    steps = [(i, k, _STEPS - i - k) for i in range(1, _STEPS) for k in range(1, _STEPS - i)]
    return [((i * ax + k * bx + n * cx) / _STEPS, (i * ay + k * by + n * cy) / _STEPS) for i, k, n in steps]


def _is_inside(point: Point, ring: Sequence[Point]) -> bool:
    x, y = point
    turns = [
        (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        for (ax, ay), (bx, by) in zip(ring, (*ring[1:], ring[0]), strict=True)
    ]
    return min(turns) > 0 or max(turns) < 0


def _hatching(ring: Sequence[Point]) -> Iterator[list[Point]]:
    """Yields lines that cover a triangle, for those who look for room."""
    a, b, c = sorted(ring, key=lambda point: point[1])
    steps = max(int((c[1] - a[1]) / 4), 1)
    for k in range(1, steps):
        y = a[1] + (c[1] - a[1]) * k / steps
        upper, lower = (a, b) if y < b[1] else (b, c)
        beside = between(upper, lower, (y - upper[1]) / ((lower[1] - upper[1]) or 1.0))
        yield [between(a, c, k / steps), beside]


def _facts(alpha: str, lengths: Sequence[str]) -> str:
    legs = ", ".join(f"L{k} = {short(length)}" for k, length in enumerate(lengths, 1))
    return f"Base A1A2A3, platform B1B2B3 at α = {short(alpha)}°, {legs}."
