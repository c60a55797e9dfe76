"""The census: the number of cusps against the length of the fixed leg; and designs, by their censuses.

Windows between transitions may be a millionth of the whole range. So the upper axis gives each of them a
width that can be seen, and a fan of lines leads from it to the axis below, which is true to scale. A design
shows what a search reached over its censuses, and those of the given geometry and of the best one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from rpr_solver.contract import LENGTHS
from rpr_solver.figures.sheet import (
    EDGE,
    SMALL,
    WIDTH,
    Frame,
    Scale,
    WidenedScale,
    number,
    sheet,
    short,
    ticks,
    width,
)
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import Box, Disc, Group, Paint, Path, Point, Scene, Shape, Text, rectangle
from rpr_solver.triangles import article_lengths

HEIGHT = 480.0
_AXIS = 398.0
_LEAST = 22.0
_APART = 13.5
"""The least distance of lengths above the plot."""

_KINDS = {"swallowtail": "swallowtail", "beak-to-beak": "beak", "lips": "lips"}


@drawing
def census_figure(style: Style, document: Mapping[str, Any]) -> Scene:
    """Draws a census.

    Args:
        document: as :meth:`Census.to_json` gives it.
    """
    wide = style.width or WIDTH
    plan = Plan.of(document, wide)
    counts = [interval["count"] for interval in document["intervals"]]
    transitions = document["transitions"]
    leg = f"L{document['fixed_leg']}"
    rise = Scale(0, 1.16 * max(*counts, 4), plan.plot.y1, plan.plot.y0)
    shapes = [
        *bands(plan),
        *_steps(plan, counts, rise),
        *_tolerance(plan, transitions),
        *fan(plan, style.axis(leg)),
        *marks(plan, [t["kind"] for t in transitions]),
        *legend({t["kind"] for t in transitions}, plan.plot),
    ]
    low, high = min(counts), max(counts)
    cusps = f"{low} cusps" if low == high else f"{low} to {high} cusps"
    windows = [
        f"{n} from {a} to {b}"
        for n, a, b in zip(counts, plan.labels, [*plan.labels[1:], "∞" if plan.is_open else ""], strict=False)
    ]
    note = f"Numbers of cusps by {leg}: {'; '.join(windows[: len(counts)])}."
    spans = [f"{t['from']} to {t['to']}" for t in transitions if t.get("from") is not None]
    if spans:
        note += (
            f" Shaded: where the transitions are for all geometries within the tolerance: {'; '.join(spans)}."
        )
    title = f"Number of cusps against {leg}: {cusps}"
    return sheet(style, title, document, note, shapes, (wide, HEIGHT))


@dataclass(frozen=True)
class Plan:
    """The horizontal scales: ``seen``, with widened windows, and ``true``; both across ``plot``."""

    plot: Box
    seen: WidenedScale
    true: Scale
    labels: tuple[str, ...]
    is_open: bool

    @classmethod
    def of(cls, document: Mapping[str, Any], wide: float = WIDTH) -> Plan:
        """The scales of a census in a picture of this width."""
        plot = Box(66, 160, wide - 30, 350)
        leg = f"l{document['fixed_leg']}"
        start, stop = (document["range"][end] for end in ("from", "to"))
        inner = [t[leg] for t in document["transitions"]]
        end = _end(document, number(start)) if stop is None else number(stop)
        knots = _apart([number(start), *map(number, inner), end])
        labels = _labels([start, *inner, *([] if stop is None else [stop])])
        return cls(
            plot,
            WidenedScale.of(knots, plot.x0, plot.x1, _LEAST),
            Scale(knots[0], knots[-1], plot.x0, plot.x1),
            labels,
            stop is None,
        )

    @property
    def inner(self) -> Sequence[tuple[float, float]]:
        """The places of the transitions, on both axes."""
        return [(self.seen(x), self.true(x)) for x in self.seen.knots[1:-1]]


def _end(document: Mapping[str, Any], start: float) -> float:
    """Where an open axis ends: beyond the last transition; without one, where it shows the size of the
    manipulator and what is degenerate."""
    known = [number(t[f"l{document['fixed_leg']}"]) for t in document["transitions"]]
    if not known:
        lengths = article_lengths(document["geometry"])
        sides = [abs(number(lengths[name])) for name in LENGTHS]
        ends = [number(part["to"]) for part in document.get("degenerate", ()) if part["to"] is not None]
        known = [start + max(sides), *ends]
    last = max(known)
    return last + 0.12 * (last - start)


def _apart(values: list[float]) -> list[float]:
    """Values that ascend: floats that coincide are moved by the least amount."""
    least = max(abs(values[-1]), 1e-300) * 1e-14
    for k in range(1, len(values)):
        values[k] = max(values[k], values[k - 1] + least)
    return values


def _labels(texts: Sequence[str]) -> tuple[str, ...]:
    """The lengths with enough digits to distinguish neighbours."""
    labels = []
    for k, text in enumerate(texts):
        beside = [texts[i] for i in (k - 1, k + 1) if 0 <= i < len(texts)]
        digits = next((n for n in range(4, 12) if short(text, n) not in {short(x, n) for x in beside}), 12)
        labels.append(short(text, digits))
    return tuple(labels)


def bands(plan: Plan) -> Iterator[Shape]:
    """The windows that are drawn wider than they are."""
    places = plan.seen.places
    for k in range(len(places) - 1):
        if plan.seen.is_widened(k):
            yield rectangle(Box(places[k], plan.plot.y0, places[k + 1], plan.plot.y1), Paint("tint"))


def _tolerance(plan: Plan, transitions: Sequence[Mapping[str, Any]]) -> Iterator[Shape]:
    """Where each transition is for all geometries within a tolerance, if the census has one."""
    for transition in transitions:
        if transition.get("from") is not None:
            low, high = (number(transition[end]) for end in ("from", "to"))
            first, *_, last = plan.seen.knots
            ends = plan.seen(max(low, first)), plan.seen(min(high, last))
            box = Box(ends[0], plan.plot.y0, ends[1], plan.plot.y1)
            yield rectangle(box, Paint("curve", opacity=0.25))


def _steps(plan: Plan, counts: Sequence[int], rise: Scale) -> Iterator[Shape]:
    places = plan.seen.places
    line: list[Point] = []
    for k, count in enumerate(counts):
        line += [(places[k], rise(count)), (places[k + 1], rise(count))]
    area = [(line[0][0], plan.plot.y1), *line, (line[-1][0], plan.plot.y1)]
    yield Path((area,), Paint("poses4", opacity=0.6), closed=True)
    levels = list(range(0, max(*counts, 2) + 1, 2 if max(counts) < 20 else 10))
    yield Path(
        tuple([(plan.plot.x0, rise(n)), (plan.plot.x1, rise(n))] for n in levels[1:]),
        Paint(stroke="faint", width=0.6),
    )
    yield rectangle(plan.plot, EDGE)
    yield Path((line,), Paint(stroke="curve", width=2.2))
    for n in levels:
        yield Text((plan.plot.x0 - 8, rise(n)), str(n), SMALL, "soft", "end")
    yield Text((plan.plot.x0 - 46, plan.plot.centre[1]), "cusps", 15, "ink", "middle", turn=-90)
    for k, count in enumerate(counts):
        middle, room = (places[k] + places[k + 1]) / 2, places[k + 1] - places[k]
        if room > width(str(count), 13) + 4:
            yield Text((middle, rise(count) - 11), str(count), 13, "ink", "middle", bold=True, halo="paper")


def fan(plan: Plan, leg: str) -> Iterator[Shape]:
    """The lines from the widened axis to the true one, and its ticks."""
    top, bottom = plan.plot.y1, _AXIS
    ends = [(plan.plot.x0, plan.plot.x0), *plan.inner, (plan.plot.x1, plan.plot.x1)]
    wide = [k for k in range(len(ends) - 1) if plan.seen.is_widened(k)]
    for k in wide:
        (a, p), (b, q) = ends[k : k + 2]
        yield Path(([(a, top), (b, top), (q, bottom), (p, bottom)],), Paint("tint"), closed=True)
    yield Path(tuple([(a, top), (p, bottom)] for a, p in plan.inner), Paint(stroke="ghost", width=0.7))
    yield Path(([(plan.plot.x0, bottom), (plan.plot.x1, bottom)],), EDGE)
    for value, words in ticks(plan.true.low, plan.true.high, int(plan.plot.width / 70)):
        x = plan.true(value)
        yield Path(([(x, bottom), (x, bottom + 5)],), EDGE)
        if not (plan.is_open and x > plan.plot.x1 - 24):
            yield Text((x, bottom + 16), words, SMALL, "soft", "middle")
    if plan.is_open:
        yield Path(
            ([(plan.plot.x1 - 7, bottom - 4), (plan.plot.x1, bottom), (plan.plot.x1 - 7, bottom + 4)],), EDGE
        )
        yield Text((plan.plot.x1, bottom + 16), "∞", 15, "soft", "middle")
    yield Text(((plan.plot.x0 + plan.plot.x1) / 2, bottom + 36), f"{leg}, true to scale", 14, "ink", "middle")


def marks(plan: Plan, kinds: Sequence[str]) -> Iterator[Shape]:
    """The transitions: a mark of each kind, and the length above it where there is room."""
    y, last = plan.plot.y0 - 12, -_APART
    labels = plan.labels[1:]
    for (x, _), kind, words in zip(plan.inner, kinds, labels, strict=False):
        yield Path(([(x, y), (x, plan.plot.y1)],), Paint(stroke="ghost", width=0.7, dash=(2, 3)))
        yield Group((mark(kind, (x, y)),), f"{kind} at {words}")
        if x >= last + _APART:
            yield Text((x + 3, y - 11), words, 11.5, "soft", turn=-58)
            last = x


def legend(kinds: set[str], plot: Box) -> Iterator[Shape]:
    """The marks of kinds of transitions, and what is shaded."""
    known = sum(36 + width(kind, SMALL) for kind in kinds)
    first = x = plot.x0 if plot.x0 + known < plot.x1 + 30 else 8
    y = 52 if x + known < plot.x1 + 46 else 45
    for kind in sorted(kinds, key=lambda kind: ([*_KINDS, kind].index(kind), kind)):
        if x + 17 + width(kind, SMALL) > plot.x1 + 28:
            x, y = first, y + 17
        yield mark(kind, (x + 6, y))
        yield Text((x + 17, y), kind, SMALL, "soft")
        x += 36 + width(kind, SMALL)
    words = "shaded: drawn wider than to scale"
    if kinds and x + 19 + width(words, SMALL) < plot.x1 + 30:
        yield rectangle(Box(x + 1, y - 6, x + 13, y + 6), Paint("tint", "ghost", 0.7))
        yield Text((x + 19, y), words, SMALL, "soft")


def mark(kind: str, at: Point, radius: float = 5.5) -> Shape:
    """The mark of a kind of transition: a triangle, a diamond, a disc, or a square for other kinds."""
    (x, y), r = at, radius
    paint = Paint(_KINDS.get(kind, "soft"), "paper", 1)
    if kind == "lips":
        return Disc(at, r * 0.85, paint)
    corners = {
        "swallowtail": [(x, y - r), (x + r, y + 0.8 * r), (x - r, y + 0.8 * r)],
        "beak-to-beak": [(x, y - r), (x + r, y), (x, y + r), (x - r, y)],
    }
    return Path((corners.get(kind, Box.around([at]).grown(0.7 * r).corners),), paint, closed=True)


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
    return sheet(style, title, best, note, shapes, (wide, _HEIGHT))


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
        yield rectangle(Box(box.x0, high, box.x1, low), Paint("poses4", opacity=0.45))
    line = [
        frame.place((min(number(end or "1e300"), frame.x.high), part["count"]))
        for part in intervals
        for end in (part["from"], part["to"])
    ]
    yield Path((line,), Paint(stroke="curve", width=2.0))
    yield rectangle(box, EDGE)
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
