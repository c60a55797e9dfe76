"""What all pictures have: a title above, the geometry below, and a description for those who do not see."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rpr_solver.figures.wording import short
from rpr_solver.notebook import degenerate_words
from rpr_solver.notebook.figure import Figure
from rpr_solver.notebook.scene import Scene, Shape, Text

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
    remark: str = "",
) -> Figure:
    """A figure with its title, the geometry that it is about, and a remark above that."""
    caption = caption_of(geometry)
    around = (
        Text((width / 2, 24), title, 18, "ink", "middle"),
        Text((width / 2, height - 13), caption, 11, "soft", "middle"),
        *([Text((width / 2, height - 28), remark, 11.5, "ink", "middle")] if remark else []),
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


def degenerate_remark(document: Mapping[str, Any]) -> str:
    """What is degenerate throughout a census or its curves, in one short line.

    >>> curve = {"kind": "curve", "from": "0", "to": None, "equation": "alpha = 0 deg"}
    >>> degenerate_remark({"degenerate": [curve, {"kind": "node", "from": "0", "to": "9", "count": 2}]})
    'Degenerate throughout: curve alpha = 0 deg, node'
    """
    names = dict.fromkeys(
        f"{part['kind']} {part.get('equation', '')}".strip() for part in document.get("degenerate", ())
    )
    return f"Degenerate throughout: {', '.join(names)}" if names else ""


def degenerate_facts(document: Mapping[str, Any]) -> str:
    """The same in full, for the description of a picture."""
    words = [degenerate_words(part, document["fixed_leg"]) for part in document.get("degenerate", ())]
    return f" Degenerate: {'; '.join(words)}." if words else ""
