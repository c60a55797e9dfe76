"""A slice in joint space: singular curves, regions by their number of poses, cusps circled and lettered.

Cusps too close to anything else to be seen are magnified in insets. The number of poses between singular
curves, at any magnification, is twice the winding number of these curves, each run with J > 0 on its left
(Theorem 26 in docs/mathematics.md); insets are shaded by it, since the outlines of regions are too coarse.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import floor, log10
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator

from rpr_solver.figures.room import Room, size_of
from rpr_solver.figures.strands import Places, SliceCurves
from rpr_solver.figures.words import figure_about, listed, short
from rpr_solver.notebook import Style, counted
from rpr_solver.notebook.figure import Figure

_LOW, _HIGH, _USUAL = 0.45, 1.05, 0.756
"""The height of the plot, by its width: at least, at most, and if the scales differ."""
_LEVELS = (0, 2, 4, 6)
CIRCLE = 10.0
"""The width of the circle round a cusp, thin so that the tip within it is seen."""
CURVE = 1.3
"""The width of a singular curve."""
AXIS = 40.0
"""From the plot to what is below its axis."""

_ROW, _OVER = 7, 40.0
"""Longer legends have columns; how much wider than axes they may be."""

_CLEAR, _ASIDE = 11.0, 5.5
"""How far a cusp must be from other cusps and corners to be seen, and from other pieces of curve."""
_REACH, _OWN = 26.0, 12.0
"""Crowded cusps not farther than this share an inset; the branches of a cusp so near are its own."""
_SIDE, _OUT, _GAP, _FOOT = 118.0, 30.0, 14.0, 17.0
"""The side of an inset, unless the picture has no room for two; how much wider than the plane rows of them
are; what is between two; and the line below each."""
_LEAST_ZOOM, _MOST_ZOOM, _DEEPEST = 2.5, 1e7, 4
_TICK = 0.026
"""The length of a tick of an inset, by its side."""
_STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
"""Readable factors, by powers of ten."""
_SAME = 1e-6
"""Cusps that are nearer, in points, by the magnification, are one point of the plane."""
_SHOWN = 2.2
"""How much farther than necessary an inset takes its cusps apart."""
_FAR = 190.0
"""An inset in the plane is not farther than this from what it magnifies."""
_FINENESS = 300
"""Dots of the shades of an inset across; edges are below the curves."""
_MARK = 8.0
"""The least side, in points, of the frame round what an inset magnifies."""


def joint_figure(document: Mapping[str, Any]) -> Figure:
    """The singular curves of a slice in the plane of the free legs.

    Args:
        document: as :meth:`SingularCurves.to_json` gives it.
    """
    plane = _JointPlane(document, SliceCurves.of(document))
    curves = plane.curves
    cusps = counted(len(curves.cusps), "cusp") if len(curves.cusps) else "no cusp"
    title = f"Singular curves at L{curves.leg} = {short(document[f'l{curves.leg}'], 8)}: {cusps}"
    return figure_about(document, title, plane.facts(), plane.paint, plane.height)


@dataclass(frozen=True)
class _JointPlane:
    document: Mapping[str, Any]
    curves: SliceCurves

    @cached_property
    def names(self) -> list[str]:
        """The free legs."""
        return [f"L{k}" for k in (1, 2, 3) if k != self.curves.leg]

    @cached_property
    def cusps(self) -> Places:
        """The places of the cusps in the plane."""
        return self.curves.floats.lengths(self.curves.cusps)

    @cached_property
    def limits(self) -> tuple[float, float, float, float]:
        """Left, below, right and above: both axes to one scale unless that makes it very flat or high."""
        points = np.concatenate([self.curves.floats.lengths(strand.poses) for strand in self.curves.strands])
        ends = []
        for low, high in zip(points.min(axis=0), points.max(axis=0), strict=True):
            wide = (high - low) or high or 1.0
            ends.append((0.0 if low < 0.45 * wide else low - 0.06 * wide, high + 0.05 * wide))
        (x0, x1), (y0, y1) = ends
        share = (y1 - y0) / (x1 - x0)
        if _LOW / 2 <= share < _LOW:
            y1 = y0 + _LOW * (x1 - x0)
        elif _HIGH < share <= 2 * _HIGH:
            x1 = x0 + (y1 - y0) / _HIGH
        return x0, y0, x1, y1

    def height(self, wide: float) -> float:
        """The height of the plot."""
        x0, y0, x1, y1 = self.limits
        share = (y1 - y0) / (x1 - x0)
        return wide * (share if 0.999 * _LOW <= share <= 1.001 * _HIGH else _USUAL)

    def paint(self, ax: Axes, style: Style) -> None:
        """Draws regions, curves, cusps, insets and the legend."""
        x0, y0, x1, y1 = self.limits
        ax.set(
            xlim=(x0, x1), ylim=(y0, y1), xlabel=style.axis(self.names[0]), ylabel=style.axis(self.names[1])
        )
        ax.grid(visible=True)
        regions = list(self._regions())
        for poses, rings in regions:
            path = Path.make_compound_path(*(Path(ring, closed=True) for ring in rings))
            ax.add_patch(PathPatch(path, facecolor=style.colour(role_of(poses)), lw=0, zorder=0.5))
        view = _View.of(ax, self, min(_SIDE, (size_of(ax)[0] + _OUT - _GAP) / 2))
        view.draw_curves(style)
        room = view.room
        windows = list(view.windows())
        for window in windows:
            low, high = view.marked(window)
            room.add_box(*room.points(low)[0], *room.points(high)[0])
        shared = {k for window in windows for k in window.members}
        view.draw_letters(style, [k for k in range(len(self.cusps)) if k not in shared])
        for window in windows:
            names = ", ".join(self.curves.letters[k] for k in window.members)
            label = {"size": 10.5, "weight": "bold", "color": style.colour("cusp")}
            room.label(window.centre, names, reach=max(view.points_of(window.half), _MARK / 2) + 3, **label)
        below = self._insets(ax, view, windows, style)
        for poses, rings in sorted(regions, key=lambda region: -region[0]):
            room.number(rings, f"{poses}", size=11, color=style.colour("ink"))
        shades = [
            Patch(fc=style.colour(role), ec=style.colour("soft"), lw=0.6, label=words)
            for role, words in {
                role_of(n): f"{n} poses" if n else "no pose" for n, _ in sorted(regions, key=lambda r: r[0])
            }.items()
        ]
        legend_below(ax, shades, AXIS + below)

    def _insets(self, ax: Axes, view: _View, windows: Sequence[_Window], style: Style) -> float:
        """Draws the insets where the plane has room, and others in rows below; how high these rows are."""
        size, room, side = view.room.size, view.room, view.side
        columns = max(int((size[0] + _OUT + _GAP + 1) // (side + _GAP)), 1)
        placed = 0
        pending = [(view, window, 1) for window in windows]
        while pending:
            source, window, depth = pending.pop(0)
            near = room.points(window.centre)[0]
            centre = room.free((side + 12, side + _FOOT + 12), near)
            if centre is None or np.hypot(*(centre - near)) > _FAR:
                if not style.is_alone:
                    continue
                centre = None
                row, column = divmod(placed, columns)
                corner = np.array(
                    (column * (side + _GAP) - _OUT / 2, -AXIS - 6 - (row + 1) * (side + _FOOT + 8) + _FOOT)
                )
                placed += 1
            else:
                corner = centre - (side / 2, (side - _FOOT) / 2)
                room.add_box(*(corner - (3, _FOOT + 1)), *(corner + side + 3))
            inset = ax.inset_axes((*(corner / size), *(side / size)), zorder=4)
            child, window = self._inset(inset, source, window, style)
            low, high = source.marked(window)
            look = {"edgecolor": style.colour("soft"), "lw": 0.9, "zorder": 3.5}
            if centre is not None and source is view:
                indicator = ax.indicate_inset((*low, *(high - low)), inset, alpha=0.9, **look)
                for line in indicator.connectors or ():
                    line.set(linewidth=0.5)
            else:
                source.ax.add_patch(Rectangle(low, *(high - low), fill=False, **look))
            if depth < _DEEPEST:
                pending += [(child, inner, depth + 1) for inner in child.windows()]
        rows = -(-placed // columns)
        return rows * (side + _FOOT + 8) + (6 if rows else 0)

    def _inset(self, ax: Axes, source: _View, window: _Window, style: Style) -> tuple[_View, _Window]:
        """Draws what a window shows, or a window in it that is for the same cusps; returns that one."""
        ax.set(xticks=[], yticks=[])
        for _ in range(_DEEPEST):
            low, high = window.centre - window.half, window.centre + window.half
            ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
            view = _View.of(ax, self, source.side, source.zoom * window.zoom)
            inner = [other for other in view.windows() if other.members == window.members]
            if not inner:
                break
            window = replace(inner[0], zoom=window.zoom * inner[0].zoom)
        _draw_ticks(ax, low, high, style)
        counts = np.clip(view.winding(_FINENESS), 0, 6)
        shades = np.array([_rgb(style.colour(role_of(n))) for n in range(7)], dtype=np.uint8)
        extent = low[0], high[0], low[1], high[1]
        ax.imshow(
            shades[counts], extent=extent, origin="lower", aspect="auto", interpolation="none", zorder=0.5
        )
        view.draw_curves(style)
        view.draw_letters(style, view.members())
        names = ", ".join(self.curves.letters[k] for k in window.members)
        ax.set_xlabel(f"{names}: × {factor(view.zoom)}", size=9, labelpad=3, color=style.colour("soft"))
        return view, window

    def _regions(self) -> Iterator[tuple[int, list[Places]]]:
        """Yields the regions with their numbers of poses; rings of holes run the other way."""
        x0, y0, x1, y1 = self.limits
        for region in self.document.get("regions", ()):
            rings = [
                np.column_stack([ring[n.lower()] for n in self.names]).astype(float)
                for ring in region["rings"]
            ]
            if not region["bounded"]:
                rings.insert(0, np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]))
            yield (
                region["poses"],
                [
                    closed(ring if (_area(ring) > 0) == (k == 0) else ring[::-1])
                    for k, ring in enumerate(rings)
                ],
            )

    def facts(self) -> str:
        """The picture in words."""
        first, second = self.names
        cusps = [
            f"{name} at {first} = {short(float(x), 6)}, {second} = {short(float(y), 6)}"
            for name, (x, y) in zip(self.curves.letters, self.cusps, strict=True)
        ]
        listing = f" Cusps: {'; '.join(cusps)}." if cusps else ""
        return f"Singular curves in the plane of {listed(self.names)}.{listing}"


@dataclass(frozen=True)
class _Window:
    """A square of the plane to be magnified.

    Attributes:
        centre: its centre.
        half: half of its sides, in both lengths.
        zoom: how often larger it is drawn.
        members: the numbers, from 0, of the cusps that it is for.
    """

    centre: Places
    half: Places
    zoom: float
    members: tuple[int, ...]


@dataclass(frozen=True)
class _View:
    """Axes that show a part of the plane, with the curves refined for them.

    Attributes:
        ax: the axes.
        plane: what they show.
        room: where there is room in them.
        poses: those of each strand, refined.
        lines: their places in points.
        side: that of its insets.
        zoom: how often larger they show it than the whole picture does.
    """

    ax: Axes
    plane: _JointPlane
    room: Room
    poses: list[Places]
    lines: list[Places]
    side: float
    zoom: float

    @classmethod
    def of(cls, ax: Axes, plane: _JointPlane, side: float, zoom: float = 1.0) -> _View:
        """The view of axes with their final limits, and insets of this side."""
        room, floats = Room(ax), plane.curves.floats

        def place(poses: Places) -> Places:
            return room.points(floats.lengths(poses))

        poses = plane.curves.lines(place, (0.0, 0.0, *room.size))
        return cls(ax, plane, room, poses, [place(line) for line in poses], side, zoom)

    @property
    def cusps(self) -> Places:
        """The places of the cusps in points."""
        return self.room.points(self.plane.cusps)

    def members(self) -> list[int]:
        """The cusps in these axes."""
        return [k for k, at in enumerate(self.cusps) if (at > 0).all() and (at < self.room.size).all()]

    def points_of(self, half: Places) -> float:
        """A half side of a window in points."""
        low, high = self.room.points([(0.0, 0.0), half])
        return float((high - low).max())

    def marked(self, window: _Window) -> tuple[Places, Places]:
        """The corners of the frame round a window, which is large enough to be seen."""
        half = window.half * max(1.0, _MARK / 2 / self.points_of(window.half))
        return window.centre - half, window.centre + half

    def draw_curves(self, style: Style) -> None:
        """Draws the curves, and circles round cusps."""
        floats, size = self.plane.curves.floats, self.room.size
        pieces = []
        for poses, line in zip(self.poses, self.lines, strict=True):
            near = ((line > -40) & (line < size + 40)).all(axis=1)
            near = near | np.append(near[1:], False) | np.append(False, near[:-1])
            near |= _crossing(line, size)
            values = floats.lengths(poses)
            values[~near] = np.nan
            pieces += [values, [(np.nan, np.nan)]]
            self.room.add_line(line)
        self.ax.plot(*_thinned(np.concatenate(pieces)).T, color=style.colour("curve"), lw=CURVE, zorder=2)
        draw_circles(self.ax, self.plane.cusps[self.members()], style)
        for at in self.cusps:
            self.room.add_point(at, CIRCLE / 2)

    def draw_letters(self, style: Style, members: Sequence[int]) -> None:
        """Writes the letters of cusps, those at one place together."""
        for group in self._together(members):
            names = ", ".join(self.plane.curves.letters[k] for k in group)
            label_cusp(self.room, self.plane.cusps[group[0]], names, style)

    def _together(self, members: Sequence[int]) -> list[list[int]]:
        groups: list[list[int]] = []
        for k in members:
            known = next(
                (g for g in groups if np.hypot(*(self.cusps[g[0]] - self.cusps[k])) < _SAME * self.zoom + 1),
                None,
            )
            groups.append([k]) if known is None else known.append(k)
        return groups

    def windows(self) -> Iterator[_Window]:
        """Yields the windows that are needed to see every cusp of these axes."""
        members = self.members()
        rooms = {k: self._clear(k) for k in members}
        crowded = [k for k in members if rooms[k] < _CLEAR]
        while crowded:
            group, grown = [crowded.pop(0)], True
            while grown:
                near = [
                    k
                    for k in crowded
                    if min(np.hypot(*(self.cusps[k] - self.cusps[i])) for i in group) < _REACH
                ]
                crowded = [k for k in crowded if k not in near]
                group += near
                grown = bool(near)
            yield from self._window(sorted(group), min(rooms[k] for k in group))

    def _window(self, group: list[int], clear: float) -> Iterator[_Window]:
        """Yields the window of a group, unless no factor shows more of it."""
        at = self.cusps[group]
        low, high = at.min(axis=0), at.max(axis=0)
        widest = self.side / max(1.5 * float((high - low).max()), 1e-300)
        zoom = min(_SHOWN * _CLEAR / max(clear, 1e-300), widest)
        if min(zoom, widest) >= _LEAST_ZOOM and zoom * self.zoom <= _MOST_ZOOM:
            zoom = _readable(zoom * self.zoom) / self.zoom
            half = self.side / zoom / 2
            values = self.ax.transData.inverted()
            scale, corner = self.room._scale, self.room._corner
            centre = (low + high) / 2
            first, last = (
                values.transform(point / scale + corner) for point in (centre - half, centre + half)
            )
            yield _Window((first + last) / 2, (last - first) / 2, zoom, tuple(group))

    def _clear(self, k: int) -> float:
        """How far a cusp is from everything else, in points; other pieces of curve count twice."""
        at, least = self.cusps[k], _SAME * max(self.zoom, 1.0) ** 0.5
        others = [
            np.delete(self.cusps, k, axis=0),
            self.room.points(self.plane.curves.floats.lengths(self.plane.curves.corners)),
        ]
        aside = []
        home, index = self.plane.curves.homes[k]
        for i, line in enumerate(self.lines):
            far = np.hypot(*(line - at).T)
            if i == home:
                pose = self.plane.curves.strands[home].poses[index]
                own = int(np.flatnonzero((self.poses[i] == pose).all(axis=1))[0])
                far = _but_own(far, own)
            aside.append(far)
        points = np.concatenate(others)
        distances = np.concatenate((np.hypot(*(points - at).T), *(far * _CLEAR / _ASIDE for far in aside)))
        distances = distances[distances > least]
        return float(distances.min()) if len(distances) else np.inf

    def winding(self, dots: int) -> Any:
        """The numbers of poses on a grid over these axes, from below; outlines are precise in them."""
        wide, high = self.room.size
        counts = np.zeros((dots, dots + 1), dtype=int)
        rows = (np.arange(dots) + 0.5) * high / dots
        for strand, line in zip(self.plane.curves.strands, self.lines, strict=True):
            a, b = line[:-1], line[1:]
            first, last = (
                np.searchsorted(rows, side)
                for side in (np.minimum(a[:, 1], b[:, 1]), np.maximum(a[:, 1], b[:, 1]))
            )
            for k in np.flatnonzero((last > first) & (np.minimum(a[:, 0], b[:, 0]) < wide)):
                span = np.arange(first[k], last[k])
                share = (rows[span] - a[k, 1]) / (b[k, 1] - a[k, 1])
                x = a[k, 0] + share * (b[k, 0] - a[k, 0])
                column = np.clip(np.ceil(x / wide * dots - 0.5), 0, dots).astype(int)
                np.add.at(counts, (span, column), strand.sense if b[k, 1] > a[k, 1] else -strand.sense)
        return 2 * np.abs(counts.cumsum(axis=1)[:, :dots])


def _draw_ticks(ax: Axes, low: Places, high: Places, style: Style) -> None:
    """Draws ticks at round lengths on the edges of an inset, without numbers."""
    locator = MaxNLocator(4)
    lines: list[tuple[float, float]] = []
    for k in (0, 1):
        for value in locator.tick_values(low[k], high[k]):
            share = (value - low[k]) / (high[k] - low[k])
            for start, stop in ((0.0, _TICK), (1.0 - _TICK, 1.0)) if 0 < share < 1 else ():
                ends = [(share, start), (share, stop), (np.nan, np.nan)]
                lines += ends if k == 0 else [(y, x) for x, y in ends]
    x, y = np.reshape(lines, (-1, 2)).T
    ax.plot(x, y, color=style.colour("soft"), lw=0.75, transform=ax.transAxes, zorder=2.5)


def _but_own(far: Any, own: int) -> Any:
    """Distances along a line from a cusp on it, without its own branches."""
    away = np.flatnonzero(far > _OWN)
    before, after = away[away < own], away[away > own]
    first = before[-1] + 1 if len(before) else 0
    last = after[0] if len(after) else len(far)
    return np.concatenate((far[:first], far[last:]))


def _crossing(line: Places, size: Any) -> Any:
    """Which points of a line begin or end a chord that may cross the axes."""
    a, b = line[:-1], line[1:]
    meets = ((np.minimum(a, b) < size) & (np.maximum(a, b) > 0)).all(axis=1)
    return np.append(meets, False) | np.append(False, meets)


def _thinned(values: Places) -> Places:
    """Points without those between others that are left out."""
    gone = np.isnan(values[:, 0])
    return values[~(gone & np.append(False, gone[:-1]))]


def _readable(zoom: float) -> float:
    power = 10.0 ** floor(log10(zoom))
    return power * max(step for step in _STEPS if step * power <= zoom * 1.0000001)


def factor(zoom: float) -> str:
    """A factor of magnification.

    >>> factor(2.5), factor(40), factor(3000), factor(2e6)
    ('2.5', '40', '3000', '2 million')
    """
    return f"{zoom:.10g}" if zoom < 1e6 else f"{zoom / 1e6:.10g} million"


def _rgb(colour: str) -> tuple[int, int, int]:
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def role_of(poses: int) -> str:
    """The shade of a number of poses."""
    return f"poses{max(level for level in _LEVELS if level <= poses)}"


def closed(ring: Places) -> Places:
    """A ring that ends where it begins."""
    return np.concatenate((ring, ring[:1]))


def _area(ring: Places) -> float:
    x, y = ring.T
    return float((np.roll(x, 1) * y - x * np.roll(y, 1)).sum())


def draw_circles(ax: Axes, places: Places, style: Style) -> None:
    """Circles round cusps."""
    look = {"mfc": "none", "mec": style.colour("cusp"), "mew": 1.05, "zorder": 3}
    ax.plot(*np.reshape(places, (-1, 2)).T, ls="", marker="o", ms=CIRCLE, **look)


def label_cusp(room: Room, at: Any, names: str, style: Style) -> None:
    """The letters of cusps."""
    room.label(at, names, reach=CIRCLE / 2 + 2, size=11, weight="bold", color=style.colour("cusp"), zorder=5)


def legend_below(ax: Axes, handles: Sequence[Any], down: float = AXIS) -> None:
    """A legend below axes, in one row if it has room there, else in columns."""
    if not handles:
        return
    wide, high = size_of(ax)
    look = {"handles": handles, "loc": "upper center", "handlelength": 1.4}
    look["bbox_to_anchor"] = 0.5, -down / high
    first = len(handles) if len(handles) < _ROW else 1
    extent = ax.legend(**look, ncols=first).get_window_extent().width / ax.get_window_extent().width
    if first > 1 and extent * wide > wide + _OVER:
        extent = ax.legend(**look, ncols=1).get_window_extent().width / ax.get_window_extent().width
        first = 1
    if first == 1:
        ax.legend(**look, ncols=max(int((wide + _OVER) / (extent * wide)), 1))
