"""A slice on the torus of α and the fixed leg's angle: singular curves, aspects and cusps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import ceil, floor
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.transforms import Bbox

from rpr_solver.figures.joint_plane import CIRCLE, CURVE, closed, draw_circles, label_cusp, legend_below
from rpr_solver.figures.room import Room
from rpr_solver.figures.strands import Places, SliceCurves
from rpr_solver.figures.words import figure_about, short
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import Figure

_SHARE = 0.92
"""The height of the plot, by its width."""
_NARROW = 300.0
_SHADES = 3


def torus_figure(document: Mapping[str, Any]) -> Figure:
    """The singular curves of a slice on the torus of (α, θ), with its aspects coloured.

    Args:
        document: as :meth:`SingularCurves.to_json` gives it.
    """
    curves, areas = SliceCurves.of(document), areas_of(document)
    counted = " and ".join(
        f"{sum(area.sign == sign for area in areas)} with {_SIGNS[sign]}" for sign in (1, -1)
    )
    title = f"Aspects at L{curves.leg} = {short(document[f'l{curves.leg}'], 8)}: {counted}"
    text = (
        f"Singular curves J = 0 in the plane of θ{curves.leg} and α, both from −180° to 180°, opposite sides "
        f"glued; the areas between them are the aspects: {counted}. Circles: {len(curves.cusps)} cusps."
    )

    def paint(ax: Axes, style: Style) -> None:
        ax.set(
            xlim=(-180, 180), ylim=(-180, 180), xlabel=style.words(f"θ{curves.leg}"), ylabel=style.words("α")
        )
        step = 60 if ax.get_window_extent().width > _NARROW else 90
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_ticks(
                range(-180, 181, step), [f"{n}°".replace("-", "−") for n in range(-180, 181, step)]
            )
        ax.grid(visible=True)
        roles = list(_roles(areas))
        for area, role in roles:
            ax.add_patch(PathPatch(area.path(), facecolor=style.colour(role), lw=0, zorder=0.5))
        room = Room(ax)
        draw_strands(ax, room, curves, style)
        cusps = curves.cusps[:, ::-1]
        draw_circles(ax, cusps, style)
        for place in room.points(cusps):
            room.add_point(place, CIRCLE / 2)
        for name, cusp in zip(curves.letters, cusps, strict=True):
            label_cusp(room, cusp, name, style)
        for area in areas:
            biggest = max(area.rings, key=_extent)
            room.number(
                [closed(biggest)], style.words(_SIGNS[area.sign]), size=10.5, color=style.colour("ink")
            )
        handles = {
            role: Patch(
                fc=style.colour(role),
                ec=style.colour("soft"),
                lw=0.6,
                label=style.words(_SIGNS[area.sign]) + ("" if role.endswith("1") else ", another aspect"),
            )
            for area, role in roles
        }
        legend_below(ax, list(handles.values()))

    return figure_about(document, title, text, paint, lambda wide: _SHARE * wide)


_SIGNS = {1: "J > 0", -1: "J < 0"}


@dataclass(frozen=True)
class Area:
    """An aspect: the sign of J, and rings of (θ, α) that together cover it."""

    sign: int
    rings: tuple[Places, ...]

    def path(self, window: Bbox | None = None) -> Path | None:
        """The outline of those rings that may meet a window; None if none does."""
        paths = [Path(closed(ring), closed=True) for ring in self.rings]
        paths = [path for path in paths if window is None or window.overlaps(path.get_extents())]
        return Path.make_compound_path(*paths) if paths else None


def areas_of(document: Mapping[str, Any]) -> list[Area]:
    """The aspects of a document of singular curves."""
    theta = f"theta{document['fixed_leg']}_deg"
    return [
        Area(
            aspect["sign"],
            tuple(
                np.column_stack((ring[theta], ring["alpha_deg"])).astype(float) for ring in aspect["polygons"]
            ),
        )
        for aspect in document.get("aspects", ())
    ]


def draw_strands(ax: Axes, room: Room, curves: SliceCurves, style: Style) -> None:
    """Draws the singular curves on the torus, as often as they are seen in axes."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    for poses in curves.lines(lambda poses: room.points(poses[:, ::-1])):
        line = poses[:, ::-1]
        turns = (
            range(floor((first - most) / 360) + 1, ceil((last - least) / 360))
            for first, last, least, most in zip(
                (left, low), (right, high), line.min(axis=0), line.max(axis=0), strict=True
            )
        )
        for shift in product(*turns):
            moved = line + 360.0 * np.array(shift)
            ax.plot(*moved.T, color=style.colour("curve"), lw=CURVE, zorder=2)
            room.add_line(room.points(moved))


def _roles(areas: Sequence[Area]) -> Iterator[tuple[Area, str]]:
    """Yields each aspect with its colour: that of its sign, in shades for several."""
    seen = {1: 0, -1: 0}
    for area in areas:
        shade = min(seen[area.sign], _SHADES - 1) + 1
        seen[area.sign] += 1
        yield area, f"{'plus' if area.sign > 0 else 'minus'}{shade}"


def _extent(ring: Places) -> float:
    wide, high = np.ptp(ring, axis=0)
    return float(wide * high)
