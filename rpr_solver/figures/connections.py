"""Which poses of a joint vector, or of two, are joined: a matrix, poses that are joined beside each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rpr_solver.figures.sheet import (
    EDGE,
    SMALL,
    WIDTH,
    listed,
    sheet,
    short,
    swatches,
    swatches_height,
    wrapped,
)
from rpr_solver.notebook import Style, counted
from rpr_solver.notebook.figure import drawing
from rpr_solver.notebook.scene import Box, Disc, Group, Paint, Scene, Shape, Text, rectangle

_TOP, _LINE = 52.0, 18.0
_LARGEST = 56.0
"""Of a cell, in pixels."""
_HEADINGS, _NUMBERS = 286.0, 62.0
"""The room for the names of the rows, with angles and without."""
_NARROW = 600.0
_WORDS = {
    "joined": ("poses6", "", "joined"),
    "opposite-signs": ("poses2", "±", "J has opposite signs"),
    "other-aspect": ("minus1", "A", "another aspect"),
    "separated-by-limits": ("minus2", "L", "separated by limits"),
    "outside-limits": ("faint", "×", "a pose outside limits"),
    "singular-pose": ("faint", "0", "a singular pose"),
    "undecided": ("paper", "?", "undecided"),
}
"""Of each word of the matrix its colour, its sign, and what it means."""
_SIGNS = {1: "J > 0", -1: "J < 0", 0: "J = 0", None: "J = ?"}


@drawing
def connections_figure(style: Style, document: Mapping[str, Any]) -> Scene:
    """Draws which poses are joined by paths without a singularity.

    Args:
        document: as :meth:`PoseConnections.to_json` gives it.
    """
    poses, matrix = document["poses"], document["matrix"]
    order = _order(document)
    wide = style.width or WIDTH
    lines = [line for text in _about(document) for line in wrapped(text.split(", "), wide - 32, SMALL)]
    about = [
        Text((wide / 2, _TOP + _LINE * k), line, SMALL, "soft", "middle") for k, line in enumerate(lines)
    ]
    top, left = _TOP + _LINE * len(lines) + 26, _NUMBERS if wide < _NARROW else _HEADINGS
    cell = min(_LARGEST, (wide - left - 24) / max(len(order), 1))
    start = max(left, (wide + left - cell * len(order)) / 2) if wide < _NARROW else left
    plot = Box(start, top, start + cell * len(order), top + cell * len(order))
    used = [word for word in _WORDS if any(word in row for row in matrix)]
    legend = [(_WORDS[word][0], f"{_WORDS[word][1]} {_WORDS[word][2]}".strip()) for word in used]
    y = plot.y1 + 22 + swatches_height(legend, wide - 16)
    shapes: list[Shape] = [
        *about,
        *_headings(document, order, plot, wide >= _NARROW),
        *_cells(matrix, order, plot),
        *_blocks(document, order, plot),
        *swatches(legend, wide / 2, y, wide - 16),
    ]
    groups = listed("-".join(map(str, group)) for group in document["groups"]) if document["groups"] else ""
    if not poses:
        shapes.append(Text((wide / 2, plot.y1), "no pose", 15, "soft", "middle"))
    title = f"{counted(len(poses), 'pose')}, joined: {groups or 'none'}"
    return sheet(style, title, document, _facts(document, lines, groups), shapes, (wide, y + 44))


def _order(document: Mapping[str, Any]) -> list[int]:
    """The places of the poses, those that are joined beside each other."""
    grouped = [place for group in document["groups"] for place in group]
    return [*grouped, *(place for place in range(1, len(document["poses"]) + 1) if place not in grouped)]


def _about(document: Mapping[str, Any]) -> Iterator[str]:
    """The joint vectors, and what paths have to keep."""
    if "l1" in document:
        yield _legs(document)
    else:
        vectors: dict[str, list[int]] = {}
        for place, pose in enumerate(document["poses"], 1):
            vectors.setdefault(_legs(pose), []).append(place)
        for words, places in vectors.items():
            yield (
                f"poses {places[0]} to {places[-1]}: {words}" if places[1:] else f"pose {places[0]}: {words}"
            )
    if between := document["between"]:
        leg = document["fixed_leg"]
        yield f"L{leg} from {short(between['from'], 6)} to {short(between['to'], 6)}"
    for name, limit in (document["limits"] or {}).items():
        ends = [
            f"{word} {short(limit[end], 6)}"
            for end, word in (("min", "at least"), ("max", "at most"))
            if limit[end] is not None
        ]
        yield f"{name.upper()} {' and '.join(ends)}"
    if region := document.get("allowed"):
        count = "undecided" if region["count"] is None else region["count"]
        yield f"parts of the allowed region: {count}"


def _legs(part: Mapping[str, Any]) -> str:
    return ", ".join(f"L{leg} = {short(part[f'l{leg}'], 6)}" for leg in (1, 2, 3))


def _angles(document: Mapping[str, Any], place: int) -> str:
    leg, pose = document["fixed_leg"], document["poses"][place - 1]
    alpha, theta = short(pose["alpha_deg"]), short(pose[f"theta{leg}_deg"])
    return f"{_SIGNS[pose['sign']]}, α = {alpha}°, θ{leg} = {theta}°"


def _headings(
    document: Mapping[str, Any], order: Sequence[int], plot: Box, with_angles: bool
) -> Iterator[Shape]:
    """The numbers of the poses above and on the left, there with the sign of J, and the angles."""
    cell = plot.width / max(len(order), 1)
    for k, place in enumerate(order):
        across, down = plot.x0 + (k + 0.5) * cell, plot.y0 + (k + 0.5) * cell
        sign = _SIGNS[document["poses"][place - 1]["sign"]]
        yield Text((across, plot.y0 - 13), str(place), SMALL, "ink", "middle", bold=True)
        yield Text((plot.x0 - 8, down), str(place), SMALL, "ink", "end", bold=True)
        words = _angles(document, place) if with_angles else sign
        yield Text((plot.x0 - 32, down), words, SMALL if with_angles else 12, "soft", "end")


def _cells(matrix: Sequence[Sequence[str]], order: Sequence[int], plot: Box) -> Iterator[Shape]:
    """A square for each pair."""
    cell = plot.width / max(len(order), 1)
    for i, first in enumerate(order):
        for k, second in enumerate(order):
            role, sign, words = _WORDS[matrix[first - 1][second - 1]]
            x, y = plot.x0 + k * cell, plot.y0 + i * cell
            box = Box(x, y, x + cell, y + cell)
            shapes: list[Shape] = [rectangle(box, Paint(role, "soft", 0.6))]
            if sign:
                shapes.append(Text(box.centre, sign, min(15, 0.6 * cell), "ink", "middle"))
            else:
                shapes.append(Disc(box.centre, min(7, 0.25 * cell), Paint("ink")))
            name = f"pose {first}" if first == second else f"poses {first} and {second}"
            yield Group(tuple(shapes), f"{name}: {words}")


def _blocks(document: Mapping[str, Any], order: Sequence[int], plot: Box) -> Iterator[Shape]:
    """The outline of the matrix, and of what is joined in it."""
    cell, done = plot.width / max(len(order), 1), 0
    if order:
        yield rectangle(plot, EDGE)
    for group in document["groups"]:
        low, high = done * cell, (done + len(group)) * cell
        box = Box(plot.x0 + low, plot.y0 + low, plot.x0 + high, plot.y0 + high)
        yield rectangle(box, Paint("", "ink", 2.2))
        done += len(group)


def _facts(document: Mapping[str, Any], lines: Sequence[str], groups: str) -> str:
    """All pairs in words."""
    poses = "; ".join(
        f"pose {place}: {_angles(document, place)}" for place in range(1, len(document["poses"]) + 1)
    )
    apart: dict[str, list[str]] = {}
    for i, row in enumerate(document["matrix"], 1):
        for k, word in enumerate(row[: i - 1], 1):
            if word != "joined":
                apart.setdefault(word, []).append(f"{k}-{i}")
    reasons = "".join(f" {_WORDS[word][2]}: {', '.join(pairs)}." for word, pairs in apart.items())
    return (
        f"A matrix of pairs of poses, with {'; '.join(lines)}. {poses or 'No pose'}. "
        f"Joined with each other by paths without a singularity: {groups or 'none'}.{reasons}"
    )
