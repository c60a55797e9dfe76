"""Batches over HTTP, with a real worker."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from redis import Redis

from service.api.batches import results as batch_results
from service.api.settings import Settings
from service.schemas.limits import Limits
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import open_chunks
from tests.support.processes import PATIENCE, until
from tests.support.service_server import GEOMETRY, serving
from worker.answers.kinds import ItemSolver
from worker.connection import connect
from worker.jobs.attempts import Attempts
from worker.jobs.batches import Batches
from worker.jobs.queue import JobQueue

NDJSON = {"Content-Type": "application/x-ndjson"}
CSV = {"Content-Type": "text/csv"}
HEAD = "a2x,a3x,a3y,d1,d2,d3"
ROW = "15.91,0,10,17.04,16.54,20.84"

Line = dict[str, Any]


def table(l1: Any, **more: Any) -> dict[str, Any]:
    return {"kind": "cusp-table", "request": {"geometry": GEOMETRY, "l1": l1, "digits": 20}, **more}


def poses(l2: Any, **more: Any) -> dict[str, Any]:
    request = {"geometry": GEOMETRY, "l1": 14.98, "l2": l2, "l3": 30, "digits": 20}
    return {"kind": "poses", "request": request, **more}


def lines(*items: object) -> str:
    return "".join(json.dumps(item) + "\n" for item in items)


@pytest.fixture(scope="module")
def client(valkey: EmbeddedValkey, worker: None) -> Iterator[httpx.Client]:  # noqa: ARG001
    with serving(Settings(redis_url=valkey.url)) as base, httpx.Client(base_url=base) as client:
        client.timeout = httpx.Timeout(PATIENCE)
        yield client


@pytest.fixture
def idle(valkey: EmbeddedValkey, idle_redis: Redis) -> Iterator[httpx.Client]:  # noqa: ARG001
    """A service without workers, with small limits."""
    limits = Limits(max_batch_items=5, max_batch_bytes=4000, max_body_bytes=1500)
    settings = Settings(redis_url=f"{valkey.url}?db=2", limits=limits)
    with serving(settings) as base, httpx.Client(base_url=base) as client:
        client.timeout = httpx.Timeout(PATIENCE)
        yield client


def submitted(client: httpx.Client, body: object, headers: dict[str, str] | None = None) -> dict[str, Any]:
    answer = (
        client.post("/v1/batches", content=body, headers=headers)
        if isinstance(body, str | bytes)
        else client.post("/v1/batches", json=body, headers=headers)
    )
    assert answer.status_code == 202, answer.text
    batch: dict[str, Any] = answer.json()
    assert answer.headers["location"] == batch["links"]["self"] == f"/v1/batches/{batch['id']}"
    return batch


def results(
    client: httpx.Client, batch: dict[str, Any], prefer: str = "wait=60", after: str = ""
) -> list[Line]:
    answer = client.get(batch["links"]["results"] + after, headers={"Prefer": prefer} if prefer else {})
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/x-ndjson"
    assert answer.headers.get("preference-applied", "") == prefer
    return [json.loads(line) for line in answer.text.splitlines()]


def problem(answer: httpx.Response, status: int, slug: str) -> dict[str, Any]:
    assert (answer.status_code, answer.json()["type"]) == (status, f"/problems/{slug}"), answer.text
    document: dict[str, Any] = answer.json()
    return document


@pytest.mark.parametrize(
    ("body", "headers"),
    [
        ({"items": [table(27), poses(15)]}, None),
        (json.dumps([table(27), poses(15)]), {"Content-Type": "application/json"}),
        (lines(table(27), poses(15)), NDJSON),
        (
            f"{HEAD},kind,l1,l2,l3,digits\r\n{ROW},,27,,,20\r\n{ROW},poses,14.98,15,30,20\r\n",
            CSV,
        ),
    ],
    ids=["object", "array", "ndjson", "csv"],
)
def test_all_forms_are_one_question(
    client: httpx.Client, body: object, headers: dict[str, str] | None
) -> None:
    batch = submitted(client, body, headers)
    assert batch["progress"]["total"] == 2
    first, second = results(client, batch)
    assert (first["index"], first["id"], first["status"]) == (0, None, "succeeded")
    assert (second["index"], second["status"]) == (1, "succeeded")
    assert (first["result"]["slices"][0]["count"], second["result"]["count"]) == (8, 2)


def test_a_result_is_byte_for_byte_the_answer_to_the_question_alone(client: httpx.Client) -> None:
    items = [
        table([14.98, 0.5, 27]),
        poses(16),
        poses({"from": 10, "to": 20}),
        {"kind": "census", "request": {"geometry": GEOMETRY, "digits": 20}},
        {"kind": "census", "request": {"geometry": GEOMETRY, "digits": 20, "range": {"from": 20, "to": 30}}},
        {"kind": "article-table", "request": {"geometry": GEOMETRY, "l1": 27, "digits": 20}},
    ]
    batch = submitted(client, {"items": items})
    answer = client.get(batch["links"]["results"], headers={"Prefer": "wait=60"})
    paths = ("cusp-tables", "poses", "poses", "censuses", "censuses", "cusp-tables")
    for line, path, item in zip(answer.content.splitlines(), paths, items, strict=True):
        request = item["request"] | ({"method": "article"} if item["kind"] == "article-table" else {})
        alone = client.post(f"/v1/{path}", json=request)
        assert alone.status_code == 200
        assert line.partition(b'"result":')[2] == alone.content + b"}"


def test_items_have_thresholds(client: httpx.Client) -> None:
    asked = {"geometry": GEOMETRY, "l1": 27, "clearance": 25}
    pairs = {**asked, "l2": "25.7", "l3": "9.2", "tolerance": "0.001"}
    items = {"kind": "assembly-modes", "request": asked}, {"kind": "pose-connections", "request": pairs}
    modes, joined = results(client, submitted(client, lines(*items), NDJSON))
    assert modes["result"]["asked"]["clearance"] == "25"
    assert modes["result"]["change"] == "possible"
    assert joined["result"]["groups"] == [[1], [2], [3], [4]]
    assert [path["poses"] for path in joined["result"]["paths"]] == [[1, 3]]


def test_a_bad_item_is_a_problem_in_its_place(client: httpx.Client) -> None:
    flat = {**GEOMETRY, "d1": -1}
    items: list[Any] = [
        table(27, id="good"),
        {"id": "flat", "kind": "cusp-table", "request": {"geometry": flat, "l1": 27}},
        {"kind": "table", "request": {}},
        17,
        {**poses(15), "colour": "red"},
        table(27, id=4),
        {"kind": "cusp-table", "request": {"geometry": GEOMETRY, "l1": 1, "deadline_seconds": 4}},
        {"kind": "cusp-table", "request": {"geometry": GEOMETRY, "l1": 1, "digits": 10**6}},
    ]
    body = lines(*items) + '{"kind": "poses", "kind": "poses"}\n{"id": \n' + lines(poses(15, id="\ud800"))
    batch = submitted(client, body, NDJSON)
    assert (batch["progress"]["total"], batch["failed"]) == (11, 9)
    got = results(client, batch)
    assert [line["index"] for line in got] == list(range(11))
    assert [line["status"] for line in got] == ["succeeded", *["failed"] * 9, "succeeded"]
    assert [line["id"] for line in got] == ["good", "flat", *[None] * 8, "\ud800"]
    fields = [line["problem"]["errors"][0]["field"] for line in got[1:10]]
    assert fields == [
        "items[1].request.geometry.d1",
        "items[2].kind",
        "items[3]",
        "items[4].colour",
        "items[5].id",
        "items[6].request.deadline_seconds",
        "items[7].request.digits",
        "items[8].kind",
        "items[9]",
    ]
    types = [line["problem"]["type"].rpartition("/")[2] for line in got[1:10]]
    assert types == [*["invalid-request"] * 6, "limit-exceeded", "invalid-json", "invalid-json"]
    state = client.get(batch["links"]["self"]).json()
    assert (state["status"], state["done"], state["progress"]["done"]) == ("completed", True, 11)
    assert (state["succeeded"], state["failed"]) == (2, 9)
    assert state["created_at"] <= state["started_at"] <= state["ended_at"] < state["expires_at"]


def test_an_id_is_given_once(client: httpx.Client) -> None:
    items = [table(27, id="a"), {"id": "b", "kind": "poses", "request": {}}, table(27, id="a"), table(27)]
    got = results(client, submitted(client, lines(*items, table(27)), NDJSON))
    assert [line["status"] for line in got] == ["succeeded", "failed", "failed", "succeeded", "succeeded"]
    assert got[2]["id"] == "a"
    [error] = got[2]["problem"]["errors"]
    assert error["field"] == "items[2].id"
    assert "as of items[0]" in error["message"]


def test_results_as_one_array(client: httpx.Client) -> None:
    batch = submitted(client, lines(*[table(x) for x in (1, 2, 3)], {"kind": "poses", "request": {}}), NDJSON)
    expected = results(client, batch)
    url = batch["links"]["results"]
    for params, headers in (({"format": "json"}, {}), ({}, {"Accept": "application/json"})):
        answer = client.get(url, params=params, headers=headers)
        assert answer.headers["content-type"] == "application/json"
        assert answer.json() == expected
    assert client.get(url, params={"format": "json", "after": 2}).json() == expected[3:]
    assert client.get(url, params={"format": "json", "after": 3}).json() == []
    waited = client.get(url, params={"format": "json"}, headers={"Prefer": "wait=5"}).json()
    assert [line["index"] for line in waited] == [0, 1, 2, 3]
    assert client.get(url, params={"format": "csv"}).status_code == 422


def test_rows_of_every_kind(client: httpx.Client) -> None:
    head = f"\ufeffid,kind,{HEAD},fixed_leg,l1,l1_from,l1_to,l1_step,l2,l3,digits,max_cusps,sensitivities"
    rows = [
        f"a,,{ROW},,27;28.1,,,,,,20,",
        f"b,cusp-table,{ROW},,,26,28,1,,,20,",
        f"c,census,{ROW},1,,20,30,,,,20,,true",
        f'"d, e",check,{ROW},,,28,29,,,,,8',
        f"f,cusp-table,{ROW},2,,,,,17,,20,",
        "",
        f"g,cusp-table,{ROW},,,,,,,,,",
        f"h,poses,{ROW},,1,,,,2,,,",
    ]
    got = results(client, submitted(client, "\n".join([head, *rows]), CSV))
    assert [line["id"] for line in got] == ["a", "b", "c", "d, e", "f", "g", "h"]
    assert [line["status"] for line in got] == [*["succeeded"] * 5, "failed", "failed"]
    assert [line["kind"] for line in got[3:]] == ["check", "cusp-table", "cusp-table", "poses"]
    assert [part["l1"] for part in got[1]["result"]["slices"]] == ["26", "27", "28"]
    assert got[2]["result"]["range"] == {"from": "20", "to": "30"}
    assert got[2]["result"]["transitions"][0]["events"][0]["sensitivity"]["d1"]
    assert got[3]["result"]["passed"] is False
    assert [line["problem"]["errors"][0]["field"] for line in got[5:]] == [
        "items[5].request.l1",
        "items[6].request.l3",
    ]


@pytest.mark.parametrize(
    ("body", "headers", "slug"),
    [
        ('{"items": []}', {}, "invalid-request"),
        ("", NDJSON, "invalid-request"),
        (f"{HEAD},l1,l1\n", CSV, "invalid-request"),
        (f'{HEAD},l1\n{ROW},"1\n2"\n', CSV, "invalid-csv"),
        (b"a2x\xff\n", CSV, "invalid-csv"),
        ('{"items": [{},,{}]}', {}, "invalid-json"),
        ('{"items": [{}]', {}, "invalid-json"),
        ('{"items": [{}]} {}', {}, "invalid-json"),
        (lines(*[table(1)] * 6), NDJSON, "limit-exceeded"),
        (lines(table([1] * 1000)), NDJSON, "limit-exceeded"),
        (b" " * 5000, NDJSON, "body-too-large"),
        (lines(table(1)), {"Content-Type": "text/plain"}, "unsupported-media-type"),
        (lines(table(1)), {**NDJSON, "Content-Encoding": "gzip"}, "unsupported-media-type"),
        (lines(table(1)), {**NDJSON, "Idempotency-Key": "a key"}, "invalid-header"),
    ],
)
def test_what_is_refused_as_a_whole(
    idle: httpx.Client, idle_redis: Redis, body: str | bytes, headers: dict[str, str], slug: str
) -> None:
    headers = {"Content-Type": "application/json"} | headers
    answer = idle.post("/v1/batches", content=body, headers=headers)
    assert answer.json()["type"] == f"/problems/{slug}", answer.text
    assert 400 <= answer.status_code < 500
    assert idle_redis.keys("cusps:job*") == idle_redis.keys("cusps:submission:*") == []


def test_a_body_in_small_pieces(client: httpx.Client) -> None:
    items = [table(27, id='a "quoted" ]} \\ name'), poses(15, id="é")]
    body = json.dumps({"items": items}, ensure_ascii=False, indent=1).encode()
    pieces = (body[i : i + 7] for i in range(0, len(body), 7))
    answer = client.post("/v1/batches", content=pieces, headers={"Content-Type": "application/json"})
    assert [line["id"] for line in results(client, answer.json())] == ['a "quoted" ]} \\ name', "é"]


class Worker:
    """The test as a worker of a batch."""

    def __init__(self, redis: Redis, batch: dict[str, Any]) -> None:
        self.queue = JobQueue(redis)
        self.id, self.last = batch["id"], batch["progress"]["total"] - 1

    def answer(self, position: int) -> None:
        """Answers one item."""
        [ref] = [ref for ref in open_chunks(self.queue) if ref.job_id == self.id]
        attempts = Attempts(self.queue.redis, self.queue.settings)
        chunk = attempts.start(ref, 0, self.last)
        assert chunk is not None
        request = attempts.items(ref, chunk)[position].request
        assert request is not None
        solver = ItemSolver(self.queue.store)
        outcome = solver.solve(request)
        solver.keep()
        attempts.put_items(ref, -1, {position: outcome}, {})


def test_results_while_it_runs_and_after_its_end_for_some(idle: httpx.Client, idle_redis: Redis) -> None:
    batch = submitted(idle, [poses(x) for x in (15, 16, 17)])
    assert (batch["status"], batch["progress"]["done"], batch["expires_at"]) == ("queued", 0, None)
    assert results(idle, batch, "") == []
    worker = Worker(idle_redis, batch)
    worker.answer(1)
    state = idle.get(batch["links"]["self"])
    assert state.headers["retry-after"]
    assert (state.json()["status"], state.json()["succeeded"]) == ("running", 1)
    assert [line["index"] for line in results(idle, batch, "")] == [1]
    assert [line["index"] for line in results(idle, batch, "wait=0")] == []
    worker.answer(0)
    assert [line["index"] for line in results(idle, batch, "wait=0")] == [0, 1]
    assert [line["index"] for line in results(idle, batch, "", "?after=0")] == [1]
    problem(idle.get(batch["links"]["results"], headers={"Accept": "text/csv"}), 406, "not-acceptable")
    canceled = idle.delete(batch["links"]["self"]).json()
    assert (canceled["status"], canceled["succeeded"], canceled["canceled"]) == ("canceled", 2, 1)
    statuses = [line["status"] for line in results(idle, batch, "")]
    assert statuses == ["succeeded", "succeeded", "canceled"]


def test_a_reader_hears_of_the_end_however_long_it_would_pause(
    idle: httpx.Client, idle_redis: Redis, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("_PAUSE", "_LONGEST_PAUSE"):
        monkeypatch.setattr(batch_results, name, 10 * PATIENCE)
    batch = submitted(idle, [poses(15), poses(16)])
    worker = Worker(idle_redis, batch)
    worker.answer(0)
    prefer = {"Prefer": f"wait={2 * PATIENCE:.0f}"}
    with idle.stream("GET", batch["links"]["results"], headers=prefer) as answer:
        found = answer.iter_lines()
        assert json.loads(next(found))["index"] == 0
        worker.answer(1)
        assert [json.loads(line)["index"] for line in found] == [1]


def test_a_batch_is_canceled_for_all_by_the_operator_alone(idle: httpx.Client) -> None:
    batch = submitted(idle, [poses(15)])
    by_proxy = idle.delete(f"{batch['links']['self']}?force=true", headers={"X-Real-IP": "192.0.2.7"})
    problem(by_proxy, 403, "forbidden")
    assert idle.delete(f"{batch['links']['self']}?force=true").json()["status"] == "canceled"
    problem(idle.get(f"/v1/jobs/{batch['id']}/result"), 404, "not-found")
    problem(idle.get("/v1/batches/ba-0"), 404, "not-found")


def test_results_that_expired(client: httpx.Client, valkey: EmbeddedValkey) -> None:
    batch = submitted(client, [poses("15.5"), poses("15.25")])
    assert len(results(client, batch)) == 2
    with connect(valkey.url) as redis:
        queue = JobQueue(redis)
        [stored] = Batches(redis, queue.settings).read(batch["id"], [1])
        assert stored.item.request is not None
        redis.delete(queue.store.keys.document(stored.item.request.content_hash))
    first, second = results(client, batch, "")
    assert (first["status"], second["status"]) == ("succeeded", "failed")
    assert second["problem"]["type"] == "/problems/result-expired"


def test_events(client: httpx.Client) -> None:
    batch = submitted(client, [poses("15.75"), 1, poses("15.875")])
    with client.stream("GET", batch["links"]["events"]) as answer:
        text = "".join(answer.iter_text())
    events = [dict(line.split(": ", 1) for line in part.splitlines()) for part in text.strip().split("\n\n")]
    named = [(event["event"], json.loads(event["data"])) for event in events if "event" in event]
    assert [name for name, _ in named] == ["status", "status", "item", "item", "status"]
    assert named[2][1] == {"index": 0, "status": "succeeded", "progress": {"done": 2, "total": 3}}
    assert named[-1][1]["links"] == batch["links"]
    assert (named[-1][1]["status"], named[-1][1]["failed"]) == ("completed", 1)
    last = {"Last-Event-ID": events[-1]["id"]}
    assert client.get(batch["links"]["events"], headers=last).status_code == 204


def test_the_same_submission_is_one_batch(idle: httpx.Client, idle_redis: Redis) -> None:
    key = {**NDJSON, "Idempotency-Key": "7f9c2ba4"}
    first = submitted(idle, lines(poses(15)), key)
    assert submitted(idle, lines(poses(15)), key)["id"] == first["id"]
    assert submitted(idle, lines(poses(15)), {**NDJSON, "Idempotency-Key": "other"})["id"] != first["id"]
    again = idle.post("/v1/batches", content=lines(poses(16)), headers=key)
    assert problem(again, 422, "idempotency-key-reused")["errors"][0]["field"] == "Idempotency-Key"
    [name] = [
        x for x in idle_redis.keys("cusps:submission:*") if idle_redis.hget(x, "job") == first["id"].encode()
    ]
    assert idle_redis.ttl(name) > 86000


def test_a_submission_that_is_still_received(idle: httpx.Client, idle_redis: Redis) -> None:
    key = {**NDJSON, "Idempotency-Key": "slow"}

    def body() -> Iterator[bytes]:
        yield lines(poses(15)).encode()
        until(lambda: idle_redis.keys("cusps:submission:*"))
        answer = idle.post("/v1/batches", content=lines(poses(15)), headers=key)
        problem(answer, 409, "submission-in-progress")
        assert int(answer.headers["retry-after"]) >= 1
        yield lines(poses(16)).encode()

    answer = idle.post("/v1/batches", content=body(), headers=key)
    assert (answer.status_code, answer.json()["progress"]["total"]) == (202, 2)


def test_a_replay_says_that_it_is_one(idle: httpx.Client) -> None:
    key = {**NDJSON, "Idempotency-Key": "sent-twice"}
    answers = [idle.post("/v1/batches", content=lines(poses(15)), headers=key) for _ in range(2)]
    assert [answer.headers.get("idempotent-replayed") for answer in answers] == [None, "true"]


def test_another_process_serves_the_batch(valkey: EmbeddedValkey, idle_redis: Redis) -> None:
    settings = Settings(redis_url=f"{valkey.url}?db=2")
    key = {**NDJSON, "Idempotency-Key": "before-and-after"}
    with serving(settings) as base, httpx.Client(base_url=base) as client:
        batch = submitted(client, lines(poses(15)), key)
    Worker(idle_redis, batch).answer(0)
    with serving(settings) as base, httpx.Client(base_url=base) as client:
        assert submitted(client, lines(poses(15)), key)["status"] == "completed"
        assert [line["status"] for line in results(client, batch)] == ["succeeded"]


def test_a_full_queue(valkey: EmbeddedValkey, idle_redis: Redis, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RPR_CUSPS_MAX_BACKLOG_SECONDS", "0.001")
    with serving(Settings(redis_url=f"{valkey.url}?db=2")) as base, httpx.Client(base_url=base) as client:
        submitted(client, [poses(15)])
        before = set(idle_redis.keys("*"))
        answer = client.post("/v1/batches", json=[poses(16)], headers={"Idempotency-Key": "full"})
        problem(answer, 503, "queue-full")
        assert int(answer.headers["retry-after"]) >= 1
        assert set(idle_redis.keys("*")) <= before
        alone = client.post("/v1/poses", json=poses(16)["request"], headers={"Prefer": "wait=0"})
        assert alone.status_code == 202  # its lane is not that of batches


def test_a_refused_submission_leaves_its_key(idle: httpx.Client) -> None:
    key = {**NDJSON, "Idempotency-Key": "again"}
    problem(idle.post("/v1/batches", content=lines(*[poses(15)] * 6), headers=key), 422, "limit-exceeded")
    assert submitted(idle, lines(poses(15)), key)["progress"]["total"] == 1


MANY = lines(*(poses(20 + i % 30) for i in range(700)))
"""More items than are pushed together."""


def test_nobody_sees_a_batch_until_it_is_whole(client: httpx.Client, redis: Redis) -> None:
    """If its client leaves before, nothing stays of it."""

    def body() -> Iterator[bytes]:
        yield MANY.encode()
        until(lambda: redis.keys("cusps:job*:ba-*:items"))
        raise KeyError

    before = set(redis.keys("cusps:job*:ba-*"))
    with pytest.raises(KeyError), httpx.Client(base_url=client.base_url) as other:
        other.post("/v1/batches", content=body(), headers=NDJSON)
    until(lambda: set(redis.keys("cusps:job*:ba-*")) <= before)


def test_a_batch_of_many_items_comes_in_order(client: httpx.Client) -> None:
    sent = MANY + lines(poses(15), {"kind": "poses"})
    batch = client.post("/v1/batches", content=sent, headers=NDJSON).json()
    assert (batch["progress"]["total"], batch["failed"]) == (702, 1)
    found = results(client, batch)
    assert [line["index"] for line in found] == list(range(702))
    assert [line["index"] for line in found if line["status"] != "succeeded"] == [701]
    assert found[0]["result"] == found[30]["result"]
