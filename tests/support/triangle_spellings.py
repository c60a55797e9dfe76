"""Random geometries by sides, points, roots and circles, as people give them."""

from random import Random
from typing import Any

from hypothesis import assume
from hypothesis import strategies as st

from rpr_solver import InputError, Manipulator
from rpr_solver.triangles import Geometry, own_shapes, read_geometry
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


def manipulator_with_roots(random: Random) -> Manipulator:
    """One by points, sides or roots that no shape makes special, and whose triangles are in one field."""
    while True:
        try:
            found = Manipulator.of(read_geometry(drawn(random)))
            if not found.is_rational and not own_shapes(found.geometry) and found.frame:
                return found
        except InputError:
            continue


def drawn(draw: Random) -> dict[str, Any]:
    """A geometry as people write it; not all are manipulators."""
    spelling = {name: _drawn_triangle(draw) for name in ("base", "platform")}
    return (
        spelling
        if "points" in spelling["platform"]
        else spelling | {"orientation": draw.choice(["ccw", "cw"])}
    )


def _drawn_triangle(draw: Random) -> Any:
    def decimal(low: int, high: int) -> str:
        return f"{draw.uniform(low, high):.2f}"

    def whole() -> str:
        return str(draw.randint(3, 12))

    def root() -> str:
        return f"{draw.randint(1, 6)}*sqrt({draw.randint(2, 7)})"

    corners = [
        ["0", "0"],
        [decimal(3, 15), "0"],
        [decimal(0, 15), f"{decimal(1, 4)}*sqrt({draw.randint(2, 1000)})"],
    ]
    spellings = (
        {"equilateral": decimal(3, 15)},
        {"equilateral": root()},
        {"circumradius": decimal(3, 6)},
        {"sides": [decimal(3, 14) for _ in range(3)]},
        {"sides": [whole(), root(), whole()]},
        {"points": [[decimal(-5, 15), decimal(-5, 15)] for _ in range(3)]},
        {"points": draw.sample(corners, 3)},
    )
    return draw.choice(spellings)


def rational_near(m: Manipulator) -> Manipulator:
    """Six rational numbers within 2⁻¹²⁷ of the lengths, of which no root is known."""
    a2x, a3x, a3y, d1, d2, d3 = ((low + high) / 2 for low, high in m.bounds())
    return Manipulator(a2x, a3x, a3y, d1, d2, d3, m.orientation)
