"""Questions that one document answers, with a real queue and a real worker."""

from __future__ import annotations

import csv
import io
import json
from fractions import Fraction
from typing import Any

import httpx
import pytest

import rpr_solver
from rpr_solver import (
    EXAMPLES,
    cusp_curves,
    leg_poses,
    poses,
    workspace,
    workspace_csv,
    workspace_sweep,
)
from service.schemas.registry import all_questions
from service.schemas.tables import CuspTable
from tests.support.processes import PATIENCE, until
from tests.support.service_server import GEOMETRY, NO_WAIT, ended
from tests.support.shared import census_of

POSES = {"geometry": GEOMETRY, "l1": 14.98, "l2": 15, "l3": "30", "digits": 20}


def is_whole(model: str, document: object) -> bool:
    """Asserts that the model accepts the document and has all its fields."""
    [answer] = [question.answer for question in all_questions() if question.answer.__name__ == model]
    return answer.model_validate(document).model_dump(exclude_unset=True, by_alias=True) == document


def answered(response: httpx.Response) -> httpx.Response | None:
    assert response.status_code in (200, 202)
    return response if response.status_code == 200 else None


def test_poses_are_answered_without_being_asked_to_wait(api: httpx.Client, base_url: str) -> None:
    with httpx.Client(base_url=base_url, timeout=PATIENCE) as plain:  # which prefers nothing
        answer = until(lambda: answered(plain.post("/v1/poses", json=POSES)))
    assert "preference-applied" not in answer.headers
    assert answer.json() == poses(EXAMPLES["innocenti"], "14.98", 15, 30, digits=20).to_json()
    assert is_whole("Poses", answer.json())
    along = {"geometry": GEOMETRY, "l1": 17, "l2": {"from": 10, "to": 20}, "l3": "15", "digits": 20}
    answer = api.post("/v1/poses", json=along)
    assert (
        answer.json() == leg_poses(EXAMPLES["innocenti"], {"l1": 17, "l3": 15}, 10, 20, digits=20).to_json()
    )
    assert is_whole("Poses", answer.json())
    lines = api.post("/v1/poses", json=along, headers={"Accept": "text/csv"}).text.splitlines()
    assert len(lines) == 1 + len(answer.json()["intervals"])
    refused = api.post("/v1/poses", json={**along, "l3": {"from": 1, "to": 2}})
    assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, "l3")


def test_workspaces_at_one_orientation_and_at_several(api: httpx.Client) -> None:
    limits = {"l1": {"min": 5, "max": 30}, "l2": {"max": "25"}}
    bounds = {"l1": (5, 30), "l2": (None, 25)}
    innocenti = EXAMPLES["innocenti"]
    for phi, expected in (
        (30, workspace(innocenti, 30, bounds)),
        ({"from": -30, "to": 30, "step": 30}, workspace_sweep(innocenti, -30, 30, 30, bounds)),
    ):
        asked = {"geometry": GEOMETRY, "phi": phi, "limits": limits}
        answer = api.post("/v1/workspaces", json=asked)
        assert answer.json() == expected.to_json()
        assert is_whole("Workspace", answer.json())
        named = {"phi": "30"} if phi == 30 else {"phi_from": "-30", "phi_to": "30", "phi_step": "30"}
        query = {**GEOMETRY, **named, "l1_min": 5, "l1_max": 30, "l2_max": "25"}
        assert api.get("/v1/workspaces", params=query).json() == expected.to_json()
        lines = api.get("/v1/workspaces", params={**query, "format": "csv"}).text.splitlines()
        assert lines == workspace_csv(expected.to_json()).splitlines()
        picture = api.post("/v1/workspaces", json=asked, headers={"Accept": "image/svg+xml"})
        assert picture.text.startswith("<svg")
    refused = api.post("/v1/workspaces", json={**asked, "limits": {"l1": {"min": 5}}})
    assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, "limits")


