"""A slice in joint space: its cusps lettered in the order of the table, insets where they are needed."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from math import dist
from random import Random

import pytest

from rpr_solver import EXAMPLES, Figure, Manipulator, SingularCurves, singular_curves
from rpr_solver.contract import letter
from rpr_solver.figures.joint_plane import joint_figure
from rpr_solver.figures.sheet import box_of
from rpr_solver.figures.strands import CIRCLE
from rpr_solver.notebook.scene import Box, Disc, Group, Path, Text, area
from rpr_solver.notebook.tables import SCREEN, Style
from tests.support.pictures import check, every, meet, random_robot, words


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
    assert {letter(k) for k in range(1, count + 1)} <= set(shown)
    factors = sum(": × " in word for word in shown)
    assert factors >= insets
    assert (insets == 0) == (factors == 0)
    assert figure.scene.title == f"Singular curves at L1 = {length}: {count} cusps"
    groups = [shape.name for shape in every(figure.scene.shapes) if isinstance(shape, Group)]
    assert {f"cusp {letter(k)}" for k in range(1, count + 1)} <= set(groups)


def test_letters_are_those_of_the_table() -> None:
    slices = curves("innocenti", "14.98")
    text = joint_figure(slices.to_json()).scene.description
    for k, cusp in enumerate(slices.table.cusps, 1):
        assert f"{letter(k)} at L2 = {float(cusp.l2):.6g}, L3 = {float(cusp.l3):.6g}" in text


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


COLUMN = Style(width=344, is_print=True, has_symbols=True, unit="mm")
VECTORS = [
    ("sixteen-cusps", "14.46845", 16),
    ("eighteen-cusps", "15.6431", 18),
]


@pytest.mark.parametrize(("name", "length", "count"), VECTORS)
@pytest.mark.parametrize(
    "style", [SCREEN, Style(width=344, is_print=True, unit="mm")], ids=["page", "column"]
)
def test_many_cusps_are_told_apart(name: str, length: str, count: int, style: Style) -> None:
    figure = joint_figure(curves(name, length).to_json()).styled(style)
    check(figure)
    assert_insets_apart(figure)
    shown = [word for text in words(figure) for word in text.split(": ")[0].split(", ")]
    assert {letter(k) for k in range(1, count + 1)} <= set(shown)
    assert_cusps_apart(figure, count)


def assert_cusps_apart(figure: Figure, count: int) -> None:
    """Each cusp has a circle, in the plane or in an inset, that no circle of another cusp touches."""
    groups = [shape for shape in every(figure.scene.shapes) if isinstance(shape, Group)]
    marks = [
        (group.name, shape.centre) for group in groups for shape in group.shapes if isinstance(shape, Disc)
    ]
    for name in (f"cusp {letter(k)}" for k in range(1, count + 1)):
        others = [at for other, at in marks if other != name and other.startswith("cusp ")]
        clear = [min(dist(at, other) for other in others) for own, at in marks if own == name]
        assert max(clear) >= 2 * CIRCLE, name


def assert_insets_apart(figure: Figure) -> None:
    """No inset covers another, a label that is not its own, or leaves the picture."""
    scene = figure.scene
    texts = [shape for shape in every(scene.shapes) if isinstance(shape, Text) and not shape.turn]
    boxes = []
    for foot in (text for text in texts if ": × " in text.words):
        frames = [
            box
            for shape in every(scene.shapes)
            if isinstance(shape, Path) and shape.closed and shape.paint.width == 1.4 and len(shape.lines) == 1
            for box in [Box.around(shape.lines[0])]
            if abs(box.centre[0] - foot.at[0]) < 0.1 and 0 < foot.at[1] - box.y1 < 20
        ]
        boxes.append(Box(frames[0].x0, frames[0].y0, frames[0].x1, frames[0].y1 + 17))
    whole = Box(0, 0, scene.width, scene.height)
    for k, box in enumerate(boxes):
        assert all(corner in whole for corner in box.corners)
        assert not any(meet(box, other) for other in boxes[:k])
        for text in texts:
            inner = box_of(text)
            assert not meet(box, inner) or all(corner in box.grown(2) for corner in inner.corners), text.words


@LONG
@pytest.mark.parametrize("seed", range(200))
def test_random_slices(seed: int) -> None:
    rng = Random(seed)
    robot = random_robot(rng)
    leg = rng.choice((1, 2, 3))
    figure = singular_curves(robot, Fraction(rng.randint(1, 400), 10), fixed_leg=leg).figure()
    for style in (SCREEN, COLUMN):
        drawn = figure.styled(style)
        check(drawn)
        assert_insets_apart(drawn)
