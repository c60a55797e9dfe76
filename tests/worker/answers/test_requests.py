"""Requests: canonical, identified by their content, and kept in Redis."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import rpr_solver
from rpr_solver import EXAMPLES
from worker.answers.censuses import CENSUS, CHECK, MARGIN
from worker.answers.designs import DESIGN
from worker.answers.documents import (
    ASPECTS,
    CUSP_CURVES,
    PLOT,
    POSES,
    SINGULAR_CURVES,
    VERIFICATION,
)
from worker.answers.kind import JobRequest
from worker.answers.kinds import KINDS, kind_of_job, request_from_json
from worker.answers.paths import CONNECTIONS, MODES, PATH
from worker.answers.tables import ARTICLE_TABLE, CUSP_TABLE
from worker.answers.workspaces import WORKSPACE

GEOMETRY = EXAMPLES["innocenti"].to_json()

OF_VERSION_2 = {
    "ct-94612320235d97a2778f4b3771589f397e15f69f": JobRequest(
        CUSP_TABLE, {"geometry": GEOMETRY, "fixed_leg": 2, "digits": 30, "l1": ["14.98", "27", "1/3"]}
    ),
    "at-d63b043f56092d4104453e145f40955e082a8e16": JobRequest(
        ARTICLE_TABLE, {"geometry": GEOMETRY, "l1": ["14.98", "27"], "digits": 30}
    ),
    "po-bfbaa4adbf4641df505db06aebea24f98bb242e5": JobRequest(
        POSES, {"geometry": GEOMETRY, "l1": "14.98", "l2": "15", "l3": "30.5", "digits": 20}
    ),
    "ce-1679db5350ac2f86d75f9a981219198589feaf3d": JobRequest(
        CENSUS,
        {"geometry": GEOMETRY, "fixed_leg": 3, "digits": 30, "range": {"from": "28", "to": "31"}},
    ),
    "ch-e76414571dc59287436735be81e3ca2026362507": JobRequest(
        CHECK,
        {
            "geometry": GEOMETRY,
            "requirement": {
                "fixed_leg": 1,
                "range": {"from": "28", "to": "31"},
                "max_cusps": 8,
                "min_cusps": None,
                "limits": {"l2": {"min": "5", "max": None}},
            },
            "digits": 30,
        },
    ),
    "cc-071c3b28117cc36ca08634ef2a4021e9ce90dbfa": JobRequest(
        CUSP_CURVES,
        {
            "geometry": GEOMETRY,
            "fixed_leg": 1,
            "digits": 15,
            "range": {"from": "0", "to": "29"},
            "lengths": ["27", "28"],
            "samples": 4,
        },
    ),
    "pa-237c1220106db83b7372c68186d763b37342730f": JobRequest(
        PATH,
        {
            "geometry": GEOMETRY,
            "fixed_leg": 1,
            "length": "27",
            "cusp": 2,
            "samples": 101,
            "timing": "cosine",
            "duration": "1",
            "others": False,
            "digits": 15,
        },
    ),
    "sc-40cd71f380ef9daf3dde9e521c5d369bf81c06ee": JobRequest(
        SINGULAR_CURVES,
        {"geometry": GEOMETRY, "fixed_leg": 1, "length": "27", "tolerance": "0.001", "digits": 15},
    ),
    "as-ad47bad0a7c329912824c6f91b4aa55cd0ed3c2a": JobRequest(
        ASPECTS,
        {"geometry": GEOMETRY, "fixed_leg": 1, "range": {"from": "27", "to": None}, "digits": 15},
    ),
    "ws-ed92ed65945312ad01ba9f5faa25d61985ffd23f": JobRequest(
        WORKSPACE,
        {
            "geometry": GEOMETRY,
            "phi": "30",
            "limits": {"l1": {"min": "5", "max": "30"}, "l2": {"min": None, "max": "25"}},
            "digits": 15,
        },
    ),
    "pl-401044c46fa64f59b88a1e07a64f589c97e2ef7a": JobRequest(
        PLOT,
        {
            "geometry": GEOMETRY,
            "plot": "slice",
            "theme": "light",
            "fixed_leg": 1,
            "digits": 15,
            "length": "27",
        },
    ),
    "ma-ef67cade4f67b44b9f5a640a0a1765f7f06e158b": JobRequest(
        MARGIN,
        {
            "geometry": GEOMETRY,
            "fixed_leg": 1,
            "digits": 15,
            "length": "28.1",
            "weights": dict.fromkeys(("a2x", "a3x", "a3y", "d1", "d2", "d3"), "1"),
        },
    ),
    "de-8a4dc6fdb82feac3d943824182976c20fb26814c": JobRequest(
        DESIGN,
        {
            "geometry": GEOMETRY,
            "fixed_leg": 1,
            "digits": 15,
            "objective": "longest-range",
            "requirement": {
                "fixed_leg": 1,
                "range": {"from": "5", "to": "30"},
                "max_cusps": 4,
                "min_cusps": None,
                "limits": {},
                "degenerate": "allowed",
            },
            "vary": {"d1": {"from": "14.484", "to": "19.596"}, "d2": {"from": "14.059", "to": "19.021"}},
            "family": None,
            "decimals": 2,
            "min_height": None,
            "budget": {"censuses": 4},
            "seed": 1,
        },
    ),
    "am-9720ca4f41737f4e961f79413564be413721ba5a": JobRequest(
        MODES,
        {
            "geometry": GEOMETRY,
            "fixed_leg": 1,
            "length": "27",
            "limits": {"l2": {"min": "12", "max": "30"}},
            "digits": 15,
        },
    ),
    "pc-7edb981662537b175fc7d5815bf24c1ca0d7c275": JobRequest(
        CONNECTIONS,
        {
            "geometry": GEOMETRY,
            "fixed_leg": 1,
            "l1": "27",
            "l2": "20",
            "l3": "20",
            "limits": {"l2": {"min": "5", "max": "21"}},
            "digits": 15,
        },
    ),
    "ve-8f9ded9c446b06058ff1c37bc730ad24253c23d8": JobRequest(
        VERIFICATION,
        {
            "geometry": GEOMETRY,
            "document": {"geometry": GEOMETRY, "digits": 15, "slices": []},
            "digits": 15,
        },
    ),
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
    [
        {"geometry": EXAMPLES["zein-flat"].to_json()},
        {"fixed_leg": 2},
        {"digits": 91},
        {"l1": ["1"]},
        {"l1": ["2", "1"]},
    ],
)
def test_every_member_changes_the_id(change: dict[str, Any]) -> None:
    content = {"geometry": GEOMETRY, "fixed_leg": 1, "digits": 90, "l1": ["1", "2"]}
    assert JobRequest(CUSP_TABLE, content | change).job_id != JobRequest(CUSP_TABLE, content).job_id


def test_another_version_of_the_solver_has_other_ids(monkeypatch: pytest.MonkeyPatch) -> None:
    job_ids = {request.job_id for request in OF_VERSION_2.values()}
    monkeypatch.setattr("worker.answers.kind.SOLVER_VERSION", rpr_solver.SOLVER_VERSION + "x")
    assert job_ids.isdisjoint(replace(request).job_id for request in OF_VERSION_2.values())
