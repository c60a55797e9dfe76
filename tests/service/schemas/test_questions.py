"""Every question, as it is read from JSON and from the command line."""

from __future__ import annotations

import json
from contextlib import suppress
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, InputError, exact_str
from service.schemas.censuses import CensusRequest, CheckRequest
from service.schemas.curves import CuspCurvesRequest, MarginRequest
from service.schemas.designs import DesignRequest
from service.schemas.document import JsonNumber, Source, parse_json, read
from service.schemas.lengths import OpenRange, split_ends
from service.schemas.limits import LimitError, Limits
from service.schemas.modes import AssemblyModesRequest, PoseConnectionsRequest
from service.schemas.paths import PathRequest
from service.schemas.plots import PlotRequest
from service.schemas.poses import AspectsRequest, PosesRequest, SingularCurvesRequest
from service.schemas.questions import Question
from service.schemas.registry import all_questions
from service.schemas.tables import CuspTableRequest
from service.schemas.workspaces import WorkspaceRequest
from tests.support.service_server import GEOMETRY
from worker.answers.kinds import KINDS

JSON = Source(Limits())
OPTIONS = Source(Limits(), {"range": "--l1-range"}, is_text=True)
QUESTIONS = all_questions()
BODY: dict[str, Any] = {"geometry": {key: JsonNumber(value) for key, value in GEOMETRY.items()}}
POSITIVE = st.fractions(min_value=Fraction(1, 1000), max_value=1000, max_denominator=1000)


def content(question: type[Question], body: object, source: Source = JSON) -> dict[str, Any]:
    return dict(read(question, body, source).job_request().content)


def problems(question: type[Question], body: str, limits: Limits | None = None) -> list[tuple[str, str]]:
    with pytest.raises(InputError) as caught:
        read(question, parse_json(body.encode()), Source(limits or Limits()))
    return [(problem.field, problem.message) for problem in caught.value.problems]


def spellings(x: Fraction) -> st.SearchStrategy[str | Fraction]:
    """Ways to write one number."""
    plain = exact_str(x)
    return st.sampled_from(
        [
            x,
            plain,
            JsonNumber(plain) if "/" not in plain else plain,
            f"{x.numerator}/{x.denominator}",
            f" {plain} ",
        ]
    )


@given(st.data(), POSITIVE, POSITIVE)
def test_every_spelling_is_one_question(data: st.DataObject, start: Fraction, width: Fraction) -> None:
    stop = start + width
    ends = {"from": data.draw(spellings(start)), "to": data.draw(spellings(stop))}
    bounds = {"from": exact_str(start), "to": exact_str(stop)}
    geometry = EXAMPLES["innocenti"].to_json()
    assert content(CensusRequest, {**BODY, "range": ends}) == {
        **{"geometry": geometry, "fixed_leg": 1, "digits": 90},
        "range": bounds,
    }
    legs = {f"l{leg}": data.draw(spellings(start)) for leg in (1, 2, 3)}
    text = dict.fromkeys(legs, exact_str(start))
    assert content(PosesRequest, {**BODY, **legs}) == {"geometry": geometry, **text, "digits": 90}
    requirement = {"range": ends, "max_cusps": JsonNumber("4")}
    checked = content(CheckRequest, {**BODY, "requirement": requirement})["requirement"]
    assert (checked["range"], checked["max_cusps"], checked["min_cusps"]) == (bounds, 4, None)
    lengths = [data.draw(spellings(x)) for x in (stop, start, stop)]
    sampled = content(CuspCurvesRequest, {**BODY, "l1": lengths, "range": ends})
    assert sampled["lengths"] == [exact_str(start), exact_str(stop)]


@given(st.none() | POSITIVE, st.none() | POSITIVE)
def test_a_range_is_the_same_on_the_command_line(start: Fraction | None, stop: Fraction | None) -> None:
    ends = {"from": start and exact_str(start), "to": stop and exact_str(stop)}
    option = split_ends(f"{ends['from'] or ''}:{ends['to'] or ''}")
    if stop is not None and stop <= (start or 0):
        with pytest.raises(InputError, match=r"^range\.to: .* must exceed"):
            read(CensusRequest, {**BODY, "range": ends}, JSON)
        with pytest.raises(InputError, match=r"^--l1-range\.to: .* must exceed"):
            read(CensusRequest, {**BODY, "range": option}, OPTIONS)
        return
    for source, sent in ((JSON, ends), (OPTIONS, option)):
        assert read(OpenRange, sent, source).ends == (start or 0, stop)


