"""Every picture names what it shows and its geometry."""

from rpr_solver.figures.sheet import caption_of, listed, sheet
from tests.support.pictures import GEOMETRY, check, words


def test_title_caption_and_description() -> None:
    figure = sheet("Nothing", GEOMETRY, "An empty picture.", (), 200)
    check(figure)
    assert words(figure) == ["Nothing", caption_of(GEOMETRY)]
    assert figure.scene.description == f"An empty picture. Geometry: {caption_of(GEOMETRY)}."


def test_enumerations() -> None:
    assert [listed(x) for x in (["A"], ["A", "B"], ["A", "B", "C"])] == ["A", "A and B", "A, B and C"]
