"""Answers in a notebook and a data frame: short reprs, HTML, pictures, rows, typed certificates."""

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any
from xml.etree import ElementTree

import pytest

from rpr_solver import (
    EXAMPLES,
    Manipulator,
    Requirement,
    article_table,
    census,
    check,
    cusp_table,
    joint_path,
    poses,
    poses_of_squares,
    verify_document,
)
from rpr_solver.notebook.tables import html_table
from tests.support.shared import census_of, curves_of

FLAT = EXAMPLES["zein-flat"]
ANSWERS: dict[str, Callable[[], Any]] = {
    "table": lambda: cusp_table(FLAT, 10, digits=15)[0],
    "degenerate table": lambda: cusp_table(Manipulator(20, 6, 0, 7, 9, 16), 3, digits=15)[0],
    "congruent table": lambda: cusp_table(Manipulator(30, 0, 40, 30, 50, 40), 5, digits=15)[0],
    "census": lambda: census_of(FLAT, digits=15),
    "short census": lambda: census(FLAT, start=38, digits=15),
    "curves": lambda: curves_of(FLAT, digits=15),
    "poses": lambda: poses(FLAT, 20, "20.5", "61/3", digits=15),
    "poses of squares": lambda: poses_of_squares(EXAMPLES["innocenti"], 225, 200, 900, digits=15),
    "report": lambda: check(FLAT, Requirement(start=30, stop=40, max_cusps=6), digits=15),
    "audit": lambda: article_table(EXAMPLES["innocenti"], 27, digits=15),
    **{name: lambda m=m: m for name, m in EXAMPLES.items()},  # type: ignore[misc]
}


@cache
def the(name: str) -> Any:
    """The answer of a name, computed when a test first needs it."""
    return ANSWERS[name]()


@pytest.fixture
def answer(name: str) -> Any:
    return the(name)


def test_answers_to_questions_of_yes_or_no_are_true_or_false() -> None:
    failed, passed = (check(FLAT, Requirement(start=30, stop=40, max_cusps=most)) for most in (6, 8))
    assert (bool(failed), bool(passed)) == (failed.passed, passed.passed) == (False, True)
    document = the("poses").to_json()
    assert verify_document(document)
    assert not verify_document({**document, "count": document["count"] + 1})
    assert not joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 3)
    assert joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 2, samples=2)


def test_the_repr_of_a_requirement_reads_back() -> None:
    requirement = Requirement(2, "1/3", max_cusps=8, min_cusps=0, limits={1: (0, 5), "l3": (None, "2.5")})  # type: ignore[dict-item]
    assert eval(repr(requirement), {"Requirement": Requirement}) == requirement


@pytest.mark.parametrize("name", ANSWERS)
def test_html_is_one_well_formed_element_without_scripts(answer: Any) -> None:
    html = answer._repr_html_()
    root = ElementTree.fromstring(html)
    assert root.tag == "div"
    assert not {element.tag for element in root.iter()} & {"script", "style", "a", "img"}
    assert "color" not in html


def test_html_is_escaped() -> None:
    html = html_table("<b>", [{"<i>": "</td>"}], ["a & b"])
    assert [e.text for e in ElementTree.fromstring(html).iter() if e.text] == ["<b>", "<i>", "</td>", "a & b"]


@pytest.mark.parametrize("name", [*EXAMPLES, "census", "short census"])
def test_pictures_are_well_formed(answer: Any) -> None:
    root = ElementTree.fromstring(answer._repr_svg_())
    assert root.tag == "{http://www.w3.org/2000/svg}svg"


# Rows for data frames


@pytest.mark.parametrize("name", sorted(ANSWERS.keys() - EXAMPLES.keys()))
def test_rows_have_floats_beside_their_texts(answer: Any) -> None:
    rows = answer.rows()
    assert rows
    for row in rows:
        for name in [name for name in row if name.endswith("_text")]:
            value, text = row[name.removesuffix("_text")], row[name]
            assert isinstance(value, float)
            if text is None:
                assert value == float("inf")
            elif text.startswith("sqrt"):
                assert value > 0
            else:
                assert value == pytest.approx(float(Fraction(text)), rel=1e-15, abs=0)


def test_rows_tell_cusps_from_degenerate_points() -> None:
    assert [(row["kind"], row["cusp"]) for row in the("table").rows()] == [("cusp", n) for n in (1, 2, 3, 4)]
    assert [(row["kind"], row["cusp"]) for row in the("degenerate table").rows()] == [("quadruple", None)] * 4
    assert the("congruent table").rows()[0]["equation"] == "alpha = 0 deg"


# Certificates
