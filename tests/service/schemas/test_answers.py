"""The example of an answer is true."""

from __future__ import annotations

import copy

import httpx
from pydantic import BaseModel

from service.schemas.tables import EXAMPLE_TABLE, CuspTable
from tests.support.service_server import GEOMETRY


def is_whole(model: type[BaseModel], document: object) -> bool:
    """Whether the model takes the document and knows every one of its fields."""
    return model.model_validate(document).model_dump(exclude_unset=True) == document


def test_the_example_answer_is_true(api: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "l1": 0.2, "digits": 15}
    table = api.post("/v1/cusp-tables", json=body, headers={"Prefer": "wait=20"}).json()
    assert is_whole(CuspTable, EXAMPLE_TABLE)
    for document in (table, expected := copy.deepcopy(EXAMPLE_TABLE)):
        del document["slices"][0]["certificate"]
    assert table == expected
