"""A slice in joint space: its cusps lettered in the order of the table, insets where they are needed."""

from functools import cache

import pytest

from rpr_solver import EXAMPLES, Manipulator, SingularCurves, singular_curves
from rpr_solver.figures.joint_plane import joint_figure
from rpr_solver.figures.wording import letters
from rpr_solver.notebook.scene import Group, Path, area
from tests.support.pictures import check, every, words


@cache
def curves(name: str, length: str) -> SingularCurves:
    return singular_curves(EXAMPLES[name], length)


LONG = pytest.mark.long
SLICES = [
    ("innocenti", "14.98", 6, 1),
    pytest.param("innocenti", "27", 8, 2, marks=LONG),
    ("innocenti", "28.1", 10, 3),
    pytest.param("innocenti", "34", 4, 0, marks=LONG),
    ("zein-flat", "3", 4, 0),
    pytest.param("fourteen-cusps", "5.96", 14, 4, marks=LONG),
]


@pytest.mark.parametrize(("name", "length", "count", "insets"), SLICES)
def test_the_figures_of_the_article_and_beyond(name: str, length: str, count: int, insets: int) -> None:
    figure = joint_figure(curves(name, length).to_json())
    check(figure)
    shown = [word for text in words(figure) for word in text.split(", ")]
    assert {letters(k) for k in range(1, count + 1)} <= set(shown)
    assert sum(word.startswith("×") for word in shown) >= insets
    assert (insets == 0) == (not any(word.startswith("×") for word in shown))
    assert figure.scene.title == f"Singular curves at L1 = {length}: {count} cusps"
    groups = [shape.name for shape in every(figure.scene.shapes) if isinstance(shape, Group)]
    assert {f"cusp {letters(k)}" for k in range(1, count + 1)} <= set(groups)


def test_letters_are_those_of_the_table() -> None:
    slices = curves("innocenti", "14.98")
    text = joint_figure(slices.to_json()).scene.description
    for k, cusp in enumerate(slices.table.cusps, 1):
        assert f"{letters(k)} at L2 = {float(cusp.l2):.6g}, L3 = {float(cusp.l3):.6g}" in text


def test_regions_with_their_numbers_of_poses() -> None:
    slices = curves("zein-flat", "3")
    figure = joint_figure(slices.to_json())
    shown = words(figure)
    assert {"no pose", "2 poses", "4 poses"} <= set(shown)
    assert shown.count("0") == 3  # outside, the hole, and the first tick
    painted = [shape for shape in every(figure.scene.shapes[:1]) if isinstance(shape, Path)]
    assert len(painted) == len(slices.regions)
    for path in painted:
        assert [area(ring) > 0 for ring in path.lines] == [k == 0 for k in range(len(path.lines))]


@LONG
def test_another_leg_and_a_slice_without_cusps() -> None:
    figure = singular_curves(EXAMPLES["innocenti"], 16, fixed_leg=2).figure()
    check(figure)
    assert {"L1", "L3"} <= set(words(figure))
    empty = singular_curves(Manipulator(10, 5, 8, 5, 4, 5), "0.05").figure()
    check(empty)
