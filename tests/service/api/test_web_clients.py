"""Web pages and editors as clients."""

from __future__ import annotations

from collections.abc import Iterator

import httpx
import pytest
from pydantic import ValidationError

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE
from tests.support.service_server import GEOMETRY, serving

PAGE = "https://tools.example.com"
PREFLIGHT = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "content-type,prefer"}
QUESTION = {"geometry": GEOMETRY, "l1": "6.0625", "digits": 15}


@pytest.fixture(scope="module")
def shared(valkey: EmbeddedValkey) -> Iterator[httpx.Client]:
    """A client of a service that one page may call."""
    settings = Settings(redis_url=f"{valkey.url}?db=1", cors_origins=f"https://other.example, {PAGE}")
    with serving(settings) as url, httpx.Client(base_url=url, timeout=PATIENCE) as client:
        yield client


def test_a_page_whose_origin_is_allowed_may_ask(shared: httpx.Client) -> None:
    asked = shared.options("/v1/cusp-tables", headers={"Origin": PAGE, **PREFLIGHT})
    assert (asked.status_code, asked.headers["access-control-allow-origin"]) == (200, PAGE)
    answer = shared.post("/v1/cusp-tables", json=QUESTION, headers={"Origin": PAGE})
    assert answer.headers["access-control-allow-origin"] == PAGE
    assert "Location" in answer.headers["access-control-expose-headers"]
    where = {**GEOMETRY, "l1": "6.0625", "wait": 0}
    own = shared.get(
        "/v1/cusp-tables", params=where, headers={"Origin": PAGE, "Sec-Fetch-Site": "cross-site"}
    )
    assert own.status_code == 202


def test_other_pages_may_not(shared: httpx.Client, idle: httpx.Client) -> None:
    for client, page in ((shared, "https://evil.example"), (idle, PAGE)):
        asked = client.options("/v1/cusp-tables", headers={"Origin": page, **PREFLIGHT})
        assert asked.status_code >= 400
        assert "access-control-allow-origin" not in asked.headers


def test_an_origin_is_no_address() -> None:
    with pytest.raises(ValidationError, match="no origin; write one such as"):
        Settings(cors_origins=f"{PAGE}/page")


def test_a_geometry_may_name_its_schema(idle: httpx.Client) -> None:
    answer = idle.get("/schemas/geometry.json")
    schema = answer.json()
    assert schema["$id"] == str(answer.url)
    assert {"$schema", *GEOMETRY} <= schema["properties"].keys()
    assert {"name", "unit"} <= schema["properties"].keys()
    beside = {"$schema": schema["$id"], "name": "Gripper", "unit": "mm"}
    named = {**QUESTION, "geometry": {**beside, **GEOMETRY}}
    ids = {idle.post("/v1/cusp-tables", json=body).json()["id"] for body in (QUESTION, named)}
    assert len(ids) == 1, "it is no part of the question"
    refused = idle.post("/v1/cusp-tables", json={**QUESTION, "geometry": {**GEOMETRY, "unit": 5}})
    assert (refused.status_code, refused.json()["detail"]) == (422, "geometry.unit: is 5; give a text")