def test_only_on_the_command_line_is_text_a_whole_number() -> None:
    body = {"geometry": EXAMPLES["innocenti"], "digits": "30", "fixed_leg": "2"}
    assert content(CensusRequest, body, OPTIONS)["fixed_leg"] == 2
    with pytest.raises(InputError, match="digits: is a string; give a whole number: 15 to 1000"):
        read(CensusRequest, body, JSON)


@pytest.mark.parametrize("question", QUESTIONS)
def test_faults_are_told_as_they_are_documented(question: type[Question]) -> None:
    schema = question.model_json_schema()
    of_slices = CuspTableRequest, PathRequest, SingularCurvesRequest
    required = set(schema["required"]) | ({"l1"} if question in of_slices else set())
    sent = json.dumps({**dict.fromkeys(schema["properties"]), "other": 1})
    unknown = [field for field, message in problems(question, sent) if message.startswith("unknown field")]
    assert set(unknown) - {"l2", "l3"} == {"other"}
    missing = problems(question, "{}")
    assert {field for field, message in missing if message.startswith("is missing; give ")} == required
    assert problems(question, "[]") == [("body", f"is a list; {question.expected}")]


@pytest.mark.parametrize("question", [question for question in QUESTIONS if question.names_geometry])
def test_the_digits_are_those_of_the_limits(question: type[Question]) -> None:
    _, example = next(iter(question.examples.values()))
    body = parse_json(json.dumps({"geometry": GEOMETRY, **example, "digits": None}).encode())
    assert isinstance(body, dict)
    del body["digits"]
    digits = read(question, body, Source(Limits(default_digits=50))).job_request().digits
    of_15 = (
        PathRequest,
        SingularCurvesRequest,
        AspectsRequest,
        AssemblyModesRequest,
        PoseConnectionsRequest,
        PlotRequest,
        MarginRequest,
        DesignRequest,
        WorkspaceRequest,
    )
    expected = {CheckRequest: 30, **dict.fromkeys(of_15, 15)}
    assert digits == expected.get(question, 50)


def test_every_kind_of_document_has_one_question() -> None:
    assert sorted(kind.name for question in QUESTIONS for kind in question.kinds) == sorted(
        kind.name for kind in KINDS
    )


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (
            '{"geometry": {"a2x": 1, "orientation": "up", "dd": 2}}',
            [
                ("geometry.dd", "unknown member; did you mean d3?"),
                ("geometry.orientation", "'up' is neither"),
                *((f"geometry.{name}", "is missing; give a number") for name in ("a3x", "a3y")),
                *((f"geometry.{name}", "is missing; give a number") for name in ("d1", "d2", "d3")),
            ],
        ),
        ('{"geometry": %s, "range": {"from": []}}', [("range.from", "is a list; give a number such as")]),
    ],
)
def test_a_fault_is_reported_with_a_valid_alternative(body: str, expected: list[tuple[str, str]]) -> None:
    faults = problems(CensusRequest, body.replace("%s", json.dumps(GEOMETRY)))
    assert [field for field, _ in faults] == [field for field, _ in expected]
    assert all(message.startswith(start) for (_, message), (_, start) in zip(faults, expected, strict=True))


def test_limits_alone_are_a_limit_error() -> None:
    long = {**BODY["geometry"], "d1": "1" * 401, "d2": "1e500"}
    with pytest.raises(LimitError) as caught:
        read(CensusRequest, {"geometry": long, "digits": JsonNumber("1001")}, JSON)
    assert caught.value.limit == "max_number_digits"
    assert [p.field for p in caught.value.problems] == ["geometry.d1", "geometry.d2", "digits"]
    with pytest.raises(InputError) as mixed:
        read(CensusRequest, {"geometry": long, "digits": "x"}, JSON)
    assert not isinstance(mixed.value, LimitError)


