"""A loop round a cusp, or a path between poses: joint space, the torus of poses, the mechanism.

The path crosses singular curves in joint space, where they are of other poses, and none on the torus. Numbers
are at equal times in all three.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch

from rpr_solver.contract import letter
from rpr_solver.figures.joint_plane import CIRCLE, CURVE, draw_circles, label_cusp
from rpr_solver.figures.mechanism import (
    Triangles,
    corners,
    draw_base,
    draw_joints,
    draw_leg,
    draw_platform,
    fit,
    stage_height,
)
from rpr_solver.figures.room import Room, size_of
from rpr_solver.figures.strands import Places, SliceCurves
from rpr_solver.figures.torus import areas_of, draw_strands
from rpr_solver.figures.words import figure_about, number, short
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import Figure

_WIDTH, _NARROW = 700.0, 430.0
_FRAMES, _TIMES = 36, 5
"""Samples of a path with times of its own, and how often the platform is drawn, from the start to the end."""
_AXIS, _BESIDE = 44.0, 54.0
"""Below a plane, and between two."""
_TURNS = range(-2, 3)


def loop_figure(path: Mapping[str, Any], curves: Mapping[str, Any] | None = None) -> Figure:
    """A path, which may come back to its leg lengths.

    Args:
        path: as :meth:`Path.to_json` gives it.
        curves: the singular curves of the slice, with its aspects, as :meth:`SingularCurves.to_json` gives
            them; None leaves them out.
    """
    course = _Course.of(path)
    leg, cusp, ends = path["fixed_leg"], path["cusp"], (path["from"], path["to"])
    lengths = dict.fromkeys(short(end.get(f"l{leg}", path.get(f"l{leg}")), 8) for end in ends)
    slice_name = f"L{leg} = {' to '.join(lengths)}"
    around = f"round cusp {letter(cusp)} at {slice_name}" if cusp else f"at {slice_name}"
    start, stop = (
        f"pose {end['pose']}" if end["pose"] else name
        for end, name in zip(ends, ("the start", "the end"), strict=True)
    )
    known = None if curves is None else (SliceCurves.of(curves), areas_of(curves))

    def paint(ax: Axes, style: Style) -> None:
        ax.set_axis_off()
        size = size_of(ax)
        joints, torus, stage = (
            ax.inset_axes((x / size[0], 1 - (y + high) / size[1], wide / size[0], high / size[1]))
            for x, y, wide, high in _boxes(course, size[0])
        )
        first, second = (style.axis(f"L{k}") for k in (1, 2, 3) if k != leg)
        _limit(joints, course.route, least=0.0)
        joints.set(xlabel=first, ylabel=second)
        _limit(torus, course.angles)
        torus.set(xlabel=style.words(f"θ{leg} [°]"), ylabel=style.words("α [°]"))
        rooms = Room(joints), Room(torus)
        if known is not None:
            _draw_slice(joints, rooms[0], known[0], style)
            _draw_torus(torus, rooms[1], *known, style)
        _draw_course(joints, rooms[0], course.route, course.at(course.joints), style)
        _draw_course(torus, rooms[1], course.angles, course.at(course.turns), style)
        _draw_mechanism(stage, course, (f"1: {start}", f"{_TIMES}: {stop}"), style)

    back = " of the same leg lengths" if path["closed"] else ""
    text = (
        f"First the path of the leg lengths in joint space, {around}; the singular curves that it crosses "
        f"are of other poses. Then the same on the torus of poses, where it crosses none. At the bottom the "
        f"mechanism, which begins in {start} and ends in {stop}{back}, and is nowhere singular between. The "
        f"numbers 1 to {_TIMES} are at equal times."
    )
    title = f"{'Loop' if path['closed'] else 'Path'} {around}: from {start} to {stop}"
    remark = f"1 to {_TIMES}: equal times{'' if curves is None else '; circles: cusps'}"

    def height(wide: float) -> float:
        *_, (_, y, _, high) = _boxes(course, wide)
        return y + high

    return figure_about(path, title, text, paint, height, remark, width=_WIDTH)


def _boxes(course: _Course, wide: float) -> list[tuple[float, float, float, float]]:
    """Left, top, width and height of joint space, the torus and the mechanism."""
    if wide < _NARROW:
        side, high = wide, 0.75 * wide
        planes = [(0.0, 0.0, side, high), (0.0, high + _AXIS, side, high)]
    else:
        side = (wide - _BESIDE) / 2
        high = 0.85 * side
        planes = [(0.0, 0.0, side, high), (side + _BESIDE, 0.0, side, high)]
    top = planes[-1][1] + high + _AXIS
    return [*planes, (0.0, top, wide, stage_height([course.shape.base, *course.platforms], wide))]


@dataclass(frozen=True)
class _Course:
    """The samples of a path in floats.

    Attributes:
        shape: the triangles, in their unit.
        route: the lengths of the free legs at all samples.
        angles: the fixed leg's angle and the orientation, continuous, at all samples.
        joints: the lengths of the free legs at the samples that are at even times.
        turns: the angles at these.
        platforms: the points of the platform there.
    """

    shape: Triangles
    route: Places
    angles: Places
    joints: Places
    turns: Places
    platforms: tuple[Any, ...]

    @classmethod
    def of(cls, path: Mapping[str, Any]) -> _Course:
        """The course of a document."""
        leg, shape, samples = path["fixed_leg"], Triangles.of(path["geometry"]), path["samples"]
        free = [f"l{k}" for k in (1, 2, 3) if k != leg]
        angular = (f"theta{leg}_deg", "alpha_deg")

        def read(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Places:
            return np.array([[number(row[name]) for name in names] for row in rows])

        even = list(_at_even_times(samples)) if "deviation" in path else samples
        turns = np.unwrap(read(even, angular), period=360, axis=0)
        platforms = tuple(
            shape.placed(alpha, shape.held(leg, shape.length(row[f"l{leg}"]), alpha, theta))
            for row, (theta, alpha) in zip(even, turns, strict=True)
        )
        angles = np.unwrap(read(samples, angular), period=360, axis=0)
        return cls(shape, read(samples, free), angles, read(even, free), turns, platforms)

    def at(self, rows: Any) -> Any:
        """Those of rows at even times that are drawn."""
        last = len(rows) - 1
        return [rows[round(k * last / (_TIMES - 1))] for k in range(_TIMES)]


def _at_even_times(samples: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, str]]:
    """Samples at equal times, interpolated linearly: those of a motion or of a chord are not."""
    times = [float(Fraction(sample["time"])) for sample in samples]
    names = [name for name in samples[0] if name not in ("time", "place")]
    for k in range(_FRAMES + 1):
        time = times[-1] * k / _FRAMES
        row = min(bisect_right(times, time), len(times) - 1)
        share = (time - times[row - 1]) / (times[row] - times[row - 1])
        before, after = samples[row - 1], samples[row]
        yield {
            name: repr(x + share * (number(after[name]) - x))
            for name in names
            for x in (number(before[name]),)
        }


def _limit(ax: Axes, points: Places, least: float = -np.inf) -> None:
    """Limits round a path."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.45 * max(*(high - low), 1e-9)
    ax.grid(visible=True)
    (x0, y0), (x1, y1) = np.maximum(low - margin, least), high + margin
    ax.set(xlim=(x0, x1), ylim=(y0, y1))


