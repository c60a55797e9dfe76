"""The cusp locus: every curve with its name, its ends, and its shadow."""

from math import sin
from typing import Any

import pytest

from rpr_solver import EXAMPLES
from rpr_solver.figures.locus import locus_figure
from rpr_solver.notebook.scene import Group
from tests.support.pictures import GEOMETRY, check, words
from tests.support.shared import curves_of


def curve(name: str, start: float, stop: float, kind: str = "swallowtail") -> dict[str, Any]:
    points = [
        {"l1": str(x), "l2": str(10 + 5 * sin(x)), "l3": str(x / 2 + 3)}
        for x in (start + k * (stop - start) / 20 for k in range(1, 20))
    ]
    event = {"kind": kind, "l2": str(10 + 5 * sin(start)), "l3": str(start / 2 + 3)}
    return {
        "name": name,
        "from": {"l1": str(start), "kind": kind, "joins": None, "events": [event]},
        "to": {"l1": None, "kind": "open", "joins": None, "events": []},
        "points": points,
    }


def document(*curves: dict[str, Any]) -> dict[str, Any]:
    return {"geometry": GEOMETRY, "fixed_leg": 1, "range": {"from": "0", "to": None}, "curves": [*curves]}


def test_curves_and_their_ends() -> None:
    figure = locus_figure(document(curve("C1", 2, 9), curve("C2", 4, 12, "lips")))
    check(figure)
    assert {"C1", "C2", "L1", "L2", "L3", "swallowtail", "lips"} <= set(words(figure))
    names = [shape.name for shape in figure.scene.shapes if isinstance(shape, Group)]
    assert names == ["swallowtail at 2", "lips at 4"]
    assert "C2 from L1 = 4 (lips) to ∞ (open)" in figure.scene.description


@pytest.mark.parametrize("count", [0, 1, 20])
def test_any_number_of_curves(count: int) -> None:
    check(locus_figure(document(*(curve(f"C{k}", k / 7, 5 + k) for k in range(count)))))


def test_curves_without_points_or_ends() -> None:
    bare = {**curve("C1", 1, 2), "points": []}
    check(locus_figure(document(bare)))


@pytest.mark.long
def test_curves_of_a_manipulator() -> None:
    curves = curves_of(EXAMPLES["zein-flat"], digits=15)
    figure = curves.figure()
    check(figure)
    assert figure.scene.title == f"Cusp locus: {len(curves.curves)} curves of cusps"