def test_of_many_unknown_fields_some_are_told() -> None:
    body = json.dumps({"geometry": {**GEOMETRY, **{f"k{i}": 1 for i in range(10_000)}}})
    assert len(problems(CensusRequest, body)) == 20


@given(st.recursive(st.none() | st.booleans() | st.text() | st.builds(JsonNumber, st.just("1")), st.lists))
def test_anything_else_is_refused_as_input(value: object) -> None:
    members = ("geometry", "requirement", "range", "l1", "samples", "method", "fixed_leg", "digits")
    for question in QUESTIONS:
        for body in (value, {**BODY, **dict.fromkeys(members[1:], value)}, dict.fromkeys(members, value)):
            with suppress(InputError):
                read(question, body, JSON)


def test_sensitivities_are_another_question_and_their_absence_is_none() -> None:
    plain, off, on = (
        read(CensusRequest, BODY | more, JSON)
        for more in ({}, {"sensitivities": False}, {"sensitivities": True})
    )
    assert plain.job_request() == off.job_request()
    assert "sensitivities" not in plain.content()
    assert on.job_request() != plain.job_request()
    assert read(CensusRequest, on.body(), JSON).content() == on.content()
    with pytest.raises(InputError, match="sensitivities: is a string; give true or false"):
        read(CensusRequest, BODY | {"sensitivities": "true"}, JSON)


def test_a_tolerance_makes_another_check_in_canonical_form() -> None:
    sent = {**BODY, "requirement": {"range": {"from": 1, "to": 2}, "max_cusps": 4}}
    plain, common, single = (
        read(CheckRequest, sent | more, JSON)
        for more in ({}, {"tolerance": JsonNumber("0.10")}, {"tolerance": {"d1": "1/3", "a3x": "0"}})
    )
    assert "tolerance" not in plain.content()
    assert common.content()["tolerance"] == dict.fromkeys(("a2x", "a3x", "a3y", "d1", "d2", "d3"), "0.1")
    assert single.content()["tolerance"]["d1"] == "1/3"
    assert len({question.job_request().job_id for question in (plain, common, single)}) == 3
    assert read(CheckRequest, common.body(), JSON).content() == common.content()
    for wrong, named in (("-1", "tolerance"), ({"d1": "0"}, "tolerance"), ({"b": "1"}, "tolerance.b")):
        with pytest.raises(InputError) as caught:
            read(CheckRequest, sent | {"tolerance": wrong}, JSON)
        assert [problem.field for problem in caught.value.problems] == [named]


@pytest.mark.parametrize(
    ("question", "body", "expected"),
    [
        (PoseConnectionsRequest, {"l1": 1, "l2": 1, "l3": 1, "parts": "yes"}, "parts: is a string; give"),
        (PathRequest, {"l1": 27, "l2": 20, "l3": 20}, "l2: .* for a path from pose to pose give from and to"),
        (CheckRequest, {"requirement": {"max_cusps": "\ud800"}}, r"max_cusps: is '.ud800'; give a whole"),
        (DesignRequest, {"objective": "most-cusps", "fixed": ["d1", None]}, r"fixed\[1\]: is null; give a"),
    ],
)
def test_a_wrong_value_is_named_with_what_would_be_right(
    question: type[Question], body: dict[str, Any], expected: str
) -> None:
    with pytest.raises(InputError, match=expected):
        read(question, parse_json(json.dumps({"geometry": GEOMETRY, **body}).encode()), JSON)


@pytest.mark.parametrize("question", QUESTIONS)
def test_the_body_of_a_question_asks_the_same(question: type[Question]) -> None:
    geometry = {"geometry": GEOMETRY} if question.names_geometry else {}
    more = {"width_mm": 86, "style": "paper", "labels": "none"} if question is PlotRequest else {}
    for _, example in question.examples.values():
        asked = read(question, parse_json(json.dumps({**geometry, **example, **more}).encode()), JSON)
        sent = read(question, parse_json(json.dumps(asked.body()).encode()), JSON)
        assert (sent.kind, sent.content()) == (asked.kind, asked.content())