def test_the_picture_of_a_workspace_is_in_the_frame_of_the_points(api: httpx.Client) -> None:
    base, platform = [[100, 0], [110, 0], [105, 8]], [[0, 0], [3, 0], [1, 2]]
    machine = {"base": {"points": base}, "platform": {"points": platform}}
    asked = {"plot": "workspace", "geometry": machine, "phi": 20, "limits": {"l1": {"min": 2, "max": 8}}}
    answer = api.post("/v1/plots", json=asked)
    assert answer.status_code == 200
    assert "105" in answer.json()["svg"]  # on the axis
    refused = api.post("/v1/plots", json={**asked, "l1": 5})
    assert refused.json()["errors"][0]["field"] == "l1"


def test_a_change_of_mode_keeps_thresholds(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": 27, "clearance": 0.5, "tolerance": "0.05"}
    answer = api.post("/v1/assembly-modes", json=body, headers={"Prefer": "wait=60"}).json()
    assert is_whole("AssemblyModes", answer)
    assert (answer["change"], answer["asked"]["clearance"]) == ("possible", "0.5")
    assert set(answer["asked"]["tolerance"].values()) == {"0.05"}
    assert Fraction(answer["witness"]["path"]["clearance"]["proved"]) > 40


def test_a_motion_within_limits_in_every_form(api: httpx.Client) -> None:
    motion = {"speed": 10, "acceleration": {"l2": 20, "l3": 30}}
    body = {"geometry": GEOMETRY, "l1": 27, "cusp": "d", "motion": motion, "sampling": {"chord": "0.5"}}
    answer = api.post("/v1/paths", json=body)
    loop = rpr_solver.cusp_loop(EXAMPLES["innocenti"], 27, 4, motion=motion, sampling={"chord": "0.5"})
    assert answer.json() == loop.to_json()
    assert is_whole("Path", loop.to_json())
    lines = api.post("/v1/paths", json=body, headers={"Accept": "application/x-ndjson"})
    assert lines.headers["content-type"].startswith("application/x-ndjson")
    assert [json.loads(line) for line in lines.text.splitlines()] == loop.to_json()["samples"]
    table = api.post("/v1/paths", json=body, headers={"Accept": "text/csv"})
    assert table.text == rpr_solver.path_csv(loop.to_json())
    # by leg or for all legs, by number or as samples: the same question, the same job
    legs = {"l1": 10, "l2": 10, "l3": 10}
    by_leg = api.post("/v1/paths", json={**body, "motion": {**motion, "speed": legs}})
    assert by_leg.content == answer.content
    few = {"geometry": GEOMETRY, "l1": 27, "cusp": "d"}
    numbers = ({**few, "samples": 4}, {**few, "sampling": {"number": 4}})
    assert len({api.post("/v1/paths", json=asked).headers["content-location"] for asked in numbers}) == 1


def test_condition_numbers(api: httpx.Client) -> None:
    first = EXAMPLES["innocenti"]
    answer = api.post("/v1/poses", json={**POSES, "length_scale": "2.5"})
    expected = rpr_solver.with_condition(poses(first, "14.98", 15, 30, digits=20), "2.5").to_json()
    assert (answer.status_code, answer.json()) == (200, expected)
    assert is_whole("Poses", expected)
    lines = api.post("/v1/poses", json={**POSES, "condition": True}, headers={"Accept": "text/csv"}).text
    assert lines.splitlines()[0].endswith(",multiplicity,condition,clearance_deg")
    body = {"geometry": GEOMETRY, "l1": 27, "l2": 20, "l3": 20, "from": 1, "to": 2, "samples": 2}
    for most, obstacle in ((12, None), ("9.5", "undecided"), (7, "ill-conditioned")):
        answer = api.post("/v1/paths", json={**body, "max_condition": most})
        path = rpr_solver.joint_path(first, 27, 20, 20, 1, 2, samples=2, max_condition=most)
        assert (answer.status_code, answer.json()) == (200, path.to_json())
        assert is_whole("Path", path.to_json())
        assert answer.json().get("obstacle") == obstacle
    for path, question, field in (
        ("/v1/paths", {**body, "max_condition": "0.5"}, "max_condition"),
        ("/v1/paths", {**body, "length_scale": 0}, "length_scale"),
        ("/v1/poses", {**POSES, "l2": {"from": 1, "to": 2}, "condition": True}, "condition"),
    ):
        refused = api.post(path, json=question)
        assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, field)


