"""Labels that cover no other: what of axes is taken by texts and lines, and where there is room.

All is measured in points from the lower left corner of the axes, on the texts as they are drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.path import Path
from matplotlib.text import Annotation

_APART = 1.5
"""How far texts are from each other, at least."""
_TURNS = np.exp(2j * np.pi * np.arange(16) / 16)
_REACHES = (1.0, 1.6, 2.6, 4.0, 6.0, 9.0, 13.0, 18.0)
"""How far a label is tried from its point, by the least distance."""
_HIDING, _LEADER = 2.5, 14.0
"""What hiding a point of line costs, in points of distance; from where on a line leads to a label."""
_FINE, _LONGEST = 0.8, 4000.0
"""How densely lines are marked, and the longest chord that is."""
_STEP = 3.0
"""The grid on which numbers of areas, and insets, are tried."""
_MOST = 1500
"""The most places at which the number of an area is tried."""


class Room:
    """The room in axes.

    Args:
        ax: the axes, with their final limits.
        beyond: how far labels may leave the axes on each side.
    """

    def __init__(self, ax: Axes, beyond: float = -2.0) -> None:
        self._ax = ax
        box = ax.get_window_extent()
        self._scale = _scale_of(ax)
        self._corner = np.array((box.x0, box.y0))
        self.size = np.array((box.width, box.height)) * self._scale
        self._least, self._most = -beyond * np.ones(2), self.size + beyond
        self._beyond = int(max(beyond, 0)) + 1
        wide, high = (int(x) + 2 * self._beyond + 2 for x in self.size)
        self._hits = np.zeros((high, wide), dtype=np.int64)
        self._sums: Any = None
        self._boxes: list[tuple[float, float, float, float]] = []

    def points(self, values: Any) -> Any:
        """Places of data, in points: an array of rows (x, y)."""
        data = self._ax.transData.transform(np.reshape(np.asarray(values, dtype=float), (-1, 2)))
        return (data - self._corner) * self._scale

    def add_line(self, places: Any) -> None:
        """A polyline, in points, that labels are not to hide."""
        a, b = places[:-1], places[1:]
        most = self.size + self._beyond
        meets = ((np.minimum(a, b) < most) & (np.maximum(a, b) > -self._beyond)).all(axis=1)
        a, step = a[meets], (b - a)[meets]
        count = np.ceil(np.minimum(np.hypot(*step.T), _LONGEST) / _FINE).astype(int) + 1
        own = np.repeat(np.arange(len(count)), count)
        share = (np.arange(len(own)) - np.repeat(count.cumsum() - count, count)) / count[own]
        x, y = (a[own] + share[:, None] * step[own] + self._beyond).T
        high, wide = self._hits.shape
        inside = (x >= 0) & (x < wide) & (y >= 0) & (y < high)
        self._hits[y[inside].astype(int), x[inside].astype(int)] = 1
        self._sums = None

    def add_box(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """A box, in points, in which there are no labels."""
        self._boxes.append((x0, y0, x1, y1))

    def add_point(self, place: Any, radius: float) -> None:
        """A mark, in points, in which there are no labels."""
        x, y = place
        self.add_box(x - radius, y - radius, x + radius, y + radius)

    def label(self, at: Sequence[float], words: str, *, reach: float = 7.0, **look: Any) -> Annotation | None:
        """Writes a label near a point where it covers no other and hides least; None without room.

        Args:
            at: the point, in data.
            words: the label.
            reach: the least distance of both, in points.
            look: properties of the text.
        """
        text, half = self._text(at, words, look)
        [place] = self.points(at)
        reaches = np.array(_REACHES) * reach
        away = np.multiply.outer(reaches, _TURNS).ravel()
        turns = np.tile(_TURNS, len(reaches))
        offsets = np.stack((away.real + half[0] * turns.real, away.imag + half[1] * turns.imag), axis=1)
        offset = self._best(place, offsets, half, np.abs(away))
        if offset is None:
            grid = self._grid(half) - place
            offset = self._best(place, grid, half, np.hypot(*grid.T))
        if offset is None:
            text.remove()
            return None
        return self._settled(text, place, offset, half)

    def number(self, rings: Sequence[Any], words: str, clear: float = 3.0, **look: Any) -> bool:
        """Writes a word in an area, as far from its outline as there is room.

        Args:
            rings: its outline and those of its holes, in data.
            words: the word.
            clear: the least distance of both, in points.
            look: properties of the text.
        """
        path, *holes = (Path(self.points(ring)) for ring in rings)
        inside, extent = self._grid(np.zeros(2)), path.get_extents()
        inside = inside[((inside > extent.min) & (inside < extent.max)).all(axis=1)]
        inside = inside[:: len(inside) // _MOST + 1]
        inside = inside[path.contains_points(inside)]
        for hole in holes:
            inside = inside[~hole.contains_points(inside)]
        if not len(inside):
            return False
        centre = inside.mean(axis=0)
        text, half = self._text((0.0, 0.0), words, look)
        for margin in (24.0, 16.0, 11.0, 7.0, 5.0, clear):
            place = self._best(np.zeros(2), inside, half + margin, np.hypot(*(inside - centre).T), 1)
            if place is not None:
                text.xy = self._ax.transData.inverted().transform(place / self._scale + self._corner)
                self._settled(text, place, np.zeros(2), half, leads=False)
                return True
        text.remove()
        return False

    def free(self, size: Any, near: Any) -> Any:
        """The centre, in points, of a box of this size that hides nothing, nearest to a place; or None."""
        half = np.asarray(size) / 2
        grid = self._grid(half)
        return self._best(np.zeros(2), grid, half, np.hypot(*(grid - near).T), 1)

    def _text(self, at: Sequence[float], words: str, look: dict[str, Any]) -> tuple[Annotation, Any]:
        """A text to be placed, and half of its width and height."""
        usual = {"textcoords": "offset points", "ha": "center", "va": "center", "annotation_clip": False}
        text = self._ax.annotate(words, at, (0, 0), **{**usual, **look})
        extent = text.get_window_extent()
        return text, np.array((extent.width, extent.height)) * self._scale / 2

    def _grid(self, half: Any) -> Any:
        """Centres of boxes all over the axes."""
        low, high = self._least + half, self._most - half
        x, y = np.meshgrid(*(np.arange(low[k], max(high[k], low[k]) + 0.1, _STEP) for k in (0, 1)))
        return np.stack((x.ravel(), y.ravel()), axis=1)

    def _best(self, place: Any, offsets: Any, half: Any, cost: Any, most: float = np.inf) -> Any:
        """The offset of the box with the least cost, which covers no other; None if there is none.

        Args:
            place: from where offsets count.
            offsets: those of the centres of boxes.
            half: half of their sides.
            cost: of each, to which what it hides is added.
            most: how much it may hide, less than.
        """
        low, high = place + offsets - half, place + offsets + half
        free = ((low >= self._least) & (high <= self._most)).all(axis=1)
        if self._boxes:
            x0, y0, x1, y1 = (np.array(side)[:, None] for side in zip(*self._boxes, strict=True))
            covers = (x0 < high[:, 0] + _APART) & (low[:, 0] - _APART < x1)
            covers &= (y0 < high[:, 1] + _APART) & (low[:, 1] - _APART < y1)
            free &= ~covers.any(axis=0)
        if not free.any():
            return None
        hidden = self._hidden(low[free], high[free])
        kept = hidden < most
        if not kept.any():
            return None
        return offsets[free][kept][np.argmin(cost[free][kept] + _HIDING * hidden[kept])]

    def _hidden(self, low: Any, high: Any) -> Any:
        """How many points of lines boxes hide."""
        if self._sums is None:
            self._sums = np.pad(self._hits.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        ends = np.array(self._sums.shape[::-1]) - 1
        (x0, y0), (x1, y1) = (
            np.clip(np.floor(side + self._beyond).astype(int) + k, 0, ends).T
            for side, k in ((low, 0), (high, 1))
        )
        sums = self._sums
        return sums[y1, x1] - sums[y0, x1] - sums[y1, x0] + sums[y0, x0]

    def _settled(
        self, text: Annotation, place: Any, offset: Any, half: Any, *, leads: bool = True
    ) -> Annotation:
        """A text at its place, with a line to its point if it is far from that."""
        text.set_position(tuple(offset))
        centre = place + offset
        self.add_box(*(centre - half), *(centre + half))
        nearest = np.clip(place, centre - half, centre + half)
        gap = float(np.hypot(*(nearest - place)))
        if leads and gap > _LEADER:
            end = place + (nearest - place) * (1 - 1.5 / gap)
            line = np.stack((place, end))
            self.add_line(line)
            colour = text.get_color()
            self._ax.annotate(
                "",
                self._data(place),
                tuple(end - place),
                textcoords="offset points",
                annotation_clip=False,
                arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.6, "shrinkA": 0, "shrinkB": 2},
            )
        return text

    def _data(self, place: Any) -> tuple[float, float]:
        x, y = self._ax.transData.inverted().transform(place / self._scale + self._corner)
        return float(x), float(y)


def size_of(ax: Axes) -> Any:
    """Width and height of axes in points."""
    box = ax.get_window_extent()
    return np.array((box.width, box.height)) * _scale_of(ax)


def _scale_of(ax: Axes) -> float:
    """What a dot of the picture is in points."""
    figure: Any = ax.get_figure()
    return 72.0 / float(figure.dpi)
