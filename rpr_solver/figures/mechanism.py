"""The mechanism at a pose: base, platform and legs, other poses of the same legs behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.markers import MarkerStyle
from matplotlib.path import Path

from rpr_solver.contract import LENGTHS
from rpr_solver.errors import InputError
from rpr_solver.figures.room import Room, size_of
from rpr_solver.figures.words import BARE, exact, figure_about, number, short
from rpr_solver.notebook import Style
from rpr_solver.notebook.figure import Figure
from rpr_solver.triangles import article_lengths

_UNEVEN = Decimal("1e30")
"""Lengths are not drawn with others that are longer by this factor: 60 digits hold the square of it."""
_DIGITS = 60

Triple = tuple[complex, complex, complex]


@dataclass(frozen=True)
class Triangles:
    """The two triangles of a manipulator; points are complex numbers.

    Attributes:
        base: A1, A2, A3.
        platform: B1, B2, B3 at α = 0, seen from B1.
        unit: the length that is 1 here, in the user's unit.
    """

    base: Triple
    platform: Triple
    unit: Decimal

    @classmethod
    def of(cls, geometry: Mapping[str, Any]) -> Triangles:
        """The triangles of the contract's geometry object.

        Raises:
            InputError: naming ``geometry``: one length is too much longer than another to be drawn with it.
        """
        known = article_lengths(geometry)
        with localcontext(prec=_DIGITS):
            lengths = [exact(known[name]) for name in LENGTHS]
            sizes = [abs(x) for x in lengths if x]
            if max(sizes) > _UNEVEN * min(sizes):
                raise InputError.of(
                    "geometry",
                    f"has lengths from {short(str(min(sizes)))} to {short(str(max(sizes)))}, which no "
                    "picture can show together",
                )
            unit = Decimal(10) ** max(sizes).adjusted()
            a2x, a3x, a3y, d1, d2, d3 = (x / unit for x in lengths)
            # where B1 and B2 are one, α is the direction of B1B3
            x = (d1 * d1 + d3 * d3 - d2 * d2) / (2 * d1) if d1 else d3
            y = max(d3 * d3 - x * x, Decimal(0)).sqrt()
        corner = complex(float(x), float(-y if known["orientation"] == "cw" else y))
        base = 0j, complex(float(a2x), 0.0), complex(float(a3x), float(a3y))
        return cls(base, (0j, complex(float(d1), 0.0), corner), unit)

    def length(self, text: str) -> float:
        """A length of a document in the unit of the triangles.

        Raises:
            InputError: naming ``geometry``: it is too large to be drawn with them.
        """
        value = exact(text) / self.unit
        if abs(value) > _UNEVEN:
            raise InputError.of("geometry", f"is too small to be drawn with a length of {short(text)}")
        return float(value)

    def placed(self, alpha: float, b1: complex) -> Any:
        """The platform's points at a pose; α in degrees."""
        return b1 + np.exp(1j * np.radians(alpha)) * np.array(self.platform)

    def held(self, leg: int, length: float, alpha: float, theta: float) -> complex:
        """B1 at a pose that a leg gives: its length, and its angle; angles in degrees."""
        foot, head = self.base[leg - 1], self.placed(alpha, 0j)[leg - 1]
        return complex(foot + length * np.exp(1j * np.radians(theta)) - head)


_SHARE, _NARROW_SHARE, _NARROW = 0.58, 1.0, 330.0
"""The height of the picture by its width, at most; narrower ones are higher."""
_LEAST = 110.0
"""Its height at least, in points."""
_SIDE, _BELOW = 30.0, 28.0
"""Margins of the mechanism, in points: at the sides, and above and below."""
_ROD, _CYLINDER, _OUTLINE, _JOINT = 2.2, 7.0, 1.0, 8.0
_GROUND = Path(
    [(0, 0), (-10, -15), (10, -15), (0, 0), (-14, -15), (14, -15)]
    + [point for d in range(-9, 12, 6) for point in ((d + 4, -15), (d - 2, -21))],
    [1, 2, 2, 79] + [1, 2] * 5,
)
"""The sign of the ground, below a joint."""
_SHARES = (0.5, 0.4, 0.6, 0.3, 0.7)
"""Where along a leg its length is tried."""


