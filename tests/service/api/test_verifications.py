"""Verifications over HTTP: the verdict on right and wrong documents, and what is no document."""

from __future__ import annotations

import json
from copy import deepcopy
from typing import Any

import httpx
import pytest

from rpr_solver import EXAMPLES, table_document, verify_document
from service.api.batches.rows import read_item
from service.schemas.limits import Limits
from tests.service.api.test_documents_api import is_whole

TABLE = table_document(EXAMPLES["zein-flat"], [10], digits=15)


def without_a_cusp() -> dict[str, Any]:
    document = deepcopy(TABLE)
    document["slices"][0]["cusps"].pop()
    return document


@pytest.mark.parametrize(("document", "verdict"), [(TABLE, "verified"), (without_a_cusp(), "refused")])
def test_a_document_is_verified_or_refused(api: httpx.Client, document: dict[str, Any], verdict: str) -> None:
    answer = api.post("/v1/verifications", json={"document": document})
    assert answer.status_code == 200
    expected = verify_document(document).to_json()
    assert answer.json() == {**EXAMPLES["zein-flat"].identity_json(), **expected}
    assert answer.json()["verdict"] == verdict
    assert is_whole("Verification", answer.json())


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({}, "document"),
        ({"document": {**TABLE, "geometry": {}}}, "document.geometry"),
        (
            {"document": {**TABLE, "geometry": {**TABLE["geometry"], "d1": "1/" + "3" * 15_000}}},
            "document.geometry.d1",
        ),
        (
            {"document": {**TABLE, "geometry": {**TABLE["geometry"], "\ud800": "1"}}},
            "document.geometry",
        ),
        ({"document": {**TABLE, "slices": [{"l1": "1", "count": 10**4000}]}}, "document.slices[0].count"),
        ({"document": TABLE, "geometry": TABLE["geometry"]}, "geometry"),
    ],
)
def test_what_cannot_be_verified_is_refused_at_once(api: httpx.Client, body: object, field: str) -> None:
    text = json.dumps(body)  # ASCII: httpx would not send half of a character
    sent = {"content": text, "headers": {"Content-Type": "application/json"}}
    answer = api.post("/v1/verifications", **sent)
    assert answer.status_code == 422
    assert field in [fault["field"] for fault in answer.json()["errors"]]
    item = read_item(json.dumps({"kind": "verification", "request": body}).encode(), 0, Limits())
    assert item.problem is not None
    assert f"items[0].request.{field}" in [fault["field"] for fault in item.problem["errors"]]


def test_a_document_that_cannot_be_read_fails_as_a_job(api: httpx.Client) -> None:
    part = TABLE["slices"][0]
    for change in ({"l1": "x"}, {"l1": "10.0"}, {"l1": 10}, {"l1": 10.5}, {"l1": "1e1"}):
        answer = api.post("/v1/verifications", json={"document": {**TABLE, "slices": [{**part, **change}]}})
        assert answer.status_code == 422
        assert "/slices/0/l1" in answer.text
