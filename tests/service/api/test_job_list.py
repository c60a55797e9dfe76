"""The lists of jobs and batches: to whom they show what."""

from __future__ import annotations

import time
from collections.abc import Iterator

import httpx
import pytest
from redis import Redis

from service.api.access.keys import KeyStore, Scope, make_key
from service.api.settings import Settings
from service.client import AsyncServiceClient, ServiceClient
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE
from tests.support.service_server import GEOMETRY, serving

Headers = dict[str, str]


@pytest.fixture
def client(valkey: EmbeddedValkey, idle_redis: Redis) -> Iterator[httpx.Client]:  # noqa: ARG001 - emptied
    """A client of a service without jobs, keys and workers."""
    with (
        serving(Settings(redis_url=f"{valkey.url}?db=2")) as url,
        httpx.Client(base_url=url, timeout=PATIENCE) as client,
    ):
        yield client


def key(redis: Redis, name: str, scope: Scope) -> Headers:
    made, token = make_key(name, scope, time.time(), None)
    assert KeyStore(redis, "cusps").add(made, time.time())
    return {"Authorization": f"Bearer {token}"}


def asked(client: httpx.Client, l1: str, headers: Headers | None = None) -> str:
    answer = client.post("/v1/cusp-tables", json={"geometry": GEOMETRY, "l1": l1}, headers=headers)
    assert answer.status_code == 202
    return str(answer.json()["id"])


def batch(client: httpx.Client, headers: Headers | None = None) -> str:
    items = [{"kind": "cusp-table", "request": {"geometry": GEOMETRY, "l1": "3"}}]
    return str(client.post("/v1/batches", json={"items": items}, headers=headers).json()["id"])


def ids(client: httpx.Client, path: str, headers: Headers | None = None) -> list[str]:
    """What all pages of a list have."""
    found: list[str] = []
    following: str | None = path
    while following is not None:
        answer = client.get(following, headers=headers)
        assert answer.status_code == 200, answer.text
        found += [item["id"] for item in answer.json()["items"]]
        following = answer.json()["next"]
    return found


def test_the_operator_of_an_open_service_sees_all(client: httpx.Client) -> None:
    jobs = [asked(client, str(n)) for n in range(1, 6)]
    of_all = batch(client)
    assert ids(client, "/v1/jobs?limit=2") == jobs[::-1]
    assert ids(client, "/v1/batches") == [of_all]
    client.delete(f"/v1/jobs/{jobs[2]}?force=true")
    assert ids(client, "/v1/jobs?status=canceled") == [jobs[2]]
    assert ids(client, "/v1/jobs?status=active&limit=1") == [jobs[4], jobs[3], jobs[1], jobs[0]]
    assert ids(client, "/v1/jobs?status=running") == []
    [item] = client.get("/v1/jobs?limit=1").json()["items"]
    assert item.keys() == {
        *("id", "kind", "status", "created_at", "started_at", "estimate_s", "runs_s", "overruns", "key")
    }
    assert (item["kind"], item["status"], item["runs_s"], item["key"]) == ("cusp-table", "queued", None, None)
    assert item["estimate_s"] > 0


def test_through_a_proxy_nobody_is_the_operator(client: httpx.Client) -> None:
    asked(client, "1")
    for name in ("X-Forwarded-For", "X-Real-IP"):
        items = client.get("/v1/jobs", headers={name: "192.0.2.9"}).json()["items"]
        assert items == [] or name == "X-Real-IP", "what was asked for from that address, at most"


def test_a_key_sees_its_own_and_an_admin_all(client: httpx.Client, idle_redis: Redis) -> None:
    ann, ben, root = (
        key(idle_redis, name, scope)
        for name, scope in (("ann", "submit"), ("ben", "submit"), ("root", "admin"))
    )
    one, both, two = asked(client, "1", ann), asked(client, "2", ann), asked(client, "3", ben)
    assert asked(client, "2", ben) == both
    of_ann = batch(client, ann)
    assert ids(client, "/v1/jobs", ann) == [both, one]
    assert set(ids(client, "/v1/jobs", ben)) == {both, two}
    assert ids(client, "/v1/jobs", root) == [two, both, one]
    assert ids(client, "/v1/batches", ann) == ids(client, "/v1/batches", root) == [of_ann]
    assert ids(client, "/v1/batches", ben) == []
    names = {item["id"]: item["key"] for item in client.get("/v1/jobs", headers=root).json()["items"]}
    assert names == {one: "ann", both: "ann", two: "ben"}
    assert client.get("/v1/jobs").status_code == 401
    assert client.delete(f"/v1/jobs/{one}?force=true", headers=ann).status_code == 403


@pytest.mark.parametrize("query", ["status=lost", "limit=0", "limit=101", "before=yesterday", "before=1e3"])
def test_what_cannot_be_asked(client: httpx.Client, query: str) -> None:
    answer = client.get(f"/v1/jobs?{query}")
    assert (answer.status_code, answer.json()["type"]) == (422, "/problems/invalid-request")
    assert answer.json()["errors"][0]["field"] == f"query.{query.partition('=')[0]}"


@pytest.mark.anyio
async def test_the_clients_read_all_pages(client: httpx.Client) -> None:
    jobs = [asked(client, str(n)) for n in range(1, 53)]
    made = batch(client)
    url = str(client.base_url)
    with ServiceClient(url) as here:
        assert [job.id for job in here.jobs()] == jobs[::-1]
        assert [job.id for job in here.batches("queued")] == [made]
        assert here.cancel(jobs[0], force=True)["status"] == "canceled"
    async with AsyncServiceClient(url) as there:
        assert [job.id async for job in there.jobs("active")] == jobs[:0:-1]
        assert [job.id async for job in there.batches()] == [made]
        assert (await there.cancel(made, force=True))["status"] == "canceled"