def _draw_slice(ax: Axes, room: Room, curves: SliceCurves, style: Style) -> None:
    """The singular curves and cusps of the slice in joint space."""
    floats = curves.floats

    def place(poses: Places) -> Places:
        return room.points(floats.lengths(poses))

    for line in curves.lines(place, (0.0, 0.0, *room.size)):
        values = floats.lengths(line)
        ax.plot(*values.T, color=style.colour("curve"), lw=CURVE, zorder=2)
        room.add_line(room.points(values))
    _draw_cusps(ax, room, floats.lengths(curves.cusps), curves.letters, style)


def _draw_torus(ax: Axes, room: Room, curves: SliceCurves, areas: Sequence[Any], style: Style) -> None:
    """The same on the torus, with the aspects."""
    shifts = [360.0 * np.array(shift) for shift in product(_TURNS, repeat=2)]
    for area in areas:
        face = (style.colour("plus1" if area.sign > 0 else "minus1"), 0.7)
        for shift in shifts:
            if path := area.path(ax.viewLim.translated(*-shift)):
                path.vertices += shift
                ax.add_patch(PathPatch(path, facecolor=face, lw=0, zorder=0.5))
    draw_strands(ax, room, curves, style)
    cusps = np.concatenate([curves.cusps[:, ::-1] + shift for shift in shifts])
    _draw_cusps(ax, room, cusps, curves.letters * len(shifts), style)


