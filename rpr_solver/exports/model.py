"""The machine at a pose as a model of SDFormat 1.9, with its closed loops.

The links are the base, in each leg a cylinder and a rod, and the platform; the plane of the machine is z = 0,
and the frame of the model is that of the article. In leg i,

    ``leg{i}_base``      base → cylinder     revolute, at Aᵢ
    ``leg{i}``           cylinder → rod      prismatic, along the leg
    ``leg{i}_platform``  rod → platform      revolute, at Bᵢ

The first leg carries the platform. The joints of the others close the loops: their child is the platform,
which has a parent already, as SDFormat allows. All joints are at 0 in this pose, so that the position of
``leg{i}`` is the change of the length. Masses and inertias are small and positive, not those of a machine;
each link has those of a cube at its origin, m a²/6 about each axis.
"""

from __future__ import annotations

import re
from cmath import phase, rect
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from math import radians
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from rpr_solver.contract import LEGS
from rpr_solver.errors import InputError, shown
from rpr_solver.exact.numerals import double
from rpr_solver.exports.metres import in_metres, metres_of
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap

VERSION = "1.9"
_MASS = 0.1
"""In kg, of each link."""
_THICK = 0.01
"""Of the sum of all sides of the base and the platform: the width of links, so that they are seen."""
_FREE = "1e+16"
"""The limit of a joint without limits, by the description of SDFormat."""
_NAME = re.compile(r"[^\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]+")
"""What a text of XML can hold, without line breaks."""
_RESERVED = re.compile(r"world|__.*__")
"""Names that SDFormat keeps for itself."""

Place = tuple[float, float, float]
"""x, y and an angle."""


def sdf(document: Mapping[str, Any], unit: str | None, *, pose: int = 1, name: str = "planar_3rpr") -> str:
    """The model.

    Args:
        document: all poses of a joint vector, as JSON.
        unit: that of its lengths: ``"m"``, ``"cm"``, ``"mm"`` or ``"in"``.
        pose: the number of the pose, from 1.
        name: of the model.

    Raises:
        InputError: naming ``document``, which is no table of poses, ``unit``, ``pose`` or ``name``.

    >>> from rpr_solver import EXAMPLES, poses
    >>> text = sdf(poses(EXAMPLES["zein-flat"], 20, 20, 20, digits=15).to_json(), "mm", name="<left>")
    >>> [line.strip() for line in text.splitlines()[1:4]]
    ['<sdf version="1.9">', '<model name="&lt;left&gt;">', '<link name="base">']
    """
    metres = metres_of(unit)
    if not _NAME.fullmatch(name) or "::" in name or _RESERVED.fullmatch(name):
        raise InputError.of("name", f"is {shown(name)}; give a name that SDFormat allows, without ::")
    try:
        found = document["poses"]
        manipulator = Manipulator.from_json(document["geometry"], max_digits=1 << 20)
        count = len(found)
        if not 1 <= pose <= count:
            raise InputError.of("pose", f"is {pose}; give 1 to {count}" if count else "is of no pose")
        machine = _Machine.of(manipulator, found[pose - 1], metres)
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError.of("document", "is no table of poses; give one as JSON") from None
    root = Element("sdf", version=VERSION)
    _add_model(SubElement(root, "model", name=name), machine)
    indent(root)
    return f'<?xml version="1.0"?>\n{tostring(root, encoding="unicode")}\n'


@dataclass(frozen=True)
class _Machine:
    """A machine at a pose, in metres and radians.

    Attributes:
        base: A1, A2 and A3.
        platform: B1, B2 and B3, seen from B1 and B1B2.
        tips: where they are.
        alpha: the orientation of the platform.
        thetas, lengths: of the legs.
    """

    base: tuple[complex, ...]
    platform: tuple[complex, ...]
    tips: tuple[complex, ...]
    alpha: float
    thetas: tuple[float, ...]
    lengths: tuple[float, ...]

    @classmethod
    def of(
        cls,
        manipulator: Manipulator,
        pose: Mapping[str, Any],
        metres: Fraction,
    ) -> _Machine:
        slice_map = SliceMap.of(manipulator, with_shared=True)
        corners = [leg.doubles(slice_map.scale / metres) for leg in (slice_map.f, slice_map.g)]
        platform, base = ((0j, *points) for points in zip(*corners, strict=True))
        alpha = radians(double(Fraction(pose["alpha_deg"])))
        b1 = complex(*(in_metres(pose[name], metres) for name in ("b1_x", "b1_y")))
        turn = rect(1, alpha)
        tips = tuple(b1 + turn * b for b in platform)
        legs = [b - a for a, b in zip(base, tips, strict=True)]
        thetas = tuple(map(phase, legs))
        return cls(base, platform, tips, alpha, thetas, tuple(map(abs, legs)))

    @property
    def thickness(self) -> float:
        """The width of links."""
        corners = (self.base, self.platform)
        return _THICK * sum(abs(p - q) for points in corners for p, q in combinations(points, 2))


