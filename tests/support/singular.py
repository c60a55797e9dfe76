"""Slices whose singular curves many tests use, computed once per process."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

from rpr_solver import EXAMPLES, Manipulator, SingularCurves, trace_slice
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.singular.sweep import Sweep, sweep
from tests.support.families import FAMILIES, family
from tests.support.shared import eliminant_of

SLICES = (
    ("innocenti", 1, "14.98"),
    ("innocenti", 1, "27"),
    ("innocenti", 3, "28.1"),
    ("zein-flat", 1, "34"),
    ("fourteen-cusps", 1, "5.96"),
    ("both flat", 1, "25.646"),
    ("similar", 1, "18"),
    ("congruent, mirrored", 2, "23"),
    ("right angles", 3, "10"),
)
"""A manipulator, the fixed leg and its length; the families among them have nodes and multiple lines."""


def manipulator(name: str) -> Manipulator:
    return family(name) if name in FAMILIES else EXAMPLES[name]


@cache
def traced(name: str, leg: int, length: str) -> SingularCurves:
    return trace_slice(eliminant_of(manipulator(name), leg), length)


@cache
def swept(name: str, leg: int, length: str) -> Sweep:
    slice_map = SliceMap.of(manipulator(name), leg)
    return sweep(slice_map, Fraction(length) * slice_map.scale)
