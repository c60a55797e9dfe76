"""The cusp locus: every curve with its name, its ends, and its shadow."""

from math import sin
from typing import Any

import pytest

from rpr_solver import EXAMPLES, InputError
from rpr_solver.figures.locus import locus_figure, projections_figure
from rpr_solver.figures.views import figure_of
from tests.support.pictures import GEOMETRY, check, sheet_of, words
from tests.support.sampling import long
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
    assert {"C1: 2 to ∞", "C2: 4 to ∞", "L1", "L2", "L3", "swallowtail", "lips"} <= set(words(figure))
    assert "C2 from L1 = 4 (lips) to ∞ (open)" in figure.description


@pytest.mark.parametrize("count", [long(0), 20])
def test_any_number_of_curves(count: int) -> None:
    for draw in (locus_figure, projections_figure):
        check(draw(document(*(curve(f"C{k}", k / 7, 5 + k) for k in range(count)))))


def test_curves_without_points_or_ends() -> None:
    bare = {**curve("C1", 1, 2), "points": []}
    for draw in (locus_figure, projections_figure):
        check(draw(document(bare)))


def test_every_curve_is_in_each_plane() -> None:
    two = document(curve("C1", 2, 9), curve("C2", 4, 12, "lips")) | {"range": {"from": "0", "to": "12"}}
    figure = projections_figure(two)
    check(figure)
    assert figure.title == "Cusp locus: 2 curves of cusps, in three planes"
    assert {"L1", "L2", "L3", "swallowtail", "lips", "C1: 2 to ∞"} <= set(words(figure))
    assert words(figure).count("C1") == words(figure).count("C2") == 3
    assert "in the planes of L1 and L2, L1 and L3, and L3 and L2" in figure.description
    [ax] = sheet_of(figure).axes
    planes = [plane.lines[0].get_xydata() for plane in ax.child_axes]
    assert planes[0][:, 0] == pytest.approx(planes[1][:, 0])
    assert planes[1][:, 1] == pytest.approx(planes[2][:, 0])
    assert planes[0][:, 1] == pytest.approx(planes[2][:, 1])


def test_a_view_that_there_is_not() -> None:
    with pytest.raises(InputError, match=r"^view: is 'plane'; give space or projections$"):
        figure_of(document(), view="plane")


@pytest.mark.long
def test_curves_of_a_manipulator() -> None:
    curves = curves_of(EXAMPLES["zein-flat"], digits=15)
    figure = curves.figure()
    check(figure)
    assert figure.title == f"Cusp locus: {len(curves.curves)} curves of cusps"
