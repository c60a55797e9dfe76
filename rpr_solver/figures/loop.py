"""A loop round a cusp, or a path between poses, in motion: the point in joint space, the mechanism beside it.

The motion runs to the end, rests, runs back and rests. Without motion the picture shows the loop, the pose at
its start, and the pose at its end behind it.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import atan2, ceil, cos, degrees, radians, sin
from typing import Any

from rpr_solver.contract import letter
from rpr_solver.figures.axes import Frame
from rpr_solver.figures.labels import OccupancyGrid
from rpr_solver.figures.mechanism import Triangles, Triple, View, base_shapes, joint, platform_shape
from rpr_solver.figures.sheet import number, sheet, short
from rpr_solver.figures.strands import Angles, SliceCurves, cusp_mark, smooth
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import (
    Box,
    Disc,
    Group,
    Motion,
    Paint,
    Path,
    Point,
    Scene,
    Shape,
    clipped,
    distance,
)
from rpr_solver.notebook.style import Style

_WIDTH, _HEIGHT, _NARROW = 980.0, 500.0, 620.0
_FRAMES, _REST = 36, 6
_SECONDS = 9.0

Keyframe = tuple[float, float, float, float]


@dataclass(frozen=True)
class _Layout:
    """Where the joint plane and the mechanism are drawn.

    Attributes:
        plot: the frame of the joint plane.
        stage: the box of the mechanism, with its labels around it.
        size: of the whole picture.
    """

    plot: Box
    stage: Box
    size: Point

    @classmethod
    def of(cls, wide: float) -> _Layout:
        """Side by side, or one below the other in a narrow picture."""
        if wide < _NARROW:
            high = 0.9 * (wide - 100)
            plot = Box(76, 50, wide - 24, 50 + high)
            stage = Box(50, plot.y1 + 76, wide - 50, plot.y1 + 76 + high)
            return cls(plot, stage, (wide, stage.y1 + 70))
        share = wide / _WIDTH
        high = share * _HEIGHT
        plot = Box(76, 50, 470 * share, high - 90)
        return cls(plot, Box(520 * share, 60, wide - 30, high - 70), (wide, high))


@drawing
def loop_figure(style: Style, path: Mapping[str, Any], curves: Mapping[str, Any] | None = None) -> Scene:
    """Draws a path, which may come back to its leg lengths.

    Args:
        path: as :meth:`Path.to_json` gives it.
        curves: the singular curves of the slice, as :meth:`SingularCurves.to_json` gives them; None leaves
            them out.
    """
    course = _Course.of(path)
    leg, cusp = path["fixed_leg"], path["cusp"]
    lengths = dict.fromkeys(short(end.get(f"l{leg}", path.get(f"l{leg}")), 8) for end in _ends(path))
    slice_name = f"L{leg} = {' to '.join(lengths)}"
    around = f"round cusp {letter(cusp)} at {slice_name}" if cusp else f"at {slice_name}"
    names_of_ends = _names(path)
    start, stop = names_of_ends
    layout = _Layout.of(style.width or _WIDTH)
    names = [style.axis(f"L{k}") for k in (1, 2, 3) if k != leg]
    shapes = [
        *_joint_plane(course, curves, layout.plot, names),
        *_mechanism(course, names_of_ends, layout.stage),
    ]
    first, second = ("Above", "Below") if layout.size[0] < _NARROW else ("Left", "Right")
    text = (
        f"{first}: the path of the leg lengths in joint space, {around}. {second}: the mechanism, which "
        f"begins in {start} and ends in {stop}{' of the same leg lengths' if path['closed'] else ''}, and is "
        "nowhere singular between."
    )
    title = f"{'Loop' if path['closed'] else 'Path'} {around}: from {start} to {stop}"
    return sheet(style, title, path["geometry"], text, shapes, layout.size)


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
        alphas: the orientation in degrees, continuous.
    """

    fixed_leg: int
    shape: Triangles
    route: tuple[Point, ...]
    joints: tuple[Point, ...]
    platforms: tuple[Triple, ...]
    alphas: tuple[float, ...]

    @classmethod
    def of(cls, path: Mapping[str, Any]) -> _Course:
        """The course of a document, with not too many samples."""
        leg, shape, samples = path["fixed_leg"], Triangles.of(path["geometry"]), path["samples"]
        first, second = (f"l{k}" for k in (1, 2, 3) if k != leg)
        route = tuple((number(sample[first]), number(sample[second])) for sample in samples)
        if "deviation" in path:
            samples = list(_at_even_times(samples))
        step = ceil((len(samples) - 1) / _FRAMES)
        samples = [*samples[:-1:step], samples[-1]]
        alphas = tuple(number(sample["alpha_deg"]) for sample in samples)
        platforms = []
        for sample, alpha in zip(samples, alphas, strict=True):
            theta, length = number(sample[f"theta{leg}_deg"]), shape.length(sample[f"l{leg}"])
            platforms.append(shape.placed(alpha, shape.held(leg, length, alpha, theta)))
        joints = tuple((number(sample[first]), number(sample[second])) for sample in samples)
        return cls(leg, shape, route, joints, tuple(platforms), alphas)


