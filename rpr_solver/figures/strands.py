"""The strands of singular curves, read from their document and drawn at any magnification."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rpr_solver.figures.slice_floats import Angles, SliceFloats
from rpr_solver.notebook.scene import Box, Point, distance, off_segment

_DEPTH = 10
_FINE = 0.1
"""The deviation of a drawn curve, in pixels."""

Place = Callable[[Angles], Point]


@dataclass(frozen=True)
class Strand:
    """A piece of a singular curve.

    Attributes:
        poses: α and θ at its samples, in degrees, continuous.
        points: the lengths of the free legs there.
        vertices: the special points, as in the document, each with the ``index`` of its sample.
    """

    poses: tuple[Angles, ...]
    points: tuple[Point, ...]
    vertices: tuple[Mapping[str, Any], ...]


def strands_of(document: Mapping[str, Any]) -> list[Strand]:
    """The strands of a document of singular curves."""
    leg = document["fixed_leg"]
    first, second = (f"l{k}" for k in (1, 2, 3) if k != leg)
    return [
        Strand(
            tuple(zip(strand["alpha_deg"], strand[f"theta{leg}_deg"], strict=True)),
            tuple(zip(strand[first], strand[second], strict=True)),
            tuple(strand["vertices"]),
        )
        for component in document["components"]
        for strand in component["strands"]
    ]


def drawn(
    strand: Strand,
    floats: SliceFloats,
    place: Place,
    window: Box | None = None,
    places: Sequence[Point] | None = None,
) -> Iterator[list[Point]]:
    """Yields a strand in a picture as polylines that are smooth at the picture's scale.

    Args:
        strand: a strand.
        floats: its slice.
        place: the place of a pose in the picture.
        window: a box of the picture; pieces far outside it are left out. None: all.
        places: those of the strand's poses, if they are known.
    """
    if places is None:
        places = [place(pose) for pose in strand.poses]
    line: list[Point] = []
    for p, q, a, b in zip(strand.poses, strand.poses[1:], places, places[1:], strict=False):
        if window is not None and not _is_near(a, b, window):
            if line:
                yield line
            line = []
            continue
        if not line:
            line = [a]
        line += _between(p, q, a, b, floats, place)
    if line:
        yield line


def _between(
    p: Angles, q: Angles, a: Point, b: Point, floats: SliceFloats, place: Place, depth: int = 0
) -> list[Point]:
    """The curve from one pose to the next in the picture, without its start."""
    middle = (p[0] + q[0]) / 2, (p[1] + q[1]) / 2
    pose = floats.onto_curve(middle)
    if depth == _DEPTH or distance(pose, middle) > 0.5 * distance(p, q):
        return [b]
    m = place(pose)
    if off_segment(m, a, b) < _FINE and (depth > 0 or distance(a, b) < 20):
        return [b]
    return [
        *_between(p, pose, a, m, floats, place, depth + 1),
        *_between(pose, q, m, b, floats, place, depth + 1),
    ]


def _is_near(a: Point, b: Point, window: Box) -> bool:
    """Whether a chord may pass through a window; curves leave their chords by little of their lengths."""
    reach = 2 + 0.3 * distance(a, b)
    (ax, ay), (bx, by) = a, b
    return (
        min(ax, bx) - reach < window.x1
        and window.x0 < max(ax, bx) + reach
        and min(ay, by) - reach < window.y1
        and window.y0 < max(ay, by) + reach
    )


def cusps_of(strands: Sequence[Strand]) -> list[Mapping[str, Any]]:
    """The cusps among the vertices of strands, in the order of the table."""
    cusps = {v["cusp"]: v for strand in strands for v in strand.vertices if v["kind"] == "cusp"}
    return [cusps[number] for number in sorted(cusps)]
