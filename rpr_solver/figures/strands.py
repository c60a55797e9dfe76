"""The strands of singular curves, read from their document and drawn smoothly at any magnification.

They are drawn in the joint plane, round loops, and here on the torus of α and the fixed leg's angle, with
aspects and cusps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, floor, hypot, radians, sin
from typing import Any

from rpr_solver.contract import letter
from rpr_solver.figures.labels import OccupancyGrid, names_inside
from rpr_solver.figures.mechanism import Triangles
from rpr_solver.figures.sheet import (
    WIDTH,
    Frame,
    angle_ticks,
    number,
    sheet,
    short,
    swatches,
    swatches_height,
)
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import (
    Box,
    Disc,
    Group,
    Line,
    Paint,
    Path,
    Point,
    Scene,
    clipped,
    distance,
    off_segment,
    simplified,
)

CIRCLE = 7.0
"""The radius of the circle round a cusp, thin so that the tip within it is seen."""
_DEGREE = 57.29577951308232

Angles = tuple[float, float]
"""α and the angle of the fixed leg, in degrees."""


_DEPTH = 10
_FINE = 0.1
"""The deviation of a drawn curve, in pixels."""

Projection = Callable[[Angles], Point]


@dataclass(frozen=True)
class SliceFloats:
    """The map of a slice, (α, θ) → the lengths of the free legs, in floats.

    Attributes:
        length: of the fixed leg, in the unit of ``shape``.
        moving: for each free leg its platform point and its base point, both seen from the fixed leg.
        unit: the unit of ``shape`` in the user's.
    """

    length: float
    moving: tuple[tuple[Point, Point], tuple[Point, Point]]
    unit: float

    @classmethod
    def of(cls, geometry: Mapping[str, Any], fixed_leg: int, length: str) -> SliceFloats:
        """The slice of a geometry with this leg at this length."""
        shape = Triangles.of(geometry)
        (bx, by), (ax, ay) = shape.platform[fixed_leg - 1], shape.base[fixed_leg - 1]
        first, second = (
            ((b[0] - bx, b[1] - by), (a[0] - ax, a[1] - ay))
            for k, (b, a) in enumerate(zip(shape.platform, shape.base, strict=True), 1)
            if k != fixed_leg
        )
        return cls(shape.length(length), (first, second), float(shape.unit))

    def lengths(self, pose: Angles) -> Point:
        """The lengths of the free legs, in the user's unit."""
        (_, _, x, y), (_, _, u, v), _ = self._vectors(pose)
        return hypot(x, y) * self.unit, hypot(u, v) * self.unit

    def singular(self, pose: Angles) -> tuple[float, float, float]:
        """J, up to a constant factor, and its slopes by α and θ, in radians."""
        (rx, ry, x, y), (sx, sy, u, v), (px, py) = self._vectors(pose)
        f_a, f_t = y * rx - x * ry, y * px - x * py
        g_a, g_t = v * sx - u * sy, v * px - u * py
        square = self.length * self.length
        f_aa, f_at, f_tt = rx * rx + ry * ry - x * rx - y * ry, px * rx + py * ry, square - x * px - y * py
        g_aa, g_at, g_tt = sx * sx + sy * sy - u * sx - v * sy, px * sx + py * sy, square - u * px - v * py
        return (
            f_a * g_t - f_t * g_a,
            f_aa * g_t + f_a * g_at - f_at * g_a - f_t * g_aa,
            f_at * g_t + f_a * g_tt - f_tt * g_a - f_t * g_at,
        )

    def onto_curve(self, pose: Angles) -> Angles:
        """The point of the singular curve near a point that is almost on it."""
        for _ in range(2):
            value, a, t = self.singular(pose)
            square = a * a + t * t
            if square == 0:
                break
            step = value / square * _DEGREE
            pose = pose[0] - step * a, pose[1] - step * t
        return pose

    def _vectors(
        self, pose: Angles
    ) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float], Point]:
        """For each free leg its turned platform point and its vector; and the vector of the fixed leg."""
        ca, sa = cos(radians(pose[0])), sin(radians(pose[0]))
        px, py = self.length * cos(radians(pose[1])), self.length * sin(radians(pose[1]))
        ((mx, my), (ax, ay)), ((nx, ny), (bx, by)) = self.moving
        rx, ry = ca * mx - sa * my, sa * mx + ca * my
        sx, sy = ca * nx - sa * ny, sa * nx + ca * ny
        return (rx, ry, px + rx - ax, py + ry - ay), (sx, sy, px + sx - bx, py + sy - by), (px, py)


@dataclass(frozen=True)
class Strand:
    """A piece of a singular curve.

    Attributes:
        poses: α and θ at its samples, in degrees, continuous.
        points: the lengths of the free legs there.
        vertices: the special points, as in the document, each with the ``index`` of its sample.
    """

    poses: tuple[Angles, ...]
    points: tuple[Point, ...]
    vertices: tuple[Mapping[str, Any], ...]


