"""The number of cusps of a slice, from the exact eliminant alone."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import atan2, degrees

from rpr_solver.verify.boxes import Equations, Pair, zero_near
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.lines import special_lines, unlisted
from rpr_solver.verify.manipulator import Geometry
from rpr_solver.verify.surds import Indivisible
from rpr_solver.verify.system import Leg, System

_BITS = 60
_MOST = 12
"""The most poses that are looked at on one line; J has degree 4 there."""


def cusps_counted(geometry: Geometry, fixed: int, length: Fraction) -> tuple[int, bool] | None:
    """The number of cusps, and whether it is proved. None if the resultant says nothing.

    It is where every root of Q is simple and apart from the spurious ones: one cusp is on each line. On other
    lines the cusps are those that a search finds.
    """
    return count_of(System.of(geometry, fixed, length))


def count_of(system: System) -> tuple[int, bool] | None:
    """As :func:`cusps_counted`, of a slice."""
    try:
        eliminant = Eliminant.of(system)
    except Indivisible:
        return None
    if not eliminant.form:
        return None
    single = len(eliminant.single_roots)
    if eliminant.generic:
        return single, True
    return single + sum(_cusps_on(system, line) for line in special_lines(system, eliminant)), False


def other_poses(system: System, eliminant: Eliminant) -> list[tuple[Fraction, Fraction]]:
    """The angles, in degrees, of poses near which J = E = 0 is not excluded, and that are no cusps."""
    if eliminant.generic:
        return []
    return [
        pose
        for line in special_lines(system, eliminant)
        for pose in _poses_on(system, line)
        if not any(_is_cusp(system, leg, *pose) for leg in system.legs)
    ]


def _cusps_on(system: System, line: Pair) -> int:
    """The cusps that are found on a line: where J = E = 0 cannot be excluded, a regular zero is one."""
    return sum(any(_is_cusp(system, leg, *pose) for leg in system.legs) for pose in _poses_on(system, line))


def _poses_on(system: System, line: Pair) -> Iterator[tuple[Fraction, Fraction]]:
    """Where J = E = 0 cannot be excluded on a line: α and θ in degrees."""
    holes: list[Interval] = []
    theta = Fraction(degrees(atan2(float(line[1].middle), float(line[0].middle))))
    while (alpha := unlisted(system, line, holes)) is not None and len(holes) < _MOST:
        holes.append(Interval.of(alpha, line[0].bits))
        yield Fraction(degrees(float(alpha))), theta


def _is_cusp(system: System, leg: Leg, alpha: Fraction, theta: Fraction) -> bool:
    equations = Equations.of(system.singular, leg.kernel, system.ring.radicand)
    box = zero_near(equations, alpha, theta, _BITS)
    return box is not None and any(box.directions.value(slope).sign for slope in (leg.alpha, leg.theta))


def simplest_between(low: Fraction, high: Fraction) -> Fraction:
    """The decimal of fewest places strictly between two numbers.

    >>> simplest_between(Fraction(1, 3), Fraction(1, 2))
    Fraction(2, 5)
    """
    unit = Fraction(1)
    while True:
        candidate = (low // unit + 1) * unit
        if low < candidate < high:
            middle = round((low + high) / 2 / unit) * unit
            return middle if low < middle < high else candidate
        unit /= 10
