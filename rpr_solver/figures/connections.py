"""Which poses of a joint vector, or of two, are joined: a matrix, poses that are joined beside each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Patch, Rectangle

from rpr_solver.figures.joint_plane import legend_below
from rpr_solver.figures.room import size_of
from rpr_solver.figures.words import BARE, figure_about, listed, short
from rpr_solver.notebook import Style, counted
from rpr_solver.notebook.figure import Figure

_LARGEST, _HEAD, _LINE = 42.0, 18.0, 13.5
"""The side of a cell at most, the room for numbers above, and a line of what is asked."""
_HEADINGS, _NUMBERS, _NARROW = 190.0, 44.0, 430.0
"""The room for the names of the rows, with angles, and without in a narrow picture."""
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


def connections_figure(document: Mapping[str, Any]) -> Figure:
    """Which poses are joined by paths without a singularity.

    Args:
        document: as :meth:`PoseConnections.to_json` gives it.
    """
    matrix, order = document["matrix"], _order(document)
    about = list(_about(document))
    used = [word for word in _WORDS if any(word in row for row in matrix)]
    count = max(len(order), 1)

    def cell(wide: float) -> float:
        return min(_LARGEST, (wide - (_HEADINGS if wide > _NARROW else _NUMBERS)) / count)

    def lines(wide: float) -> list[str]:
        return [line for text in about for line in _wrapped(text, int(wide / 5.2))]

    def height(wide: float) -> float:
        return count * cell(wide) + _HEAD + _LINE * len(lines(wide))

    def paint(ax: Axes, style: Style) -> None:
        wide, high = size_of(ax)
        ax.set(xlim=(0, wide), ylim=(high, 0))
        ax.set_axis_off()
        text = lines(wide)
        soft, ink = style.colour("soft"), style.colour("ink")
        for k, line in enumerate(text):
            ax.text(
                wide / 2, _LINE * (k + 0.5), style.words(line), size=9.5, ha="center", va="center", color=soft
            )
        side, left = cell(wide), _HEADINGS if wide > _NARROW else _NUMBERS
        x0 = left + max((wide - left - side * count) / 2, 0) if wide <= _NARROW else left
        y0 = _LINE * len(text) + _HEAD
        for i, first in enumerate(order):
            middle = y0 + (i + 0.5) * side
            words = (
                _angles(document, first) if wide > _NARROW else _SIGNS[document["poses"][first - 1]["sign"]]
            )
            ax.text(
                x0 + (i + 0.5) * side, y0 - 9, f"{first}", size=9.5, weight="bold", ha="center", va="center"
            )
            ax.text(x0 - 6, middle, f"{first}", size=9.5, weight="bold", ha="right", va="center")
            ax.text(
                x0 - 22,
                middle,
                style.words(words),
                size=9 if wide > _NARROW else 8.5,
                ha="right",
                va="center",
                color=soft,
            )
            for k, second in enumerate(order):
                role, sign, _ = _WORDS[matrix[first - 1][second - 1]]
                corner, centre = (x0 + k * side, y0 + i * side), (x0 + (k + 0.5) * side, middle)
                ax.add_patch(Rectangle(corner, side, side, fc=style.colour(role), ec=soft, lw=0.45))
                if sign:
                    ax.text(*centre, sign, size=min(11, 0.6 * side), ha="center", va="center")
                else:
                    ax.plot(*centre, "o", ms=min(10, 0.5 * side), color=ink, mew=0)
        done = 0
        for group in document["groups"]:
            start, size = x0 + done * side, len(group) * side
            ax.add_patch(Rectangle((start, y0 + done * side), size, size, fill=False, ec=ink, lw=1.6))
            done += len(group)
        if not order:
            ax.text(wide / 2, y0, "no pose", size=11, ha="center", va="center", color=soft)
        handles = [
            Patch(
                fc=style.colour(_WORDS[word][0]),
                ec=soft,
                lw=0.6,
                label=style.words(f"{_WORDS[word][1]} {_WORDS[word][2]}".strip()),
            )
            for word in used
        ]
        legend_below(ax, handles, down=10)

    groups = listed("-".join(map(str, group)) for group in document["groups"]) if document["groups"] else ""
    title = f"{counted(len(order), 'pose')}, joined: {groups or 'none'}"
    return figure_about(document, title, _facts(document, about, groups), paint, height, margins=BARE)


def _wrapped(text: str, letters: int) -> Iterator[str]:
    """Yields an enumeration in lines of not more letters, unless an item has them."""
    line = ""
    for item in text.split(", "):
        if line and len(line) + len(item) + 2 > letters:
            yield line + ","
            line = item
        else:
            line = f"{line}, {item}" if line else item
    yield line


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