@dataclass(frozen=True)
class SliceCurves:
    """The singular curves of a document, with their slice in floats.

    Attributes:
        leg: the fixed leg.
        floats: the slice.
        strands: of all components.
        cusps: the vertices that are cusps, in the order of the table.
        aspects: as in the document.
    """

    leg: int
    floats: SliceFloats
    strands: tuple[Strand, ...]
    cusps: tuple[Mapping[str, Any], ...]
    aspects: tuple[Mapping[str, Any], ...]

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> SliceCurves:
        """The curves of a document of singular curves."""
        leg = document["fixed_leg"]
        floats = SliceFloats.of(document["geometry"], leg, document[f"l{leg}"])
        first, second = (f"l{k}" for k in (1, 2, 3) if k != leg)
        strands = tuple(
            Strand(
                tuple(zip(strand["alpha_deg"], strand[f"theta{leg}_deg"], strict=True)),
                tuple(zip(strand[first], strand[second], strict=True)),
                tuple(strand["vertices"]),
            )
            for component in document["components"]
            for strand in component["strands"]
        )
        cusps = {v["cusp"]: v for strand in strands for v in strand.vertices if v["kind"] == "cusp"}
        in_order = tuple(cusps[number] for number in sorted(cusps))
        return cls(leg, floats, strands, in_order, tuple(document.get("aspects", ())))

    @property
    def poses(self) -> list[Angles]:
        """The cusps, by their angles."""
        return [(number(cusp["alpha_deg"]), number(cusp[f"theta{self.leg}_deg"])) for cusp in self.cusps]

    def areas(self, place: Projection) -> list[Area]:
        """The aspects in a picture."""
        theta = f"theta{self.leg}_deg"
        return [
            Area(
                aspect["sign"],
                tuple(
                    [place(pose) for pose in zip(polygon["alpha_deg"], polygon[theta], strict=True)]
                    for polygon in aspect["polygons"]
                ),
            )
            for aspect in self.aspects
        ]

    @property
    def senses(self) -> list[int]:
        """For each strand 1 if J > 0 on its left in the plane of α and θ, −1 if on its right."""
        return [self._sense(strand.poses) for strand in self.strands]

    def _sense(self, poses: Sequence[Angles]) -> int:
        """Where the slope of J is largest, it is least in doubt."""
        best = 0.0
        for p, q in pairwise(poses):
            _, a, t = self.floats.singular(((p[0] + q[0]) / 2, (p[1] + q[1]) / 2))
            left = ((q[0] - p[0]) * t - (q[1] - p[1]) * a) / (distance(p, q) or 1.0)
            best = max(best, left, key=abs)
        return 1 if best > 0 else -1

    def lines(
        self, place: Projection, window: Box | None = None, places: Sequence[Sequence[Point]] | None = None
    ) -> list[list[Point]]:
        """The strands in a picture as polylines that are smooth at the picture's scale.

        Args:
            place: the place of a pose in the picture.
            window: a box of the picture; far outside it chords join the samples. None: all is smooth.
            places: those of the poses of each strand, if they are known.
        """
        return [
            self._drawn(strand, place, window, None if places is None else places[k])
            for k, strand in enumerate(self.strands)
        ]

    def _drawn(
        self, strand: Strand, place: Projection, window: Box | None, places: Sequence[Point] | None
    ) -> list[Point]:
        if places is None:
            places = [place(pose) for pose in strand.poses]
        line = [places[0]]
        for (p, q), (a, b) in zip(pairwise(strand.poses), pairwise(places), strict=True):
            is_near = window is None or _is_near(a, b, window)
            line += self._between((p, a), (q, b), place) if is_near else [b]
        return line

    def _between(
        self, first: tuple[Angles, Point], last: tuple[Angles, Point], place: Projection, depth: int = 0
    ) -> list[Point]:
        """The curve from one pose, with its place, to the next in the picture, without its start."""
        (p, a), (q, b) = first, last
        middle = (p[0] + q[0]) / 2, (p[1] + q[1]) / 2
        pose = self.floats.onto_curve(middle)
        if depth == _DEPTH or distance(pose, middle) > 0.5 * distance(p, q):
            return [b]
        at = pose, place(pose)
        if off_segment(at[1], a, b) < _FINE and (depth > 0 or distance(a, b) < 20):
            return [b]
        return [*self._between(first, at, place, depth + 1), *self._between(at, last, place, depth + 1)]


def _is_near(a: Point, b: Point, window: Box) -> bool:
    """Whether a chord may pass through a window; curves leave their chords by little of their lengths."""
    reach = 2 + 0.3 * distance(a, b)
    (ax, ay), (bx, by) = a, b
    return (
        min(ax, bx) - reach < window.x1
        and window.x0 < max(ax, bx) + reach
        and min(ay, by) - reach < window.y1
        and window.y0 < max(ay, by) + reach
    )