def geometry_figure(geometry: Mapping[str, Any]) -> Figure:
    """A manipulator without a pose: base and platform at α = 0 with a common centre."""
    shape = Triangles.of(geometry)
    platform = shape.placed(0.0, sum(shape.base) / 3 - sum(shape.platform) / 3)
    text = "Base A1A2A3 and platform B1B2B3 at α = 0 with a common centre, joined by three legs."
    return _figure("Manipulator at α = 0", geometry, text, _Scene(shape, [platform], 0, ()))


def poses_figure(document: Mapping[str, Any], pose: int = 1) -> Figure:
    """One pose of a table of poses in full, and its other poses behind.

    Args:
        document: as :meth:`PoseTable.to_json` gives it.
        pose: the number of the pose from 1.

    Raises:
        InputError: naming ``pose``: the table has no such pose.
    """
    shape, table = Triangles.of(document["geometry"]), document["poses"]
    if not 1 <= pose <= len(table):
        there_are = f"give 1 to {len(table)}" if table else "these legs have no pose"
        raise InputError.of("pose", f"is {pose}; {there_are}")
    platforms = [
        shape.placed(number(p["alpha_deg"]), complex(shape.length(p["b1_x"]), shape.length(p["b1_y"])))
        for p in table
    ]
    own = document if "l1" in document else table[pose - 1]
    legs = [own[f"l{k}"] for k in (1, 2, 3)]
    one = len(table) == 1
    title = "The only pose with these legs" if one else f"Pose {pose} of {len(table)} with these legs"
    others = "" if one else " The other poses with the same legs are drawn lightly, with their numbers."
    text = f"{_facts(table[pose - 1]['alpha_deg'], legs)}{others}"
    return _figure(title, document["geometry"], text, _Scene(shape, platforms, pose - 1, legs))


def point_figure(
    geometry: Mapping[str, Any], fixed_leg: int, length: str, point: Mapping[str, str], title: str
) -> Figure:
    """A manipulator at a point of a slice, such as a cusp.

    Args:
        geometry: the contract's geometry object.
        fixed_leg: the leg with the fixed length.
        length: its length.
        point: the point with the names of documents, such as ``alpha_deg``, ``theta1_deg``, ``l2``, ``l3``.
        title: what is drawn.
    """
    shape, legs = Triangles.of(geometry), {**point, f"l{fixed_leg}": length}
    alpha, theta = number(point["alpha_deg"]), number(point[f"theta{fixed_leg}_deg"])
    platform = shape.placed(alpha, shape.held(fixed_leg, shape.length(length), alpha, theta))
    lengths = [legs[f"l{k}"] for k in (1, 2, 3)]
    return _figure(
        title, geometry, _facts(point["alpha_deg"], lengths), _Scene(shape, [platform], 0, lengths)
    )


