"""A geometry in a body: read whole, kept canonical, and sent as it was given."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rpr_solver.contract import silent
from rpr_solver.errors import InputError
from service.schemas.columns import COLUMNS, POINTS, SIDES, SIX, form_of, geometry_of
from service.schemas.document import Source, parse_json, read
from service.schemas.limits import Limits
from service.schemas.poses import PosesRequest
from service.schemas.tables import CuspTableRequest
from worker.answers.kind import Store
from worker.answers.kinds import request_from_json

SOURCE = Source(Limits())
LONG = "3.123456789012345678901234567890123456789"
FAR = {"points": [[0, 0], [LONG, LONG[::-1].strip("0").lstrip(".")[:20]], [1, LONG]]}
CORNERS = {"points": [[1, 2], [4, 6], [1, 10]]}


def asked(geometry: object, **members: object) -> CuspTableRequest:
    body = json.dumps({"geometry": geometry, "l1": 1, **members}).encode()
    return read(CuspTableRequest, parse_json(body), SOURCE)


def test_points_that_coordinates_need_go_with_the_job_but_are_not_its_question() -> None:
    drawn = asked({"base": FAR, "platform": {"equilateral": 1}}).job_request()
    assert drawn.points.keys() == {"base"}
    kept = request_from_json(drawn.to_json())
    assert kept.manipulator.geometry.base.points == drawn.manipulator.geometry.base.points is not None
    bare = asked(drawn.content["geometry"]).job_request()
    assert (bare.points, bare.content, bare.job_id) == ({}, drawn.content, drawn.job_id)


@pytest.mark.parametrize(
    "geometry",
    [{"base": {"equilateral": 10}, "platform": {"sides": [6, 7, 5]}}],
)
def test_no_points_go_with_a_job_that_finds_its_coordinates(geometry: object) -> None:
    request = asked(geometry).job_request()
    assert "points" not in json.loads(request.to_json())


def test_the_points_of_another_triangle_are_refused() -> None:
    request = asked({"base": FAR, "platform": {"equilateral": 1}}).job_request()
    other = json.loads(request.to_json())
    other["points"]["base"][2] = ["1", "1"]
    with pytest.raises(InputError, match=r"geometry\.base"):
        _ = request_from_json(json.dumps(other)).manipulator


@pytest.mark.parametrize(
    "geometry",
    [
        {"base": CORNERS, "platform": {"points": [[7, 1], [7, 4], [3, 4]]}},
        {"base": {"circumradius": 3}, "platform": CORNERS},
    ],
)
def test_a_question_is_sent_with_the_points_that_it_was_given(geometry: dict[str, Any]) -> None:
    body = json.dumps({"geometry": geometry, "l1": 1, "l2": 2, "l3": 3}).encode()
    question = read(PosesRequest, parse_json(body), SOURCE)
    again = read(PosesRequest, parse_json(json.dumps(question.body()).encode()), SOURCE)
    assert again.content() == question.content()
    given = [name for name in ("base", "platform") if "points" in geometry[name]]
    assert list(question.content().get("points", {})) == given


def test_larger_fields_and_longer_roots_cost_more() -> None:
    def cost(base: object, platform: object = "7") -> float:
        geometry = {"base": {"equilateral": base}, "platform": {"sides": [6, platform, 5]}}
        return asked(geometry).job_request().cost.whole

    few, more, most = cost("10"), cost("10", "sqrt(50.123456)"), cost("10", f"sqrt(50.{'123456' * 9})")
    assert few < more < most


def test_roots_that_are_too_long_to_compute_with_are_refused_by_name() -> None:
    number = f"sqrt(1{'7' * 1590})"
    geometry = {
        "base": {"sides": [number, f"{number}", f"sqrt(1{'3' * 1590})"]},
        "platform": {"equilateral": 1},
    }
    request = asked(geometry).job_request()
    with pytest.raises(InputError) as caught:
        request.kind.compute(request, Store(), silent)
    assert caught.value.problems[0].field == "geometry.base"


def test_columns_of_one_form_are_a_geometry() -> None:
    assert set(SIX) | set(POINTS) | set(SIDES) | {"orientation"} == set(COLUMNS)
    for form in (SIX, POINTS, SIDES):
        assert form_of(["l1", *form]) == form
        assert form_of(["orientation", *reversed(form)]) == form
    cells = dict(zip(POINTS, "abcdefghijkl", strict=True))
    assert geometry_of(cells) == {
        "base": {"points": [["a", "b"], ["c", "d"], ["e", "f"]]},
        "platform": {"points": [["g", "h"], ["i", "j"], ["k", "l"]]},
    }
    assert geometry_of({"a2x": "1", "d1": "2", "orientation": "cw", "l1": "3"}) == {
        **{"a2x": "1", "d1": "2"},
        "orientation": "cw",
    }


@pytest.mark.parametrize("pair", [("d1", "a1x"), ("a2x", "base_s12")])
def test_columns_of_two_forms_are_refused(pair: tuple[str, str]) -> None:
    for names in (pair, pair[::-1]):
        with pytest.raises(InputError) as caught:
            form_of(names)
        assert caught.value.problems[0].field in pair
