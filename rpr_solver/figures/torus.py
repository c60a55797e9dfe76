"""A slice on the torus of α and the fixed leg's angle: singular curves, aspects, cusps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import ceil, floor
from typing import Any

from rpr_solver.figures.axes import Frame
from rpr_solver.figures.figure import Figure
from rpr_solver.figures.labels import Room
from rpr_solver.figures.plane import Box, Line, Point, clipped, simplified
from rpr_solver.figures.scales import angle_ticks
from rpr_solver.figures.scene import Disc, Group, Paint, Path, Shape, Text
from rpr_solver.figures.sheet import WIDTH, sheet
from rpr_solver.figures.sign_areas import Area, areas
from rpr_solver.figures.slice_floats import Angles, SliceFloats
from rpr_solver.figures.strands import cusps_of, drawn, strands_of
from rpr_solver.figures.wording import box_of, letters, number, short, width

HEIGHT = 736.0
_PLOT = Box(86, 46, WIDTH - 40, HEIGHT - 108)
_CIRCLE = 6.5
_SHADES = 3


def torus_figure(document: Mapping[str, Any]) -> Figure:
    """Draws the singular curves of a slice on the torus of (α, θ), with its aspects coloured.

    Args:
        document: as :meth:`SingularCurves.to_json` gives it.
    """
    leg = document["fixed_leg"]
    length = document[f"l{leg}"]
    strands = strands_of(document)
    floats = SliceFloats.of(document["geometry"], leg, length)
    frame = Frame.of(_PLOT, Box(-180, -180, 180, 180))

    def place(pose: Angles) -> Point:
        return frame.place((pose[1], pose[0]))

    def sign(at: Point) -> int:
        theta, alpha = 360 * (at[0] - _PLOT.x0) / _PLOT.width, 360 * (_PLOT.y1 - at[1]) / _PLOT.height
        return 1 if floats.singular((alpha - 180, theta - 180))[0] > 0 else -1

    curves = [line for strand in strands for line in drawn(strand, floats, place)]
    turns = [
        place(strand.poses[vertex["index"]])[0]
        for strand in strands
        for vertex in strand.vertices
        if vertex["kind"] not in ("cusp", "closed-leg")
    ]
    aspects = areas(curves, turns, _PLOT, sign)
    lines = [piece for line in curves for piece in _wrapped(line, _PLOT)]
    cusps = [place((number(c["alpha_deg"]), number(c[f"theta{leg}_deg"]))) for c in cusps_of(strands)]
    room = Room(_PLOT.grown(-4))
    for line in lines:
        room.add_line(line)
    for x, y in cusps:
        room.add_box(Box(x - 8, y - 8, x + 8, y + 8))
    names = [room.near(cusp, letters(k), 15, 16, "cusp") for k, cusp in enumerate(cusps, 1)]
    shapes = [
        *(_shaded(area, role) for area, role in _roles(aspects)),
        *frame.shapes(f"θ{leg}", "α", angle_ticks(), angle_ticks()),
        Group((Path(tuple(simplified(x, 0.06) for x in lines), Paint(stroke="curve", width=1.7)),), "curves"),
        *_signs(aspects, room),
        *(
            Group((Disc(cusp, _CIRCLE, Paint(stroke="cusp", width=2)),), f"cusp {letters(k)}")
            for k, cusp in enumerate(cusps, 1)
        ),
        *names,
        *_legend(aspects),
    ]
    signs = [aspect["sign"] for aspect in document["aspects"]]
    numbers = {word: signs.count(sign) for word, sign in (("> 0", 1), ("< 0", -1))}
    counted = " and ".join(f"{n} with J {word}" for word, n in numbers.items())
    title = f"Aspects at L{leg} = {short(length, 8)}: {counted}"
    text = (
        f"Singular curves J = 0 in the plane of θ{leg} and α, both from −180° to 180°, opposite sides glued; "
        f"the areas between them are the aspects: {counted}. Circles: {len(cusps)} cusps."
    )
    return sheet(title, document["geometry"], text, shapes, HEIGHT)


def _roles(aspects: Sequence[Area]) -> Iterator[tuple[Area, str]]:
    """Yields each aspect with its colour: that of its sign, in shades for several."""
    seen = {1: 0, -1: 0}
    for area in aspects:
        shade = min(seen[area.sign], _SHADES - 1) + 1
        seen[area.sign] += 1
        yield area, f"{'plus' if area.sign > 0 else 'minus'}{shade}"


def _shaded(area: Area, role: str) -> Shape:
    name = f"aspect with J {'>' if area.sign > 0 else '<'} 0"
    rings = tuple([*_thinned(ring)] for ring in area.rings)
    return Group((Path(rings, Paint(role), closed=True),), name)


def _thinned(ring: Sequence[Point]) -> list[Point]:
    """A ring with fewer points, which keeps its first and its farthest corner."""
    half = len(ring) // 2
    return [*simplified(ring[:half], 0.2), *simplified(ring[half:], 0.2)]


def _wrapped(line: Line, box: Box) -> Iterator[list[Point]]:
    """Yields the pieces of a line brought back into the box by its sides."""
    extent = Box.around(line)
    across = range(floor((extent.x0 - box.x0) / box.width), ceil((extent.x1 - box.x0) / box.width))
    down = range(floor((extent.y0 - box.y0) / box.height), ceil((extent.y1 - box.y0) / box.height))
    for i in across:
        for k in down:
            moved = [(x - i * box.width, y - k * box.height) for x, y in line]
            yield from clipped(moved, box)


def _signs(aspects: Sequence[Area], room: Room) -> Iterator[Shape]:
    for area in aspects:
        text = Text(area.middle, "J > 0" if area.sign > 0 else "J < 0", 14, "ink", "middle")
        if room.is_free(box_of(text).grown(3)):
            room.add_box(box_of(text))
            yield text


def _legend(aspects: Sequence[Area]) -> Iterator[Shape]:
    items = [
        (role, f"J {'>' if area.sign > 0 else '<'} 0{'' if role.endswith('1') else ', another aspect'}")
        for area, role in _roles(aspects)
    ]
    shown = dict(items)
    x, y = _PLOT.centre[0] - sum(34 + width(words, 12.5) for words in shown.values()) / 2, HEIGHT - 44
    for role, words in shown.items():
        yield Path((Box(x, y - 7, x + 16, y + 7).corners,), Paint(role, "soft", 0.8), closed=True)
        yield Text((x + 21, y), words, 12.5, "soft")
        x += 34 + width(words, 12.5)
