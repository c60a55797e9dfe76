"""A slice on the torus of α and the fixed leg's angle: singular curves, aspects, cusps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

from rpr_solver.contract import letter
from rpr_solver.figures.axes import Frame, angle_ticks
from rpr_solver.figures.labels import OccupancyGrid, names_inside
from rpr_solver.figures.sheet import WIDTH, sheet, short, swatches, swatches_height
from rpr_solver.figures.strands import Angles, Projection, SliceCurves, cusp_marks, smooth
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import Box, Group, Line, Paint, Path, Point, Scene, clipped
from rpr_solver.notebook.style import Style

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

    aspects = [Area.of(aspect, f"theta{leg}_deg", place) for aspect in document["aspects"]]
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
    return sheet(style, title, document["geometry"], text, shapes, (wide, y + 44))


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

    @classmethod
    def of(cls, aspect: Mapping[str, Any], theta: str, place: Projection) -> Area:
        """The area of an aspect of the document."""
        rings = tuple(
            [place(pose) for pose in zip(polygon["alpha_deg"], polygon[theta], strict=True)]
            for polygon in aspect["polygons"]
        )
        return cls(aspect["sign"], rings)

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
