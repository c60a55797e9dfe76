"""A slice in joint space: its cusps lettered in the order of the table, insets where they are needed."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from rpr_solver import EXAMPLES, Manipulator, SingularCurves, singular_curves
from rpr_solver.contract import letter
from rpr_solver.figures.joint_plane import CIRCLE, joint_figure
from rpr_solver.notebook.style import Style
from tests.support.pictures import check, sheet_of, words
from tests.support.sampling import long


@cache
def curves(name: str, length: str) -> SingularCurves:
    return singular_curves(EXAMPLES[name], length)


SLICES = [
    ("innocenti", "14.98", 6, 1),
    long("innocenti", "27", 8, 2),
    long("innocenti", "28.1", 10, 2),
    long("innocenti", "34", 4, 0),
    ("zein-flat", "3", 4, 0),
    long("fourteen-cusps", "5.96", 14, 4),
]


@pytest.mark.parametrize(("name", "length", "count", "insets"), SLICES)
def test_the_figures_of_the_article_and_beyond(name: str, length: str, count: int, insets: int) -> None:
    figure = joint_figure(curves(name, length).to_json())
    check(figure)
    shown = words(figure)
    factors = [word for word in shown if ": × " in word]
    assert len(factors) >= insets
    assert bool(factors) == bool(insets)
    letters = {name for word in shown if ": × " not in word for name in word.split(", ")}
    assert {letter(k) for k in range(1, count + 1)} <= letters
    assert figure.title == f"Singular curves at L1 = {length}: {count} cusps"


def test_regions_with_their_numbers_of_poses() -> None:
    slices = curves("zein-flat", "3")
    figure = joint_figure(slices.to_json())
    shown = words(figure)
    assert {"no pose", "2 poses", "4 poses", "2"} <= set(shown)
    [ax] = sheet_of(figure).axes
    painted = [patch for patch in ax.patches if patch.get_path().codes is not None]
    assert len(painted) == len(slices.regions)


def test_another_leg_and_a_slice_without_cusps() -> None:
    figure = singular_curves(EXAMPLES["innocenti"], 16, fixed_leg=2).figure()
    check(figure)
    assert {"L1", "L3"} <= set(words(figure))
    check(singular_curves(Manipulator(10, 5, 8, 5, 4, 5), "0.05").figure())


def test_cusps_at_one_point_have_no_inset_and_one_label() -> None:
    """A machine with a symmetry, whose cusps coincide in pairs in the plane of the free legs."""
    robot = Manipulator.from_json({"base": {"sides": [5, 6, 5]}, "platform": {"sides": [3, 2, 3]}})
    slices = singular_curves(robot, 4)
    points = [(cusp.l2, cusp.l3) for cusp in slices.table.cusps]
    shown = words(slices.figure())
    check(slices.figure())
    twins = [(i, k) for k in range(len(points)) for i in range(k) if points[i] == points[k]]
    for i, k in twins:
        assert any({letter(i + 1), letter(k + 1)} <= set(word.split(": ")[0].split(", ")) for word in shown)


PAGE, COLUMN = Style(), Style(width_mm=86, unit="mm")
CROWDED = [
    ("eighteen-cusps", "15.6431", 18, COLUMN),
    long("eighteen-cusps", "15.6431", 18, PAGE),
    long("sixteen-cusps", "14.46845", 16, COLUMN),
    long("sixteen-cusps", "14.46845", 16, PAGE),
]


@pytest.mark.parametrize(("name", "length", "count", "style"), CROWDED)
def test_many_cusps_are_told_apart(name: str, length: str, count: int, style: Style) -> None:
    figure = joint_figure(curves(name, length).to_json()).styled(style)
    check(figure)
    shown = [word for text in words(figure) for word in text.split(": ")[0].split(", ")]
    assert {letter(k) for k in range(1, count + 1)} <= set(shown)
    assert_cusps_apart(sheet_of(figure), curves(name, length))


def assert_cusps_apart(sheet: Any, slices: SingularCurves) -> None:
    """Each cusp has a circle, in the plane or in an inset, that no circle of another cusp covers by half."""
    [ax] = sheet.axes
    cusps = np.array([(float(cusp.l2), float(cusp.l3)) for cusp in slices.table.cusps])
    best = np.zeros(len(cusps))
    for plane in (ax, *ax.child_axes):
        places = plane.transData.transform(cusps)
        box = plane.bbox
        inside = (places > (box.x0, box.y0)).all(axis=1) & (places < (box.x1, box.y1)).all(axis=1)
        for k in np.flatnonzero(inside):
            clear = np.hypot(*(np.delete(places, k, axis=0) - places[k]).T).min()
            best[k] = max(best[k], clear)
    assert best.min() > CIRCLE