def _add_model(model: Element, machine: _Machine) -> None:
    thickness = machine.thickness
    base = _link(model, "base", (0.0, 0.0, 0.0))
    for corners in combinations(machine.base, 2):
        _bar(base, *corners, thickness)
    _fill(base, thickness)
    anchor = SubElement(model, "joint", name="base_to_world", type="fixed")
    SubElement(anchor, "parent").text = "world"
    SubElement(anchor, "child").text = "base"
    for leg, tip, theta, length in zip(LEGS, machine.tips, machine.thetas, machine.lengths, strict=True):
        start = machine.base[LEGS.index(leg)]
        for part, place, reach in (("cylinder", start, length / 2), ("rod", tip, -length / 2)):
            link = _link(model, f"{_joint(leg)}_{part}", (place.real, place.imag, theta))
            _bar(link, 0j, complex(reach), thickness)
            _fill(link, thickness)
    platform = _link(model, "platform", (machine.tips[0].real, machine.tips[0].imag, machine.alpha))
    for corners in combinations(machine.platform, 2):
        _bar(platform, *corners, thickness)
    _fill(platform, thickness)
    for leg, corner, length in zip(LEGS, machine.platform, machine.lengths, strict=True):
        own = _joint(leg)
        _add_joint(model, f"{own}_base", "revolute", ("base", f"{own}_cylinder"))
        _add_joint(model, own, "prismatic", (f"{own}_cylinder", f"{own}_rod"), least=-length)
        _add_joint(model, f"{own}_platform", "revolute", (f"{own}_rod", "platform"), at=corner)


def _joint(leg: str) -> str:
    """The name of the prismatic joint of ``l1``, …."""
    return f"leg{leg[1:]}"


def _number(x: float) -> str:
    return repr(x + 0.0)  # which makes −0 a 0


def _pose(parent: Element, place: Place) -> None:
    x, y, yaw = map(_number, place)
    SubElement(parent, "pose").text = f"{x} {y} 0 0 0 {yaw}"


def _link(model: Element, name: str, place: Place) -> Element:
    link = SubElement(model, "link", name=name)
    _pose(link, place)
    return link


def _fill(link: Element, thickness: float) -> None:
    """The inertia of a cube as wide as the link is thick, at the origin of the link."""
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "mass").text = _number(_MASS)
    inertia = SubElement(inertial, "inertia")
    moment = _MASS * thickness**2 / 6
    for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
        SubElement(inertia, name).text = _number(moment if name[1] == name[2] else 0.0)


def _bar(link: Element, start: complex, stop: complex, thickness: float) -> None:
    """A box from a point to another; none where they are one."""
    if start == stop:
        return
    count = len(link.findall("visual")) + 1
    visual = SubElement(link, "visual", name=f"bar{count}")
    middle = (start + stop) / 2
    _pose(visual, (middle.real, middle.imag, phase(stop - start)))
    size = abs(stop - start), thickness, thickness
    box = SubElement(SubElement(visual, "geometry"), "box")
    SubElement(box, "size").text = " ".join(map(_number, size))


def _add_joint(
    model: Element,
    name: str,
    kind: str,
    links: tuple[str, str],
    *,
    least: float | None = None,
    at: complex = 0j,
) -> None:
    """A joint at a point of its second link, which moves along its x-axis, or turns in the plane."""
    joint = SubElement(model, "joint", name=name, type=kind)
    if at:
        _pose(joint, (at.real, at.imag, 0.0))
    for end, link in zip(("parent", "child"), links, strict=True):
        SubElement(joint, end).text = link
    axis = SubElement(joint, "axis")
    SubElement(axis, "xyz").text = "1 0 0" if kind == "prismatic" else "0 0 1"
    limit = SubElement(axis, "limit")
    SubElement(limit, "lower").text = f"-{_FREE}" if least is None else _number(least)
    SubElement(limit, "upper").text = _FREE
