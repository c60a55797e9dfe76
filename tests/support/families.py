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