def _draw_cusps(ax: Axes, room: Room, cusps: Places, letters: Sequence[str], style: Style) -> None:
    """Circles and letters of the cusps in axes."""
    places = room.points(cusps)
    inside = [
        k for k, at in enumerate(places) if (at > CIRCLE / 2).all() and (at < room.size - CIRCLE / 2).all()
    ]
    draw_circles(ax, cusps[inside], style)
    for k in inside:
        room.add_point(places[k], CIRCLE / 2)
    for k in inside:
        label_cusp(room, cusps[k], letters[k], style)


def _draw_course(ax: Axes, room: Room, route: Places, stations: Sequence[Any], style: Style) -> None:
    """The path, an arrow in its direction where it is fastest, and the numbers of times."""
    mark = style.colour("mark")
    ax.plot(*route.T, color=mark, lw=1.8, zorder=3)
    places = room.points(route)
    room.add_line(places)
    k = int(np.argmax(np.hypot(*np.diff(places, axis=0).T)))
    arrow = {
        "arrowstyle": "-|>,head_width=0.28,head_length=0.5",
        "color": mark,
        "lw": 0,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    ax.annotate("", route[k + 1], route[k], arrowprops=arrow, zorder=3)
    look = {"mfc": style.colour("paper"), "mec": mark, "mew": 1.05, "zorder": 3.5}
    ax.plot(*np.array(stations).T, ls="", marker="o", ms=5, **look)
    _number_times(room, stations, lambda at: at, style.colour("mark"), range(1, _TIMES + 1))


def _number_times(
    room: Room, stations: Sequence[Any], xy: Callable[[Any], Any], colour: str, times: Sequence[int]
) -> None:
    """Writes the numbers of times, those at one place together."""
    places = room.points([xy(at) for at in stations])
    done: set[int] = set()
    for place in places:
        room.add_point(place, 2.5)
    for k, at in enumerate(stations):
        here = [i for i, place in enumerate(places) if np.hypot(*(place - places[k])) < 6 and i not in done]
        done |= set(here)
        if here:
            room.label(
                xy(at), ", ".join(str(times[i]) for i in here), reach=5.0, size=9.5, color=colour, zorder=5
            )


def _draw_mechanism(ax: Axes, course: _Course, names: tuple[str, str], style: Style) -> None:
    """The mechanism at the start, and the platform at other times; the last one has its name."""
    base, rings = np.array(course.shape.base), course.at(course.platforms)
    fit(ax, [base, *course.platforms])
    room = Room(ax)
    for ring in rings[1:-1]:
        ax.fill(*corners(ring).T, fill=False, ec=style.colour("ghost"), lw=0.75, zorder=1.5)
    look = {"fill": False, "ec": style.colour("cusp"), "ls": (0, (4, 3)), "lw": 1.3, "zorder": 2.7}
    ax.fill(*corners(rings[-1]).T, **look)
    draw_base(ax, base, style)
    draw_platform(ax, rings[0], style)
    for foot, head in zip(base, rings[0], strict=True):
        draw_leg(ax, foot, head, style)
        room.add_line(room.points(corners(np.array([foot, head]))))
    draw_joints(ax, [*base, *rings[0]], style)
    for ring in (base, *rings):
        room.add_line(room.points(corners(np.append(ring, ring[0]))))
    for x, y in room.points(corners(base)):
        room.add_box(x - 11, y - 17, x + 11, y + 5)
    for place in room.points(corners(rings[0])):
        room.add_point(place, 5)
    for k, point in enumerate(corners(base), 1):
        room.label(point, style.words(f"A{k}"), reach=8.0, size=10.5, color=style.colour("ink"))
    moves = [sum(abs(b[k] - a[k]) for a, b in pairwise(rings)) for k in range(3)]
    track = [ring[int(np.argmax(moves))] for ring in rings]
    for at, words, role in ((track[0], names[0], "line1"), (track[-1], names[1], "cusp")):
        room.label(corners(at), words, reach=7.0, size=9.5, color=style.colour(role))
    _number_times(room, track[1:-1], corners, style.colour("soft"), range(2, _TIMES))
