"""A slice on the torus of its angles."""

from functools import cache

import pytest

from rpr_solver import EXAMPLES, InputError, SingularCurves, singular_curves
from rpr_solver.figures.strands import torus_figure
from rpr_solver.notebook.scene import Group, Path, area
from tests.support.pictures import check, words


@cache
def the_curves() -> SingularCurves:
    return singular_curves(EXAMPLES["innocenti"], 27)


def test_aspects_and_cusps() -> None:
    figure = torus_figure(the_curves().to_json())
    check(figure)
    assert {"A", "H", "θ1", "α", "−180°", "180°", "J > 0", "J < 0"} <= set(words(figure))
    assert "2 with J > 0 and 1 with J < 0" in figure.scene.description
    assert the_curves().figure("torus") == figure


def test_what_is_coloured_are_the_aspects_of_the_document() -> None:
    document = the_curves().to_json()
    figure = torus_figure(document)
    groups = [shape for shape in figure.scene.shapes if isinstance(shape, Group) and "aspect" in shape.name]
    names = {1: "aspect with J > 0", -1: "aspect with J < 0"}
    assert [group.name for group in groups] == [names[aspect["sign"]] for aspect in document["aspects"]]
    whole = 0.0
    for group, aspect in zip(groups, document["aspects"], strict=True):
        [path] = group.shapes
        assert isinstance(path, Path)
        covered = sum(abs(area(ring)) for ring in path.lines)
        whole += covered
        assert covered / (634 * 582) == pytest.approx(aspect["share"], abs=1e-6)
    assert whole == pytest.approx(634 * 582)


def test_another_leg() -> None:
    figure = singular_curves(EXAMPLES["zein-flat"], 20, fixed_leg=3).figure("torus")
    check(figure)
    assert "θ3" in words(figure)


def test_a_view_that_there_is_not() -> None:
    with pytest.raises(InputError, match=r"^view: 'sphere'; give joints or torus$|^view: is 'sphere'"):
        the_curves().figure("sphere")
