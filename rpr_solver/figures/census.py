"""The census: the number of cusps against the length of the fixed leg; poses along a leg; and designs.

Windows between transitions may be a millionth of the whole range. So the upper axis gives each of them a
width that can be seen, and a fan of lines leads from it to the axis below, which is true to scale. A design
shows what a search reached over its censuses, and those of the given geometry and of the best one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rpr_solver.contract import LENGTHS
from rpr_solver.figures.joint_plane import legend_below
from rpr_solver.figures.room import size_of
from rpr_solver.figures.words import figure_about, number, short
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import Figure
from rpr_solver.triangles import article_lengths

HEIGHT = 150.0
"""Of a plot over lengths, in points."""
_FAN, _LEAST, _APART = 36.0, 16.0, 11.0
"""From the plot to the axis true to scale; the least width of a window; and of two lengths above the plot."""
_FOOT = 34.0
"""From the lower axis to the legend."""

KINDS = {
    "swallowtail": ("swallowtail", "^"),
    "beak-to-beak": ("beak", "D"),
    "lips": ("lips", "o"),
    "fold": ("swallowtail", "o"),
    "closed-leg": ("beak", "D"),
}
"""Of each kind of transition its colour and its mark."""


@dataclass(frozen=True)
class Plan:
    """Lengths from one to another, with those between at which something changes.

    Attributes:
        texts: the lengths as documents have them; of an open end None.
        knots: the same in floats, ascending; the last one is where the picture ends.
        kinds: what changes at the inner ones.
    """

    texts: tuple[str | None, ...]
    knots: tuple[float, ...]
    kinds: tuple[str, ...]

    @classmethod
    def of(cls, span: Mapping[str, Any], changes: Iterable[tuple[str, str]], size: float) -> Plan:
        """The plan of a range and the changes within it; without one, an open end shows ``size``."""
        changes = [(text, kind) for text, kind in changes]
        start, stop = span["from"] or "0", span["to"]
        texts = (start, *(text for text, _ in changes), stop)
        low, last = number(start), number(changes[-1][0]) if changes else number(start) + size
        end = last + 0.12 * (last - low) if stop is None else number(stop)
        values = [low, *(number(text) for text, _ in changes), end]
        least = max(abs(values[-1]), 1e-140) * 1e-14
        for k in range(1, len(values)):
            values[k] = max(values[k], values[k - 1] + least)
        return cls(texts, tuple(values), tuple(kind for _, kind in changes))

    @property
    def labels(self) -> list[str]:
        """The lengths with enough digits to distinguish neighbours."""
        labels = []
        for k, text in enumerate(self.texts):
            beside = [x for i in (k - 1, k + 1) if 0 <= i < len(self.texts) and (x := self.texts[i])]
            digits = next(
                (n for n in range(4, 12) if short(text or "0", n) not in {short(x, n) for x in beside}), 12
            )
            labels.append("∞" if text is None else short(text, digits))
        return labels

    def places(self, wide: float) -> list[float]:
        """The places of the knots, from 0 to 1: narrow windows are widened, the others keep proportions."""
        widths = np.diff(self.knots) / (self.knots[-1] - self.knots[0])
        least = min(_LEAST / wide, 1 / len(widths))
        narrow = np.zeros(len(widths), dtype=bool)
        while True:  # more are narrow each time, so that it ends
            free = (1 - least * narrow.sum()) / (widths[~narrow].sum() or 1.0)
            more = ~narrow & (widths * free < least)
            if not more.any():
                break
            narrow |= more
        return [0.0, *np.cumsum(np.where(narrow, least, widths * free))[:-1], 1.0]

    def paint(self, ax: Axes, style: Style, leg: str, legends: Sequence[Any] = ()) -> None:
        """Draws both axes, the fan between them, the marks of changes, and the legend."""
        wide, high = size_of(ax)
        knots, places = self.knots, self.places(wide)
        scale = (lambda x: np.interp(x, knots, places)), (lambda x: np.interp(x, places, knots))
        ax.set_xscale("function", functions=scale)
        ax.set_xlim(knots[0], knots[-1])
        ax.set_xticks([])
        true = ax.inset_axes((0, -_FAN / high, 1, 1e-3))
        true.set(xlim=(knots[0], knots[-1]), yticks=[], facecolor="none")
        true.spines[["left", "right", "top"]].set_visible(False)
        true.locator_params(axis="x", nbins=max(int(wide / 55), 2))
        true.set_xlabel(style.axis(leg) + ", true to scale")
        shares = [(x - knots[0]) / (knots[-1] - knots[0]) for x in knots]
        widened = [
            k for k in range(len(places) - 1) if places[k + 1] - places[k] > 2 * (shares[k + 1] - shares[k])
        ]
        fan = {"transform": ax.transAxes, "clip_on": False}
        for k in widened:
            ax.axvspan(knots[k], knots[k + 1], color=style.colour("tint"), lw=0, zorder=0.1)
            corners = [
                (places[k], 0),
                (places[k + 1], 0),
                (shares[k + 1], -_FAN / high),
                (shares[k], -_FAN / high),
            ]
            ax.fill(*zip(*corners, strict=True), color=style.colour("tint"), lw=0, zorder=0.1, **fan)
        ghost = style.colour("ghost")
        last, above = -1.0, 11 / high
        for k, kind in enumerate(self.kinds, 1):
            ax.plot([places[k], shares[k]], [0, -_FAN / high], color=ghost, lw=0.5, **fan)
            ax.plot([places[k]] * 2, [0, 1 + above], color=ghost, lw=0.5, ls=(0, (1.5, 2.2)), **fan)
            draw_mark(ax, (places[k], 1 + above), kind, style, **fan)
            if places[k] * wide >= last + _APART:
                last = places[k] * wide
                look = {"rotation": 90, "size": 8.5, "color": style.colour("soft"), "transform": ax.transAxes}
                ax.text(places[k], 1 + 2 * above, self.labels[k], ha="center", va="bottom", **look)
        if self.texts[-1] is None:
            end, soft = (1, -_FAN / high), style.colour("soft")
            arrow = {"arrowstyle": "->", "lw": 0.8, "color": soft}
            ax.annotate("", end, (-5, 0), ax.transAxes, "offset points", arrowprops=arrow)
            look = {"size": 10, "color": soft, "ha": "left", "va": "center"}
            ax.annotate("∞", end, (3, 0), ax.transAxes, "offset points", annotation_clip=False, **look)
        handles = [mark_of(kind, style) for kind in dict.fromkeys(self.kinds)]
        if widened:
            handles.append(
                Patch(fc=style.colour("tint"), ec=ghost, lw=0.5, label="drawn wider than to scale")
            )
        legend_below(ax, [*handles, *legends], down=_FAN + _FOOT)


def plan_of(document: Mapping[str, Any], span: Mapping[str, Any] | None = None) -> Plan:
    """The plan of a census, or of a part of it."""
    leg = f"l{document['fixed_leg']}"
    changes = [(t[leg], t["kind"]) for t in document["transitions"]]
    if span is None:
        span = document["range"]
    else:
        low, high = number(span["from"] or "0"), inf if span["to"] is None else number(span["to"])
        changes = [(text, kind) for text, kind in changes if low < number(text) < high]
    lengths = article_lengths(document["geometry"])
    ends = [number(part["to"]) for part in document.get("degenerate", ()) if part["to"] is not None]
    return Plan.of(span, changes, max([*(abs(number(lengths[name])) for name in LENGTHS), *ends]))


def census_figure(document: Mapping[str, Any]) -> Figure:
    """A census.

    Args:
        document: as :meth:`Census.to_json` gives it.
    """
    plan, leg = plan_of(document), f"L{document['fixed_leg']}"
    counts = [interval["count"] for interval in document["intervals"]]
    spans = [t for t in document["transitions"] if t.get("from") is not None]
    low, high = min(counts), max(counts)
    cusps = f"{low} cusps" if low == high else f"{low} to {high} cusps"
    note = f"Numbers of cusps by {leg}: {_windows(counts, plan)}."
    if spans:
        where = "; ".join(f"{t['from']} to {t['to']}" for t in spans)
        note += f" Shaded: where the transitions are for all geometries within the tolerance: {where}."

    def paint(ax: Axes, style: Style) -> None:
        for t in spans:
            ends = (min(max(number(t[end]), plan.knots[0]), plan.knots[-1]) for end in ("from", "to"))
            ax.axvspan(*ends, color=style.colour("curve"), alpha=0.25, lw=0)
        draw_counts(ax, plan.knots, counts, "cusps", style)
        plan.paint(ax, style, leg)
        _number_steps(ax, plan, counts, style)

    return figure_about(document, f"Number of cusps against {leg}: {cusps}", note, paint, lambda _: HEIGHT)


def along_figure(document: Mapping[str, Any]) -> Figure:
    """The number of poses while one leg moves.

    Args:
        document: as :meth:`LegPoses.to_json` gives it.
    """
    name = f"l{document['moving_leg']}"
    counts = [interval["count"] for interval in document["intervals"]]
    span, ends = document[name], [(end[name], end["kind"]) for end in document["ends"]]
    inner = [(text, kind) for text, kind in ends if text not in (span["from"], span["to"], "0")]
    held = [f"L{k} = {short(document[f'l{k}'], 6)}" for k in (1, 2, 3) if f"l{k}" != name]
    size = max(number(document[f"l{k}"]) for k in (1, 2, 3) if f"l{k}" != name)
    plan, leg = Plan.of(span, inner, 2 * size), name.upper()

    def paint(ax: Axes, style: Style) -> None:
        draw_counts(ax, plan.knots, counts, "poses", style)
        plan.paint(ax, style, leg)
        _number_steps(ax, plan, counts, style)

    title = f"Number of poses against {leg}, {' and '.join(held)}"
    note = f"Numbers of poses by {leg}, {' and '.join(held)}: {_windows(counts, plan)}."
    return figure_about(document, title, note, paint, lambda _: HEIGHT)


def _windows(counts: Sequence[int], plan: Plan) -> str:
    ends = zip(counts, pairwise(plan.labels), strict=False)
    return "; ".join(f"{n} from {a} to {b}" for n, (a, b) in ends)


def draw_counts(ax: Axes, knots: Any, counts: Sequence[int], what: str, style: Style) -> None:
    """Draws a number by length as steps over an area."""
    ax.stairs(counts, knots, fill=True, color=(style.colour("poses4"), 0.6), lw=0, zorder=1)
    ax.stairs(counts, knots, baseline=None, color=style.colour("curve"), lw=1.7, zorder=2)
    most = max(*counts, 4)
    ax.set_ylim(0, 1.2 * most)
    ax.set_yticks(range(0, most + 1, 2 if most < 10 else 4 if most < 20 else 10))
    ax.set_ylabel(what)
    ax.grid(visible=True, axis="y")


def _number_steps(ax: Axes, plan: Plan, counts: Sequence[int], style: Style) -> None:
    """Writes the numbers above the steps that are wide enough."""
    wide = size_of(ax)[0]
    places = plan.places(wide)
    for k, count in enumerate(counts):
        at = (places[k] + places[k + 1]) / 2
        if (places[k + 1] - places[k]) * wide > 6.7 * len(str(count)) + 2:
            look = {
                "size": 9.5,
                "weight": "bold",
                "ha": "center",
                "va": "bottom",
                "color": style.colour("ink"),
            }
            place = ("axes fraction", "data"), "offset points"
            ax.annotate(str(count), (at, count), (0, 2.5), *place, **look)


def draw_mark(ax: Axes, at: Sequence[float], kind: str, style: Style, **look: Any) -> None:
    """The mark of a kind of transition."""
    role, shape = KINDS.get(kind, ("soft", "s"))
    colours = {"mfc": style.colour(role), "mec": style.colour("paper"), "mew": 0.7}
    ax.plot([at[0]], [at[1]], ls="", marker=shape, ms=_mark_size(shape), zorder=4, **colours, **look)


def mark_of(kind: str, style: Style) -> Line2D:
    """The same, for a legend."""
    role, shape = KINDS.get(kind, ("soft", "s"))
    return Line2D(
        [], [], ls="", marker=shape, ms=_mark_size(shape), color=style.colour(role), mew=0, label=kind
    )


def _mark_size(shape: str) -> float:
    return 6.0 if shape == "D" else 7.5


_ROWS = (120.0, 90.0, 90.0)
"""The heights of the search, of the given geometry and of the best one."""
_BETWEEN = 52.0, 14.0
_VALUES = {
    "longest-range": "longest part",
    "least-change": "change",
    "largest-margin": "margin",
    "most-cusps": "cusps",
}


def design_figure(document: Mapping[str, Any]) -> Figure:
    """A design.

    Args:
        document: as :meth:`Design.to_json` gives it.
    """
    asked, best = document["asked"], document["best"]
    leg, wish = f"L{document['fixed_leg']}", asked["requirement"]
    tables = document["start"]["census"], best["census"]
    across = _across(tables, wish["range"])
    total = sum(_ROWS) + sum(_BETWEEN)

    def paint(ax: Axes, style: Style) -> None:
        ax.set_axis_off()
        top, panels = total, []
        for high, gap in zip(_ROWS, (*_BETWEEN, 0.0), strict=True):
            panels.append(ax.inset_axes((0, (top - high) / total, 1, high / total)))
            top -= high + gap
        _draw_search(panels[0], document, style)
        for panel, name, table in zip(panels[1:], ("given", "best found"), tables, strict=True):
            _draw_census(panel, table["intervals"], wish, across, style)
            panel.set_title(name, loc="left", size=10, weight="bold", pad=3)
        panels[1].tick_params(labelbottom=False)
        panels[2].set_xlabel(style.axis(leg))

    met = "met" if best["met"] else "not met"
    title = f"Best found: {asked['objective']}, {short(best['value'], 6)} ({met})"
    said = "; ".join(f"{short(one['value'], 6)} at census {one['census']}" for one in document["trace"])
    note = f"Improvements: {said}. Search: {document['censuses']} censuses, stopped: {document['stopped']}."
    for name, table in zip(("given geometry", "best found"), tables, strict=True):
        note += f" Numbers of cusps by {leg} of the {name}: {_said(table['intervals'])}."
    return figure_about(best, title, note, paint, lambda _: total)


def _across(tables: Sequence[Mapping[str, Any]], span: Mapping[str, str | None]) -> tuple[float, float]:
    """The range of lengths; an open one ends beyond the last transition of both geometries."""
    start = number(span["from"] or "0")
    if span["to"] is not None:
        return start, number(span["to"])
    last = max(number(part["from"]) for table in tables for part in table["intervals"])
    return start, last + 0.12 * (last - start) if last > start else start + 1


def _draw_search(ax: Axes, document: Mapping[str, Any], style: Style) -> None:
    """The best value so far over the censuses, with a disc at each improvement."""
    steps = [(one["census"], number(one["value"]), one["met"]) for one in document["trace"]]
    end = max(document["censuses"], 1)
    x, y = [k for k, _, _ in steps], [value for _, value, _ in steps]
    curve = style.colour("curve")
    ax.grid(visible=True)
    ax.step([*x, end], [*y, y[-1]], where="post", color=curve, lw=1.7)
    for k, value, is_met in steps:
        ax.plot(
            k,
            value,
            "o",
            ms=6,
            color=curve,
            mfc=curve if is_met else style.colour("paper"),
            mew=1.2,
            zorder=3,
        )
    low = min(0.0, *y)
    ax.set(xlim=(0, end * 1.01), ylim=(low, max(y) + 0.15 * (max(y) - low or 1.0)))
    ax.set(xlabel="censuses", ylabel=_VALUES[document["asked"]["objective"]])
    ax.locator_params(integer=True, axis="x")
    if not all(is_met for *_, is_met in steps):
        ax.set_title(
            "hollow: not in the whole range", loc="right", size=9.5, color=style.colour("soft"), pad=3
        )


def _draw_census(
    ax: Axes,
    intervals: Sequence[Mapping[str, Any]],
    wish: Mapping[str, Any],
    across: tuple[float, float],
    style: Style,
) -> None:
    """The number of cusps by length, true to scale, over what the requirement admits."""
    ends = [number(intervals[0]["from"]), *(inf if x["to"] is None else number(x["to"]) for x in intervals)]
    counts = [part["count"] for part in intervals]
    draw_counts(ax, np.minimum(ends, max(across[1], ends[-2] + 1)), counts, "cusps", style)
    ax.set_xlim(*across)
    ax.grid(visible=True)
    least, most = wish["min_cusps"] or 0, wish["max_cusps"]
    if least > 0 or most is not None:
        top = ax.get_ylim()[1] if most is None else most + 0.5
        ax.axhspan(max(least - 0.5, 0.0), top, color=style.colour("lips"), alpha=0.16, lw=0)


def _said(intervals: Sequence[Mapping[str, Any]]) -> str:
    ends = [(part["count"], part["from"], part["to"]) for part in intervals]
    return "; ".join(f"{n} from {short(a, 6)} to {'∞' if b is None else short(b, 6)}" for n, a, b in ends)
