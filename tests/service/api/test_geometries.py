"""One machine in all spellings: points, sides, circles and six numbers, by each way of asking."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, hypot, radians, sin
from typing import Any
from urllib.parse import urlencode

import httpx
import pytest

from tests.service.api.test_batches import CSV

WAIT = {"Prefer": "wait=30"}
SIX = {"a2x": "5", "a3x": "6.4", "a3y": "4.8", "d1": "3", "d2": "4", "d3": "5"}
CORNERS = [(1, 2), (4, 6), (1, 10)]
HAND = [(7, 1), (7, 4), (3, 4)]
SIDES = {"base": {"sides": [5, 5, 8]}, "platform": {"sides": [3, 4, 5]}}
SPELLINGS: list[dict[str, Any]] = [
    SIX,
    {**SIX, "name": "Gripper", "orientation": "ccw"},
    SIDES,
    {"base": {"points": CORNERS}, "platform": {"sides": ["3", "sqrt(16)", "30/6"]}},
    {"base": {"points": [[0, 0], [0, 5], ["-4.8", "6.4"]]}, "platform": {"points": HAND}},
    {
        "base": {"points": [["sqrt(2)", 0], ["6*sqrt(2)", 0], ["7.4*sqrt(2)", "4.8*sqrt(2)"]]},
        "platform": {"sides": ["3*sqrt(2)", "4*sqrt(2)", "5*sqrt(2)"]},
    },
]


def table(client: httpx.Client, geometry: object, l1: str) -> httpx.Response:
    body = {"geometry": geometry, "l1": l1, "digits": 15}
    return client.post("/v1/cusp-tables", json=body, headers=WAIT)


def test_a_machine_in_any_spelling_is_one_question_with_one_answer(
    api: httpx.Client, fresh: Callable[[], str]
) -> None:
    l1 = fresh()
    first, *others = [table(api, geometry, l1) for geometry in SPELLINGS[:-1]]
    assert first.json()["geometry"] == {**SIX, "orientation": "ccw"}
    canonical = table(api, IRRATIONAL[0], l1).json()["geometry"]
    assert canonical == {
        **{"base": ["10", "10", "10"], "base_orientation": "ccw"},
        **{"platform": ["6", "7", "5"], "platform_orientation": "ccw"},
    }
    assert len({table(api, geometry, l1).content for geometry in (*IRRATIONAL, canonical)}) == 1
    assert [answer.content for answer in others] == [first.content] * len(others)
    assert {answer.headers["content-location"] for answer in others} == {first.headers["content-location"]}
    larger = table(api, SPELLINGS[-1], l1)
    assert larger.json().get("geometry_hash") != first.json()["geometry_hash"]


EQUILATERAL = {"equilateral": "10"}
IRRATIONAL: list[dict[str, Any]] = [
    {"base": EQUILATERAL, "platform": {"sides": [6, 7, 5]}},
    {"base": {"circumradius": "10*sqrt(3)/3"}, "platform": {"sides": ["sqrt(36)", 7, 5]}},
    {"base": {"points": [[0, 0], [10, 0], [5, "5*sqrt(3)"]]}, "platform": {"sides": [6, 7, 5]}},
    {
        "base": {"points": [[0, 2], [0, 12], ["-5*sqrt(3)", 7]]},
        "platform": {"points": [[0, 1], [0, 7], ["-2*sqrt(6)", 2]]},
    },
    {"a2x": 10, "a3x": 5, "a3y": "sqrt(75)", "d1": 6, "d2": 7, "d3": 5},
]
"""An equilateral base and a platform whose height is a multiple of √6."""


COLUMNS: dict[str, Mapping[str, object]] = {
    "six": SIX,
    "points": {
        **{
            f"a{n}{axis}": z
            for n, point in enumerate(CORNERS, 1)
            for axis, z in zip("xy", point, strict=True)
        },
        **{f"b{n}{axis}": z for n, point in enumerate(HAND, 1) for axis, z in zip("xy", point, strict=True)},
    },
    "sides": {
        **dict(zip(("base_s12", "base_s23", "base_s31"), ("5", "sqrt(25)", "8"), strict=True)),
        **dict(zip(("platform_s12", "platform_s23", "platform_s31"), (3, 4, "10/2"), strict=True)),
    },
}


@pytest.mark.parametrize("form", COLUMNS)
def test_a_machine_is_columns_of_a_table_and_parameters_of_an_address(
    api: httpx.Client, fresh: Callable[[], str], form: str
) -> None:
    l1, row = fresh(), {**COLUMNS[form]}
    asked = table(api, SIX, l1).json()
    address = api.get(f"/v1/cusp-tables?{urlencode({**row, 'l1': l1, 'digits': 15, 'wait': 30})}")
    assert address.json() == asked
    for separator in (",", ";"):
        cells = [str(x) for x in (*row.values(), l1, "15")]
        text = separator.join((*row, "l1", "digits")) + "\n" + separator.join(cells) + "\n"
        batch = api.post("/v1/batches", content=text, headers=CSV).json()
        results = api.get(batch["links"]["results"], headers=WAIT, params={"format": "json"}).json()
        assert [line["result"] for line in results] == [asked]


@pytest.mark.parametrize(
    ("row", "field"),
    [
        ({**SIX, "b1x": 1}, "b1x"),
        ({**COLUMNS["sides"], "d1": 3}, "d1"),
        ({name: x for name, x in COLUMNS["points"].items() if name != "b3y"}, "b3y"),
        ({name: x for name, x in SIX.items() if name != "d2"}, "d2"),
    ],
)
def test_columns_that_are_mixed_ambiguous_or_missing_are_refused(
    api: httpx.Client, row: Mapping[str, object], field: str
) -> None:
    text = f"{','.join(row)},digits\n{','.join(map(str, row.values()))},15\n"
    refused = api.post("/v1/batches", content=text, headers=CSV)
    assert (refused.status_code, [error["field"] for error in refused.json()["errors"]]) == (422, [field])
    address = api.get(f"/v1/cusp-tables?{urlencode({'l1': 1, **row})}")
    assert address.status_code == 422


@pytest.mark.parametrize(
    ("geometry", "fields"),
    [
        ({"base": EQUILATERAL, "platform": {"sides": [3, 4, 8]}}, ["platform.sides[2]"]),
        ({"base": {"points": [[0, 0], [0, 0], [0, 0]]}, "platform": EQUILATERAL}, ["base"]),
        (
            {"base": {"points": [[0, None], [1, 0], ["x", 1]]}, "platform": EQUILATERAL},
            ["base.points[0][1]", "base.points[2][0]"],
        ),
        ({"base": EQUILATERAL, "platform": {"circumradius": 3, "sides": [3, 4, 5]}}, ["platform"]),
        ({**SIX, "base": EQUILATERAL}, list(SIX)),
        ({**SIX, "d1": "3*sqrt(0.5)+1"}, ["d1"]),
    ],
)
def test_an_error_is_that_of_the_spelling_that_was_meant(
    api: httpx.Client, geometry: object, fields: list[str] | None
) -> None:
    answer = table(api, geometry, "1")
    assert answer.status_code == 422
    found = [error["field"].removeprefix("geometry.") for error in answer.json()["errors"]]
    if fields is not None:
        assert found == fields
    assert all(
        field.startswith("geometry.") for field in (error["field"] for error in answer.json()["errors"])
    )


def test_a_number_of_a_root_has_limits_too(api: httpx.Client) -> None:
    long = "1" * 401
    for number in (f"sqrt({long * 4})", f"{long}*sqrt(3)", f"sqrt(3)/{long}"):
        answer = table(api, {"base": {"equilateral": number}, "platform": EQUILATERAL}, "1")
        assert answer.json()["limit"]["name"] == "max_number_digits"
        assert [error["field"] for error in answer.json()["errors"]] == ["geometry.base.equilateral"]


def test_a_length_that_is_a_root_is_refused_with_the_nearest_decimal(api: httpx.Client) -> None:
    [error] = table(api, SIX, "5*sqrt(3)/2").json()["errors"]
    assert error["field"] == "l1"
    assert "4.33012701892219" in error["message"]


def test_poses_are_told_in_the_frame_of_the_points(api: httpx.Client) -> None:
    def poses(geometry: object) -> dict[str, Any]:
        body = {"geometry": geometry, "l1": "5.5", "l2": "4", "l3": "6", "digits": 15}
        answer: dict[str, Any] = api.post("/v1/poses", json=body, headers=WAIT).json()
        return answer

    plain = poses(SIX)
    placed = poses({"base": {"points": CORNERS}, "platform": {"points": HAND}})
    assert plain["count"] > 0
    for pose in placed["poses"]:
        x, y, phi = float(pose.pop("x")), float(pose.pop("y")), radians(float(pose.pop("phi_deg")))
        joints = [(x + cos(phi) * u - sin(phi) * v, y + sin(phi) * u + cos(phi) * v) for u, v in HAND]
        legs = [hypot(u - a, v - b) for (u, v), (a, b) in zip(joints, CORNERS, strict=True)]
        assert legs == pytest.approx([5.5, 4, 6], abs=1e-12)
    assert placed == plain
    drawn = poses(IRRATIONAL[3])
    assert drawn["count"] == len(drawn["poses"]) > 0
    for pose in drawn["poses"]:
        assert ("x" in pose, "y" in pose, "phi_deg" in pose) == (True, True, True)
        for name in ("x", "y", "phi_deg"):
            del pose[name]
    assert drawn == poses(IRRATIONAL[0])


SHARED = {"base": {"points": [[1, 1], [1, 1], [7, 1]]}, "platform": {"sides": [3, 4, 5]}}


def test_a_machine_whose_legs_share_a_joint_is_answered_or_refused_at_once(api: httpx.Client) -> None:
    assert [part["count"] for part in table(api, SHARED, "3").json()["slices"]] == [0]
    answers = {
        path: api.post(path, json={"geometry": SHARED, **body}, headers=WAIT)
        for path, body in {
            "/v1/poses": {"l1": 4, "l2": 5, "l3": {"from": 0, "to": 9}},
            "/v1/censuses": {"digits": 15},
            "/v1/assembly-modes": {"l1": 4},
            "/v1/plots": {"plot": "mechanism", "l1": 4, "l2": 5, "l3": 6},
            "/v1/margins": {"l1": 4},
            "/v1/paths": {"l1": 4, "cusp": 1},
            "/v1/aspects": {"range": {"from": 1, "to": 2}},
        }.items()
    }
    refused = [path for path, answer in answers.items() if answer.status_code == 422]
    assert refused == ["/v1/margins", "/v1/paths", "/v1/aspects"]
    curves = api.post("/v1/singular-curves", json={"geometry": SHARED, "l1": 4}, headers=WAIT)
    assert len(curves.json()["aspects"]) == 4
    body = {"geometry": SHARED, "l3": 4, "fixed_leg": 3}
    [error] = api.post("/v1/singular-curves", json=body, headers=WAIT).json()["errors"]
    assert error["field"] == "fixed_leg"
    for path, answer in answers.items():
        if path in refused:
            [error] = answer.json()["errors"]
            assert error["field"] == "geometry"
            assert "A1 = A2" in error["message"]
        else:
            assert answer.status_code == 200
