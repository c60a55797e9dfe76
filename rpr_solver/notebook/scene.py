"""What a figure consists of: points, polylines and a scene of few kinds of shapes, in pixels, y downwards.

Colours are roles such as ``"ink"`` or ``"cusp"``, which the palette turns into colours of a light or a dark
theme; one scene is written as SVG (svg.py) or drawn as PNG and PDF (export.py).

Hues are after Okabe and Ito, which colour-blind readers can distinguish; neighbouring areas differ in
lightness too, so that they stay apart in grey. Figures never distinguish by colour alone: areas and curves
are labelled, and marks differ in shape.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import hypot

from rpr_solver.notebook.tables import PIXELS_IN_MM, SCREEN, Style, Theme

Point = tuple[float, float]
Line = Sequence[Point]


@dataclass(frozen=True)
class Box:
    """A rectangle with sides parallel to the axes.

    >>> Box(0, 0, 4, 2).centre, Box(0, 0, 4, 2).grown(1)
    ((2.0, 1.0), Box(x0=-1, y0=-1, x1=5, y1=3))
    """

    x0: float
    y0: float
    x1: float
    y1: float

    @classmethod
    def around(cls, points: Iterable[Point]) -> Box:
        """The smallest box with all points, of which there is at least one."""
        xs, ys = zip(*points, strict=True)
        return cls(min(xs), min(ys), max(xs), max(ys))

    @property
    def width(self) -> float:
        """The horizontal side."""
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        """The vertical side."""
        return self.y1 - self.y0

    @property
    def centre(self) -> Point:
        """The centre."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    @property
    def corners(self) -> tuple[Point, Point, Point, Point]:
        """The corners, in turn."""
        return (self.x0, self.y0), (self.x1, self.y0), (self.x1, self.y1), (self.x0, self.y1)

    def grown(self, by: float) -> Box:
        """The box with a margin on every side; a negative one shrinks it."""
        return Box(self.x0 - by, self.y0 - by, self.x1 + by, self.y1 + by)

    def __contains__(self, point: Point) -> bool:
        return self.x0 <= point[0] <= self.x1 and self.y0 <= point[1] <= self.y1


def distance(a: Point, b: Point) -> float:
    """The distance of two points."""
    return hypot(b[0] - a[0], b[1] - a[1])


