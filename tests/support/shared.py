"""Answers that many tests use, computed once per process."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import rpr_solver  # whose parts are loaded by the tests that use them

if TYPE_CHECKING:
    from rpr_solver import Census, CuspCurves, Eliminant, Manipulator
    from rpr_solver.model.slice_map import Leg


def eliminant_of(manipulator: Manipulator, fixed_leg: int = 1) -> Eliminant:
    return _eliminants(manipulator, fixed_leg)


def census_of(manipulator: Manipulator, fixed_leg: int = 1, digits: int = 30) -> Census:
    return _censuses(manipulator, fixed_leg, digits)


def curves_of(manipulator: Manipulator, fixed_leg: int = 1, digits: int = 30) -> CuspCurves:
    return _curves(manipulator, fixed_leg, digits)


def plain_leg(m: int, n: int, ax: int, ay: int, radicand: int = 1) -> Leg:
    """A leg with the platform point (m, n ω) and the base point (ax, ay)."""
    from rpr_solver.exact.quadratic import QuadraticNumber
    from rpr_solver.model.slice_map import Leg

    x, y, u, v = (QuadraticNumber(a, 0, radicand) for a in (m, n, ax, ay))
    return Leg((x, y if radicand == 1 else QuadraticNumber(0, n, radicand)), (u, v), 1, radicand)


@cache
def _eliminants(manipulator: Manipulator, fixed_leg: int) -> Eliminant:
    return rpr_solver.eliminate(manipulator, fixed_leg)


@cache
def _censuses(manipulator: Manipulator, fixed_leg: int, digits: int) -> Census:
    return rpr_solver.census(manipulator, fixed_leg=fixed_leg, digits=digits)


@cache
def _curves(manipulator: Manipulator, fixed_leg: int, digits: int) -> CuspCurves:
    return rpr_solver.cusp_curves(manipulator, fixed_leg=fixed_leg, digits=digits)