def test_a_cusp_that_a_slice_lacks_is_bad_input(api: httpx.Client) -> None:
    refused = api.post("/v1/paths", json={"geometry": GEOMETRY, "l1": 27, "cusp": "I"})
    assert (refused.status_code, refused.json()["type"]) == (422, "/problems/job-input-error")
    assert "is 9 (I); give 1 to 8, or A to H" in refused.text


def test_a_document_can_be_had_by_its_job(api: httpx.Client) -> None:
    body = {**POSES, "l3": "30.125"}
    answer = api.post("/v1/poses", json=body, headers={"Prefer": "respond-async"})
    assert (answer.status_code, answer.headers["preference-applied"]) == (202, "respond-async")
    job = answer.json()
    assert (job["kind"], answer.headers["location"]) == ("poses", job["links"]["self"])
    done = ended(api, job["id"])
    assert (done["status"], done["progress"]) == ("succeeded", {"done": 1, "total": 1})
    result = api.get(job["links"]["result"])
    assert result.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert result.json() == api.post("/v1/poses", json=body).json()
    etag = result.headers["etag"]
    assert api.get(job["links"]["result"], headers={"If-None-Match": etag}).status_code == 304
    rows = api.get(job["links"]["result"], headers={"Accept": "text/csv"}).text.splitlines()
    assert len(rows) == 1 + len(result.json()["poses"])
    no_svg = api.get(job["links"]["result"], headers={"Accept": "image/svg+xml"})
    assert (no_svg.status_code, no_svg.json()["type"]) == (406, "/problems/not-acceptable")
    events = api.get(job["links"]["events"]).text
    assert events.rstrip().splitlines()[-1].startswith('data: {"id":"po-')


def test_a_census_is_computed_once_and_serves_every_range(api: httpx.Client) -> None:
    body = {"geometry": EXAMPLES["zein-flat"].to_json(), "digits": 30}
    answer = api.post("/v1/censuses", json={**body, "range": {"from": 1, "to": "10"}}, headers=NO_WAIT)
    assert answer.status_code == 202
    job = answer.json()
    assert job["kind"] == "census"
    done = ended(api, job["id"])
    assert done["status"] == "succeeded"
    assert done["progress"]["done"] == done["progress"]["total"] > 1
    assert '\nevent: progress\ndata: {"progress":{"done":' in api.get(job["links"]["events"]).text
    part = api.get(job["links"]["result"]).json()
    assert is_whole("Census", part)
    assert part["range"] == {"from": "1", "to": "10"}

    known = [api.post("/v1/censuses", json=question) for question in (body, {**body, "digits": 20})]
    assert [response.status_code for response in known] == [200, 200]
    whole, short = (response.json() for response in known)
    assert whole == census_of(EXAMPLES["zein-flat"]).to_json()
    assert short["digits"] == 20
    assert [t["l1"][:15] for t in short["transitions"]] == [t["l1"][:15] for t in whole["transitions"]]
    assert {t["l1"] for t in part["transitions"]} <= {t["l1"] for t in whole["transitions"]}


def test_cusp_curves_are_followed_once_and_sampled_at_will(api: httpx.Client) -> None:
    body = {"geometry": EXAMPLES["zein-flat"].to_json(), "digits": 20, "fixed_leg": 2}
    lengths = {"from": 10, "to": "12", "step": 1}
    answer = api.post(
        "/v1/cusp-curves",
        json={**body, "l2": lengths, "range": {"from": 9.5, "to": 12}, "samples": 2},
        headers=NO_WAIT,
    )
    assert answer.status_code == 202
    job = answer.json()
    assert (job["kind"], job["id"][:3]) == ("cusp-curves", "cc-")
    done = ended(api, job["id"])
    assert (done["status"], done["progress"]["done"]) == ("succeeded", done["progress"]["total"])
    part = api.get(job["links"]["result"]).json()
    assert is_whole("CuspCurves", part)
    lengths = {p["l2"] for curve in part["curves"] for p in curve["points"]}
    assert {"10", "11", "12"} < lengths

    whole = api.post("/v1/cusp-curves", json=body)
    assert whole.status_code == 200
    expected = cusp_curves(EXAMPLES["zein-flat"], fixed_leg=2, digits=20)
    assert whole.json() == expected.to_json()
    inner = api.post("/v1/cusp-curves", json={**body, "range": {"to": "10"}})
    assert inner.json() == expected.within(Fraction(0), Fraction(10)).to_json()
    as_csv = api.post("/v1/cusp-curves", json=body, headers={"Accept": "text/csv"})
    rows = list(csv.DictReader(io.StringIO(as_csv.text)))
    assert [row["curve"] for row in rows] == [c.name for c in expected.curves for _ in c.points]
    assert rows[0]["theta2_deg"] == expected.curves[0].points[0].point.theta2_deg


