"""Questions that one document answers, with a real queue and a real worker."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import httpx
import pytest
from redis import Redis

import rpr_solver
from rpr_solver import (
    EXAMPLES,
    cusp_curves,
    leg_poses,
    poses,
    poses_csv,
    sensed_poses,
    workspace,
    workspace_csv,
    workspace_sweep,
)
from rpr_solver.figures.views import figure_of
from service.schemas.registry import all_questions
from service.schemas.tables import CuspTable
from tests.support.service_server import GEOMETRY, NO_WAIT, accepted, ended
from tests.support.shared import census_of
from worker.jobs.queue import JobQueue

POSES = {"geometry": GEOMETRY, "l1": 14.98, "l2": 15, "l3": "30", "digits": 20}


def is_whole(model: str, document: object) -> bool:
    """Asserts that the model accepts the document and has all its fields."""
    [answer] = [question.answer for question in all_questions() if question.answer.__name__ == model]
    return answer.model_validate(document).model_dump(exclude_unset=True, by_alias=True) == document


def test_poses_are_answered_without_being_asked_to_wait(api: httpx.Client) -> None:
    answer = api.post("/v1/poses", json=POSES)
    assert answer.status_code == 200
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


def test_poses_with_angles_of_legs(api: httpx.Client) -> None:
    innocenti = EXAMPLES["innocenti"]
    asked = {"geometry": GEOMETRY, "l1": 15, "angle2": 150, "angle3": "45", "digits": 20}
    expected = sensed_poses(innocenti, {"l1": 15}, {"angle2": 150, "angle3": 45}, digits=20).to_json()
    answer = api.post("/v1/poses", json=asked)
    assert answer.json() == expected
    assert is_whole("Poses", answer.json())
    csv = api.post("/v1/poses", json=asked, headers={"Accept": "text/csv"}).text
    assert csv.splitlines() == poses_csv(expected).splitlines()
    more = {**POSES, "angle1": "23.61", "angle_tolerance_deg": "0.01"}
    assert api.post("/v1/poses", json=more).json()["count"] == 1
    for change, field in (
        ({"angle_tolerance_deg": None}, "angle_tolerance_deg"),
        ({"l1": {"from": 1, "to": 3}}, "l1"),
        ({"angle1": 1000}, "angle1"),
    ):
        body = {name: value for name, value in {**more, **change}.items() if value is not None}
        refused = api.post("/v1/poses", json=body)
        assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, field)
    few = api.post("/v1/poses", json={"geometry": GEOMETRY, "angle1": 3, "l1": 2})
    assert [error["field"] for error in few.json()["errors"]] == ["l2"]


ROUNDED = {
    "a2x": 10, "a3x": 5, "a3y": "8.660254037844386",
    "d1": "1.7320508075688772", "d2": "1.7320508075688772", "d3": "1.7320508075688772",
}  # fmt: skip
EQUILATERAL = {"base": {"equilateral": 10}, "platform": {"equilateral": "sqrt(3)"}}


def test_a_rounded_special_machine_is_told_the_exact_one_which_is_answered_by_its_theorem(
    api: httpx.Client,
) -> None:
    legs = {"l1": 5, "l2": 6, "l3": 7, "digits": 15}
    table = api.post("/v1/poses", json={"geometry": ROUNDED, **legs}).json()
    assert is_whole("Poses", table)
    assert (table["near"][0]["shape"], table["near"][0]["effect"]) == ("similar", "contradicts")
    exact = table["near"][0]["spelling"]
    assert exact == {"base": {"equilateral": "10"}, "platform": {"equilateral": "sqrt(3)"}}
    for geometry in (exact, EQUILATERAL):
        wait = {"Prefer": "wait=60"}
        [part] = api.post("/v1/cusp-tables", json={"geometry": geometry, "l1": 5}, headers=wait).json()[
            "slices"
        ]
        assert part["count"] == 0
        census = api.post("/v1/censuses", json={"geometry": geometry}, headers=wait).json()
        assert ([x["count"] for x in census["intervals"]], census["transitions"]) == ([0], [])
        assert {x["kind"] for x in census["degenerate"]} == {"node"}
        modes = api.post("/v1/assembly-modes", json={"geometry": geometry, "l1": 5}, headers=wait).json()
        assert (modes["change"], modes["certificate"]["method"]) == ("impossible", "similar")
        requirement = {"range": {"from": 2, "to": 9}, "max_cusps": 0, "mode_change": "excluded"}
        asked = {"geometry": geometry, "requirement": requirement}
        report = api.post("/v1/checks", json=asked, headers=wait).json()
        assert (report["passed"], report["mode_change"]["certificate"]["method"]) == (True, "similar")
        assert not any("near" in document for document in (census, modes, report))


def test_a_change_of_mode_keeps_thresholds(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": 27, "clearance": 0.5, "tolerance": "0.05"}
    answer = api.post("/v1/assembly-modes", json=body, headers={"Prefer": "wait=60"}).json()
    assert is_whole("AssemblyModes", answer)
    assert (answer["change"], answer["asked"]["clearance"]) == ("possible", "0.5")
    assert set(answer["asked"]["tolerance"].values()) == {"0.05"}
    assert Fraction(answer["witness"]["path"]["clearance"]["proved"]) > 40


def test_singular_curves_are_answered_without_being_asked_to_wait(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "fixed_leg": 3, "l3": "28.1", "tolerance": 0.01}
    answer = api.post("/v1/singular-curves", json=body)
    assert answer.status_code == 200
    curves = rpr_solver.singular_curves(
        EXAMPLES["innocenti"], "28.1", fixed_leg=3, tolerance="0.01"
    ).to_json()
    assert answer.json() == curves
    assert is_whole("SingularCurves", curves)
    table = api.post("/v1/singular-curves", json=body, headers={"Accept": "text/csv"})
    assert table.text == rpr_solver.singular_csv(curves)


def test_wrong_tolerances_are_named(idle: httpx.Client) -> None:
    for tolerance, message in ((1, "is 1; give 0.000001 to 0.1"), ("x", "is not a finite number")):
        body = {"geometry": GEOMETRY, "l1": 2, "tolerance": tolerance}
        answer = idle.post("/v1/singular-curves", json=body)
        assert answer.status_code == 422
        [error] = answer.json()["errors"]
        assert error["field"] == "tolerance"
        assert message in error["message"]


def test_a_loop_is_answered_without_being_asked_to_wait(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": 27, "cusp": "d", "samples": 4}
    answer = api.post("/v1/paths", json=body)
    assert answer.status_code == 200
    loop = rpr_solver.cusp_loop(EXAMPLES["innocenti"], 27, 4, samples=4).to_json()
    assert answer.json() == loop
    assert is_whole("Path", loop)
    table = api.post("/v1/paths", json={**body, "cusp": 4}, headers={"Accept": "text/csv"})
    assert table.text == rpr_solver.path_csv(loop)


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


@pytest.mark.parametrize(
    ("members", "field", "message"),
    [
        ({"motion": {"speed": 1}}, "motion.acceleration", "is missing"),
        ({"motion": {"speed": {}, "acceleration": 1}}, "motion.speed", "has no limits"),
        ({"motion": {"speed": -1, "acceleration": 1}}, "motion.speed", "a limit must be > 0"),
        ({"motion": {"speed": 1, "acceleration": 1}, "timing": "cosine"}, "timing", "follows from motion"),
        ({"sampling": {"step": 1}, "samples": 3}, "samples", "follows from sampling"),
        ({"sampling": {}}, "sampling", "has nothing; give one of"),
    ],
)
def test_a_motion_that_cannot_be_is_refused(
    api: httpx.Client, members: dict[str, object], field: str, message: str
) -> None:
    answer = api.post("/v1/paths", json={"geometry": GEOMETRY, "l1": 27, **members})
    assert answer.status_code == 422
    [error] = answer.json()["errors"]
    assert error["field"] == field
    assert message in error["message"]


def test_a_leg_that_moves_without_a_limit_is_named(api: httpx.Client) -> None:
    motion = {"speed": 1, "acceleration": {"l2": 1}}
    answer = api.post("/v1/paths", json={"geometry": GEOMETRY, "l1": 27, "motion": motion})
    assert answer.status_code == 422
    assert "motion.acceleration.l3: is missing; this leg moves, too" in answer.json()["detail"]


def test_a_path_within_joint_limits(api: httpx.Client) -> None:
    poses = {"geometry": GEOMETRY, "l1": 27, "l2": 20, "l3": 20, "from": 1, "to": 2}
    limits = {"l2": {"min": 5, "max": 21.0}, "l3": None}
    answer = api.post("/v1/paths", json={**poses, "limits": limits})
    none = rpr_solver.joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 2, limits={"l2": (5, 21)})
    expected = none.to_json()
    assert (answer.status_code, answer.json()) == (200, expected)
    assert answer.json()["limits"] == {"l2": {"min": "5", "max": "21"}}
    assert is_whole("Path", expected)
    refused = api.post("/v1/paths", json={**poses, "limits": {"l2": {"min": 5, "max": 4}, "l3": {"min": -1}}})
    assert refused.status_code == 422
    assert [error["field"] for error in refused.json()["errors"]] == ["limits.l2.max", "limits.l3.min"]
    loop = {"geometry": GEOMETRY, "l1": 27, "cusp": "B", "limits": {"l2": {"min": 20}}}
    excluded = api.post("/v1/paths", json=loop)
    assert (excluded.status_code, excluded.json()["type"]) == (422, "/problems/job-input-error")
    assert "limits.l2: exclude cusp 2" in excluded.text


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


def test_the_widest_path(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": 27, "l2": 20, "l3": 20, "from": 1, "to": 2, "samples": 2}
    answer = api.post("/v1/paths", json={**body, "clearance": "best"})
    path = rpr_solver.joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 2, samples=2, clearance="best")
    assert (answer.status_code, answer.json()) == (200, path.to_json())
    assert is_whole("Path", path.to_json())
    none = api.post("/v1/paths", json={**body, "clearance": 25})
    assert (none.json()["obstacle"], none.json()["clearance"]["asked"]) == ("too-narrow", "25")
    assert is_whole("Path", none.json())
    for clearance in (0, "wide"):
        refused = api.post("/v1/paths", json={**body, "clearance": clearance})
        assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, "clearance")


def test_the_widest_path_in_a_range(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": 27, "l2": 20, "l3": 20, "from": 1, "to": 2, "samples": 2}
    answer = api.post("/v1/paths", json={**body, "clearance": 3, "between": {"from": 26, "to": 28}})
    assert answer.status_code == 200
    path = answer.json()
    assert is_whole("Path", path)
    assert (path["between"], path["clearance"]["asked"]) == ({"from": "26", "to": "28"}, "3")
    assert 3 <= float(path["clearance"]["proved"]) <= float(path["clearance"]["bound"])


def test_a_path_between_poses_of_two_joint_vectors(api: httpx.Client) -> None:
    start, stop = ({"l1": 27, "l2": 20, "l3": 20, "pose": 1}, {"l1": 30, "l2": 21, "l3": 19, "pose": 1})
    body = {"geometry": GEOMETRY, "from": start, "to": stop, "samples": 2}
    answer = api.post("/v1/paths", json=body)
    expected = rpr_solver.pose_path(EXAMPLES["innocenti"], start, stop, samples=2).to_json()
    assert (answer.status_code, answer.json()) == (200, expected)
    assert is_whole("Path", expected)
    same = {"geometry": GEOMETRY, "from": start, "to": {**start, "pose": 2}, "samples": 2}
    legs = {"l1": "27.0", "l2": 20, "l3": 20}
    usual = {"geometry": GEOMETRY, **legs, "from": {"pose": 1}, "to": 2, "samples": 2}
    assert api.post("/v1/paths", json=same).content == api.post("/v1/paths", json=usual).content
    refused = api.post("/v1/paths", json={**body, "to": {"alpha_deg": 1, "theta2_deg": 1, "l1": 2}})
    assert [error["field"] for error in refused.json()["errors"]] == ["to.theta1_deg"]


def test_which_poses_of_two_joint_vectors_are_joined(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": 27, "l2": 20, "l3": 20, "to": {"l1": 27, "l2": 21, "l3": 19}}
    answer = api.post("/v1/pose-connections", json=body)
    expected = rpr_solver.pose_connections(EXAMPLES["innocenti"], 27, 20, 20, to=(27, 21, 19)).to_json()
    assert (answer.status_code, answer.json()) == (200, expected)
    assert is_whole("PoseConnections", expected)
    drawn = api.post("/v1/pose-connections", json=body, headers={"Accept": "image/svg+xml"})
    assert (drawn.headers["content-type"], drawn.text) == ("image/svg+xml", figure_of(expected).svg())
    same = {**body, "to": {"l1": 27, "l2": "20.0", "l3": 20}}
    refused = api.post("/v1/pose-connections", json=same)
    assert (refused.status_code, refused.json()["type"]) == (422, "/problems/job-input-error")
    limits = {"l2": {"min": 5, "max": 4}}
    refused = api.post("/v1/pose-connections", json={**body, "limits": limits, "to": {"l1": 1, "l2": 0}})
    assert [error["field"] for error in refused.json()["errors"]] == ["to.l2", "to.l3"]
    refused = api.post("/v1/pose-connections", json={**body, "limits": limits})
    assert [error["field"] for error in refused.json()["errors"]] == ["limits.l2.max"]


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


def test_a_document_that_has_expired_is_gone(
    api: httpx.Client, redis: Redis, fresh: Callable[[], str]
) -> None:
    body = dict(POSES)

    def ask() -> httpx.Response:
        body["l3"] = fresh()
        return api.post("/v1/poses", json=body, headers={"Prefer": "respond-async"})

    job = accepted(ask).json()
    ended(api, job["id"])
    queue = JobQueue(redis)
    _, request, _ = queue.records.request(job["id"])  # type: ignore[misc]
    assert request.job_id == job["id"]
    redis.delete(queue.store.keys.document(request.content_hash))
    gone = api.get(job["links"]["result"])
    assert (gone.status_code, gone.json()["type"]) == (410, "/problems/result-expired")
    assert api.post("/v1/poses", json=body).status_code == 200


def test_a_document_is_canceled_like_a_table(idle: httpx.Client) -> None:
    job = idle.post("/v1/poses", json=POSES, headers={"Prefer": "wait=0"}).json()
    early = idle.get(job["links"]["result"])
    assert (early.status_code, early.json()["detail"]) == (409, "The job is queued: 0 of 1 steps are done.")
    assert idle.delete(job["links"]["self"]).json()["status"] == "canceled"
    assert idle.get(job["links"]["result"]).json()["type"] == "/problems/job-canceled"


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


def test_a_census_can_be_had_as_csv(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "digits": 30, "range": {"from": "28"}}
    headers = {"Accept": "text/csv", "Prefer": "wait=30"}
    answer = api.post("/v1/censuses", json=body, headers=headers)
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert [row["count"] for row in rows] == ["8", "10", "8", "6", "8", "6", "4"]
    assert answer.headers["content-type"].startswith("text/csv")
    lines = api.post("/v1/censuses", json=body, headers={"Accept": "application/x-ndjson"})
    assert lines.status_code == 406


def test_a_census_of_a_tolerance_can_be_had_as_a_url(api: httpx.Client) -> None:
    body = {**GEOMETRY, "l1_from": "26.7", "l1_to": "26.9", "digits": 15}
    question = {**body, "tolerance": "0.0001", "format": "csv", "wait": 30}
    answer = api.get("/v1/censuses", params=question)
    assert answer.status_code == 200
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert [row["count"] for row in rows] == ["6", "8"]
    bounds = [Fraction(row[end]) for row in rows for end in ("transition_from", "transition_to") if row[end]]
    assert Fraction("26.78") < bounds[0] < Fraction("26.7863") < bounds[1] < Fraction("26.79")
    wrong = api.get("/v1/censuses", params={**question, "tolerance": "0"})
    assert (wrong.status_code, wrong.json()["errors"][0]["field"]) == (422, "tolerance")


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"range": {"from": -1}}, "range.from"),
        ({"range": {"from": 2, "to": 2}}, "range.to"),
        ({"range": {"form": 2}}, "range.form"),
        ({"range": {"to": "x"}}, "range.to"),
        ({"range": "1:2"}, "range"),
        ({"fixed_leg": 4}, "fixed_leg"),
        ({"l1": 4}, "l1"),
    ],
)
def test_wrong_fields_of_a_census_are_named(idle: httpx.Client, change: dict[str, Any], field: str) -> None:
    answer = idle.post("/v1/censuses", json={"geometry": GEOMETRY, **change})
    assert answer.status_code == 422
    assert field in [error["field"] for error in answer.json()["errors"]]


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


@pytest.mark.parametrize("form", ["application/json", "text/csv", "application/x-ndjson"])
def test_a_table_without_a_possible_slice_is_422(idle: httpx.Client, form: str) -> None:
    body = {"geometry": GEOMETRY, "l1": -1, "digits": 15}
    posted = idle.post("/v1/cusp-tables", json=body, headers={"Accept": form, "Prefer": "wait=1"})
    asked = idle.get("/v1/cusp-tables", params={**GEOMETRY, "l1": "-1;0"})
    details = [answer.json()["detail"] for answer in (posted, asked)]
    assert (posted.status_code, asked.status_code) == (422, 422)
    assert details == ["l1: is -1; a leg length must be > 0", "l1: is -1, 0; a leg length must be > 0"]


@pytest.mark.parametrize(
    ("path", "question", "message"),
    [
        ("margins", {}, "l1: is missing; give exactly one of l1, requirement and window"),
        (
            "margins",
            {"l1": 1, "window": 2},
            "window: is given beside l1; give exactly one of l1, requirement and",
        ),
        ("assembly-modes", {}, "l1: is missing; give exactly one of l1 and range"),
        (
            "designs",
            {},
            "objective: is missing; give one of longest-range, least-change, largest-margin, most-",
        ),
        (
            "paths",
            {"from": {"l1": 1, "l2": 2, "l3": 3}, "to": {"l1": 1}},
            "from.pose: is missing; give the number",
        ),
        (
            "paths",
            {"l1": 27, "motion": {"speed": 1}},
            "motion.acceleration: is missing; give a number > 0, or numbers for some of l1, l2, l3",
        ),
    ],
)
def test_what_is_missing_or_too_much_is_said(
    idle: httpx.Client, path: str, question: dict[str, Any], message: str
) -> None:
    answer = idle.post(f"/v1/{path}", json={"geometry": GEOMETRY, **question})
    assert answer.status_code == 422
    assert message in answer.json()["detail"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"l1": 0}, "l1: is 0; a leg length must be > 0"),
        ({"l1": [3, 9], "range": {"to": 8}}, "l1: is 9, outside the range from 0 to 8"),
        ({"l1": []}, "l1: is an empty list"),
        ({"l2": 3}, "l2: unknown field; with fixed_leg 1 the slices are l1"),
        ({"samples": 0}, "samples: is 0; give 1 to 5"),
        ({"samples": 1.5}, "samples: is 1.5; give a whole number: 1 to 5"),
        ({"samples": 6}, "samples: asks for 6 points; the limit max_samples is 5"),
        ({"l1": {"from": 1, "to": 100, "step": 1}}, "the limit max_slices is 5"),
    ],
)
def test_wrong_fields_of_cusp_curves_are_named(
    idle: httpx.Client, change: dict[str, Any], message: str
) -> None:
    answer = idle.post("/v1/cusp-curves", json={"geometry": GEOMETRY, **change})
    assert answer.status_code == 422
    problem = answer.json()
    assert message in next(f"{error['field']}: {error['message']}" for error in problem["errors"])


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


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"method": "slow"}, "it must be one of fast, article"),
        ({"method": ["article"]}, "is a list"),
        ({"method": "article", "fixed_leg": 2, "l2": 1, "l1": None}, "fixes leg 1, but fixed_leg is 2"),
        ({"method": "article", "l1": [1, 2, 3]}, "the limit max_article_slices is 2"),
    ],
)
def test_wrong_uses_of_the_method_are_reported(idle: httpx.Client, change: dict[str, Any], said: str) -> None:
    body = {
        key: value for key, value in {"geometry": GEOMETRY, "l1": 1, **change}.items() if value is not None
    }
    answer = idle.post("/v1/cusp-tables", json=body)
    assert answer.status_code == 422
    assert said in answer.json()["detail"]


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


@pytest.mark.long
def test_a_check_within_a_tolerance(api: httpx.Client) -> None:
    requirement = {"range": {"from": 21, "to": 26}, "max_cusps": 6}
    question = {"geometry": GEOMETRY, "requirement": requirement, "digits": 15, "tolerance": "0.2"}
    report = api.post("/v1/checks", json=question, headers={"Prefer": "wait=30"}).json()
    assert is_whole("CheckReport", report)
    assert (report["passed"], report["violations"]) == (False, [])
    assert report["margin"]["verdict"] == "refuted"
    example = report["margin"]["counterexample"]
    other = {**question, "geometry": example["geometry"]}
    del other["tolerance"]
    assert api.post("/v1/checks", json=other, headers={"Prefer": "wait=30"}).json()["max_cusps_found"] > 6
    asked = {name: question[name] for name in ("geometry", "requirement", "tolerance")}
    margin = api.post("/v1/margins", json=asked)
    assert (margin.status_code, margin.json()["counterexample"]) == (200, example)


@pytest.mark.long
def test_a_transition_may_move_within_the_range_of_a_check(api: httpx.Client) -> None:
    requirement = {"range": {"from": "26.7", "to": "26.9"}, "max_cusps": 8}
    question = {"geometry": GEOMETRY, "requirement": requirement, "digits": 15, "tolerance": "0.001"}
    report = api.post("/v1/checks", json=question, headers={"Prefer": "wait=30"}).json()
    assert is_whole("CheckReport", report)
    assert [part["count"] for part in report["intervals"]] == [6, 8]
    assert (report["passed"], report["margin"]["verdict"]) == (True, "proved")


@pytest.mark.parametrize("sides", [(30, 50, 40), (15, 25, 20)], ids=["congruent", "similar"])
def test_degenerate_families_have_no_tolerance(api: httpx.Client, sides: tuple[int, ...]) -> None:
    geometry = {"a2x": 30, "a3x": 0, "a3y": 40, **dict(zip(("d1", "d2", "d3"), sides, strict=True))}
    requirement = {"range": {"from": 10, "to": 20}, "max_cusps": 0}
    question = {"geometry": geometry, "requirement": requirement, "digits": 15, "tolerance": {"d1": 1e-9}}
    report = api.post("/v1/checks", json=question, headers={"Prefer": "wait=30"}).json()
    assert is_whole("CheckReport", report)
    assert (report["passed"], report["margin"]["verdict"]) == (False, "open")
    assert "degenerate" in report["margin"]["reason"]
    assert report["margin"]["certificate"]["boxes"] == 0


def test_a_flat_platform_has_a_margin_if_its_sides_are_exact(api: httpx.Client) -> None:
    flat = {"a2x": 30, "a3x": 11, "a3y": 27, "d1": 13, "d2": 9, "d3": 4}
    question = {"geometry": flat, "l1": 20, "tolerance": "0.01"}
    none = api.post("/v1/margins", json=question, headers={"Prefer": "wait=30"}).json()
    assert (none["verdict"], none["reason"]) == ("open", "the least change makes it no manipulator")
    assert (none["validity"], none["certificate"]["boxes"]) == ("0", 0)
    question["weights"] = {"d1": 0, "d2": 0, "d3": 0}
    some = api.post("/v1/margins", json=question, headers={"Prefer": "wait=30"}).json()
    assert (some["verdict"], some["reason"]) == ("proved", None)


@pytest.mark.parametrize(("word", "passed"), [("allowed", True), ("refused", False)])
def test_a_check_says_what_is_degenerate_and_may_refuse_it(
    api: httpx.Client, word: str, passed: bool
) -> None:
    congruent = {"a2x": 30, "a3x": 0, "a3y": 40, "d1": 30, "d2": 50, "d3": 40}
    requirement = {"range": {"from": 5}, "max_cusps": 0, "degenerate": word}
    question = {"geometry": congruent, "requirement": requirement, "digits": 15}
    report = api.post("/v1/checks", json=question, headers={"Prefer": "wait=30"}).json()
    assert is_whole("CheckReport", report)
    assert (report["passed"], report["violations"]) == (passed, [])
    assert report["degenerate"][0] == {
        "kind": "curve", "from": "5", "to": None, "equation": "alpha = 0 deg"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"max_cusps": 0, "degenerate": "no"}, "requirement.degenerate"),
        ({}, "requirement.max_cusps"),
        ({"max_cusps": 1.5}, "requirement.max_cusps"),
        ({"max_cusps": -1}, "requirement.max_cusps"),
        ({"max_cusps": 1, "fixed_leg": 4}, "requirement.fixed_leg"),
        ({"max_cusps": 1, "range": {"from": 2, "to": 1}}, "requirement.range.to"),
        ({"max_cusps": 1, "limits": {"l1": {"min": 1}}}, "requirement.limits.l1"),
        ({"most_cusps": 1}, "requirement.most_cusps"),
        (None, "requirement"),
        ("max 1", "requirement"),
    ],
)
def test_wrong_fields_of_a_requirement_are_named(idle: httpx.Client, change: Any, field: str) -> None:
    answer = idle.post("/v1/checks", json={"geometry": GEOMETRY, "requirement": change})
    assert answer.status_code == 422
    assert field in [error["field"] for error in answer.json()["errors"]]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"l1": 0}, "l1"),
        ({"l2": "-1/3"}, "l2"),
        ({"l3": None}, "l3"),
        ({"digits": 3}, "digits"),
        ({"fixed_leg": 1}, "fixed_leg"),
        ({"geometry": {}}, "geometry"),
        ({"l1": "1" * 31}, "l1"),
    ],
)
def test_wrong_fields_of_poses_are_named(idle: httpx.Client, change: dict[str, Any], field: str) -> None:
    answer = idle.post("/v1/poses", json={**POSES, **change})
    assert answer.status_code == 422
    assert field in [error["field"] for error in answer.json()["errors"]]
