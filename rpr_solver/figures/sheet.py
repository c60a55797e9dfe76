"""What all figures have: a title above, the geometry below, a description; words, numbers, scales and frames.

A scale leads from a quantity to pixels, with round numbers for ticks; a frame has two of them.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise
from math import floor, isinf, log10
from typing import Any

from rpr_solver.contract import LENGTHS
from rpr_solver.errors import InputError
from rpr_solver.notebook import Style, degenerate_words
from rpr_solver.notebook.scene import Box, Line, Paint, Path, Point, Scene, Shape, Text, rectangle
from rpr_solver.triangles import article_lengths

_STEPS = (Decimal(1), Decimal(2), Decimal(5), Decimal(10))


@dataclass(frozen=True)
class Scale:
    """A linear map of the values from ``low`` to ``high`` to pixels from ``start`` to ``stop``.

    >>> Scale(0, 10, 50, 150)(5)
    100.0
    """

    low: float
    high: float
    start: float
    stop: float

    def __call__(self, value: float) -> float:
        """The pixel of a value."""
        return self.start + (value - self.low) / (self.high - self.low) * (self.stop - self.start)

    def value(self, place: float) -> float:
        """The value at a pixel."""
        return self.low + (place - self.start) / (self.stop - self.start) * (self.high - self.low)


@dataclass(frozen=True)
class WidenedScale:
    """A map that is linear between neighbouring ``knots``, each of which has its own pixel in ``places``."""

    knots: tuple[float, ...]
    places: tuple[float, ...]

    @classmethod
    def of(cls, knots: Sequence[float], start: float, stop: float, least: float) -> WidenedScale:
        """The scale in which every interval has at least ``least`` pixels, and the others keep proportions.

        >>> WidenedScale.of([0, 90, 91, 100], 0, 100, 10).places
        (0, 80.0, 90.0, 100)
        """
        widths = [b - a for a, b in pairwise(knots)]
        room = stop - start
        least = min(least, room / max(len(widths), 1))
        narrow: set[int] = set()
        while True:
            wide = sum(w for k, w in enumerate(widths) if k not in narrow)
            free = room - least * len(narrow)
            more = {k for k, w in enumerate(widths) if k not in narrow and w * free < least * wide}
            if not more:
                break
            narrow |= more
        places = [start]
        for k, w in enumerate(widths):
            places.append(places[-1] + (least if k in narrow else w * free / wide))
        return cls(tuple(knots), (*places[:-1], stop))

    def __call__(self, value: float) -> float:
        """The pixel of a value."""
        k = min(max(bisect_right(self.knots, value), 1), len(self.knots) - 1)
        (a, b), (p, q) = self.knots[k - 1 : k + 1], self.places[k - 1 : k + 1]
        return p + (value - a) / (b - a) * (q - p)

    def is_widened(self, k: int) -> bool:
        """Whether an interval, counted from 0, is drawn at least twice as wide as in proportion."""
        share = (self.knots[k + 1] - self.knots[k]) / (self.knots[-1] - self.knots[0])
        return self.places[k + 1] - self.places[k] > 2 * share * (self.places[-1] - self.places[0])


def ticks(low: float, high: float, most: int) -> list[tuple[float, str]]:
    """Round values in a range, at most about ``most`` of them, each with its text.

    >>> ticks(0, 47, 5)
    [(0.0, '0'), (10.0, '10'), (20.0, '20'), (30.0, '30'), (40.0, '40')]
    >>> ticks(-0.003, 0.0061, 5)
    [(-0.002, '−0.002'), (0.0, '0'), (0.002, '0.002'), (0.004, '0.004'), (0.006, '0.006')]
    """
    step = _step((high - low) / max(most, 1))
    first = -floor(-Decimal(low) / step)
    values = []
    while (value := first * step) <= Decimal(high):
        values.append((float(value), _text(value, step)))
        first += 1
    return values


def angle_ticks(step: int = 60) -> list[tuple[float, str]]:
    """Ticks of an angle in degrees, from −180 to 180."""
    return [(float(n), f"{n}°".replace("-", "−")) for n in range(-180, 181, step)]


def _text(value: Decimal, step: Decimal) -> str:
    """A round number; with an exponent if it has many zeros."""
    far = step < Decimal("1e-5") or abs(value) >= Decimal("1e7")
    text = "0" if not value else f"{value.normalize():e}" if far else f"{value.normalize():f}"
    return text.replace("e+", "e").replace("-", "−")


def _step(least: float) -> Decimal:
    power = Decimal(10) ** floor(log10(least))
    return next(s * power for s in _STEPS if float(s * power) >= 0.999 * least)


Ticks = Sequence[tuple[float, str]]

GRID = Paint(stroke="faint", width=0.6)
EDGE = Paint(stroke="soft", width=1)
SMALL = 13.0
"""The size of the numbers at ticks."""


@dataclass(frozen=True)
class Frame:
    """A rectangle of the picture in which a plane is drawn, its second coordinate upwards.

    >>> frame = Frame.of(Box(50, 10, 450, 310), Box(0, 0, 40, 30))
    >>> frame.place((20, 0))
    (250.0, 310.0)
    """

    box: Box
    x: Scale
    y: Scale

    @classmethod
    def of(cls, box: Box, values: Box) -> Frame:
        """The frame in a box of the picture that shows a box of values."""
        return cls(
            box, Scale(values.x0, values.x1, box.x0, box.x1), Scale(values.y0, values.y1, box.y1, box.y0)
        )

    def place(self, point: Point) -> Point:
        """The place of a point in the picture."""
        return self.x(point[0]), self.y(point[1])

    def values(self, place: Point) -> Point:
        """The point of the plane at a place of the picture."""
        return self.x.value(place[0]), self.y.value(place[1])

    def line(self, points: Line) -> list[Point]:
        """The places of points."""
        return [self.place(point) for point in points]

    def shapes(
        self, x_title: str, y_title: str, x_ticks: Ticks | None = None, y_ticks: Ticks | None = None
    ) -> Iterator[Shape]:
        """Yields grid, edge, ticks and titles."""
        box = self.box
        across = ticks(self.x.low, self.x.high, max(int(box.width / 80), 4)) if x_ticks is None else x_ticks
        up = ticks(self.y.low, self.y.high, max(int(box.height / 60), 4)) if y_ticks is None else y_ticks
        columns = [(self.x(value), words) for value, words in across]
        rows = [(self.y(value), words) for value, words in up]
        grid = [
            *([(x, box.y0), (x, box.y1)] for x, _ in columns if box.x0 + 1 < x < box.x1 - 1),
            *([(box.x0, y), (box.x1, y)] for y, _ in rows if box.y0 + 1 < y < box.y1 - 1),
        ]
        yield Path(tuple(grid), GRID)
        yield rectangle(box, EDGE)
        for x, words in columns:
            yield Text((x, box.y1 + 15), words, SMALL, "soft", "middle")
        for y, words in rows:
            yield Text((box.x0 - 8, y), words, SMALL, "soft", "end")
        yield Text((box.centre[0], box.y1 + 38), x_title, 15, "ink", "middle")
        yield Text((box.x0 - 48, box.centre[1]), y_title, 15, "ink", "middle", turn=-90)


_NARROW = {**dict.fromkeys("ijl'|", 0.28), **dict.fromkeys(" .,:;!()[]ft-/r", 0.38)}
_WIDE = {**dict.fromkeys("mwMW@%", 0.97), **dict.fromkeys("+=<>−≤≥∞→≠±", 0.84)}
_WIDTHS = {**_NARROW, **_WIDE}
_CAPITAL, _USUAL = 0.72, 0.635


def width(words: str, size: float, *, bold: bool = False) -> float:
    """The width of a line of text in a wide sans-serif font, an upper bound."""
    ems = sum(_WIDTHS.get(c) or (_CAPITAL if c.isupper() else _USUAL) for c in words)
    return ems * size * (1.09 if bold else 1)


def box_of(text: Text) -> Box:
    """The box that a text fills, which must not be turned."""
    wide = width(text.words, text.size, bold=text.bold)
    left = text.at[0] - {"start": 0, "middle": wide / 2, "end": wide}[text.anchor]
    return Box(left, text.at[1] - 0.55 * text.size, left + wide, text.at[1] + 0.55 * text.size)


def short(text: str | float, digits: int = 4) -> str:
    """A number as a reader of a picture wants it, with few significant digits; all of its integer part.

    >>> short("28.012345"), short("-0.00012345"), short("1500"), short(0.5)
    ('28.01', '−0.0001234', '1500', '0.5')
    """
    value = Decimal(text) if isinstance(text, float) else exact(text)
    if value != 0 and not Decimal("1e-5") <= abs(value) < Decimal("1e7"):
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        shown = f"{mantissa}e{int(exponent)}"
    else:
        whole = max(value.adjusted() + 1, 0) if value else 1
        shown = f"{value:.{max(digits - whole, 0) if whole else digits - value.adjusted() - 1}f}"
        shown = shown.rstrip("0").rstrip(".") if "." in shown else shown
    return shown.replace("-", "−")


def number(text: str) -> float:
    """The float nearest to a number of a document: a decimal, a fraction or ``sqrt(…)``.

    Raises:
        InputError: it is too large for a picture.

    >>> number("46/4"), number("sqrt(2.25)")
    (11.5, 1.5)
    """
    value = float(text) if "/" not in text and "(" not in text else float(exact(text))
    if isinf(value):
        raise InputError.of(
            "geometry", f"{short(text)} is too large to be drawn; give lengths in a larger unit"
        )
    return value


def exact(text: str) -> Decimal:
    """A number of a document as a decimal, of any size."""
    sign, root, square = text.partition("sqrt(")
    if root:
        return exact(square[:-1]).sqrt().copy_sign(Decimal(f"{sign}1"))
    numerator, _, denominator = text.partition("/")
    return Decimal(numerator) / Decimal(denominator or 1)


_CAPTION_DIGITS, _LONGEST_ROOT = 6, 15
"""Digits of lengths in a caption, and the letters of a root that is not written in digits."""

WIDTH = 760.0
"""Of a figure on a page, in pixels."""

_TITLE, _CAPTION, _LINE = 18.0, 11.0, 14.0
_ABOVE, _BELOW = 36.0, 22.0
"""What a picture gets lower without its title, or without its caption."""


def sheet(
    style: Style,
    title: str,
    document: Mapping[str, Any],
    description: str,
    shapes: Iterable[Shape],
    size: Point,
    remark: str = "",
) -> Scene:
    """A picture of a document: its title, the geometry that it is about, and a remark above that.

    Args:
        style: how it is set; a caption longer than a line makes the picture higher.
        title: in one line.
        document: with its ``geometry``, and perhaps what is ``degenerate`` throughout.
        description: what is shown, for those who do not see it.
        shapes: the picture itself, from 40 pixels below the top.
        size: width and height of the picture with a caption in one line.
        remark: a line above the caption; that of what is degenerate takes its place.
    """
    (wide, height), geometry = size, document["geometry"]
    remark = _degenerate_remark(document) or remark
    around: list[Shape] = []
    if style.has_title:
        letters = min(_TITLE, _TITLE * (wide - 16) / width(title, _TITLE))
        around.append(Text((wide / 2, 24), title, letters, "ink", "middle"))
    if remark:
        at = (wide / 2, height - 28 + (0 if style.has_caption else 15))
        around.append(Text(at, remark, _CAPTION + 0.5, "ink", "middle"))
    lines = wrapped(_caption(geometry), wide - 16, _CAPTION) if style.has_caption else []
    around += [
        Text((wide / 2, height - 13 + _LINE * k), line, _CAPTION, "soft", "middle")
        for k, line in enumerate(lines)
    ]
    facts = f"{description}{_degenerate_facts(document)} Geometry: {caption_of(geometry)}."
    high = height + _LINE * (len(lines) - 1) if lines else height - _BELOW
    top = 0.0 if style.has_title else _ABOVE
    return Scene(wide, high, title, facts.strip(), (*shapes, *around), style, top)


def wrapped(items: Iterable[str], room: float, size: float) -> list[str]:
    """An enumeration in lines that are not longer than ``room``, unless an item is.

    >>> wrapped(["d1 = 17", "d2 = 16", "d3 = 20"], 120, 11)
    ['d1 = 17, d2 = 16,', 'd3 = 20']
    """
    lines: list[str] = []
    for item in items:
        if lines and width(f"{lines[-1]}, {item}", size) <= room:
            lines[-1] += f", {item}"
        else:
            lines.append(item)
    return [f"{line}," for line in lines[:-1]] + lines[-1:]


def swatches(items: Iterable[tuple[str, str]], centre: float, y: float, room: float) -> Iterator[Shape]:
    """A legend of colours in rows, the last one at ``y``: for each its role, and what it says."""
    for k, row in enumerate(reversed(_rows(items, room))):
        x = centre - sum(_swatch_width(words) for _, words in row) / 2
        for role, words in row:
            box = Box(x, y - 18 * k - 7, x + 16, y - 18 * k + 7)
            yield rectangle(box, Paint(role, "soft", 0.8))
            yield Text((x + 21, y - 18 * k), words, 12.5, "soft")
            x += _swatch_width(words)


def swatches_height(items: Iterable[tuple[str, str]], room: float) -> float:
    """How much higher a legend is than one row."""
    return 18.0 * (len(_rows(items, room)) - 1)


def _rows(items: Iterable[tuple[str, str]], room: float) -> list[list[tuple[str, str]]]:
    rows: list[list[tuple[str, str]]] = [[]]
    for item in items:
        if rows[-1] and sum(_swatch_width(words) for _, words in [*rows[-1], item]) > room:
            rows.append([])
        rows[-1].append(item)
    return rows


def _swatch_width(words: str) -> float:
    return 34 + width(words, 12.5)


def caption_of(geometry: Mapping[str, Any]) -> str:
    """The geometry in one line.

    >>> caption_of({"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84",
    ...             "orientation": "ccw"})
    'A2 = (15.91, 0), A3 = (0, 10), d1 = 17.04, d2 = 16.54, d3 = 20.84, ccw'
    """
    return ", ".join(_caption(geometry))


def _caption(geometry: Mapping[str, Any]) -> list[str]:
    known = article_lengths(geometry)
    a2x, a3x, a3y, d1, d2, d3 = (_length(known[name]) for name in LENGTHS)
    sides = f"d1 = {d1}", f"d2 = {d2}", f"d3 = {d3}"
    return [f"A2 = ({a2x}, 0)", f"A3 = ({a3x}, {a3y})", *sides, known["orientation"]]


def _length(text: str) -> str:
    """A length in few digits, or as a short root.

    >>> _length("-sqrt(75)"), _length("sqrt(1369/101)"), _length("sqrt(1234567.891)")
    ('−√75', '√(1369/101)', '1111.11')
    """
    if "(" not in text or len(text) > _LONGEST_ROOT:
        return short(text, _CAPTION_DIGITS)
    sign, _, square = text[:-1].partition("sqrt(")
    return f"{sign.replace('-', '−')}√{f'({square})' if '/' in square else square}"


def listed(words: Iterable[str]) -> str:
    """Words as an enumeration.

    >>> listed(["A", "B", "C"])
    'A, B and C'
    """
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def _degenerate_remark(document: Mapping[str, Any]) -> str:
    """What is degenerate throughout a census or its curves, in one short line.

    >>> curve = {"kind": "curve", "from": "0", "to": None, "equation": "alpha = 0 deg"}
    >>> _degenerate_remark({"degenerate": [curve, {"kind": "node", "from": "0", "to": "9", "count": 2}]})
    'Degenerate throughout: curve alpha = 0 deg, node'
    """
    names = dict.fromkeys(
        f"{part['kind']} {part.get('equation', '')}".strip() for part in document.get("degenerate", ())
    )
    return f"Degenerate throughout: {', '.join(names)}" if names else ""


def _degenerate_facts(document: Mapping[str, Any]) -> str:
    """The same in full, for the description of a picture."""
    words = [degenerate_words(part, document["fixed_leg"]) for part in document.get("degenerate", ())]
    return f" Degenerate: {'; '.join(words)}." if words else ""
