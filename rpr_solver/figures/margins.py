"""How transitions move, and how far a design may be off: sensitivities, and margins over all lengths.

Both are drawn from a census with sensitivities (margins/systems.py). The curve of the margin is the
first-order estimate for the count of each slice, min |L − L*| / Σ |∂L*/∂g| over the transitions at L*; points
are radii that are proved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import ceil, inf, log10
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rpr_solver.figures.census import HEIGHT, Plan, draw_mark, plan_of
from rpr_solver.figures.joint_plane import legend_below
from rpr_solver.figures.room import size_of
from rpr_solver.figures.words import BARE, figure_about, number, short
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import Figure

_PANEL, _GAP = np.array((128.0, 118.0)), 6.0
"""A panel of sensitivities, and what is between two."""
_BARS, _VALUES, _ROW = 26.0, 42.0, 14.5
"""In a panel: where bars begin, the room for their values, and the height of a row."""
_SINGULAR = ("no simple transition:", "any change may", "resolve it; margin 0")

_SAMPLES = 40
_DECADES, _MOST_DECADES = 1.5, 10.0


def sensitivities_figure(document: Mapping[str, Any]) -> Figure:
    """How fast each transition of a census moves with each length: bars, the longest first.

    Args:
        document: a census with sensitivities.
    """
    leg = f"l{document['fixed_leg']}"
    moving = [(t[leg], event) for t in document["transitions"] for event in t["events"]]

    def columns(wide: float) -> int:
        return max(int((wide + _GAP) // (_PANEL[0] + _GAP)), 1)

    def height(wide: float) -> float:
        return float(max(ceil(len(moving) / columns(wide)), 1) * (_PANEL[1] + _GAP))

    def paint(ax: Axes, style: Style) -> None:
        wide, high = size_of(ax)
        ax.set(xlim=(0, wide), ylim=(high, 0))
        ax.set_axis_off()
        count = columns(wide)
        start = (wide + _GAP - min(count, len(moving) or 1) * (_PANEL[0] + _GAP)) / 2
        for k, (length, event) in enumerate(moving):
            corner = np.array((start, 0)) + (_PANEL + _GAP) * (k % count, k // count)
            _draw_panel(ax, corner, f"{leg.upper()} = {short(length, 6)}", event, style)
        if not moving:
            ax.text(wide / 2, high / 2, "no transitions", size=11, ha="center", color=style.colour("soft"))
        said = (("lips", "+ it moves up if the length grows"), ("beak", "− it moves down"))
        legend_below(ax, [Patch(color=style.colour(role), label=words) for role, words in said], down=2)

    note = "; ".join(_said(leg, length, event) for length, event in moving)
    facts = f"Sensitivities, sorted; bars are to scale in each panel: {note or 'there are no transitions'}."
    title = f"How {leg.upper()} of each transition moves with each length"
    return figure_about(document, title, facts, paint, height, margins=BARE)


def _draw_panel(ax: Axes, corner: Any, words: str, event: Mapping[str, Any], style: Style) -> None:
    """One transition: its mark and length, and a bar for each length of the geometry."""
    x, y = corner
    ax.plot(
        *zip(*(corner + _PANEL * share for share in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))), strict=True),
        color=style.colour("faint"),
        lw=0.75,
    )
    draw_mark(ax, corner + np.array((10, 12)), event["kind"], style)
    ax.text(x + 19, y + 12, style.words(words), size=9.5, weight="bold", va="center")
    soft = {"size": 9, "va": "center", "color": style.colour("soft")}
    if event.get("sensitivity") is None:
        for k, line in enumerate(_SINGULAR):
            ax.text(x + _PANEL[0] / 2, y + 44 + 14 * k, line, ha="center", **soft)
        return
    slopes = _sorted(event["sensitivity"])
    longest = max((abs(slope) for _, slope in slopes if slope is not None), default=0.0) or 1.0
    room = _PANEL[0] - _BARS - _VALUES
    for k, (name, slope) in enumerate(slopes):
        middle = y + 32 + _ROW * k
        ax.text(x + _BARS - 4, middle, style.words(name), size=9.5, ha="right", va="center")
        if slope is None:
            ax.text(x + _BARS + 2, middle, "none", **soft)
            continue
        long = max(room * abs(slope) / longest, 0.75)
        ax.barh(middle, long, 9, x + _BARS, color=style.colour("lips" if slope > 0 else "beak"))
        ax.text(
            x + _PANEL[0] - 4,
            middle,
            ("+" if slope > 0 else "") + short(slope, 3),
            size=9,
            ha="right",
            va="center",
        )


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
    windows = pairwise(plan_of(document, span).knots)
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


def margin_figure(
    document: Mapping[str, Any], span: Mapping[str, str | None], margins: Sequence[Mapping[str, Any]]
) -> Figure:
    """The margin of the number of cusps against the length of the fixed leg.

    Args:
        document: a census of all lengths with sensitivities.
        span: the range that is drawn, with ``from`` and ``to``.
        margins: those of some slices, as :meth:`Margin.to_json` gives them.
    """
    plan, leg = plan_of(document, span), f"L{document['fixed_leg']}"
    curves = (
        []
        if document.get("degenerate")
        else [
            [(x, y) for x in _between(low, high) if 0 < (y := first_order(document, x)) < inf]
            for low, high in pairwise(plan.knots)
        ]
    )
    proved = [(_length(m), number(m["proved"])) for m in margins if m["proved"] not in (None, "0")]
    against = [(_length(m), number(m["counterexample"]["radius"])) for m in margins if m["counterexample"]]

    def paint(ax: Axes, style: Style) -> None:
        ax.set_yscale("log")
        ax.grid(visible=True, axis="y")
        ax.yaxis.set_major_formatter(
            lambda y, _: short(y) if y > 2e-4 else f"1e{round(log10(y))}".replace("-", "−")
        )
        ax.set_ylim(*_rise([y for curve in curves for _, y in curve], [y for _, y in proved]))
        estimate = Line2D([], [], color=style.colour("curve"), lw=1.5, label="first order (an estimate)")
        for k, curve in enumerate(curves):
            ends = [plan.knots[k]] * (k > 0), [plan.knots[k + 1]] * (k + 1 < len(curves))
            x = [*ends[0], *(x for x, _ in curve), *ends[1]]
            y = [*(1e-300 for _ in ends[0]), *(y for _, y in curve), *(1e-300 for _ in ends[1])]
            if curve:
                ax.plot(x, y, color=style.colour("curve"), lw=1.5)
        paper = style.colour("paper")
        ring = {"ls": "", "marker": "D", "ms": 8, "mfc": paper, "mec": style.colour("beak"), "mew": 1.2}
        disc = {"ls": "", "marker": "o", "ms": 6, "mfc": style.colour("lips"), "mec": paper, "mew": 0.6}
        ax.plot(*np.reshape(against, (-1, 2)).T, zorder=3, **ring)
        ax.vlines([x for x, _ in proved], 1e-300, [y for _, y in proved], color=style.colour("lips"), lw=0.9)
        ax.plot(*np.reshape(proved, (-1, 2)).T, zorder=4, **disc)
        ax.set_ylabel("margin")
        marks = [
            Line2D([], [], label=words, **look)
            for words, look in (("proved", disc), ("counter-example", ring))
        ]
        plan.paint(ax, style, leg, [estimate, *marks])
        if not any(curves):
            words = (
                "degenerate throughout: the margin is 0"
                if document.get("degenerate")
                else "no transition moves"
            )
            ax.text(0.5, 0.5, words, size=12, ha="center", transform=ax.transAxes)

    title = f"How far all lengths may be off before the number of cusps changes, by {leg}"
    return figure_about(document, title, _facts(leg, plan, document, margins), paint, lambda _: 1.1 * HEIGHT)


def _between(low: float, high: float) -> list[float]:
    """Lengths of a window, denser at its ends."""
    shares = ((2 * k + 1) / (2 * _SAMPLES) for k in range(_SAMPLES))
    return [low + (high - low) * share * share * (3 - 2 * share) for share in shares]


def _rise(estimates: Sequence[float], known: Sequence[float]) -> tuple[float, float]:
    """The limits of radii: the estimates' peaks, and what is proved."""
    top = 2 * max([*estimates, *known] or [0.1])
    peaks = sorted(estimates) or [top]
    low = min(peaks[len(peaks) // 20] / 3, *(x / 2 for x in known), top / 10**_DECADES)
    return max(low, top / 10**_MOST_DECADES), top


def _length(margin: Mapping[str, Any]) -> float:
    return number(margin["asked"][f"l{margin['fixed_leg']}"])


def _facts(leg: str, plan: Plan, document: Mapping[str, Any], margins: Sequence[Mapping[str, Any]]) -> str:
    """The picture in words."""
    if document.get("degenerate"):
        return f"The margin is 0 at every {leg}."
    said = [
        f"proved {margin['proved'] or 'nothing'} at {leg} = {short(_length(margin), 6)}" for margin in margins
    ]
    inner = ", ".join(plan.labels[1:-1]) or "none"
    note = f"Transitions, where the margin is 0: {inner}. Between them the first-order estimate is drawn."
    return f"{note} {'; '.join(said)}." if said else note
