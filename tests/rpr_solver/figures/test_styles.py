"""Every figure can be set for a column of a journal, as it is for a page."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rpr_solver import (
    EXAMPLES,
    Figure,
    census,
    cusp_loop,
    poses,
    singular_curves,
    with_sensitivities,
)
from rpr_solver.figures.margins import sensitivities_figure
from rpr_solver.notebook.scene import Box, Text
from rpr_solver.notebook.tables import Style
from tests.support.pictures import SVG, check, every
from tests.support.shared import census_of, curves_of

FIRST, FLAT = EXAMPLES["innocenti"], EXAMPLES["zein-flat"]


def sensitivities() -> Figure:
    return sensitivities_figure(with_sensitivities(census(FLAT, start=30, stop=33, digits=15).to_json()))


FIGURES: dict[str, Callable[[], Figure]] = {
    "slice": lambda: singular_curves(FLAT, 3).figure(),
    "torus": lambda: singular_curves(FLAT, 3).figure("torus"),
    "mechanism": lambda: poses(FIRST, "14.98", 16, 20, digits=15).figure(2),
    "loop": lambda: cusp_loop(FIRST, 27, "B").figure(singular_curves(FIRST, 27)),
    "census": lambda: census_of(FLAT, digits=15).figure(),
    "locus": lambda: curves_of(FLAT, digits=15).part(30, 33, samples=4).figure(),
    "sensitivities": sensitivities,
}


@pytest.mark.parametrize("name", FIGURES)
def test_a_column_of_a_journal(name: str) -> None:
    figure = FIGURES[name]()
    paper = figure.styled(Style(320, is_print=True, has_symbols=True, unit="mm", has_title=False))
    root = check(paper, slack=0.5)
    width, height = paper.scene.millimetres
    assert root.attrib["width"] == f"{width:g}mm" == "80mm"
    assert float(root.attrib["height"].removesuffix("mm")) == pytest.approx(height, abs=0.01)
    texts = [shape for shape in every(paper.scene.shapes) if isinstance(shape, Text)]
    assert all(text.size >= 11 for text in texts)
    assert paper.scene.title == figure.scene.title
    assert figure.scene.title not in [text.words for text in texts]
    box = Box(0, paper.scene.top, 320, paper.scene.height)
    assert all(text.at in box for text in texts)
    assert len(list(root.iter(f"{SVG}tspan"))) > 0


def test_a_style_does_not_change_what_is_shown() -> None:
    figure = FIGURES["mechanism"]()
    assert figure.styled(Style()).svg() == figure.svg()
    assert figure.styled(Style(unit="mm")).scene.description == figure.scene.description


@pytest.mark.parametrize("form", ["png", "pdf"])
def test_files_have_the_size_of_the_column(form: str) -> None:
    pytest.importorskip("matplotlib")
    style = Style(344, is_print=True, has_symbols=True)
    content = FIGURES["mechanism"]().styled(style).encoded(f".{form}")
    if form == "png":
        width = int.from_bytes(content[16:20], "big")
        assert width == pytest.approx(86 / 25.4 * 600, abs=1)
    else:
        assert b"/MediaBox [ 0 0 243.77" in content