@dataclass(frozen=True)
class _Scene:
    """The triangles, the platforms of all poses, the one drawn in full, and the lengths of its legs."""

    shape: Triangles
    platforms: Sequence[Any]
    chosen: int
    lengths: Sequence[str]

    def paint(self, ax: Axes, style: Style) -> None:
        """Draws base, platforms and legs, and the labels where they hide least."""
        a, b = np.array(self.shape.base), self.platforms[self.chosen]
        fit(ax, [a, *self.platforms])
        room = Room(ax)
        for k, ring in enumerate(self.platforms):
            if k != self.chosen:
                _ghost(ax, a, ring, style)
            room.add_line(room.points(corners(_closed(ring))))
        draw_base(ax, a, style)
        draw_platform(ax, b, style)
        for foot, head in zip(a, b, strict=True):
            draw_leg(ax, foot, head, style)
        draw_joints(ax, [*a, *b], style)
        self._labels(room, a, b, style)

    def _labels(self, room: Room, a: Any, b: Any, style: Style) -> None:
        """Writes the numbers of poses, the names of joints, and the lengths of legs."""
        _keep_free(room, a, b)
        several = len(self.platforms) > 1
        for k, ring in enumerate(self.platforms if several else ()):
            look: dict[str, Any] = {
                "size": 10.5,
                "weight": "bold",
                "color": style.colour("line1" if k == self.chosen else "soft"),
            }
            if not room.number([corners(_closed(ring))], f"{k + 1}", **look):
                [centre] = corners(np.array([ring.mean()]))
                room.label(centre, f"{k + 1}", reach=4.0, **look)
        size = 12 if room.size[0] > _NARROW else 10.5
        for name, ring in (("A", a), ("B", b)):
            for k, point in enumerate(corners(ring), 1):
                room.label(
                    point,
                    style.words(f"{name}{k}"),
                    reach=8.0,
                    size=size,
                    weight="bold",
                    color=style.colour("ink"),
                )
        self._lengths(room, a, b, style)

    def _lengths(self, room: Room, a: Any, b: Any, style: Style) -> None:
        """Writes the lengths of legs beside all platforms."""
        for ring in self.platforms if self.lengths else ():
            p, q, r = room.points(corners(ring))
            for share in np.linspace(0.05, 0.95, 19):
                room.add_line(np.stack((p, q + share * (r - q))))
        for k, (foot, head, length) in enumerate(zip(a, b, self.lengths, strict=False), 1):
            near = corners(foot + (head - foot) * np.array(_SHARES))
            label_one_of(
                room, near, style.words(f"L{k} = {short(length)}"), size=9.5, color=style.colour("soft")
            )


def _keep_free(room: Room, a: Any, b: Any) -> None:
    """Marks where joints, ground, base and legs are."""
    for x, y in room.points(corners(a)):
        room.add_box(x - 11, y - 17, x + 11, y + 5)
    for place in room.points(corners(b)):
        room.add_point(place, 5)
    room.add_line(room.points(corners(_closed(a))))
    for foot, head in room.points(corners(np.stack((a, b), axis=1).ravel())).reshape(-1, 2, 2):
        along = (head - foot) / (np.hypot(*(head - foot)) or 1.0)
        side = along[::-1] * (_CYLINDER / 2, -_CYLINDER / 2)
        for shift in (side, 0 * side, -side):
            room.add_line(np.stack((foot + shift, head + shift)))


def label_one_of(room: Room, points: Any, words: str, **look: Any) -> None:
    """Writes a label near the first of some points, without a long way to it, or at the first of all."""
    for point in points:
        text = room.label(point, words, reach=8.0, **look) if _is_open(room, point) else None
        if text is not None:
            return
    room.label(points[0], words, reach=8.0, **look)


def _is_open(room: Room, point: Any) -> bool:
    [place] = room.points(point)
    centre = room.free((40.0, 12.0), place)
    return centre is not None and float(np.hypot(*(centre - place))) < 45.0


def corners(points: Any) -> Any:
    """Complex numbers as rows (x, y)."""
    return np.stack((np.real(points), np.imag(points)), axis=-1)


def _closed(ring: Any) -> Any:
    return np.append(ring, ring[0])


def fit(ax: Axes, rings: Sequence[Any]) -> None:
    """Sets the limits of axes, both to one scale, so that they show all points with a margin for labels."""
    points = np.concatenate([np.ravel(ring) for ring in rings])
    size = size_of(ax)
    left, right = points.real.min(), points.real.max()
    low, high = points.imag.min(), points.imag.max()
    wide, tall = size - (2 * _SIDE, 2 * _BELOW)
    scale = max((right - left) / wide, (high - low) / tall)
    x, y = (left + right) / 2, (low + high) / 2
    ax.set_xlim(x - scale * size[0] / 2, x + scale * size[0] / 2)
    ax.set_ylim(y - scale * size[1] / 2, y + scale * size[1] / 2)
    ax.set_axis_off()


