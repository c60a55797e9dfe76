"""Random geometries by sides, points, roots and circles, as people give them."""

from typing import Any

from hypothesis import assume
from hypothesis import strategies as st

from rpr_solver import InputError
from rpr_solver.triangles import Geometry, read_geometry
from tests.support.strategies import rationals

DECIMALS = rationals(1, 15, (10, 100)).map(lambda x: str(float(x)))
COORDINATES = rationals(-10, 15, (1, 10)).map(lambda x: str(float(x)))
ROOTS = st.tuples(st.integers(1, 6), st.integers(2, 30)).map(lambda x: f"{x[0]}*sqrt({x[1]})")


@st.composite
def triangles(draw: st.DrawFn) -> dict[str, Any]:
    """A triangle in one of its spellings."""
    kind = draw(st.sampled_from(["equilateral", "circumradius", "sides", "root", "points", "along", "roots"]))
    if kind in ("equilateral", "circumradius"):
        return {kind: draw(st.one_of(DECIMALS, ROOTS) if kind == "equilateral" else DECIMALS)}
    if kind == "sides":
        return {"sides": [draw(DECIMALS) for _ in range(3)]}
    if kind == "root":
        whole = st.integers(3, 12).map(str)
        return {"sides": [draw(whole), draw(ROOTS), draw(whole)]}
    if kind == "roots":
        return {"sides": [f"sqrt({n})" for n in draw(st.lists(st.integers(2, 60), min_size=3, max_size=3))]}
    if kind == "points":
        return {"points": [[draw(COORDINATES), draw(COORDINATES)] for _ in range(3)]}
    height = f"{draw(DECIMALS)}*sqrt({draw(st.integers(2, 1000))})"
    corners = [["0", "0"], [draw(DECIMALS), "0"], [draw(COORDINATES), height]]
    return {"points": draw(st.permutations(corners))}


@st.composite
def geometries(draw: st.DrawFn) -> Geometry:
    """Any manipulator with triangles in such spellings."""
    spelling: dict[str, Any] = {"base": draw(triangles()), "platform": draw(triangles())}
    if "points" not in spelling["platform"]:
        spelling["orientation"] = draw(st.sampled_from(["ccw", "cw"]))
    try:
        return read_geometry(spelling)
    except InputError:
        assume(False)
        raise
