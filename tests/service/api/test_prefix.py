"""A service behind a reverse proxy that shows it under a path."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urljoin

import httpx
import pytest
from pydantic import ValidationError

from rpr_solver import EXAMPLES
from service.api.job_views import event_documents
from service.api.settings import Settings
from service.client import ServiceClient, cusp_table
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE
from tests.support.proxies import proxied
from tests.support.service_server import GEOMETRY, serving
from worker.jobs.view import JobView
from worker.settings import WorkerSettings

BY_SETTING: dict[str, Any] = {"root_path": "/cusps"}
WAYS = {
    "a setting, the proxy strips": (BY_SETTING, {"strips": True}),
    "a setting, the proxy passes on": (BY_SETTING, {"strips": False}),
}


@contextmanager
def shown_under(url: str, settings: dict[str, Any], proxy: dict[str, Any]) -> Iterator[httpx.Client]:
    """A client of the proxy's host; all that it asks for begins with the prefix, or it is 502."""
    with (
        serving(Settings(redis_url=url, **settings)) as base,
        proxied(base, "/cusps", **proxy) as outside,
        httpx.Client(base_url=outside.removesuffix("/cusps"), timeout=PATIENCE) as client,
    ):
        yield client


def linked(client: httpx.Client, address: str) -> set[str]:
    """The addresses of what a page links to, as a browser finds them."""
    page = client.get(address)
    assert page.status_code == 200
    found = re.findall(r'(?:href|src)="([^"#]+)"', page.text)
    return {urljoin(address, link) for link in found if not link.startswith(("http", "data:"))}


@pytest.mark.parametrize("way", WAYS)
def test_every_link_stays_under_the_prefix(valkey: EmbeddedValkey, way: str) -> None:
    url = f"{valkey.url}?db=2"  # where nobody works
    with shown_under(url, *WAYS[way]) as client:
        if not WAYS[way][1]["strips"]:  # else it is the proxy that tells a browser of the slash
            assert client.get("/cusps").headers["location"] == "/cusps/"
        for page in ("/cusps/", "/cusps/docs", "/cusps/problems", "/cusps/problems/not-found"):
            for address in linked(client, page):
                assert client.get(address).status_code in (200, 503), address  # 503: /readyz
        assert client.get("/cusps/openapi.json").json()["servers"] == [{"url": "/cusps"}]
        schema = client.get("/cusps/schemas/geometry.json").json()["$id"]
        assert client.get(schema).status_code == 200

        missing = client.get("/cusps/nothing").json()
        assert (missing["type"], missing["instance"]) == ("/cusps/problems/not-found", "/cusps/nothing")
        assert client.get(missing["type"]).status_code == 200

        answer = client.post("/cusps/v1/cusp-tables", json={"geometry": GEOMETRY, "l1": 3.25})
        job = answer.json()
        assert (answer.status_code, answer.headers["location"]) == (202, job["links"]["self"])
        assert client.get(answer.headers["location"]).json()["id"] == job["id"]
        unfinished = client.get(job["links"]["result"])
        assert (unfinished.status_code, unfinished.json()["job"]) == (409, job["links"]["self"])
        with client.stream("GET", job["links"]["events"]) as events:
            first = next(line for line in events.iter_lines() if line.startswith("data:"))
        assert json.loads(first[5:])["links"]["self"] == job["links"]["self"]
        assert client.delete(job["links"]["self"]).json()["status"] == "canceled"

        item = {"kind": "poses", "request": {"geometry": GEOMETRY, "l1": 1, "l2": 2, "l3": 3}}
        batch = client.post("/cusps/v1/batches", json={"items": [item]})
        assert client.get(batch.headers["location"]).json()["id"] == batch.json()["id"]
        assert client.delete(batch.json()["links"]["self"]).status_code == 200


@pytest.mark.usefixtures("worker")
@pytest.mark.parametrize("way", WAYS)
def test_a_known_answer_and_the_python_client(valkey: EmbeddedValkey, way: str) -> None:
    with shown_under(valkey.url, *WAYS[way]) as client:
        asked = {"geometry": GEOMETRY, "l1": 14.98, "l2": 15.5, "l3": 13.9}
        answer = client.post("/cusps/v1/poses", json=asked)
        address = answer.headers["content-location"]
        assert address.startswith("/cusps/v1/jobs/")
        assert client.get(address).json() == answer.json()
        with ServiceClient(str(client.base_url.join("/cusps"))) as ours:
            question = cusp_table(EXAMPLES["innocenti"], "14.98", digits=15)
            assert ours.ask(question).content == ours.ask(question).content
            batch = ours.submit([question])
            assert [result.index for result in ours.results(batch.id, wait=60)] == [0]


def test_a_prefix_opens_nothing(valkey: EmbeddedValkey) -> None:
    settings = Settings(redis_url=f"{valkey.url}?db=2", require_keys="always", **BY_SETTING)
    with serving(settings) as base:
        for path in (
            "/metrics",
            "/cusps/metrics",
            "/cusps/cusps/metrics",
            "/cusps//metrics",
            "/cusps%2Fmetrics",
        ):
            assert httpx.get(base + path).status_code == 401, path


def test_events_of_webhooks_have_it() -> None:
    view = JobView("ct-0", "succeeded", 1, 1, *(["2026-01-15T09:30:00.000Z"] * 3), error=None, run="0")  # type: ignore[arg-type]
    document: Any = event_documents(WorkerSettings(), "/cusps")(view)
    assert document["links"]["result"] == "/cusps/v1/jobs/ct-0/result"


@pytest.mark.parametrize(
    "value",
    ["cusps", "/v1", "//a", "/" + 300 * "a"],
)
def test_a_prefix_that_is_none_is_refused(value: str) -> None:
    with pytest.raises(ValidationError, match="root_path"):
        Settings(root_path=value)