def between(a: Point, b: Point, share: float) -> Point:
    """The point at a share of the way from one point to another."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def off_segment(point: Point, a: Point, b: Point) -> float:
    """The distance of a point from a segment.

    >>> off_segment((0, 1), (-1, 0), (1, 0)), off_segment((4, 4), (0, 0), (1, 0))
    (1.0, 5.0)
    """
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    share = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / square if square else 0.0
    return distance(point, between(a, b, min(max(share, 0.0), 1.0)))


def area(ring: Line) -> float:
    """The area of a closed ring, positive if it runs clockwise in a picture.

    >>> area(Box(0, 0, 3, 2).corners), area(Box(0, 0, 3, 2).corners[::-1])
    (6.0, -6.0)
    """
    return sum(ring[k - 1][0] * ring[k][1] - ring[k][0] * ring[k - 1][1] for k in range(len(ring))) / 2


def simplified(line: Line, tolerance: float) -> list[Point]:
    """The polyline without points that are not needed within a tolerance (Douglas and Peucker).

    >>> simplified([(0, 0), (1, 0.01), (2, 0), (2, 2)], 0.1)
    [(0, 0), (2, 0), (2, 2)]
    """
    if len(line) < 3:
        return list(line)
    kept = {0, len(line) - 1}
    spans = [(0, len(line) - 1)]
    while spans:
        first, last = spans.pop()
        (ax, ay), (bx, by) = line[first], line[last]
        dx, dy = bx - ax, by - ay
        length = hypot(dx, dy)
        worst, at = tolerance, 0
        for k in range(first + 1, last):
            x, y = line[k]
            off = abs(dx * (y - ay) - dy * (x - ax)) / length if length else hypot(x - ax, y - ay)
            if off > worst:
                worst, at = off, k
        if at:
            kept.add(at)
            spans += [(first, at), (at, last)]
    return [line[k] for k in sorted(kept)]


def clipped(line: Line, box: Box) -> Iterator[list[Point]]:
    """Yields the pieces of a polyline that lie in a box.

    >>> list(clipped([(-1, 1), (3, 1), (3, 5)], Box(0, 0, 2, 2)))
    [[(0.0, 1.0), (2.0, 1.0)]]
    """
    piece: list[Point] = []
    for a, b in pairwise(line):
        inside = _inside(a, b, box)
        if inside is None:
            if piece:
                yield piece
            piece = []
            continue
        start, stop = inside
        if piece and start > 0:
            yield piece
            piece = []
        if not piece:
            piece = [between(a, b, start) if start else a]
        piece.append(between(a, b, stop) if stop < 1 else b)
        if stop < 1:
            yield piece
            piece = []
    if piece:
        yield piece


def _inside(a: Point, b: Point, box: Box) -> tuple[float, float] | None:
    """The shares of a segment between which it lies in a box (Liang and Barsky)."""
    start, stop = 0.0, 1.0
    dx, dy = b[0] - a[0], b[1] - a[1]
    for slope, room in (
        (-dx, a[0] - box.x0),
        (dx, box.x1 - a[0]),
        (-dy, a[1] - box.y0),
        (dy, box.y1 - a[1]),
    ):
        if slope == 0:
            if room < 0:
                return None
        elif slope < 0:
            start = max(start, room / slope)
        else:
            stop = min(stop, room / slope)
    return (start, stop) if start < stop else None


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


def rectangle(box: Box, paint: Paint) -> Path:
    """A box as a shape."""
    return Path((box.corners,), paint, closed=True)


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
        style: how it is set.
        top: the height at which the picture begins.
    """

    width: float
    height: float
    title: str
    description: str
    shapes: tuple[Shape, ...]
    style: Style = SCREEN
    top: float = 0.0

    @property
    def millimetres(self) -> Point:
        """Width and height in print."""
        return self.width / PIXELS_IN_MM, (self.height - self.top) / PIXELS_IN_MM


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


COLOURS: Mapping[str, tuple[str, str]] = {
    "paper": ("#ffffff", "#12171d"),
    "ink": ("#1b1f24", "#e9edf1"),
    "soft": ("#4c545d", "#b4bec8"),
    "faint": ("#c3cad1", "#47525d"),
    "ghost": ("#8b949e", "#7c8894"),
    "curve": ("#16324f", "#dbe8f4"),
    "cusp": ("#b8430b", "#ffa35c"),
    "mark": ("#0b6b50", "#4fd0a5"),
    "tint": ("#f1f3f5", "#1c232b"),
    # numbers of poses, from few to many
    "poses0": ("#ffffff", "#12171d"),
    "poses2": ("#e4eef7", "#1a2c3d"),
    "poses4": ("#b5d3ea", "#22506f"),
    "poses6": ("#7db2d8", "#2f6d94"),
    # aspects: J > 0 in blues, J < 0 in yellows
    "plus1": ("#a5cce8", "#1b4160"),
    "plus2": ("#6aa9d2", "#33709a"),
    "plus3": ("#d3e6f4", "#172f44"),
    "minus1": ("#fbe7b5", "#6b5415"),
    "minus2": ("#efc765", "#7c611a"),
    "minus3": ("#fdf4dc", "#3b3114"),
    # curves of cusps
    "line1": ("#0067b0", "#5ab4ec"),
    "line2": ("#c4480a", "#ff9a52"),
    "line3": ("#00795a", "#2fb98f"),
    "line4": ("#6d1a66", "#c98ab5"),
    "line5": ("#1b1f24", "#e9edf1"),
    # kinds of transitions
    "swallowtail": ("#0060a0", "#5ab4ec"),
    "beak": ("#b8430b", "#ff9a52"),
    "lips": ("#00795a", "#37c79c"),
}
"""Role → colour in the light and in the dark theme."""


def colour(role: str, theme: Theme) -> str:
    """The colour of a role; the light one if the theme is ``auto``."""
    return COLOURS[role][theme == "dark"]