@pytest.mark.parametrize("form", ["application/json", "application/x-ndjson"])
def test_a_table_without_a_possible_slice_is_422(idle: httpx.Client, form: str) -> None:
    body = {"geometry": GEOMETRY, "l1": -1, "digits": 15}
    posted = idle.post("/v1/cusp-tables", json=body, headers={"Accept": form, "Prefer": "wait=1"})
    asked = idle.get("/v1/cusp-tables", params={**GEOMETRY, "l1": "-1;0"})
    details = [answer.json()["detail"] for answer in (posted, asked)]
    assert (posted.status_code, asked.status_code) == (422, 422)
    assert details == ["l1: is -1; a leg length must be > 0", "l1: is -1, 0; a leg length must be > 0"]


def test_the_articles_method_is_audited_and_kept_apart(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": ["14.98", 0], "digits": 20}
    answers = [
        api.post("/v1/cusp-tables", json={**body, "method": method}, headers={"Prefer": "wait=30"})
        for method in ("fast", "article")
    ]
    assert [answer.status_code for answer in answers] == [200, 200]
    fast, article = (answer.json() for answer in answers)
    assert CuspTable.model_validate(article).model_dump(exclude_unset=True) == article
    assert "method" not in fast
    assert article["method"] == article["slices"][0]["method"] == "article"
    assert article["slices"][0]["cusps"] == fast["slices"][0]["cusps"]
    assert sum(f["degree"] * f["multiplicity"] for f in article["slices"][0]["audit"]["factors"]) == 96
    assert article["slices"][1] == fast["slices"][1]
    known = api.post("/v1/cusp-tables", json={**body, "method": "article"}, headers={"Accept": "text/csv"})
    assert known.text == rpr_solver.table_csv(fast)


def test_a_check_is_a_job_with_a_report(api: httpx.Client) -> None:
    requirement = {"range": {"from": 28, "to": 31}, "max_cusps": 8}
    answer = api.post(
        "/v1/checks",
        json={"geometry": GEOMETRY, "requirement": requirement},
        headers={"Prefer": "wait=30"},
    )
    report = answer.json()
    assert (answer.status_code, report["passed"], report["max_cusps_found"]) == (200, False, 10)
    assert is_whole("CheckReport", report)
    [violation] = report["violations"]
    assert len(violation["example"]["cusps"]) == violation["count"] == 10
    exact = {**requirement, "range": {"from": "28.0", "to": "62/2"}, "limits": {}}
    again = api.post("/v1/checks", json={"geometry": GEOMETRY, "requirement": exact, "digits": 30})
    assert (again.status_code, again.json()) == (200, report)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"max_cusps": 0, "degenerate": "no"}, "requirement.degenerate"),
        ({"max_cusps": 1, "range": {"from": 2, "to": 1}}, "requirement.range.to"),
        ({"most_cusps": 1}, "requirement.most_cusps"),
        ("max 1", "requirement"),
    ],
)
def test_wrong_fields_of_a_requirement_are_named(idle: httpx.Client, change: Any, field: str) -> None:
    answer = idle.post("/v1/checks", json={"geometry": GEOMETRY, "requirement": change})
    assert answer.status_code == 422
    assert field in [error["field"] for error in answer.json()["errors"]]


@pytest.mark.parametrize(
    ("change", "field"),
    [({"l1": 0}, "l1"), ({"digits": 3}, "digits"), ({"l1": "1" * 31}, "l1")],
)
def test_wrong_fields_of_poses_are_named(idle: httpx.Client, change: dict[str, Any], field: str) -> None:
    answer = idle.post("/v1/poses", json={**POSES, **change})
    assert answer.status_code == 422
    assert field in [error["field"] for error in answer.json()["errors"]]
