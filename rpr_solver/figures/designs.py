"""A design: what a search reached over its censuses, and those of the given geometry and of the best one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import Any

from rpr_solver.figures.axes import EDGE, SMALL, Frame, Scale, ticks
from rpr_solver.figures.sheet import WIDTH, number, sheet, short
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import Box, Disc, Group, Paint, Path, Point, Scene, Shape, Text
from rpr_solver.notebook.style import Style

_HEIGHT = 610.0
_LEFT, _RIGHT = 70.0, 30.0
_ROWS = (48.0, 196.0), (272.0, 388.0), (412.0, 528.0)
"""The heights of the search, of the given geometry and of the best one."""

_VALUES = {
    "longest-range": "longest part",
    "least-change": "change",
    "largest-margin": "margin",
    "most-cusps": "cusps",
}
_RADIUS = 4.5


@drawing
def design_figure(style: Style, document: Mapping[str, Any]) -> Scene:
    """Draws a design.

    Args:
        document: as :meth:`Design.to_json` gives it.
    """
    asked, best = document["asked"], document["best"]
    leg = f"L{document['fixed_leg']}"
    tables = document["start"]["census"], best["census"]
    across = _across(tables, asked["requirement"]["range"])
    most = max(part["count"] for table in tables for part in table["intervals"])
    wide = style.width or WIDTH
    trace, given, found = (Box(_LEFT, top, wide - _RIGHT, bottom) for top, bottom in _ROWS)
    shapes = [*_search(document, trace)]
    for box, name, table in zip((given, found), ("given", "best found"), tables, strict=True):
        rise = Scale(0, 1.2 * max(most, 4), box.y1, box.y0)
        frame = Frame(box, Scale(*across, box.x0, box.x1), rise)
        shapes += _census(frame, name, table["intervals"], asked["requirement"])
    x = Scale(*across, found.x0, found.x1)
    for value, words in ticks(*across, int(found.width / 70)):
        shapes += [
            Path(([(x(value), found.y1), (x(value), found.y1 + 5)],), EDGE),
            Text((x(value), found.y1 + 16), words, SMALL, "soft", "middle"),
        ]
    shapes.append(Text((found.centre[0], found.y1 + 36), style.axis(leg), 15, "ink", "middle"))
    met = "met" if best["met"] else "not met"
    title = f"Best found: {asked['objective']}, {short(best['value'], 6)} ({met})"
    said = "; ".join(f"{short(one['value'], 6)} at census {one['census']}" for one in document["trace"])
    note = f"Improvements: {said}. Search: {document['censuses']} censuses, stopped: {document['stopped']}."
    for name, table in zip(("given geometry", "best found"), tables, strict=True):
        note += f" Numbers of cusps by {leg} of the {name}: {_said(table['intervals'])}."
    return sheet(style, title, best["geometry"], note, shapes, (wide, _HEIGHT))


def _across(tables: Sequence[Mapping[str, Any]], span: Mapping[str, str | None]) -> tuple[float, float]:
    """The range of lengths; an open one ends beyond the last transition of both geometries."""
    start = number(span["from"] or "0")
    if span["to"] is not None:
        return start, number(span["to"])
    last = max(number(part["from"]) for table in tables for part in table["intervals"])
    return start, last + 0.12 * (last - start) if last > start else start + 1


def _search(document: Mapping[str, Any], box: Box) -> Iterator[Shape]:
    """The best value so far over the censuses, with a disc at each improvement."""
    steps = [(float(one["census"]), number(one["value"]), one["met"]) for one in document["trace"]]
    low, high = min(0.0, *(y for _, y, _ in steps)), max(y for _, y, _ in steps)
    frame = Frame.of(box, Box(0, low, max(document["censuses"], 1), high + 0.12 * (high - low or 1.0)))
    up = ticks(low, frame.y.high, 4)
    yield from frame.shapes("censuses", _VALUES[document["asked"]["objective"]], y_ticks=up)
    line: list[Point] = []
    for k, (x, y, _) in enumerate(steps):
        end = steps[k + 1][0] if k + 1 < len(steps) else float(document["censuses"])
        line += [(x, y), (end, y)]
    yield Path((frame.line(line),), Paint(stroke="curve", width=2.2))
    for x, y, is_met in steps:
        paint = Paint("curve", "paper", 1) if is_met else Paint("paper", "curve", 1.6)
        words = f"{short(y, 6)} at census {x:g}"
        yield Group((Disc(frame.place((x, y)), _RADIUS, paint),), words)
    if not all(is_met for *_, is_met in steps):
        words, y = "hollow: not in the whole range", box.y1 - 14
        yield Text((box.x1 - 10, y), words, SMALL, "soft", "end", halo="paper")


def _census(
    frame: Frame, name: str, intervals: Sequence[Mapping[str, Any]], requirement: Mapping[str, Any]
) -> Iterator[Shape]:
    """The number of cusps by length, true to scale, over what the requirement admits."""
    box = frame.box
    least = requirement["min_cusps"] or 0
    most = inf if requirement["max_cusps"] is None else requirement["max_cusps"]
    if least > 0 or most < inf:
        low, high = frame.y(max(least - 0.5, 0)), frame.y(min(most + 0.5, frame.y.high))
        yield Path((Box(box.x0, high, box.x1, low).corners,), Paint("poses4", opacity=0.45), closed=True)
    line = [
        frame.place((min(number(end or "1e300"), frame.x.high), part["count"]))
        for part in intervals
        for end in (part["from"], part["to"])
    ]
    yield Path((line,), Paint(stroke="curve", width=2.0))
    yield Path((box.corners,), EDGE, closed=True)
    for value, words in _even(frame.y.high):
        yield Text((box.x0 - 8, frame.y(value)), words, SMALL, "soft", "end")
    yield Text((box.x0 - 48, box.centre[1]), "cusps", 15, "ink", "middle", turn=-90)
    yield Text((box.x0 + 8, box.y0 + 13), name, SMALL, "ink", bold=True, halo="paper")


def _even(most: float) -> Iterator[tuple[float, str]]:
    step = 2 if most < 10 else 4
    yield from ((float(n), str(n)) for n in range(0, int(most) + 1, step))


def _said(intervals: Sequence[Mapping[str, Any]]) -> str:
    ends = [(part["count"], part["from"], part["to"]) for part in intervals]
    return "; ".join(f"{n} from {short(a, 6)} to {'∞' if b is None else short(b, 6)}" for n, a, b in ends)
