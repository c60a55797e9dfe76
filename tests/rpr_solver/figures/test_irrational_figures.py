"""Pictures and tables of manipulators with roots: of any document, and of the geometry itself."""

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

from rpr_solver import (
    Manipulator,
    census,
    cusp_loop,
    pose_connections,
    poses,
    singular_curves,
    table_document,
    with_sensitivities,
)
from rpr_solver.exports.latex import bibtex, latex_table
from rpr_solver.figures.mechanism import Triangles
from rpr_solver.figures.views import figure_of
from tests.support.pictures import words
from tests.support.sampling import long
from tests.support.triangle_spellings import rational_near

ROOTS = Manipulator(
    base={"points": [[0, 0], [3, "4*sqrt(7)"], [10, 0]]},
    platform={"points": [[1, 0], [5, 0], [3, "-4*sqrt(7)"]]},
)


def test_the_triangles_are_those_of_a_rational_manipulator() -> None:
    found, known = (Triangles.of(x.to_json()) for x in (ROOTS, rational_near(ROOTS)))
    for own, other in zip((*found.base, *found.platform), (*known.base, *known.platform), strict=True):
        assert own == pytest.approx(other, abs=1e-12)


@pytest.mark.parametrize(
    "make",
    [
        long(lambda m: m.to_json()),
        lambda m: poses(m, 8, 8, 8, digits=15).to_json(),
        lambda m: singular_curves(m, 8, digits=15).to_json(),
        long(lambda m: cusp_loop(m, 8, 1, samples=5).to_json()),
        long(lambda m: pose_connections(m, 8, 8, 8).to_json()),
        long(lambda m: census(m, start=7, stop=9, digits=15).to_json()),
        long(lambda m: with_sensitivities(census(m, start=10, stop=15, digits=15).to_json())),
    ],
)
def test_a_document_is_drawn_as_that_of_a_rational_manipulator(make: Callable[[Manipulator], Any]) -> None:
    found, known = (figure_of(make(m)) for m in (ROOTS, rational_near(ROOTS)))
    assert found.title == known.title
    assert Counter(words(found))["L2"] == Counter(words(known))["L2"]
    assert found.svg().count("<path") == known.svg().count("<path")


def test_papers_have_roots_as_latex_has_them() -> None:
    document = table_document(ROOTS, 8, digits=15)
    assert r"$A_3 = (30/11, -\sqrt{11200/121})$, $d_1 = 4$, $d_2 = \sqrt{116}$" in latex_table(document)
    assert r"\sqrt{116}" in bibtex(document, "1", 2026)
