"""A small full certificate of curves, with the proved boxes of its points."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from typing import Any

from rpr_solver import EXAMPLES
from rpr_solver.verify.chains import Place
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.schema import read_document
from rpr_solver.verify.core.system import Surface, System
from rpr_solver.verify.cusps import Point, Slice
from rpr_solver.verify.events import Events
from rpr_solver.verify.ranges import Range
from rpr_solver.verify.tubes import Pose, Tube
from tests.support.shared import curves_of
from tests.support.verified import geometry_of

_BITS = 200
PAST = 1
"""The number of the chain past the end at which the two curves join."""


@cache
def window() -> dict[str, Any]:
    """Two curves of the flat manipulator that join in a swallowtail at L1 = 0.83, with two points each."""
    part = curves_of(EXAMPLES["zein-flat"]).part("0.5", "1.2", lengths=[1, "1.05"])
    return part.to_json(certificate="full")


@cache
def surface() -> Surface:
    return Surface(geometry_of(EXAMPLES["zein-flat"]), 1)


@cache
def cut() -> Range:
    """All events of the manipulator, and the range."""
    return Range(Events(surface(), 100), [], Fraction(1, 2), Fraction(6, 5))


@cache
def poses() -> Mapping[Place, Pose]:
    """The boxes of the points."""
    result = {}
    for curve in read_document(window()).members["curves"]:
        for point in curve["points"]:
            length = point["l1"]
            system = System.of(surface().geometry, 1, length)
            [found], _ = Slice(system).located([Point.of(point, system)], _BITS)
            box = found.box
            assert box is not None
            scaled = Interval.of(length * surface().unit, box.alpha.bits)
            result[curve["name"], length] = Pose(box.alpha, box.theta, scaled)
    return result


def tubes(chain: int) -> list[Tube]:
    """The tubes of a chain."""
    parts = read_document(window()).members["certificate"]["full"]["chains"][chain]["tubes"]
    return [Tube.of(surface(), tube, "") for tube in parts]
