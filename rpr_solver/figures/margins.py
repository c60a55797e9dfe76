"""How transitions move, and how far a design may be off: sensitivities, and margins over all lengths.

Both are drawn from a census with sensitivities (margins/systems.py). The curve of the margin is the
first-order estimate for the count of each slice, min |L − L*| / Σ |∂L*/∂g| over the transitions at L*; points
are radii that are proved.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import ceil, floor, inf, log10
from typing import Any

from rpr_solver.figures.census import HEIGHT, Plan, bands, fan, legend, mark, marks
from rpr_solver.figures.sheet import (
    EDGE,
    GRID,
    SMALL,
    WIDTH,
    Scale,
    number,
    sheet,
    short,
    width,
)
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import Box, Disc, Group, Paint, Path, Point, Scene, Shape, Text, rectangle

_LEFT, _TOP, _SPACE = 24.0, 74.0, 8.0
_PANEL, _ROW, _HEAD = Box(0, 0, 172, 156), 19.0, 30.0
_NAME, _VALUE = 32.0, 52.0
_SINGULAR = ("no simple transition:", "any change may", "resolve it; margin 0")

_NARROW = 620.0
_SAMPLES = 40
_DECADES_BELOW = 1.5
_MOST_DECADES = 10.0


@drawing
def sensitivities_figure(style: Style, document: Mapping[str, Any]) -> Scene:
    """Draws how fast each transition of a census moves with each length: bars, the longest first.

    Args:
        document: a census with sensitivities.
    """
    leg = f"l{document['fixed_leg']}"
    moving = [(t[leg], event) for t in document["transitions"] for event in t["events"]]
    wide = style.width or WIDTH
    columns = max(1, floor((wide - 2 * _LEFT + _SPACE) / (_PANEL.width + _SPACE)))
    rows = max(1, ceil(len(moving) / columns))
    shapes: list[Shape] = [*_signs(wide)]
    left = max(_LEFT, (wide - columns * (_PANEL.width + _SPACE) + _SPACE) / 2) if columns == 1 else _LEFT
    for k, (length, event) in enumerate(moving):
        corner = left + k % columns * (_PANEL.width + _SPACE), _TOP + k // columns * (_PANEL.height + _SPACE)
        shapes.append(Group(tuple(_panel(corner, leg.upper(), length, event)), _said(leg, length, event)))
    if not moving:
        shapes.append(Text((wide / 2, _TOP + _PANEL.height / 2), "no transitions", 15, "soft", "middle"))
    note = "; ".join(_said(leg, length, event) for length, event in moving)
    title = f"How {leg.upper()} of each transition moves with each length"
    height = _TOP + rows * (_PANEL.height + _SPACE) + 44
    facts = f"Sensitivities, sorted: {note or 'there are no transitions'}."
    return sheet(style, title, document, facts, shapes, (wide, height))


def _signs(wide: float) -> Iterator[Shape]:
    """The legend: what the colours and the lengths of bars mean."""
    x = _LEFT + 4
    up = "+ it moves up if the length grows" if wide > _NARROW else "+ it moves up"
    for role, words in (("lips", up), ("beak", "− it moves down")):
        yield rectangle(Box(x, 46, x + 14, 58), Paint(role))
        yield Text((x + 20, 52), words, SMALL, "soft")
        x += 44 + width(words, SMALL)
    if wide > _NARROW:
        yield Text((x, 52), "bars: to scale in each panel", SMALL, "soft")


def _panel(corner: Point, leg: str, length: str, event: Mapping[str, Any]) -> Iterator[Shape]:
    """One transition: its mark and length, and a bar for each length of the geometry."""
    x, y = corner
    box = Box(x, y, x + _PANEL.width, y + _PANEL.height)
    yield rectangle(box, Paint("", "faint", 1))
    yield mark(event["kind"], (x + 14, y + 16))
    yield Text((x + 26, y + 16), f"{leg} = {short(length, 6)}", SMALL, bold=True)
    if event.get("sensitivity") is None:
        for k, words in enumerate(_SINGULAR):
            yield Text((box.centre[0], y + 60 + 18 * k), words, SMALL, "soft", "middle")
        return
    slopes = _sorted(event["sensitivity"])
    longest = max((abs(slope) for _, slope in slopes if slope is not None), default=0.0) or 1.0
    bar = Scale(0, longest, x + _NAME + 6, x + _PANEL.width - _VALUE - 6)
    for k, (name, slope) in enumerate(slopes):
        middle = y + _HEAD + 13 + _ROW * k
        yield Text((x + _NAME, middle), name, SMALL, "ink", "end")
        if slope is None:
            yield Text((x + _NAME + 8, middle), "none", SMALL, "soft")
            continue
        own = Box(bar(0), middle - 6, max(bar(abs(slope)), bar(0) + 1), middle + 6)
        yield rectangle(own, Paint("lips" if slope > 0 else "beak"))
        words = ("+" if slope > 0 else "") + short(slope, 3)
        yield Text((box.x1 - 6, middle), words, 12, "ink", "end")


def _sorted(sensitivity: Mapping[str, str | None]) -> list[tuple[str, float | None]]:
    """The lengths, that which matters most first; those without a proved digit last."""
    slopes = [(name, None if text is None else number(text)) for name, text in sensitivity.items()]
    return sorted(slopes, key=lambda item: inf if item[1] is None else -abs(item[1]))


def _said(leg: str, length: str, event: Mapping[str, Any]) -> str:
    """A panel in words."""
    place = f"{event['kind']} at {leg.upper()} = {short(length, 6)}"
    if event.get("sensitivity") is None:
        return f"{place}: {' '.join(_SINGULAR)}"
    slopes = (f"{name} {short(x, 3)}" for name, x in _sorted(event["sensitivity"]) if x is not None)
    return f"{place}: {', '.join(slopes)}"


def first_order(document: Mapping[str, Any], length: float) -> float:
    """An estimate of the margin of the count of a slice, for equal weights; infinite if nothing moves.

    Args:
        document: a census of all lengths with sensitivities.
        length: of the fixed leg.
    """
    leg, radius = f"l{document['fixed_leg']}", inf
    for transition in document["transitions"]:
        if transition["count_before"] == transition["count_after"]:
            continue
        away = abs(length - number(transition[leg]))
        for event in transition["events"]:
            slopes = (event.get("sensitivity") or {}).values()
            reach = sum(abs(number(slope)) for slope in slopes if slope is not None)
            radius = min(radius, away / reach) if reach else radius
    return radius


def lengths_to_prove(document: Mapping[str, Any], span: Mapping[str, str | None], most: int) -> list[str]:
    """Lengths at which proved margins say most: in the widest windows of a range, where the estimate is
    largest; none if something is degenerate throughout, since the margin is 0 there.

    Args:
        document: a census of all lengths with sensitivities.
        span: the range, with ``from`` and ``to``.
        most: how many, at most.
    """
    if document.get("degenerate"):
        return []
    windows = _windows(_part(document, span))
    chosen = []
    for low, high in sorted(windows, key=lambda ends: ends[0] - ends[1])[:most]:
        inner = _between(low + (high - low) / 4, high - (high - low) / 4)
        best = max(inner, key=lambda x: first_order(document, x))
        for digits in range(3, 17):
            text = f"{best:.{digits}g}"
            if low < float(text) < high and "e" not in text:
                chosen.append(text)
                break
    return sorted(chosen, key=float)


@drawing
def margin_figure(
    style: Style,
    document: Mapping[str, Any],
    span: Mapping[str, str | None],
    margins: Sequence[Mapping[str, Any]],
) -> Scene:
    """Draws the margin of the number of cusps against the length of the fixed leg.

    Args:
        document: a census of all lengths with sensitivities.
        span: the range that is drawn, with ``from`` and ``to``.
        margins: those of some slices, as :meth:`Margin.to_json` gives them.
    """
    part = _part(document, span)
    wide = style.width or WIDTH
    plan, leg = Plan.of(part, wide), f"L{document['fixed_leg']}"
    degenerate = bool(document.get("degenerate"))
    curves = [] if degenerate else [_curve(document, low, high) for low, high in _windows(part)]
    known = [number(margin["proved"]) for margin in margins if margin["proved"] not in (None, "0")]
    rise = _rise([y for curve in curves for _, y in curve if 0 < y < inf], known, plan.plot)
    kinds = {t["kind"] for t in part["transitions"]}
    shapes = [
        *bands(plan),
        *_grid(rise, plan.plot),
        *_tents(plan, rise, curves),
        *fan(plan, style.axis(leg)),
        *marks(plan, [t["kind"] for t in part["transitions"]]),
        *legend(kinds, plan.plot),
        *_points(plan, rise, margins),
        *_key(plan.plot),
    ]
    if not any(_is_finite(curve) for curve in curves):
        words = "degenerate throughout: the margin is 0" if degenerate else "no transition moves"
        shapes.append(Text(plan.plot.centre, words, 16, "ink", "middle", halo="paper"))
    title = f"How far all lengths may be off before the number of cusps changes, by {leg}"
    facts = _facts(leg, plan, document, margins)
    return sheet(style, title, document, facts, shapes, (wide, HEIGHT + 26))


def _is_finite(curve: Sequence[Point]) -> bool:
    return any(0 < y < inf for _, y in curve)


def _part(document: Mapping[str, Any], span: Mapping[str, str | None]) -> dict[str, Any]:
    """The transitions within a range; only what is drawn of them."""
    leg = f"l{document['fixed_leg']}"
    low, high = number(span["from"] or "0"), inf if span["to"] is None else number(span["to"])
    inside = [t for t in document["transitions"] if low < number(t[leg]) < high]
    return {**document, "range": {"from": span["from"] or "0", "to": span["to"]}, "transitions": inside}


def _windows(part: Mapping[str, Any]) -> list[tuple[float, float]]:
    knots = Plan.of(part).seen.knots
    return list(pairwise(knots))


def _between(low: float, high: float) -> list[float]:
    """Lengths of a window, denser at its ends."""
    shares = ((2 * k + 1) / (2 * _SAMPLES) for k in range(_SAMPLES))
    return [low + (high - low) * share * share * (3 - 2 * share) for share in shares]


def _curve(document: Mapping[str, Any], low: float, high: float) -> list[Point]:
    return [(x, first_order(document, x)) for x in _between(low, high)]


def _rise(estimates: Sequence[float], known: Sequence[float], plot: Box) -> Scale:
    """The scale of logarithms of radii."""
    shown = [*estimates, *known] or [0.1]
    top = ceil(2 * log10(2 * max(shown))) / 2
    peaks = sorted(estimates) or [max(shown)]
    low = log10(peaks[len(peaks) // 20]) - _DECADES_BELOW / 3
    low = min(low, *(log10(x) - 0.3 for x in known)) if known else low
    return Scale(max(min(low, top - _DECADES_BELOW), top - _MOST_DECADES), top, plot.y1, plot.y0)


def _grid(rise: Scale, plot: Box) -> Iterator[Shape]:
    """Powers of ten."""
    powers = range(ceil(rise.low), floor(rise.high) + 1)
    step = ceil(len(powers) / 7) or 1
    for power in powers:
        y = rise(power)
        yield Path(([(plot.x0, y), (plot.x1, y)],), GRID)
        if power % step == 0:
            words = short(10.0**power) if power > -4 else f"1e{power}".replace("-", "−")
            yield Text((plot.x0 - 8, y), words, SMALL, "soft", "end")
    yield rectangle(plot, EDGE)
    yield Text((plot.x0 - 57, plot.centre[1]), "margin", 15, "ink", "middle", turn=-90)


def _tents(plan: Plan, rise: Scale, curves: Sequence[Sequence[Point]]) -> Iterator[Shape]:
    """The estimate in each window; at transitions it falls to 0, below the picture."""
    at_transitions = {x for x, _ in plan.inner}
    for k, curve in enumerate(curves):
        line = [
            (plan.seen(x), min(max(rise(log10(y)), plan.plot.y0), plan.plot.y1))
            for x, y in curve
            if 0 < y < inf
        ]
        if line:
            first, last = plan.seen.places[k : k + 2]
            start = [(first, plan.plot.y1 if first in at_transitions else line[0][1])]
            stop = [(last, plan.plot.y1 if last in at_transitions else line[-1][1])]
            yield Path((start + line + stop,), Paint(stroke="curve", width=2))


def _points(plan: Plan, rise: Scale, margins: Sequence[Mapping[str, Any]]) -> Iterator[Shape]:
    """What is proved, above the counter-examples, which may be very near."""
    for margin in margins:
        x = plan.seen(_length(margin))
        example = margin["counterexample"]
        if example:
            ring = _diamond((x, rise(log10(number(example["radius"])))))
            yield Group((ring,), f"counter-example: {example['radius']}")
        if margin["proved"] not in (None, "0"):
            y = rise(log10(number(margin["proved"])))
            yield Path(([(x, plan.plot.y1), (x, y)],), Paint(stroke="lips", width=1.2))
            yield Group((_disc((x, y)),), f"proved: {margin['proved']}")


def _disc(at: Point) -> Shape:
    return Disc(at, 4, Paint("lips", "paper", 0.8))


def _diamond(at: Point) -> Shape:
    (x, y), r = at, 8.0
    return Path(([(x, y + r), (x + r, y), (x, y - r), (x - r, y)],), Paint("paper", "beak", 1.6), closed=True)


def _length(margin: Mapping[str, Any]) -> float:
    return number(margin["asked"][f"l{margin['fixed_leg']}"])


def _key(plot: Box) -> Iterator[Shape]:
    """What curve and points mean."""
    words = "first order (an estimate)" if plot.width > _NARROW else "estimate"
    x, y = plot.x0 + (120 if plot.width > _NARROW else -44), HEIGHT - 22
    yield Path(([(x, y), (x + 18, y)],), Paint(stroke="curve", width=2))
    yield Text((x + 24, y), words, SMALL, "soft")
    x += 40 + width(words, SMALL)
    yield _disc((x, y))
    yield Text((x + 11, y), "proved", SMALL, "soft")
    x += 30 + width("proved", SMALL)
    yield _diamond((x, y))
    yield Text((x + 14, y), "counter-example", SMALL, "soft")


def _facts(leg: str, plan: Plan, document: Mapping[str, Any], margins: Sequence[Mapping[str, Any]]) -> str:
    """The picture in words."""
    if document.get("degenerate"):
        return f"The margin is 0 at every {leg}."
    said = [
        f"proved {margin['proved'] or 'nothing'} at {leg} = {short(_length(margin), 6)}" for margin in margins
    ]
    inner = ", ".join(plan.labels[1 : 1 + len(plan.inner)]) or "none"
    note = f"Transitions, where the margin is 0: {inner}. Between them the first-order estimate is drawn."
    return f"{note} {'; '.join(said)}." if said else note
