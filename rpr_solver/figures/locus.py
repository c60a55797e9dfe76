"""The cusp locus: the curves of cusps in joint space (L1, L2, L3), seen from a corner, or in three planes.

The planes share their axes as in a technical drawing: above left that of the fixed leg and the second, below
it that of the fixed leg and the third, to the right of the first that of the third and the second. In a
column of a journal they stand below each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from rpr_solver.figures.census import draw_mark, mark_of
from rpr_solver.figures.joint_plane import AXIS, legend_below
from rpr_solver.figures.room import Room, size_of
from rpr_solver.figures.words import figure_about, number, short
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import Figure

_SHARE, _NARROW_SHARE = 0.62, 0.9
"""The height of the picture by its width."""
_MANY = 12
"""In a narrow picture the legend of more curves has only their names."""
_COLOURS = ("line1", "line2", "line3", "line4", "line5")
_DASHES: Sequence[Any] = ("-", (0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 2, 2, 2)), (0, (3, 1.5, 1, 1.5, 1, 1.5)))
_ELEVATION, _AZIMUTH = 24, -58
_AWAY = 10.0
"""How much farther than usual the titles of axes in space are, in points."""
_GAP, _NARROW, _FLAT, _SQUARE, _HIGH, _LEAST = 14.0, 330.0, 0.62, 0.85, 1.4, 82.0
"""In planes: what is between two; narrower pictures have them below each other; heights by widths: of a plane
in a column, of all without a common scale, and of all at most; and the least side with a common scale."""
_BELOW = 40.0
"""Between planes below each other."""

Spot = tuple[float, float, float]


def locus_figure(document: Mapping[str, Any]) -> Figure:
    """Curves of cusps in joint space.

    Args:
        document: as :meth:`CuspCurves.to_json` gives it, with several points on each curve.
    """
    locus = Locus.of(document)

    def paint(ax: Axes, style: Style) -> None:
        space: Any = ax
        floor = locus.spans[2][0]
        for k, (name, spots) in enumerate(locus.curves):
            points = np.reshape(spots, (-1, 3)).T
            space.plot(points[0], points[1], floor, color=style.colour("faint"), lw=1.2, zorder=1)
            space.plot(*points, **curve_look(k, style), lw=1.5, label=name, zorder=3)
        for spot, kind, _ in locus.ends:
            line = mark_of(kind, style)
            space.plot(
                *([x] for x in spot), ls="", marker=line.get_marker(), ms=6, color=line.get_color(), zorder=4
            )
        for axis, title, span in zip("xyz", locus.titles, locus.spans, strict=True):
            space.set(**{f"{axis}label": style.axis(title), f"{axis}lim": span})
        space.set_box_aspect((1.5, 1, 0.95), zoom=1.12)
        space.view_init(elev=_ELEVATION, azim=_AZIMUTH)
        for axis in (space.xaxis, space.yaxis, space.zaxis):
            axis.set_pane_color(style.colour("tint"))
            axis.labelpad = _AWAY
            axis.get_major_locator().set_params(nbins=5 if size_of(ax)[0] > _NARROW else 3)
        low = min(axis.get_tightbbox().y0 for axis in (space.xaxis, space.yaxis))
        down = (ax.get_window_extent().y0 - low) / ax.get_window_extent().height * size_of(ax)[1]
        legend_below(ax, locus.handles(style, size_of(ax)[0]), down=max(down, 0.0) + 6)

    text = locus.facts("with their shadows on the floor")
    return figure_about(
        document,
        locus.title,
        text,
        paint,
        lambda wide: (_SHARE if wide > _NARROW else _NARROW_SHARE) * wide,
        is_spatial=True,
    )


def projections_figure(document: Mapping[str, Any]) -> Figure:
    """Curves of cusps in the planes of any two lengths.

    Args:
        document: as :meth:`CuspCurves.to_json` gives it, with several points on each curve.
    """
    locus = Locus.of(document)

    def paint(ax: Axes, style: Style) -> None:
        ax.set_axis_off()
        size = size_of(ax)
        is_narrow = size[0] < _NARROW
        boxes, _ = _boxes(locus, size[0])
        axes = (0, 1), (0, 2), (2, 1)
        shown = (is_narrow, True), (True, True), (True, is_narrow)
        for (left, top, wide, high), (i, k), (has_x, has_y) in zip(boxes, axes, shown, strict=True):
            plane = ax.inset_axes(
                (left / size[0], 1 - (top + high) / size[1], wide / size[0], high / size[1])
            )
            plane.set(xlim=locus.spans[i], ylim=locus.spans[k])
            plane.locator_params(axis="x", nbins=max(int(wide / 45), 2))
            plane.locator_params(axis="y", nbins=max(int(high / 32), 2), prune="both")
            plane.tick_params(labelbottom=has_x, labelleft=has_y)
            plane.set_xlabel(style.axis(locus.titles[i]) if has_x else "")
            plane.set_ylabel(style.axis(locus.titles[k]) if has_y else "")
            _draw_plane(plane, locus, (i, k), style)
        handles = locus.handles(style, size[0])
        (_, top, _, high), (left, _, wide, _) = boxes[1:]
        if is_narrow or not _has_legend(ax, handles, (left, top + AXIS), (wide, high - AXIS)):
            legend_below(ax, handles)

    first, second, third = locus.titles
    how = f"in the planes of {first} and {second}, {first} and {third}, and {third} and {second}"
    title = f"{locus.title}, in three planes"
    return figure_about(document, title, locus.facts(how), paint, lambda wide: _boxes(locus, wide)[1])


def _has_legend(ax: Axes, handles: Sequence[Any], corner: tuple[float, float], room: Any) -> bool:
    """Whether a legend has room right and below of a corner, in points from the upper left one; draws it."""
    size = size_of(ax)
    anchor = corner[0] / size[0], 1 - corner[1] / size[1]
    for columns in (1, 2, 3):
        legend = ax.legend(
            handles=handles, loc="upper left", bbox_to_anchor=anchor, ncols=columns, handlelength=1.4
        )
        extent = legend.get_window_extent()
        if (extent.size / ax.get_window_extent().size * size <= room).all():
            return True
    return False


def _draw_plane(ax: Axes, locus: Locus, axes: tuple[int, int], style: Style) -> None:
    """Draws curves, their ends, and the names of those that are long enough."""
    ax.grid(visible=True)
    room, places = Room(ax), []
    for k, (_, spots) in enumerate(locus.curves):
        points = np.reshape(spots, (-1, 3))[:, axes]
        ax.plot(*points.T, **curve_look(k, style), lw=1.3)
        places.append((points, room.points(points)))
        room.add_line(places[-1][1])
    for spot, kind, _ in locus.ends:
        at = [spot[axes[0]], spot[axes[1]]]
        draw_mark(ax, at, kind, style)
        room.add_point(room.points(at)[0], 3.5)
    for k, ((name, _), (points, line)) in enumerate(zip(locus.curves, places, strict=True)):
        if len(line) > 1 and np.hypot(*np.diff(line, axis=0).T).sum() > 18:
            room.label(points[len(points) // 2], name, reach=4.0, size=9, color=curve_look(k, style)["color"])


def _boxes(locus: Locus, wide: float) -> tuple[list[tuple[float, float, float, float]], float]:
    """Left, top, width and height of each plane, and the height of all."""
    if wide < _NARROW:
        high = _FLAT * wide
        return [(0, k * (high + _BELOW), wide, high) for k in range(3)], 3 * high + 2 * _BELOW
    across = wide - _GAP
    first, second, third = (high - low for low, high in locus.spans)
    scale = across / (first + third)
    left, right, upper, lower = scale * first, scale * third, scale * second, scale * third
    if min(left, right, upper, lower) < _LEAST or upper + lower > _HIGH * across:
        left = right = across / 2
        upper = lower = _SQUARE * across / 2
    y = upper + _GAP
    return [(0, 0, left, upper), (0, y, left, lower), (left + _GAP, 0, right, upper)], y + lower


@dataclass(frozen=True)
class Locus:
    """The curves of a document in floats.

    Attributes:
        titles: of the axes: the fixed leg, and the two others.
        curves: each with its name and its points in (fixed leg, others).
        ends: the transitions at which curves begin and end: the point, the kind, and both in words.
        notes: where each curve begins and ends.
        ranges: the same as a range of lengths, in short.
        start: the least length of the fixed leg.
    """

    titles: tuple[str, ...]
    curves: tuple[tuple[str, tuple[Spot, ...]], ...]
    ends: tuple[tuple[Spot, str, str], ...]
    notes: tuple[str, ...]
    ranges: tuple[str, ...]
    start: float

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Locus:
        """The curves, as far as they are drawn."""
        leg = document["fixed_leg"]
        titles = tuple(f"L{k}" for k in (leg, *sorted({1, 2, 3} - {leg})))
        names = [title.lower() for title in titles]
        stop = _stop(document, names[0])
        curves = tuple(
            (curve["name"], tuple(spot for spot in _spots(curve, names) if spot[0] <= stop))
            for curve in document["curves"]
        )
        notes = tuple(_note(curve, titles[0], names[0]) for curve in document["curves"])
        ranges = tuple(_range(curve["from"][names[0]], curve["to"][names[0]]) for curve in document["curves"])
        ends, start = (
            tuple(dict.fromkeys(_ends(document["curves"], names))),
            number(document["range"]["from"]),
        )
        return cls(titles, curves, ends, notes, ranges, start)

    @cached_property
    def spans(self) -> list[tuple[float, float]]:
        """The limits of each length, with a margin above; from 0 if that is near."""
        spots = np.concatenate([np.reshape(spots, (-1, 3)) for _, spots in self.curves] or [np.zeros((1, 3))])
        if not len(spots):
            spots = np.array([[self.start, 0.0, 0.0]])
        spans = []
        for k, (low, high) in enumerate(zip(spots.min(axis=0), spots.max(axis=0), strict=True)):
            low = min(low, self.start) if k == 0 else low
            far = (high - low) or high or 1.0
            low = low if k == 0 else 0.0 if low < 0.45 * far else low - 0.04 * far
            spans.append((float(low), float(high + 0.04 * far)))
        return spans

    def handles(self, style: Style, wide: float) -> list[Line2D]:
        """The legend: how each curve is drawn and where it is, and the marks of its ends."""
        is_short = wide < _NARROW and len(self.curves) > _MANY
        lines = [
            Line2D([], [], **curve_look(k, style), lw=1.6, label=name if is_short else f"{name}: {span}")
            for k, ((name, _), span) in enumerate(zip(self.curves, self.ranges, strict=True))
        ]
        return [*lines, *(mark_of(kind, style) for kind in dict.fromkeys(kind for _, kind, _ in self.ends))]

    @property
    def title(self) -> str:
        """How many curves there are."""
        count = len(self.curves)
        return f"Cusp locus: {'one curve' if count == 1 else f'{count} curves'} of cusps"

    def facts(self, how: str) -> str:
        """What is drawn, and where each curve begins and ends."""
        return f"Curves of cusps in ({', '.join(self.titles)}), {how}. {'; '.join(self.notes)}."


def _note(curve: Mapping[str, Any], title: str, name: str) -> str:
    """Where a curve begins and ends."""
    start, stop = curve["from"], curve["to"]
    begins = f"{curve['name']} from {title} = {_end(start, name)} ({start['kind']})"
    return f"{begins} to {_end(stop, name)} ({stop['kind']})"


def _spots(curve: Mapping[str, Any], names: Sequence[str]) -> list[Spot]:
    """The points of a curve, with its ends where a single pose is known there."""
    start, stop = (_end_spot(curve[end], names) for end in ("from", "to"))
    spots = [start, *(_spot(point, names) for point in curve["points"]), stop]
    return [spot for spot in spots if spot is not None]


def _end_spot(end: Mapping[str, Any], names: Sequence[str]) -> Spot | None:
    """Where a curve begins or ends, if it is a single pose."""
    if end[names[0]] is None or len(end["events"]) != 1:
        return None
    return _spot({**end["events"][0], names[0]: end[names[0]]}, names)


def _spot(point: Mapping[str, str], names: Sequence[str]) -> Spot:
    a, b, c = (number(point[name]) for name in names)
    return a, b, c


def _stop(document: Mapping[str, Any], name: str) -> float:
    """The greatest length that is drawn: that of the range, or not far from the last end of a curve."""
    if document["range"]["to"] is not None:
        return number(document["range"]["to"])
    ends = [end[name] for curve in document["curves"] for end in (curve["from"], curve["to"])]
    return 1.3 * max((number(end) for end in ends if end is not None), default=0.0) or inf


def _range(start: str | None, stop: str | None) -> str:
    """A range with enough digits to distinguish its ends.

    >>> _range("9.18680657065541", "9.18688909674875"), _range("20.5551", None)
    ('9.1868 to 9.1869', '20.56 to ∞')
    """
    ends = [end for end in (start, stop) if end is not None]
    digits = next((n for n in range(4, 12) if len({short(end, n) for end in ends}) == len(ends)), 12)
    first, last = ("∞" if end is None else short(end, digits) for end in (start, stop))
    return f"{first} to {last}"


def _end(end: Mapping[str, Any], name: str) -> str:
    return "∞" if end[name] is None else f"{number(end[name]):.5g}"


def curve_look(k: int, style: Style) -> dict[str, Any]:
    """How a curve is drawn: its colour, and its dashes."""
    colours = len(_COLOURS)
    return {"color": style.colour(_COLOURS[k % colours]), "ls": _DASHES[k // colours % len(_DASHES)]}


def _ends(curves: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Iterator[tuple[Spot, str, str]]:
    """Yields the transitions at which curves begin and end, for each of them."""
    for curve in curves:
        for end in (curve["from"], curve["to"]):
            if (spot := _end_spot(end, names)) is not None:
                yield spot, end["kind"], f"{end['kind']} at {end[names[0]]}"
