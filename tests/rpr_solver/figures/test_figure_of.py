"""Every document with a figure is drawn by one function; others are refused."""

from __future__ import annotations

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    cusp_loop,
    joint_path,
    pose_connections,
    poses,
    singular_curves,
)
from rpr_solver import table_document as table
from rpr_solver.figures.views import figure_of
from tests.support.shared import census_of, curves_of

FLAT = EXAMPLES["zein-flat"]


def test_a_document_has_the_figure_of_its_answer() -> None:
    census_, curves = census_of(FLAT, digits=15), curves_of(FLAT, digits=15).part(30, 34, samples=1)
    for answer in (FLAT, census_, curves):
        assert figure_of(answer.to_json()).svg() == answer.figure().svg()
    slice_, loop = singular_curves(FLAT, 34), cusp_loop(FLAT, 34, "A", samples=5)
    found = poses(FLAT, 10, 25, 35, digits=15)
    joined = pose_connections(EXAMPLES["innocenti"], 27, 20, 20)
    pairs = [
        (figure_of(slice_.to_json(), view="torus"), slice_.figure("torus"), slice_.figure()),
        (figure_of(loop.to_json(), curves=slice_.to_json()), loop.figure(slice_), loop.figure()),
        (figure_of(found.to_json(), pose=2), found.figure(2), found.figure()),
        (figure_of(joined.to_json()), joined.figure(), found.figure()),
    ]
    for drawn, own, other in pairs:
        assert drawn.svg() == own.svg() != other.svg()


def test_documents_without_a_figure() -> None:
    apart = joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 3)
    for document in (table(FLAT, 10, digits=15), apart.to_json(), {}):
        with pytest.raises(InputError, match=r"^document: has no figure; give curves, a census, a path, "):
            figure_of(document)


def test_a_view_that_there_is_not() -> None:
    with pytest.raises(InputError, match=r"^view: is 'plan'; give joints or torus$"):
        singular_curves(FLAT, 34).figure("plan")
