"""The degenerate families of manipulators, one of each and some combinations."""

from rpr_solver import Manipulator

FAMILIES = {
    "flat platform": (30, 11, 27, 13, 9, 4, "ccw"),
    "flat base": (10, 4, 0, 5, 6, 7, "ccw"),
    "both flat": (20, 6, 0, 7, 9, 16, "ccw"),
    "similar": (30, 0, 40, 15, 25, 20, "ccw"),
    "similar, mirrored": (30, 0, 40, 15, 25, 20, "cw"),
    "congruent": (30, 0, 40, 30, 50, 40, "ccw"),
    "congruent, mirrored": (30, 0, 40, 30, 50, 40, "cw"),
    "isosceles": (6, 3, 7, 8, 5, 5, "ccw"),
    "isosceles, irrational": (10, 5, 8, 6, 7, 7, "ccw"),
    "right angles": (10, 0, 8, 6, 10, 8, "ccw"),
    "d1 = a2x": (10, 3, 8, 10, 7, 9, "ccw"),
    "folded flat platform": (2, -4, 4, 1, 4, 3, "ccw"),
}


def family(name: str) -> Manipulator:
    keys = ("a2x", "a3x", "a3y", "d1", "d2", "d3", "orientation")
    return Manipulator.from_json(dict(zip(keys, FAMILIES[name], strict=True)))


MIRRORED_ISOSCELES = Manipulator.from_json(
    {"a2x": 6, "a3x": 3, "a3y": 4, "d1": 6, "d2": 5, "d3": 5, "orientation": "cw"}
)
"""Congruent, mirrored and isosceles."""
MIRRORED_RIGHT_BASE = Manipulator.from_json({"a2x": 7, "a3x": -9, "a3y": -12, "d1": 7, "d2": 20, "d3": 15})
CONGRUENT_FLAT = Manipulator.from_json({"a2x": -7, "a3x": -4, "a3y": 0, "d1": 7, "d2": 3, "d3": 4})
