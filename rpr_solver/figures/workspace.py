"""The workspace: allowed places at one orientation, tinted by the sign of J; and areas by orientation.

Arcs are sampled in floats from the document's vertices: those of circles by their angle, those of the conic
by the directions in which it is seen from a point inside the arc.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from rpr_solver.figures.joint_plane import CURVE, closed, legend_below
from rpr_solver.figures.mechanism import Triangles, corners
from rpr_solver.figures.room import Room
from rpr_solver.figures.words import figure_about, number, short
from rpr_solver.notebook import Style, counted
from rpr_solver.notebook.figure import Figure

_SAMPLES = 91
"""Points of an arc."""
_GRID = 160
"""Points of the grid, in each direction, on which the conic outside is drawn."""
_MARGIN = 0.06
"""Beside what is shown, by its size."""
_LEAST, _MOST = 0.55, 1.05
"""The height of the plot, by its width."""
_LEGS = ("line1", "line2", "line3")
"""The colours of the limits of legs."""
_EDGE = 1.9
"""The width of a limit that bounds the workspace."""
_SIGNS = {1: ("plus1", "J > 0"), -1: ("minus1", "J < 0"), 0: ("poses2", "J = 0")}
_AREAS = {"positive": 1, "negative": -1, "singular": 0}
_HEIGHT = 0.5


def workspace_figure(document: Mapping[str, Any]) -> Figure:
    """The workspace at one orientation.

    Args:
        document: as :meth:`Workspace.to_json` gives it.
    """
    plane = Plane(document)
    phi, kind = short(document["phi_deg"], 8), document["conic"]["kind"]
    found = [(sign, sum(r["sign"] == sign for r in document["regions"])) for sign in (1, -1, 0)]
    said = " and ".join(f"{counted(n, 'region')} with {_SIGNS[sign][1]}" for sign, n in found if n)
    title = f"Workspace at φ = {phi}°: {said or 'no region'}"
    limits = "; ".join(_limit_words(leg, ends) for leg, ends in document["limits"].items())
    text = (
        f"Places of the platform's origin at φ = {phi}° that the legs' limits allow: {limits}. "
        f"{said or 'No region'}; J = 0 is: {kind}. The machine is drawn at one of them."
    )
    return figure_about(document, title, text, plane.paint, plane.height)


def sweep_figure(document: Mapping[str, Any]) -> Figure:
    """The areas of both signs of J against the orientation.

    Args:
        document: as :meth:`WorkspaceSweep.to_json` gives it.
    """
    rows = document["orientations"]
    phi = [number(row["phi_deg"]) for row in rows]
    areas = {sign: [number(row.get(name, "0")) for row in rows] for name, sign in _AREAS.items()}
    ends = document["phi_deg"]
    title = f"Area of the workspace against φ, from {short(ends['from'])}° to {short(ends['to'])}°"
    largest = max(rows, key=lambda row: sum(float(row.get(name, "0")) for name in _AREAS))
    text = f"Areas by the sign of J, one above the other. The largest sum is at φ = {largest['phi_deg']}°."

    def paint(ax: Axes, style: Style) -> None:
        below = np.zeros(len(phi))
        handles = []
        for sign, values in areas.items():
            if any(values):
                role, words = _SIGNS[sign]
                above = below + np.array(values)
                ax.fill_between(phi, below, above, color=style.colour(role), lw=0, zorder=1)
                ax.plot(phi, above, color=style.colour("curve"), lw=CURVE, zorder=2)
                handles.append(
                    Patch(fc=style.colour(role), ec=style.colour("soft"), lw=0.6, label=style.words(words))
                )
                below = above
        ax.set_xlim(phi[0], phi[-1] if len(phi) > 1 else phi[0] + 1)
        ax.set_ylim(0, 1.08 * (float(below.max()) or 1.0))
        unit = f" [{style.unit}²]" if style.unit else ""
        ax.set(xlabel="φ [°]", ylabel=f"area{unit}")
        ax.grid(visible=True)
        legend_below(ax, handles)

    return figure_about(document, title, text, paint, lambda wide: _HEIGHT * wide)


def _limit_words(leg: str, ends: Mapping[str, str | None]) -> str:
    low, high = ends["min"], ends["max"]
    if high is None:
        return f"{leg.upper()} ≥ {short(low or '0')}"
    return (
        f"{leg.upper()} ≤ {short(high)}"
        if low is None
        else f"{leg.upper()} from {short(low)} to {short(high)}"
    )


@dataclass(frozen=True)
class Plane:
    """The plane of places of a document."""

    document: Mapping[str, Any]

    @cached_property
    def machine(self) -> tuple[Any, Any]:
        """A1, A2, A3 and, turned but at place 0, B1, B2, B3: complex numbers in the user's unit."""
        shape = Triangles.of(self.document["geometry"])
        base, platform = (np.array(ring) * float(shape.unit) for ring in (shape.base, shape.platform))
        given = self.document.get("points", {})
        if "base" in given:
            base = _complex(given["base"])
        if "platform" in given:
            platform = _complex(given["platform"])
        return base, platform * np.exp(1j * np.radians(number(self.document["phi_deg"])))

    @cached_property
    def conic(self) -> list[float]:
        """The coefficients of J."""
        return [number(x) for x in self.document["conic"]["coefficients"].values()]

    @cached_property
    def loops(self) -> list[list[list[Any]]]:
        """Of each region its loops, each the polylines of its arcs."""
        return [
            [[self._arc(arc) for arc in loop] for loop in region["boundary"]]
            for region in self.document["regions"]
        ]

    @cached_property
    def place(self) -> complex:
        """Where the machine is drawn: inside the largest region, far from its boundary; or at a vertex."""
        if not self.loops:
            vertices = self.document["vertices"]
            return complex(self.machine[0].mean()) if not vertices else self._vertex(1)
        largest = max(range(len(self.loops)), key=lambda k: float(self.document["regions"][k]["area"]))
        lines = [np.concatenate(loop) for loop in self.loops[largest]]
        low, high = lines[0].min(axis=0), lines[0].max(axis=0)
        grid = np.stack(np.meshgrid(*(np.linspace(low[k], high[k], 41)[1:-1] for k in (0, 1))), axis=-1)
        points = grid.reshape(-1, 2)
        path = Path.make_compound_path(*(Path(closed(line), closed=True) for line in lines))
        points = points[path.contains_points(points)]
        if not len(points):
            return complex(*lines[0].mean(axis=0))
        borders = np.concatenate(lines)
        far = [float(np.hypot(*(borders - point).T).min()) for point in points]
        return complex(*points[int(np.argmax(far))])

    @cached_property
    def limits(self) -> tuple[float, float, float, float]:
        """Left, below, right and above of what is shown."""
        base, platform = self.machine
        rings = [corners(base), corners(self.place + platform)]
        rings += [np.concatenate(loop) for loops in self.loops for loop in loops]
        points = np.concatenate(rings)
        (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
        aside = _MARGIN * max(x1 - x0, y1 - y0)
        x0, y0, x1, y1 = x0 - aside, y0 - aside, x1 + aside, y1 + aside
        # as wide or as high as the shares of the plot demand
        wider = max(y1 - y0, _LEAST * (x1 - x0)) / _MOST - (x1 - x0)
        higher = _LEAST * (x1 - x0) - (y1 - y0)
        x0, x1 = x0 - max(wider, 0) / 2, x1 + max(wider, 0) / 2
        y0, y1 = y0 - max(higher, 0) / 2, y1 + max(higher, 0) / 2
        return float(x0), float(y0), float(x1), float(y1)

    def height(self, wide: float) -> float:
        """The height of the plot."""
        x0, y0, x1, y1 = self.limits
        return wide * (y1 - y0) / (x1 - x0)

    def paint(self, ax: Axes, style: Style) -> None:
        """Draws regions, limits, the conic, the machine and the legend."""
        x0, y0, x1, y1 = self.limits
        ax.set(xlim=(x0, x1), ylim=(y0, y1), xlabel=style.axis("x"), ylabel=style.axis("y"))
        ax.grid(visible=True)
        for region, loops in zip(self.document["regions"], self.loops, strict=True):
            rings = [Path(closed(np.concatenate(loop)), closed=True) for loop in loops]
            colour = style.colour(_SIGNS[region["sign"]][0])
            ax.add_patch(PathPatch(Path.make_compound_path(*rings), facecolor=colour, lw=0, zorder=0.5))
        self._draw_limits(ax, style)
        self._draw_conic(ax, style)
        self._draw_borders(ax, style)
        self._draw_machine(ax, style)
        legend_below(ax, list(self._handles(style)))

    def _draw_limits(self, ax: Axes, style: Style) -> None:
        """All circles, faintly."""
        turns = np.exp(1j * np.linspace(0, 2 * np.pi, 2 * _SAMPLES))
        for centre, radius, role in self._circles():
            look = {"color": style.colour(role), "lw": 0.7, "ls": (0, (4, 3)), "alpha": 0.75, "zorder": 1}
            ax.plot(*corners(centre + radius * turns).T, **look)

    def _circles(self) -> Iterator[tuple[complex, float, str]]:
        base, platform = self.machine
        for k, role in enumerate(_LEGS):
            for end in (self.document["limits"].get(f"l{k + 1}") or {}).values():
                if end is not None and number(end):
                    yield base[k] - platform[k], number(end), role

    def _draw_conic(self, ax: Axes, style: Style) -> None:
        """The conic outside of the regions."""
        if self.document["conic"]["kind"] == "plane":
            return
        x0, y0, x1, y1 = self.limits
        x, y = np.meshgrid(np.linspace(x0, x1, _GRID), np.linspace(y0, y1, _GRID))
        a, b, c, d, e, f = self.conic
        values = a * x * x + b * x * y + c * y * y + d * x + e * y + f
        soft = style.colour("curve")
        ax.contour(x, y, values, [0.0], colors=[soft], linewidths=0.8, linestyles=[(0, (1.5, 2))], zorder=1.4)

    def _draw_borders(self, ax: Axes, style: Style) -> None:
        """The arcs between regions and outside of them, in the colours of legs, or of the conic."""
        regions, seen = self.document["regions"], set[str]()
        for region, loops in zip(regions, self.loops, strict=True):
            for arcs, lines in zip(region["boundary"], loops, strict=True):
                for arc, line in zip(arcs, lines, strict=True):
                    is_conic = arc["on"] == "singular"
                    if is_conic and str(arc["through"]) in seen:
                        continue  # it is between two regions
                    seen.add(str(arc.get("through")))
                    role = "curve" if is_conic else _LEGS[int(arc["on"][1]) - 1]
                    width = _EDGE + 0.3 if is_conic else _EDGE
                    look = {"solid_capstyle": "round", "zorder": 2.2 if is_conic else 2}
                    ax.plot(*line.T, color=style.colour(role), lw=width, **look)
        for arc in self.document["thin"]:
            ax.plot(*self._arc(arc).T, color=style.colour(_LEGS[int(arc["on"][1]) - 1]), lw=_EDGE, zorder=2)
        alone = [self._vertex(k) for k in self.document["isolated"]]
        if alone:
            look = {"mfc": style.colour("paper"), "mec": style.colour("cusp"), "mew": 1.4, "zorder": 4}
            ax.plot(*corners(np.array(alone)).T, ls="", marker="o", ms=7, **look)

    def _draw_machine(self, ax: Axes, style: Style) -> None:
        """The machine at one place, lightly."""
        base, turned = self.machine
        platform, room = self.place + turned, Room(ax)
        ink = style.colour("ghost")
        ax.fill(*corners(base).T, facecolor="none", edgecolor=ink, lw=0.9, ls=(0, (4.5, 3)), zorder=2.6)
        for k, (foot, head) in enumerate(zip(base, platform, strict=True)):
            line = corners(np.array([foot, head]))
            ax.plot(*line.T, color=style.colour(_LEGS[k]), lw=2.2, alpha=0.55, zorder=2.8)
            room.add_line(room.points(line))
        ax.fill(
            *corners(platform).T, facecolor=(style.colour("ghost"), 0.25), edgecolor=ink, lw=1.1, zorder=2.7
        )
        look = {"mfc": style.colour("paper"), "mec": ink, "mew": 1.1, "zorder": 3}
        ax.plot(*corners(np.concatenate([base, platform])).T, ls="", marker="o", ms=5.5, **look)
        ax.plot(
            self.place.real,
            self.place.imag,
            ls="",
            marker="o",
            ms=4.5,
            color=style.colour("cusp"),
            zorder=3.2,
        )
        for loops in self.loops:
            for loop in loops:
                for line in loop:
                    room.add_line(room.points(line))
        for name, ring in (("A", base), ("B", platform)):
            for point in room.points(corners(ring)):
                room.add_point(point, 4)
            for k, point in enumerate(corners(ring), 1):
                words = {"size": 9.5, "weight": "bold", "color": style.colour("ink")}
                room.label(point, style.words(f"{name}{k}"), reach=6.0, **words)

    def _handles(self, style: Style) -> Iterator[Any]:
        for sign in dict.fromkeys(region["sign"] for region in self.document["regions"]):
            role, words = _SIGNS[sign]
            yield Patch(fc=style.colour(role), ec=style.colour("soft"), lw=0.6, label=style.words(words))
        kind = self.document["conic"]["kind"]
        if kind != "plane":
            yield Line2D([], [], color=style.colour("curve"), lw=_EDGE, label=style.words(f"J = 0 ({kind})"))
        for leg in self.document["limits"]:
            role = _LEGS[int(leg[1]) - 1]
            label = style.words(f"limits of {leg.upper()}")
            yield Line2D([], [], color=style.colour(role), lw=_EDGE, label=label)

    def _vertex(self, k: int) -> complex:
        vertex = self.document["vertices"][k - 1]
        return complex(number(vertex["x"]), number(vertex["y"]))

    def _arc(self, arc: Mapping[str, Any]) -> Any:
        """An arc as a polyline."""
        ends = None if arc["from"] is None else (self._vertex(arc["from"]), self._vertex(arc["to"]))
        if arc["on"] != "singular":
            return self._of_circle(arc, ends)
        if "line" in self.document["conic"]["kind"]:
            return corners(np.array(ends))
        return self._of_conic(complex(*(number(arc["through"][axis]) for axis in "xy")), ends)

    def _of_circle(self, arc: Mapping[str, Any], ends: tuple[complex, complex] | None) -> Any:
        leg, end = arc["on"].split()[0].split("_")
        base, platform = self.machine
        k = int(leg[1]) - 1
        centre, radius = base[k] - platform[k], number(self.document["limits"][leg][end])
        start, sweep = 0.0, 2 * np.pi
        if ends is not None:
            start, last = (float(np.angle(p - centre)) for p in ends)
            sweep = (last - start) % (2 * np.pi) or 2 * np.pi
            if not arc["ccw"]:
                sweep = sweep - 2 * np.pi if sweep < 2 * np.pi else -2 * np.pi
        elif not arc["ccw"]:
            sweep = -sweep
        share = np.linspace(0, 1, 6 + int(_SAMPLES * abs(sweep) / np.pi / 1.5))
        return corners(centre + radius * np.exp(1j * (start + sweep * share)))

    def _of_conic(self, through: complex, ends: tuple[complex, complex] | None) -> Any:
        """Points of the conic in directions from a point of it, from the tangent there to the ends."""
        a, b, c, d, e, _ = self.conic
        x, y = through.real, through.imag
        slope = complex(2 * a * x + b * y + d, b * x + 2 * c * y + e)
        tangent = 1j * slope / abs(slope)

        def seen(angles: Any) -> Any:
            u = tangent * np.exp(1j * angles)
            square = a * u.real**2 + b * u.real * u.imag + c * u.imag**2
            along = -(slope.real * u.real + slope.imag * u.imag)
            return through + np.divide(along, square, out=np.zeros_like(along), where=square != 0) * u

        if ends is None:
            return corners(seen(np.linspace(0, np.pi, _SAMPLES)))
        turns = [float(np.angle((end - through) / tangent)) for end in ends]
        # both ends are on one side of the tangent; from its point the curve comes to one at angles from 0
        # on, to the other at angles from a half turn back
        side = 1.0 if turns[0] + turns[1] > 0 else -1.0
        first, last = (abs(turn) for turn in turns)
        half = np.linspace(0, 1, _SAMPLES // 3)
        ways = (
            [first * half, np.pi + (last - np.pi) * half]
            if first < last
            else [
                np.pi + (first - np.pi) * half,
                last * half,
            ]
        )
        before, after = (seen(side * way) for way in ways)
        return corners(np.concatenate([[ends[0]], before[-2:0:-1], [through], after[1:-1], [ends[1]]]))


def _complex(points: Sequence[Sequence[str]]) -> Any:
    return np.array([complex(number(x), number(y)) for x, y in points])