def draw_base(ax: Axes, ring: Any, style: Style) -> None:
    """The base, with the ground below each joint."""
    xy = corners(ring)
    soft = style.colour("soft")
    ax.fill(
        *xy.T, facecolor=style.colour("tint"), edgecolor=soft, linestyle=(0, (4.5, 3)), lw=1.0, zorder=1.5
    )
    marker = MarkerStyle(_GROUND)
    ax.plot(
        *xy.T,
        ls="",
        marker=marker,
        ms=31,
        mfc=style.colour("paper"),
        mec=soft,
        mew=1.0,
        zorder=2.5,
        clip_on=False,
    )


def draw_platform(ax: Axes, ring: Any, style: Style) -> None:
    """The platform."""
    face = (style.colour("poses4"), 0.6)
    ax.fill(*corners(ring).T, facecolor=face, edgecolor=style.colour("line1"), lw=1.8, zorder=2.6)


def _ghost(ax: Axes, a: Any, b: Any, style: Style) -> None:
    ghost = style.colour("ghost")
    for foot, head in zip(a, b, strict=True):
        ax.plot(*corners(np.array([foot, head])).T, color=ghost, lw=0.75, ls=(0, (2.2, 2.2)), zorder=1.2)
    ax.fill(*corners(b).T, facecolor=(style.colour("poses4"), 0.25), edgecolor=ghost, lw=0.9, zorder=1.3)


def draw_leg(ax: Axes, foot: complex, head: complex, style: Style, share: float = 0.55) -> None:
    """A leg: the rod at the platform, and the cylinder at the base."""
    rod, cylinder = (corners(np.array([foot, foot + part * (head - foot)])).T for part in (1.0, share))
    ink, butt = style.colour("ink"), {"solid_capstyle": "butt", "zorder": 3}
    ax.plot(*rod, color=ink, lw=_ROD, **butt)
    ax.plot(*cylinder, color=ink, lw=_CYLINDER, **butt)
    inner = corners(np.array([foot, foot + share * (head - foot)])).T
    ax.plot(*inner, color=style.colour("tint"), lw=_CYLINDER - 2 * _OUTLINE, **butt)


def draw_joints(ax: Axes, points: Any, style: Style) -> None:
    """Revolute joints."""
    look = {"mfc": style.colour("paper"), "mec": style.colour("ink"), "mew": 1.5, "zorder": 4}
    ax.plot(*corners(np.array(points)).T, ls="", marker="o", ms=_JOINT, **look)


def stage_height(rings: Sequence[Any], wide: float) -> float:
    """The height of a picture of the mechanism by its width: what shows all points, but not too much."""
    points = np.concatenate([np.ravel(ring) for ring in rings])
    across, up = np.ptp(points.real) or 1.0, np.ptp(points.imag)
    needed = up / across * (wide - 2 * _SIDE) + 2 * _BELOW
    return float(np.clip(needed, _LEAST, (_SHARE if wide > _NARROW else _NARROW_SHARE) * wide))


def _figure(title: str, geometry: Mapping[str, Any], text: str, scene: _Scene) -> Figure:
    rings, paint = [np.array(scene.shape.base), *scene.platforms], scene.paint

    def height(wide: float) -> float:
        return stage_height(rings, wide)

    return figure_about({"geometry": geometry}, title, text, paint, height, margins=BARE)


def _facts(alpha: str, lengths: Sequence[str]) -> str:
    legs = ", ".join(f"L{k} = {short(length)}" for k, length in enumerate(lengths, 1))
    return f"Base A1A2A3, platform B1B2B3 at α = {short(alpha)}°, {legs}."
