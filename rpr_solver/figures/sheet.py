"""What all pictures have: a title above, the geometry below, and a description for those who do not see."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rpr_solver.figures.figure import Figure
from rpr_solver.figures.scene import Scene, Shape, Text
from rpr_solver.figures.wording import short

WIDTH = 760.0
TITLE, CAPTION = 40.0, 26.0
"""The heights that a title and a caption take."""

_NAMES = ("a2x", "a3x", "a3y", "d1", "d2", "d3")


def sheet(
    title: str,
    geometry: Mapping[str, str],
    description: str,
    shapes: Iterable[Shape],
    height: float,
    width: float = WIDTH,
) -> Figure:
    """A figure with its title and the geometry that it is about."""
    caption = caption_of(geometry)
    around = (
        Text((width / 2, 24), title, 18, "ink", "middle"),
        Text((width / 2, height - 13), caption, 11, "soft", "middle"),
    )
    facts = f"{description} Geometry: {caption}."
    return Figure(Scene(width, height, title, facts.strip(), (*shapes, *around)))


def caption_of(geometry: Mapping[str, str]) -> str:
    """The geometry in one line.

    >>> caption_of({"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84",
    ...             "orientation": "ccw"})
    'A2 = (15.91, 0), A3 = (0, 10), d1 = 17.04, d2 = 16.54, d3 = 20.84, ccw'
    """
    a2x, a3x, a3y, d1, d2, d3 = (short(geometry[name], 6) for name in _NAMES)
    sides = f"d1 = {d1}, d2 = {d2}, d3 = {d3}"
    return f"A2 = ({a2x}, 0), A3 = ({a3x}, {a3y}), {sides}, {geometry['orientation']}"


def listed(words: Iterable[str]) -> str:
    """Words as an enumeration.

    >>> listed(["A", "B", "C"])
    'A, B and C'
    """
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last
