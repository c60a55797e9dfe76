"""The documented models against what is really answered."""

from __future__ import annotations

import copy

import httpx
import pytest
from pydantic import BaseModel

from service.schemas.answers import ProblemDocument
from service.schemas.resources import Job, Readiness, Version
from service.schemas.tables import EXAMPLE_TABLE, CuspTable
from tests.support.service_server import GEOMETRY


def is_whole(model: type[BaseModel], document: object) -> bool:
    """Whether the model takes the document and knows every one of its fields."""
    return model.model_validate(document).model_dump(exclude_unset=True) == document


@pytest.mark.parametrize("leg", [2])
def test_tables_are_as_documented(api: httpx.Client, leg: int) -> None:
    body = {"geometry": GEOMETRY, f"l{leg}": [0, 14.98, 27], "fixed_leg": leg, "digits": 20}
    table = api.post("/v1/cusp-tables", json=body, headers={"Prefer": "wait=20"}).json()
    assert is_whole(CuspTable, table)
    assert [set(part) >= {"cusps"} for part in table["slices"]] == [False, True, True]


def test_the_example_answer_is_true(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": 0.2, "digits": 15}
    table = api.post("/v1/cusp-tables", json=body, headers={"Prefer": "wait=20"}).json()
    assert is_whole(CuspTable, EXAMPLE_TABLE)
    for document in (table, expected := copy.deepcopy(EXAMPLE_TABLE)):
        del document["slices"][0]["certificate"]
    assert table == expected


def test_jobs_and_problems_are_as_documented(idle: httpx.Client) -> None:
    job = idle.post("/v1/cusp-tables", json={"geometry": GEOMETRY, "l1": 9}).json()
    assert is_whole(Job, job)
    assert is_whole(ProblemDocument, idle.get(job["links"]["result"]).json())
    assert is_whole(ProblemDocument, idle.get("/nope").json())
    assert is_whole(
        ProblemDocument,
        idle.post("/v1/cusp-tables", json={"geometry": GEOMETRY, "l1": 9, "digits": 2000}).json(),
    )


@pytest.mark.parametrize(
    ("path", "model"),
    [("/readyz", Readiness), ("/v1/version", Version)],
)
def test_operational_answers_are_as_documented(api: httpx.Client, path: str, model: type[BaseModel]) -> None:
    assert is_whole(model, api.get(path).json())