def cusp_mark(number: int, place: Point) -> Group:
    """The circle round a cusp, named by its letter."""
    return Group((Disc(place, CIRCLE, Paint(stroke="cusp", width=1.4)),), f"cusp {letter(number)}")


def cusp_marks(places: Sequence[Point]) -> list[Group]:
    """The circles round all cusps, in order."""
    return [cusp_mark(k, place) for k, place in enumerate(places, 1)]


def smooth(lines: Iterable[Sequence[Point]]) -> Path:
    """Singular curves as a shape."""
    return Path(tuple(simplified(line, 0.06) for line in lines), Paint(stroke="curve", width=1.7))


_LEFT, _TOP, _RIGHT = 86.0, 46.0, 40.0
_SHARE = 582 / 634
"""The height of the plot, by its width."""
_LEGEND = 64.0
_SHADES = 3


@drawing
def torus_figure(style: Style, document: Mapping[str, Any]) -> Scene:
    """Draws the singular curves of a slice on the torus of (α, θ), with its aspects coloured.

    Args:
        document: as :meth:`SingularCurves.to_json` gives it.
    """
    slice_curves = SliceCurves.of(document)
    leg, length = slice_curves.leg, document[f"l{slice_curves.leg}"]
    wide = style.width or WIDTH
    plot = Box(_LEFT, _TOP, wide - _RIGHT, _TOP + _SHARE * (wide - _LEFT - _RIGHT))
    frame = Frame.of(plot, Box(-180, -180, 180, 180))

    def place(pose: Angles) -> Point:
        return frame.place((pose[1], pose[0]))

    aspects = slice_curves.areas(place)
    lines = [piece for line in slice_curves.lines(place) for piece in _wrapped(line, plot)]
    cusps = [place(pose) for pose in slice_curves.poses]
    room = OccupancyGrid(plot.grown(-4), lines, cusps)
    names = [room.near(cusp, letter(k), 15, 16, "cusp") for k, cusp in enumerate(cusps, 1)]
    roles = list(_roles(aspects))
    legend = _legend(roles)
    y = plot.y1 + _LEGEND + swatches_height(legend.items(), wide - 16)
    shapes = [
        *(
            Group((Path(area.rings, Paint(role), closed=True),), f"aspect with {area.words}")
            for area, role in roles
        ),
        *frame.shapes(f"θ{leg}", "α", *(angle_ticks(60 if plot.width > 400 else 90) for _ in "xy")),
        Group((smooth(lines),), "curves"),
        *names_inside(((area.rings, area.words) for area in aspects), room, 40),
        *cusp_marks(cusps),
        *names,
        *swatches(legend.items(), plot.centre[0], y, wide - 16),
    ]
    counted = _counted([area.sign for area in aspects])
    title = f"Aspects at L{leg} = {short(length, 8)}: {counted}"
    text = (
        f"Singular curves J = 0 in the plane of θ{leg} and α, both from −180° to 180°, opposite sides glued; "
        f"the areas between them are the aspects: {counted}. Circles: {len(cusps)} cusps."
    )
    return sheet(style, title, document, text, shapes, (wide, y + 44))


def _counted(signs: Sequence[int]) -> str:
    numbers = {word: signs.count(sign) for word, sign in (("> 0", 1), ("< 0", -1))}
    return " and ".join(f"{n} with J {word}" for word, n in numbers.items())


def _legend(roles: Sequence[tuple[Area, str]]) -> dict[str, str]:
    return {role: f"{area.words}{'' if role.endswith('1') else ', another aspect'}" for area, role in roles}


@dataclass(frozen=True)
class Area:
    """An aspect in the picture: the sign of J, and rings that together cover it."""

    sign: int
    rings: tuple[Line, ...]

    @property
    def words(self) -> str:
        """The sign of J."""
        return "J > 0" if self.sign > 0 else "J < 0"


def _roles(aspects: Sequence[Area]) -> Iterator[tuple[Area, str]]:
    """Yields each aspect with its colour: that of its sign, in shades for several."""
    seen = {1: 0, -1: 0}
    for area in aspects:
        shade = min(seen[area.sign], _SHADES - 1) + 1
        seen[area.sign] += 1
        yield area, f"{'plus' if area.sign > 0 else 'minus'}{shade}"


def _wrapped(line: Line, box: Box) -> Iterator[list[Point]]:
    """Yields the pieces of a line brought back into the box by its sides."""
    extent = Box.around(line)
    across = range(floor((extent.x0 - box.x0) / box.width), ceil((extent.x1 - box.x0) / box.width))
    down = range(floor((extent.y0 - box.y0) / box.height), ceil((extent.y1 - box.y0) / box.height))
    for i in across:
        for k in down:
            moved = [(x - i * box.width, y - k * box.height) for x, y in line]
            yield from clipped(moved, box)