def _at_even_times(samples: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, str]]:
    """Samples at equal intervals of time, where those of a motion or of a chord are not: linearly between."""
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
    course: _Course, curves: Mapping[str, Any] | None, plot: Box, names: Sequence[str]
) -> Iterator[Shape]:
    bounds = Box.around(course.route)
    margin = 0.45 * max(bounds.width, bounds.height)
    x0, y0 = max(bounds.x0 - margin, 0.0), max(bounds.y0 - margin, 0.0)
    frame = Frame.of(plot, Box(x0, y0, bounds.x1 + margin, bounds.y1 + margin))
    loop = frame.line(course.route)
    room = OccupancyGrid(plot.grown(-4), [loop])
    yield from frame.shapes(names[0], names[1])
    if curves is not None:
        yield from _curves(curves, frame, room)
    yield Group((Path((loop,), Paint(stroke="mark", width=2.4)), *_arrow(loop)), "path of the leg lengths")
    point = (Disc((0, 0), 6.5, Paint("mark", "paper", 1.5)),)
    moves = [(x, y, 0.0, 1.0) for x, y in frame.line(course.joints)]
    yield Group(point, "leg lengths", motion=_motion(moves))


def _curves(document: Mapping[str, Any], frame: Frame, room: OccupancyGrid) -> Iterator[Shape]:
    """Yields the singular curves in the frame, and the cusps there."""
    slice_curves = SliceCurves.of(document)

    def place(pose: Angles) -> Point:
        return frame.place(slice_curves.floats.lengths(pose))

    lines = [piece for line in slice_curves.lines(place, frame.box) for piece in clipped(line, frame.box)]
    shape = smooth(lines)
    for line in shape.lines:
        room.add_line(line)
    yield Group((shape,), "singular curves")
    for k, at in enumerate(map(place, slice_curves.poses), 1):
        if at in frame.box.grown(-8):
            room.add_point(at)
            yield cusp_mark(k, at)
            yield room.near(at, letter(k), 15, 16, "cusp")


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
    ends = (rings[0], names[0], "line1"), (rings[-1], names[1], "cusp")
    yield Path((base,), Paint("tint", "soft", 1.4, (6, 4)), closed=True)
    for ring, pose, role in ends:
        yield Group((Path((ring,), Paint(stroke=role, width=1.6, dash=(5, 4)), closed=True),), pose)
    yield Group(tuple(base_shapes(base))[1:], "ground")
    platform = [(view.scale * x, -view.scale * y) for x, y in course.shape.platform]
    turns = [-alpha for alpha in course.alphas]
    moves = [(*ring[0], turn, 1.0) for ring, turn in zip(rings, turns, strict=True)]
    yield Group((platform_shape(platform),), "platform", motion=_motion(moves))
    for k, foot in enumerate(base):
        yield from _leg(foot, [ring[k] for ring in rings])
    yield Group(tuple(joint(point) for point in platform), motion=_motion(moves))
    yield from (joint(point) for point in base)
    yield from _labels(base, ends, Box(stage.x0 - 20, stage.y0 - 14, stage.x1 + 22, stage.y1 + 40))


def _labels(
    base: Sequence[Point], ends: Sequence[tuple[Sequence[Point], str, str]], around: Box
) -> Iterator[Shape]:
    """Yields the names of the base points and of the poses, where they hide nothing."""
    (first, _, _), (last, _, _) = ends
    room = OccupancyGrid(around, ([*ring, ring[0]] for ring in (base, first, last)))
    for (x, y), head in zip(base, first, strict=True):
        room.add_box(Box(x - 12, y - 8, x + 12, y + 21))
        room.add_line([(x, y), head])
    for k, point in enumerate(base, 1):
        yield room.near(point, f"A{k}", 14, 15)
    for ring, pose, role in ends:
        centre = sum(x for x, _ in ring) / 3, sum(y for _, y in ring) / 3
        yield room.near(centre, pose, 13, 4, role)


def _leg(foot: Point, heads: Sequence[Point]) -> Iterator[Shape]:
    """Yields the rod of a leg, which is stretched as it moves, and its cylinder."""
    lengths = [distance(foot, head) for head in heads]
    turns = _continuous([degrees(atan2(y - foot[1], x - foot[0])) for x, y in heads])
    rod = Path((Box(0, -1.5, 1, 1.5).corners,), Paint("ink"), closed=True)
    stretched = [(*foot, turn, length) for turn, length in zip(turns, lengths, strict=True)]
    yield Group((rod,), motion=_motion(stretched))
    cylinder = Path((Box(0, -4.5, 0.6 * min(lengths), 4.5).corners,), Paint("tint", "ink", 1.4), closed=True)
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
