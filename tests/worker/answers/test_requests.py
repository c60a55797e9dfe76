"""Requests: canonical, identified by their content, and kept in Redis."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

import rpr_solver
from rpr_solver import EXAMPLES
from tests.support.processes import ROOT
from worker.answers.documents import (
    POSES,
)
from worker.answers.kind import JobRequest
from worker.answers.kinds import KINDS, kind_of_job, request_from_json
from worker.answers.tables import CUSP_TABLE

GEOMETRY = EXAMPLES["innocenti"].to_json()

KIND = {kind.name: kind for kind in KINDS}
OF_VERSION_2 = {
    one["id"]: JobRequest(KIND[one["kind"]], one["content"])
    for one in json.loads((ROOT / "tests/data/job_ids.json").read_text(encoding="utf-8"))
}
"""Job id with version 2 of the solver → request, one of each kind."""


@pytest.mark.parametrize("job_id", OF_VERSION_2)
def test_the_id_of_a_job_never_changes(job_id: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("worker.answers.kind.SOLVER_VERSION", "2")
    content = dict(reversed(OF_VERSION_2[job_id].content.items()))
    request = JobRequest(OF_VERSION_2[job_id].kind, content)
    assert request.job_id == job_id
    assert kind_of_job(job_id) == request.kind
    assert request.content_hash.startswith(job_id[3:])


def test_each_kind_is_pinned_and_can_be_answered() -> None:
    assert {request.kind for request in OF_VERSION_2.values()} == set(KINDS)
    assert len({kind.prefix for kind in KINDS}) == len({kind.name for kind in KINDS}) == len(KINDS)
    assert kind_of_job("xx-1") is None


@pytest.mark.parametrize("request_", OF_VERSION_2.values(), ids=OF_VERSION_2)
def test_json_and_back(request_: JobRequest) -> None:
    assert request_from_json(request_.to_json()) == request_


def test_a_geometry_is_hashed_without_reading_its_numbers() -> None:
    for manipulator in EXAMPLES.values():
        turned = dict(reversed(manipulator.to_json().items()))
        request = JobRequest(POSES, {"geometry": turned})
        assert request.geometry_hash == manipulator.geometry_hash
        assert request.manipulator == manipulator


@pytest.mark.parametrize(
    "change",
    [{"geometry": EXAMPLES["zein-flat"].to_json()}, {"fixed_leg": 2}, {"l1": ["2", "1"]}],
)
def test_every_member_changes_the_id(change: dict[str, Any]) -> None:
    content = {"geometry": GEOMETRY, "fixed_leg": 1, "digits": 90, "l1": ["1", "2"]}
    assert JobRequest(CUSP_TABLE, content | change).job_id != JobRequest(CUSP_TABLE, content).job_id


def test_another_version_of_the_solver_has_other_ids(monkeypatch: pytest.MonkeyPatch) -> None:
    job_ids = {request.job_id for request in OF_VERSION_2.values()}
    monkeypatch.setattr("worker.answers.kind.SOLVER_VERSION", rpr_solver.SOLVER_VERSION + "x")
    assert job_ids.isdisjoint(replace(request).job_id for request in OF_VERSION_2.values())
