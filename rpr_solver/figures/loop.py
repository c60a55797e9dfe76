"""A loop round a cusp, or a path between poses, in motion: joint space, the torus of poses, the mechanism.

The path crosses singular curves in joint space, where they are of other poses, and none on the torus. Numbers
are at equal times in all three. The motion runs to the end, rests, runs back and rests; without motion the
picture shows the loop, and the platform at these times.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise, product
from math import atan2, ceil, cos, degrees, radians, sin
from typing import Any

from rpr_solver.contract import letter
from rpr_solver.figures.labels import OccupancyGrid, near_one_of
from rpr_solver.figures.mechanism import Triangles, Triple, View, base_shapes, joint, platform_shape
from rpr_solver.figures.sheet import Frame, number, sheet, short
from rpr_solver.figures.strands import Angles, SliceCurves, cusp_mark, smooth
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import (
    Box,
    Disc,
    Group,
    Line,
    Motion,
    Paint,
    Path,
    Point,
    Scene,
    Shape,
    clipped,
    distance,
    rectangle,
)

_WIDTH, _NARROW = 980.0, 620.0
_FRAMES, _REST = 36, 6
_SECONDS = 9.0
_TIMES = 5
"""How often the platform is drawn, from the start to the end."""
_LEFT, _RIGHT, _TOP, _AXIS = 76.0, 22.0, 50.0, 62.0
"""Around a plane: with its axis on the left, on the right, above the first one, and below with the axis."""
_TURNS = range(-2, 3)

Keyframe = tuple[float, float, float, float]


@dataclass(frozen=True)
class _Layout:
    """Where the planes and the mechanism are drawn.

    Attributes:
        planes: the boxes of joint space and of the torus.
        stage: the box of the mechanism, with its labels around it.
        size: of the whole picture.
    """

    planes: tuple[Box, Box]
    stage: Box
    size: Point

    @classmethod
    def of(cls, wide: float) -> _Layout:
        """The planes side by side, or one below the other in a narrow picture; the mechanism below."""
        if wide < _NARROW:
            side = wide - _LEFT - _RIGHT
            first = Box(_LEFT, _TOP, wide - _RIGHT, _TOP + 0.75 * side)
            second = Box(_LEFT, first.y1 + _AXIS, wide - _RIGHT, first.y1 + _AXIS + 0.75 * side)
            high = 0.7 * side
        else:
            side = wide / 2 - _LEFT - _RIGHT
            first = Box(_LEFT, _TOP, _LEFT + side, _TOP + 0.85 * side)
            second = Box(wide - _RIGHT - side, _TOP, wide - _RIGHT, first.y1)
            high = side
        top = second.y1 + _AXIS + 20
        stage = Box(50, top, wide - 50, top + high)
        return cls((first, second), stage, (wide, stage.y1 + 78))


@drawing
def loop_figure(style: Style, path: Mapping[str, Any], curves: Mapping[str, Any] | None = None) -> Scene:
    """Draws a path, which may come back to its leg lengths.

    Args:
        path: as :meth:`Path.to_json` gives it.
        curves: the singular curves of the slice, with its aspects, as :meth:`SingularCurves.to_json` gives
            them; None leaves them out.
    """
    course = _Course.of(path)
    slice_curves = None if curves is None else SliceCurves.of(curves)
    leg, cusp = path["fixed_leg"], path["cusp"]
    lengths = dict.fromkeys(short(end.get(f"l{leg}", path.get(f"l{leg}")), 8) for end in _ends(path))
    slice_name = f"L{leg} = {' to '.join(lengths)}"
    around = f"round cusp {letter(cusp)} at {slice_name}" if cusp else f"at {slice_name}"
    names_of_ends = _names(path)
    start, stop = names_of_ends
    layout = _Layout.of(style.width or _WIDTH)
    names = [style.axis(f"L{k}") for k in (1, 2, 3) if k != leg]
    shapes = [
        *_joint_plane(course, slice_curves, layout.planes[0], names),
        *_torus(course, slice_curves, layout.planes[1], (f"θ{leg} [°]", "α [°]")),
        *_mechanism(course, names_of_ends, layout.stage),
    ]
    is_narrow = layout.size[0] < _NARROW
    first, second = ("Above", "Below it") if is_narrow else ("Left", "Right")
    text = (
        f"{first}: the path of the leg lengths in joint space, {around}; the singular curves that it crosses "
        f"are of other poses. {second}: the same on the torus of poses, where it crosses none. At the "
        f"bottom: the mechanism, which begins in {start} and ends in {stop}"
        f"{' of the same leg lengths' if path['closed'] else ''}, and is nowhere singular between. The "
        f"numbers 1 to {_TIMES} are at equal times."
    )
    title = f"{'Loop' if path['closed'] else 'Path'} {around}: from {start} to {stop}"
    remark = f"1 to {_TIMES}: equal times{'' if curves is None else '; circles: cusps'}"
    return sheet(style, title, path, text, shapes, layout.size, remark)


def _ends(path: Mapping[str, Any]) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    return path["from"], path["to"]


def _names(path: Mapping[str, Any]) -> tuple[str, str]:
    """The poses at the ends; those without a number are the start and the end."""
    start, stop = (end["pose"] for end in _ends(path))
    return f"pose {start}" if start else "the start", f"pose {stop}" if stop else "the end"


@dataclass(frozen=True)
class _Course:
    """The samples of a path in floats.

    Attributes:
        fixed_leg: the leg that is held at both ends.
        shape: the triangles, in their unit.
        route: the lengths of the free legs at all samples.
        joints: the same at the samples that are drawn in motion.
        platforms: the points of the platform.
        angles: the fixed leg's angle and the orientation, continuous, at all samples.
        turns: the same at the samples that are drawn in motion.
    """

    fixed_leg: int
    shape: Triangles
    route: tuple[Point, ...]
    joints: tuple[Point, ...]
    platforms: tuple[Triple, ...]
    angles: tuple[Point, ...]
    turns: tuple[Point, ...]

    @classmethod
    def of(cls, path: Mapping[str, Any]) -> _Course:
        """The course of a document, with not too many samples."""
        leg, shape, samples = path["fixed_leg"], Triangles.of(path["geometry"]), path["samples"]
        first, second = (f"l{k}" for k in (1, 2, 3) if k != leg)
        route = tuple((number(sample[first]), number(sample[second])) for sample in samples)
        if "deviation" in path:
            samples = list(_at_even_times(samples))
        both = (
            _continuous([number(sample[name]) for sample in samples])
            for name in (f"theta{leg}_deg", "alpha_deg")
        )
        angles = tuple(zip(*both, strict=True))
        step = ceil((len(samples) - 1) / _FRAMES)
        samples = [*samples[:-1:step], samples[-1]]
        turns = (*angles[:-1:step], angles[-1])
        platforms = []
        for sample, (_, alpha) in zip(samples, turns, strict=True):
            theta, length = number(sample[f"theta{leg}_deg"]), shape.length(sample[f"l{leg}"])
            platforms.append(shape.placed(alpha, shape.held(leg, length, alpha, theta)))
        joints = tuple((number(sample[first]), number(sample[second])) for sample in samples)
        return cls(leg, shape, route, joints, tuple(platforms), angles, turns)

    @property
    def times(self) -> list[int]:
        """The samples in motion at equal times, from the first to the last."""
        last = len(self.joints) - 1
        return sorted({round(k * last / (_TIMES - 1)) for k in range(_TIMES)})


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


def _joint_plane(
    course: _Course, curves: SliceCurves | None, plot: Box, names: Sequence[str]
) -> Iterator[Shape]:
    """Yields the path of the leg lengths, with the singular curves of the slice."""
    bounds = _around(course.route)
    frame = Frame.of(plot, Box(max(bounds.x0, 0.0), max(bounds.y0, 0.0), bounds.x1, bounds.y1))
    yield from frame.shapes(names[0], names[1])
    lines: list[Line] = []
    cusps: list[tuple[int, Point]] = []
    if curves is not None:

        def place(pose: Angles) -> Point:
            return frame.place(curves.floats.lengths(pose))

        lines = [piece for line in curves.lines(place, plot) for piece in clipped(line, plot)]
        cusps = list(enumerate(map(place, curves.poses), 1))
    yield from _route(
        frame.line(course.route), frame.line(course.joints), lines, cusps, course.times, plot, "leg lengths"
    )


def _torus(course: _Course, curves: SliceCurves | None, plot: Box, names: Sequence[str]) -> Iterator[Shape]:
    """Yields the path on the torus, where it was proved to cross no singular curve."""
    frame = Frame.of(plot, _around(course.angles))
    lines: list[Line] = []
    cusps: list[tuple[int, Point]] = []
    aspects: list[Shape] = []
    if curves is not None:
        for across, up in product(_TURNS, repeat=2):

            def place(pose: Angles, across: int = across, up: int = up) -> Point:
                return frame.place((pose[1] + 360 * across, pose[0] + 360 * up))

            lines += [piece for line in curves.lines(place, plot) for piece in clipped(line, plot)]
            cusps += enumerate(map(place, curves.poses), 1)
            for area in curves.areas(place):
                rings = tuple(ring for ring in area.rings if _meet(Box.around(ring), plot))
                if rings:
                    role = "plus1" if area.sign > 0 else "minus1"
                    aspects.append(Path(rings, Paint(role, opacity=0.7), closed=True))
    yield Group(tuple(aspects), "aspects", plot)
    yield from frame.shapes(names[0], names[1])
    yield from _route(
        frame.line(course.angles), frame.line(course.turns), lines, cusps, course.times, plot, "pose"
    )


def _route(
    loop: Sequence[Point],
    moving: Sequence[Point],
    lines: Sequence[Line],
    cusps: Sequence[tuple[int, Point]],
    times: Sequence[int],
    plot: Box,
    name: str,
) -> Iterator[Shape]:
    """Yields singular curves and cusps in a plane, and the path, its times and the point that moves."""
    room = OccupancyGrid(plot.grown(-4), [loop, *lines])
    if lines:
        yield Group((smooth(lines),), "singular curves")
    seen = [(k, at) for k, at in cusps if at in plot.grown(-8)]
    for k, at in seen:
        room.add_point(at)
        yield cusp_mark(k, at)
    for k, at in seen:
        yield room.near(at, letter(k), 15, 16, "cusp")
    yield Group((Path((loop,), Paint(stroke="mark", width=2.4)), *_arrow(loop)), f"path of the {name}")
    for at in (moving[k] for k in times):
        yield Disc(at, 3.4, Paint("paper", "mark", 1.4))
    for at, words in _stations([moving[k] for k in times]):
        yield replace(room.near(at, words, 13, 11, "mark"), halo="paper")
    point = (Disc((0, 0), 6.5, Paint("mark", "paper", 1.5)),)
    yield Group(point, name, motion=_motion([(x, y, 0.0, 1.0) for x, y in moving]))


def _stations(places: Sequence[Point]) -> list[tuple[Point, str]]:
    """The numbers of times at places; those at one place together."""
    together: list[tuple[Point, list[str]]] = []
    for k, place in enumerate(places, 1):
        known = next((names for at, names in together if distance(at, place) < 8), None)
        if known is None:
            together.append((place, [str(k)]))
        else:
            known.append(str(k))
    return [(at, ", ".join(names)) for at, names in together]


def _around(points: Sequence[Point]) -> Box:
    """A window round a path."""
    bounds = Box.around(points)
    return bounds.grown(0.45 * max(bounds.width, bounds.height))


def _meet(a: Box, b: Box) -> bool:
    return a.x0 < b.x1 and b.x0 < a.x1 and a.y0 < b.y1 and b.y0 < a.y1


def _arrow(loop: Sequence[Point]) -> Iterator[Shape]:
    """Yields the direction of a loop, at its fastest."""
    k = max(range(1, len(loop)), key=lambda k: distance(loop[k - 1], loop[k]))
    (x, y), (u, v) = loop[k - 1], loop[k]
    turn = atan2(v - y, u - x)
    tips = [(u + 11 * cos(turn + side), v + 11 * sin(turn + side)) for side in (radians(155), radians(-155))]
    yield Path(([tips[0], (u, v), tips[1]],), Paint("mark"), closed=True)


def _mechanism(course: _Course, names: tuple[str, str], stage: Box) -> Iterator[Shape]:
    """Yields the mechanism in motion, and its poses at both ends with their names."""
    points = [*course.shape.base, *(point for platform in course.platforms for point in platform)]
    view = View(points, stage)
    base = view.line(course.shape.base)
    rings = [view.line(platform) for platform in course.platforms]
    ends = (rings[0], f"1: {names[0]}", "line1"), (rings[-1], f"{len(course.times)}: {names[1]}", "cusp")
    outline, *ground = base_shapes(base)
    yield outline
    for k, time in enumerate(course.times[1:-1], 2):
        yield Group((Path((rings[time],), Paint(stroke="ghost", width=1), closed=True),), f"time {k}")
    for ring, pose, role in ends:
        yield Group((Path((ring,), Paint(stroke=role, width=1.6, dash=(5, 4)), closed=True),), pose)
    yield Group(tuple(ground), "ground")
    platform = [(view.scale * x, -view.scale * y) for x, y in course.shape.platform]
    moves = [(*ring[0], -alpha, 1.0) for ring, (_, alpha) in zip(rings, course.turns, strict=True)]
    yield Group((platform_shape(platform),), "platform", motion=_motion(moves))
    for k, foot in enumerate(base):
        yield from _leg(foot, [ring[k] for ring in rings])
    yield Group(tuple(joint(point) for point in platform), motion=_motion(moves))
    yield from (joint(point) for point in base)
    yield from _labels(
        base,
        ends,
        [rings[k] for k in course.times],
        Box(stage.x0 - 20, stage.y0 - 14, stage.x1 + 22, stage.y1 + 40),
    )


def _labels(
    base: Sequence[Point],
    ends: Sequence[tuple[Sequence[Point], str, str]],
    rings: Sequence[Sequence[Point]],
    around: Box,
) -> Iterator[Shape]:
    """Yields the names of the base points and of the poses, and the times at the corner that moves most."""
    room = OccupancyGrid(around, ([*ring, ring[0]] for ring in (base, *rings)))
    for (x, y), *heads in zip(base, rings[0], strict=True):
        room.add_box(Box(x - 12, y - 8, x + 12, y + 21))
        room.add_line([(x, y), *heads])
        room.add_point(heads[0])
    for k, point in enumerate(base, 1):
        yield room.near(point, f"A{k}", 14, 15)
    corner = max(range(3), key=lambda k: sum(distance(a[k], b[k]) for a, b in pairwise(rings)))
    track = [ring[corner] for ring in rings]
    for (ring, pose, role), at in zip(ends, (track[0], track[-1]), strict=True):
        yield replace(near_one_of(room, [at, *ring], pose, 13, 10, role), halo="paper")
    for at, words in _stations(track)[1:]:
        inner = [word for word in words.split(", ") if word != str(len(track))]
        if inner:
            yield replace(room.near(at, ", ".join(inner), 13, 10, "soft"), halo="paper")


def _leg(foot: Point, heads: Sequence[Point]) -> Iterator[Shape]:
    """Yields the rod of a leg, which is stretched as it moves, and its cylinder."""
    lengths = [distance(foot, head) for head in heads]
    turns = _continuous([degrees(atan2(y - foot[1], x - foot[0])) for x, y in heads])
    rod = rectangle(Box(0, -1.5, 1, 1.5), Paint("ink"))
    stretched = [(*foot, turn, length) for turn, length in zip(turns, lengths, strict=True)]
    yield Group((rod,), motion=_motion(stretched))
    cylinder = rectangle(Box(0, -4.5, 0.6 * min(lengths), 4.5), Paint("tint", "ink", 1.4))
    yield Group((cylinder,), motion=_motion([(*foot, turn, 1.0) for turn in turns]))


def _motion(places: Sequence[Keyframe]) -> Motion:
    """There, a rest, and back."""
    rest = [places[-1]] * _REST
    back = list(reversed(places))
    return Motion((*places, *rest, *back, *([places[0]] * _REST)), _SECONDS)


def _continuous(angles: Sequence[float]) -> list[float]:
    """Each angle by whole turns as near as possible to the one before it."""
    result = list(angles[:1])
    for angle in angles[1:]:
        result.append(angle - 360 * round((angle - result[-1]) / 360))
    return result
