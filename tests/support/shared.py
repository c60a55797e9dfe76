"""Answers that many tests use, computed once per process."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import rpr_solver  # whose parts are loaded by the tests that use them

if TYPE_CHECKING:
    from rpr_solver import Census, CuspCurves, Eliminant, Manipulator


def eliminant_of(manipulator: Manipulator, fixed_leg: int = 1) -> Eliminant:
    return _eliminants(manipulator, fixed_leg)


def census_of(manipulator: Manipulator, fixed_leg: int = 1, digits: int = 30) -> Census:
    return _censuses(manipulator, fixed_leg, digits)


def curves_of(manipulator: Manipulator, fixed_leg: int = 1, digits: int = 30) -> CuspCurves:
    return _curves(manipulator, fixed_leg, digits)


@cache
def _eliminants(manipulator: Manipulator, fixed_leg: int) -> Eliminant:
    return rpr_solver.eliminate(manipulator, fixed_leg)


@cache
def _censuses(manipulator: Manipulator, fixed_leg: int, digits: int) -> Census:
    return rpr_solver.census(manipulator, fixed_leg=fixed_leg, digits=digits)


@cache
def _curves(manipulator: Manipulator, fixed_leg: int, digits: int) -> CuspCurves:
    return rpr_solver.cusp_curves(manipulator, fixed_leg=fixed_leg, digits=digits)
