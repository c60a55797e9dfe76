"""The cusp locus in three planes: one scale, every curve in each plane, names that hide nothing."""

from __future__ import annotations

from math import hypot

import pytest

from rpr_solver import InputError
from rpr_solver.figures.projections import projections_figure
from rpr_solver.figures.views import figure_of
from rpr_solver.notebook.figure import Figure
from rpr_solver.notebook.scene import Box, Group, Path
from rpr_solver.notebook.tables import SCREEN, Style
from tests.rpr_solver.figures.test_locus import curve, document
from tests.support.pictures import check, every, words

COLUMN, PAGE = (Style(width, is_print=True, has_symbols=True, unit="mm") for width in (320, 720))
TWO = document(curve("C1", 2, 9), curve("C2", 4, 12, "lips")) | {"range": {"from": "0", "to": "12"}}


def planes(figure: Figure) -> list[Box]:
    """The frames of the planes, in order."""
    paths = [shape for shape in figure.scene.shapes if isinstance(shape, Path)]
    return [Box.around(path.lines[0]) for path in paths if path.closed and len(path.lines[0]) == 4]


def drawn(figure: Figure, name: str) -> list[Path]:
    """A curve, in each plane."""
    groups = [shape for shape in figure.scene.shapes if isinstance(shape, Group) and shape.name == name]
    return [path for group in groups for path in group.shapes if isinstance(path, Path)]


def test_every_curve_is_in_each_plane_and_lengths_have_one_scale() -> None:
    figure = projections_figure(TWO)
    check(figure)
    above, below, beside = planes(figure)
    assert (above.x0, above.x1) == (below.x0, below.x1)
    assert (above.y0, above.y1) == (beside.y0, beside.y1)
    first, second, third = drawn(figure, "curve C1")
    for path, box in zip((first, second, third), (above, below, beside), strict=True):
        assert all(point in box.grown(0.1) for point in path.lines[0])
    (l1, l2), (r1, r2) = first.lines[0][0], first.lines[0][-1]
    (_, l3), (_, r3) = second.lines[0][0], second.lines[0][-1]
    (m3, m2), (n3, n2) = third.lines[0][0], third.lines[0][-1]
    assert (m2, n2) == pytest.approx((l2, r2))
    assert n3 - m3 == pytest.approx(l3 - r3)  # as long to the right as upwards
    assert l3 - r3 == pytest.approx((r1 - l1) / 2)  # L3 = L1/2 + 3
    assert hypot(r1 - l1, r2 - l2) > 100


def test_what_stands_in_it() -> None:
    figure = projections_figure(TWO)
    assert figure.scene.title == "Cusp locus: 2 curves of cusps, in three planes"
    assert {"L1", "L2", "L3", "swallowtail", "lips", "C1: L1 from 2 to ∞"} <= set(words(figure))
    assert words(figure).count("C1") == words(figure).count("C2") == 3
    assert "in the planes of L1 and L2, L1 and L3, and L3 and L2" in figure.scene.description
    assert "C2 from L1 = 4 (lips) to ∞ (open)" in figure.scene.description


@pytest.mark.parametrize("style", [SCREEN, COLUMN, PAGE], ids=["screen", "column", "page"])
@pytest.mark.parametrize("count", [0, 1, 25])
def test_any_number_of_curves_at_any_width(count: int, style: Style) -> None:
    figure = projections_figure(document(*(curve(f"C{k}", k / 7, 5 + k) for k in range(count)))).styled(style)
    check(figure)
    legend = [shape.paint for shape in figure.scene.shapes if isinstance(shape, Path) and not shape.closed]
    samples = {(paint.stroke, paint.dash) for paint in legend if paint.width == 1.8}
    assert len(samples) == count, "every curve looks different"
    if style is COLUMN:
        first, second, third = planes(figure)
        assert first.y1 < second.y0 < second.y1 < third.y0
        assert first.x0 == second.x0 == third.x0


def test_lengths_of_very_different_size_have_scales_of_their_own() -> None:
    short = document(curve("C1", 200, 200.5))
    figure = projections_figure({**short, "range": {"from": "200", "to": "200.5"}})
    check(figure)
    sides = [side for box in planes(figure) for side in (box.width, box.height)]
    assert min(sides) > 110


def test_the_views_of_a_locus() -> None:
    assert figure_of(TWO, view="projections") == projections_figure(TWO)
    assert figure_of(TWO, view="space") == figure_of(TWO) != projections_figure(TWO)
    with pytest.raises(InputError, match=r"^view: is 'plan'; give space or projections$"):
        figure_of(TWO, view="plan")


def test_curves_without_points() -> None:
    bare = {**curve("C1", 1, 2), "points": []}
    figure = projections_figure(document(bare))
    check(figure)
    assert not any(isinstance(shape, Path) and len(shape.lines) == 0 for shape in every(figure.scene.shapes))
