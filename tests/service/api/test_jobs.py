"""Jobs: the lists and who sees them, what costs too much, a full queue, places in it, and deadlines."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator
from datetime import datetime
from typing import Any

import httpx
import pytest
from redis import Redis
from redis.asyncio import Redis as AsyncRedis

from service.api.job_events import Tails, event_id
from service.api.keys import KeyStore, make_key
from service.api.settings import KeyScope, Settings
from service.client import AsyncServiceClient, ServiceClient
from service.schemas.limits import Limits
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


def key(redis: Redis, name: str, scope: KeyScope) -> Headers:
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
        assert answer.headers.get("link") == (None if following is None else f'<{following}>; rel="next"')
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
        *("id", "kind", "status", "created_at", "started_at", "ended_at", "estimate_seconds", "key")
    }
    assert (item["kind"], item["status"], item["ended_at"], item["key"]) == (
        "cusp-table",
        "queued",
        None,
        None,
    )
    assert item["estimate_seconds"] > 0


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


@pytest.mark.parametrize("query", ["status=lost", "limit=0", "before=yesterday"])
def test_what_cannot_be_asked(client: httpx.Client, query: str) -> None:
    answer = client.get(f"/v1/jobs?{query}")
    assert (answer.status_code, answer.json()["type"]) == (422, "/problems/invalid-request")
    assert answer.json()["errors"][0]["field"] == f"{query.partition('=')[0]}"


def test_the_clients_read_all_pages(client: httpx.Client) -> None:
    jobs = [asked(client, str(n)) for n in range(1, 53)]
    made = batch(client)
    url = str(client.base_url)
    with ServiceClient(url) as here:
        assert [job.id for job in here.jobs()] == jobs[::-1]
        assert [job.id for job in here.batches("queued")] == [made]
        assert here.cancel(jobs[0], force=True)["status"] == "canceled"

    async def awaited() -> None:
        async with AsyncServiceClient(url) as there:
            assert [job.id async for job in there.jobs("active")] == jobs[:0:-1]
            assert [job.id async for job in there.batches()] == [made]
            assert (await there.cancel(made, force=True))["status"] == "canceled"

    asyncio.run(awaited())


Fresh = Callable[[], str]

EXTREME = {"a2x": "1e200", "a3x": "0", "a3y": "1", "d1": "1", "d2": "1e-100", "d3": "1"}
LONG = {name: f"{x}{'7318526904' * 39}" if name != "a3x" else x for name, x in GEOMETRY.items()}
LONG["a3y"] = "10." + "3" * 390
LIMIT = 8


@pytest.fixture
def alone(
    valkey: EmbeddedValkey,
    idle_redis: Redis,  # noqa: ARG001
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[httpx.Client]:
    """A client of a service without a worker, with room for a little work, and little of the usual limit."""
    monkeypatch.setenv("RPR_CUSPS_MAX_BACKLOG_SECONDS", "0.22")
    limits = Limits(deadline_seconds=50, max_cost_seconds=LIMIT)
    settings = Settings(redis_url=f"{valkey.url}?db=2", limits=limits)
    with serving(settings) as url, httpx.Client(base_url=url, timeout=PATIENCE) as client:
        yield client


def table(l1: object, **more: Any) -> dict[str, Any]:
    return {"geometry": GEOMETRY, "l1": l1, "digits": 15, **more}


@pytest.mark.parametrize(
    ("path", "body", "fields"),
    [
        ("cusp-tables", {"geometry": EXTREME, "l1": "1e-200", "digits": 15}, {"geometry"}),
        ("censuses", {"geometry": LONG}, {"geometry"}),
        (
            "cusp-tables",
            {"geometry": {**GEOMETRY, "d1": "17.0412345678"}, "method": "article", "l1": list(range(1, 51))},
            {"l1"},
        ),
    ],
)
def test_what_takes_too_long_is_refused_at_once(
    alone: httpx.Client, path: str, body: dict[str, Any], fields: set[str]
) -> None:
    answer = alone.post(f"/v1/{path}", json=body)
    problem = answer.json()
    assert (answer.status_code, problem["type"]) == (422, "/problems/limit-exceeded")
    assert problem["limit"] == {"name": "max_cost_seconds", "value": LIMIT}
    assert {error["field"] for error in problem["errors"]} == fields
    for error in problem["errors"]:
        assert error["message"].startswith("would take about ")
        assert f"; the limit max_cost_seconds is {LIMIT}; " in error["message"]
    assert alone.get("/metrics").text.count("rpr_cusps_jobs_active 0.0") == 1


def test_usual_questions_are_far_below_the_limit(alone: httpx.Client) -> None:
    body = table({"from": "0.01", "to": "20", "step": "0.01"}, digits=500)
    table_of_many = alone.post("/v1/cusp-tables", json=body)
    assert table_of_many.status_code == 202
    alone.delete(table_of_many.json()["links"]["self"])
    assert alone.post("/v1/cusp-curves", json={"geometry": GEOMETRY, "samples": 4}).status_code == 202


def test_a_full_queue_says_when_to_come_again(alone: httpx.Client) -> None:
    accepted = [alone.post("/v1/cusp-tables", json=table(n)) for n in range(1, 5)]
    assert {answer.status_code for answer in accepted} == {202}
    full = alone.post("/v1/cusp-tables", json=table(5))
    assert (full.status_code, full.json()["type"]) == (503, "/problems/queue-full")
    assert full.headers["retry-after"] == "1"
    again = alone.post("/v1/cusp-tables", json=table(1))
    assert (again.status_code, again.json()["id"]) == (202, accepted[0].json()["id"])
    alone.delete(again.json()["links"]["self"])
    assert alone.post("/v1/cusp-tables", json=table(5)).status_code == 202


def test_a_queued_job_shows_its_place(alone: httpx.Client) -> None:
    body = {"geometry": GEOMETRY, "digits": 30, "samples": 5}
    jobs = [alone.post("/v1/cusp-curves", json={**body, "fixed_leg": 1})]
    jobs.append(alone.post("/v1/cusp-tables", json=table(1)))
    assert [job.json()["position"] for job in jobs] == [0, 0], "each in its lane"
    assert {job.headers["retry-after"] for job in jobs} == {"1"}
    second = alone.post("/v1/cusp-tables", json=table(2)).json()
    shown = alone.get(second["links"]["self"])
    assert shown.json()["position"] == 1
    assert alone.get(second["links"]["result"]).headers["retry-after"] == shown.headers["retry-after"]


def test_the_wait_follows_the_estimate(valkey: EmbeddedValkey, idle_redis: Redis) -> None:  # noqa: ARG001
    settings = Settings(redis_url=f"{valkey.url}?db=2", longest_poll_seconds=5)
    with serving(settings) as url, httpx.Client(base_url=url, timeout=PATIENCE) as client:
        bodies = [{"geometry": GEOMETRY, "digits": digits, "samples": 2} for digits in (30, 31, 32, 33)]
        answers = [client.post("/v1/cusp-curves", json=body) for body in bodies]
    waits = [int(answer.headers["retry-after"]) for answer in answers]
    assert waits[0] == 1
    assert waits == sorted(waits)
    assert 2 <= waits[1] <= 6
    assert waits[-1] == 5, "at most"


def test_a_deadline_is_no_part_of_the_question(alone: httpx.Client) -> None:
    job = alone.post("/v1/cusp-tables", json=table(1, deadline_seconds=30)).json()
    assert datetime.fromisoformat(job["deadline_at"]) > datetime.fromisoformat(job["created_at"])
    same = alone.post("/v1/cusp-tables", json=table(1, deadline_seconds="40.5")).json()
    assert same["id"] == job["id"]
    assert same["deadline_at"] > job["deadline_at"]
    assert alone.post("/v1/cusp-tables", json=table(1)).json()["deadline_at"] is None


@pytest.mark.parametrize(
    ("deadline", "kind", "message"),
    [
        (50.5, "limit-exceeded", "is 50.5 s; the limit deadline_seconds is 50"),
        (0, "invalid-request", "is 0; give a number of seconds > 0"),
    ],
)
def test_deadlines_that_are_refused(alone: httpx.Client, deadline: object, kind: str, message: str) -> None:
    for path, body in (("cusp-tables", table(1)), ("censuses", {"geometry": GEOMETRY})):
        problem = alone.post(f"/v1/{path}", json={**body, "deadline_seconds": deadline}).json()
        assert problem["type"] == f"/problems/{kind}"
        [error] = problem["errors"]
        assert error["field"] == "deadline_seconds"
        assert error["message"].startswith(message)


def test_a_known_answer_has_no_price(api: httpx.Client, valkey: EmbeddedValkey, fresh: Fresh) -> None:
    body = table(fresh())
    assert api.post("/v1/cusp-tables", json=body, headers={"Prefer": "wait=30"}).status_code == 200
    strict = Settings(redis_url=valkey.url, limits=Limits(max_cost_seconds=1))
    with serving(strict) as url, httpx.Client(base_url=url, timeout=PATIENCE) as client:
        assert client.post("/v1/cusp-tables", json=body).status_code == 200
        many = table([f"{fresh()}1" for _ in range(1000)])
        problem = client.post("/v1/cusp-tables", json=many).json()
    assert [error["field"] for error in problem["errors"]] == ["l1"]
    assert problem["errors"][0]["message"].endswith("; ask for fewer than 1000")


@pytest.mark.parametrize("more", [0, 30])
@pytest.mark.parametrize("status", ["running", "succeeded"])
def test_of_many_events_at_once_the_newest_is_heard_first(
    valkey: EmbeddedValkey, idle_redis: Redis, more: int, status: str
) -> None:
    events = [{"type": "progress"}] * (2 + more) + [{"type": "status", "status": status}]
    ids = [idle_redis.xadd("events", {**event}).decode() for event in events]

    async def heard() -> tuple[object, bool]:
        redis = AsyncRedis.from_url(f"{valkey.url}?db=2", decode_responses=True)
        async with redis, Tails(redis, 1, print).of("events", since=ids[0]) as tail:
            assert await tail.wait_beyond(event_id(ids[0]), PATIENCE)
            return tail.newest, tail.has_ended

    assert asyncio.run(heard()) == (event_id(ids[-1]), status == "succeeded")
