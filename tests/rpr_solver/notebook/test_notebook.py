"""Answers in a notebook and a data frame: short reprs, HTML, pictures, rows, typed certificates."""

import inspect
import json
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from fractions import Fraction
from functools import cache
from typing import Any
from xml.etree import ElementTree

import pytest

import rpr_solver
from rpr_solver import (
    EXAMPLES,
    Manipulator,
    Requirement,
    article_table,
    census,
    check,
    cusp_loop,
    cusp_table,
    joint_path,
    poses,
    poses_of_squares,
    singular_curves,
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
LENGTHS = ("a2x", "a3x", "a3y", "d1", "d2", "d3")


@cache
def the(name: str) -> Any:
    """The answer of a name, computed when a test first needs it."""
    return ANSWERS[name]()


@pytest.fixture
def answer(name: str) -> Any:
    return the(name)


def parts(answer: object) -> list[object]:
    """An answer and its parts."""
    inside = (
        "cusps",
        "transitions",
        "curves",
        "poses",
        "intervals",
        "polynomial",
        "requirement",
        "manipulator",
    )
    found = [answer]
    for name in inside:
        part = getattr(answer, name, ())
        found += part if isinstance(part, tuple) else [part]
    found += [event for transition in getattr(answer, "transitions", ()) for event in transition.events]
    for curve in getattr(answer, "curves", ()):
        found += [curve.start, curve.stop, *curve.points] if hasattr(curve, "start") else []
    return [part for part in found if not isinstance(part, dict) and not callable(part)]


@pytest.mark.parametrize("name", ANSWERS)
def test_reprs_are_one_short_line(answer: object) -> None:
    for part in parts(answer):
        assert "\n" not in repr(part)
        assert len(repr(part)) <= 160, repr(part)


def _public(found: object) -> Iterator[object]:
    """The objects of public classes in an answer, itself included."""
    if isinstance(found, tuple):
        for part in found:
            yield from _public(part)
    elif type(found).__name__ in rpr_solver.__all__:
        yield found
        if is_dataclass(found) and not isinstance(found, type):
            for member in fields(found):
                yield from _public(getattr(found, member.name))


@pytest.mark.slow
def test_every_public_object_of_curves_and_paths_has_a_short_repr() -> None:
    manipulator = EXAMPLES["innocenti"]
    curves = singular_curves(manipulator, 27, digits=200)
    loop = cusp_loop(manipulator, 27, "A", samples=3, digits=60).with_others()
    none = joint_path(manipulator, 27, 20, 20, 1, 3, digits=200)
    answers = (
        curves,
        curves.regions,
        curves.aspects,
        tuple(curves.strands),
        tuple(curves.vertices),
        loop,
        none,
    )
    found = {type(part).__name__: repr(part) for part in _public(answers)}
    assert {"Region", "Aspect", "Strand", "Vertex", "PathSample", "PathPose", "OtherPose"} < set(found)
    assert {name: text for name, text in found.items() if len(text) > 250 or "\n" in text} == {}
    assert len(repr(curves.aspects)) < 200


def test_answers_to_questions_of_yes_or_no_are_true_or_false() -> None:
    failed, passed = (check(FLAT, Requirement(start=30, stop=40, max_cusps=most)) for most in (6, 8))
    assert (bool(failed), bool(passed)) == (failed.passed, passed.passed) == (False, True)
    document = the("poses").to_json()
    assert verify_document(document)
    assert not verify_document({**document, "count": document["count"] + 1})
    assert not joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 3)
    assert joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 2, samples=2)


def test_a_table_is_a_sequence_of_its_cusps_and_prints_as_a_table() -> None:
    table = the("table")
    assert (list(table), len(table)) == (list(table.cusps), table.count)
    title, head, *lines = str(table).splitlines()
    assert (title, head.split()[0], len(lines)) == ("SliceTable L1=10: 4 cusps, 15 digits", "l1", table.count)
    empty = the("degenerate table")
    assert (len(empty), bool(empty)) == (0, True)
    assert len(str(empty).splitlines()) == 2 + len(empty.degenerate_points)


def test_the_repr_of_a_requirement_reads_back() -> None:
    requirement = Requirement(2, "1/3", max_cusps=8, min_cusps=0, limits={1: (0, 5), "l3": (None, "2.5")})  # type: ignore[dict-item]
    assert eval(repr(requirement), {"Requirement": Requirement}) == requirement


def test_reprs_do_not_grow_with_the_digits() -> None:
    [table] = cusp_table(FLAT, "10/3", digits=1000)
    assert repr(table) == f"<SliceTable L1=10/3: {table.count} cusps, 1000 digits>"
    assert all(len(repr(cusp)) < 120 for cusp in table.cusps)
    assert len(table._repr_html_()) < 3000


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


def test_a_long_table_says_what_it_leaves_out() -> None:
    html = html_table("many", [{"n": n} for n in range(60)])
    assert html.count("<tr>") == 51
    assert "and 10 more rows" in html


@pytest.mark.parametrize("name", [*EXAMPLES, "census", "short census"])
def test_pictures_are_well_formed(answer: Any) -> None:
    root = ElementTree.fromstring(answer._repr_svg_())
    assert root.tag == "{http://www.w3.org/2000/svg}svg"


def test_a_picture_of_enormous_lengths_is_the_same_but_for_its_caption() -> None:
    huge = Manipulator(*(FLAT.to_dict()[name] * 10**350 for name in LENGTHS))  # type: ignore[literal-required]
    usual, large = (m.figure().styled(has_caption=False).svg().partition("</desc>")[2] for m in (FLAT, huge))
    assert usual == large


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


def test_rows_say_what_the_documents_say() -> None:
    assert [row["count"] for row in the("census").rows()] == list(the("census").counts)
    assert [row["transition_at_end"] for row in the("census").rows()] == [
        *(t.kind for t in the("census").transitions),
        None,
    ]
    assert [row["admitted"] for row in the("report").rows()].count(False) == len(the("report").violations)
    assert len(the("curves").rows()) == sum(len(curve.points) for curve in the("curves").curves)
    assert [row["alpha_deg_text"] for row in the("poses").rows()] == [
        pose.alpha_deg for pose in the("poses").poses
    ]


# Certificates


@pytest.mark.parametrize("name", ["table", "degenerate table", "congruent table", "census", "poses", "audit"])
def test_a_certificate_has_exactly_the_members_of_its_type(answer: Any) -> None:
    answer = getattr(answer, "table", answer)
    kind = inspect.get_annotations(type(answer), eval_str=True)["certificate"]
    assert answer.certificate.keys() == kind.__required_keys__
    assert answer.to_json()["certificate"] == answer.certificate
    json.dumps(answer.certificate)


def test_an_audit_has_exactly_the_members_of_its_type() -> None:
    kind = inspect.get_annotations(type(the("audit")), eval_str=True)["audit"]
    assert the("audit").audit.keys() == kind.__required_keys__
    assert the("audit").to_json()["audit"] == the("audit").audit
