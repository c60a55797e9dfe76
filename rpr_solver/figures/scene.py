"""What a picture consists of: a scene of few kinds of shapes, in pixels, y downwards.

Colours are roles such as ``"ink"`` or ``"cusp"``, which the palette turns into colours of a light or a dark
theme; one scene is written as SVG (svg.py) or drawn as PNG and PDF (export.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rpr_solver.figures.plane import Box, Line, Point


@dataclass(frozen=True)
class Paint:
    """How a shape is painted; an empty role leaves it out.

    Attributes:
        fill: the role of the area's colour.
        stroke: the role of the outline's colour.
        width: the width of the outline.
        dash: lengths of dashes and gaps in turn.
        opacity: of the area.
    """

    fill: str = ""
    stroke: str = ""
    width: float = 1.0
    dash: tuple[float, ...] = ()
    opacity: float = 1.0


@dataclass(frozen=True)
class Path:
    """One or more polylines; ``closed`` ones bound an area, in which rings of the other sense are holes."""

    lines: tuple[Line, ...]
    paint: Paint
    closed: bool = False


@dataclass(frozen=True)
class Disc:
    """A circle."""

    centre: Point
    radius: float
    paint: Paint


@dataclass(frozen=True)
class Text:
    """A line of text.

    Attributes:
        at: the middle of the text's height, at its start, middle or end as ``anchor`` says.
        words: the text.
        size: the height of the font.
        role: the colour.
        anchor: ``"start"``, ``"middle"`` or ``"end"``.
        turn: the angle of the text in degrees, clockwise.
        bold: whether the font is bold.
        halo: the role of a border around the letters that keeps them legible on lines, or empty.
    """

    at: Point
    words: str
    size: float = 14
    role: str = "ink"
    anchor: str = "start"
    turn: float = 0
    bold: bool = False
    halo: str = ""


@dataclass(frozen=True)
class Motion:
    """A repeated motion.

    Attributes:
        places: of the shape at equal times, each (x, y, degrees clockwise, stretch along its own x).
        seconds: the time of one run.
    """

    places: tuple[tuple[float, float, float, float], ...]
    seconds: float


@dataclass(frozen=True)
class Group:
    """Shapes with something in common.

    Attributes:
        shapes: from the lowest to the uppermost.
        name: what they are, for screen readers and as a tip.
        clip: the box outside which they are not drawn.
        motion: how they move; without it, or where motion is not wanted, they stay at its first place.
    """

    shapes: tuple[Shape, ...]
    name: str = ""
    clip: Box | None = None
    motion: Motion | None = None


Shape = Path | Disc | Text | Group


@dataclass(frozen=True)
class Scene:
    """A picture.

    Attributes:
        width, height: in pixels.
        title: one line that says what it shows.
        description: what is in it, in sentences, for those who do not see it.
        shapes: from the lowest to the uppermost.
    """

    width: float
    height: float
    title: str
    description: str
    shapes: tuple[Shape, ...]


def roles(shapes: tuple[Shape, ...]) -> Iterator[tuple[str, str]]:
    """Yields each role that shapes use, as ``("fill", role)`` or ``("stroke", role)``, perhaps repeatedly."""
    for shape in shapes:
        if isinstance(shape, Group):
            yield from roles(shape.shapes)
        elif isinstance(shape, Text):
            yield "fill", shape.role
            if shape.halo:
                yield "stroke", shape.halo
        else:
            if shape.paint.fill:
                yield "fill", shape.paint.fill
            if shape.paint.stroke:
                yield "stroke", shape.paint.stroke
