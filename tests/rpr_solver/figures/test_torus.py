"""A slice on the torus of its angles."""

from functools import cache

import numpy as np
import pytest

from rpr_solver import EXAMPLES, InputError, SingularCurves, singular_curves
from rpr_solver.figures.torus import areas_of, torus_figure
from tests.support.pictures import check, words


@cache
def the_curves() -> SingularCurves:
    return singular_curves(EXAMPLES["innocenti"], 27)


def test_aspects_and_cusps() -> None:
    figure = torus_figure(the_curves().to_json())
    check(figure)
    assert {"A", "H", "θ1", "α", "−180°", "180°", "J > 0", "J < 0"} <= set(words(figure))
    assert "2 with J > 0 and 1 with J < 0" in figure.description
    assert the_curves().figure("torus").svg() == figure.svg()


def test_what_is_coloured_are_the_aspects_of_the_document() -> None:
    document, whole = the_curves().to_json(), 0.0
    for area, aspect in zip(areas_of(document), document["aspects"], strict=True):
        assert area.sign == aspect["sign"]
        covered = sum(
            abs((np.roll(x, 1) * y - x * np.roll(y, 1)).sum()) / 2 for x, y in (ring.T for ring in area.rings)
        )
        assert covered / 360**2 == pytest.approx(aspect["share"], abs=1e-6)
        whole += covered
    assert whole == pytest.approx(360**2)


def test_another_leg() -> None:
    figure = singular_curves(EXAMPLES["zein-flat"], 20, fixed_leg=3).figure("torus")
    check(figure)
    assert "θ3" in words(figure)


def test_a_view_that_there_is_not() -> None:
    with pytest.raises(InputError, match=r"^view: is 'sphere'; give joints or torus$"):
        the_curves().figure("sphere")
