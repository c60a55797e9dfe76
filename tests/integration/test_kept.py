"""Answers that the API keeps for a while."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator

import httpx
import pytest
from redis import Redis
from starlette.types import Message, Receive, Scope, Send

from service.api.answer import Asked, question_in
from service.api.context import KeptAnswers, Repeats, note_kept
from service.api.settings import Settings
from service.client import ServiceClient
from service.errors import ServiceError
from service.schemas.limits import Limits
from service.schemas.questions import Question
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, Workers
from tests.support.service_server import GEOMETRY, serving

TABLE = {"geometry": GEOMETRY, "l1": "14.98", "digits": 20}
POSES = {"geometry": GEOMETRY, "l1": "14.98", "l2": "16", "l3": "30"}


def test_the_latest_answers_are_kept_within_their_memory() -> None:
    kept = KeptAnswers(5000, 60)
    for name in "abc":
        kept.put(name, "json", "digest", bytes(1000))
    assert kept.get("a", "json") is not None
    kept.put("d", "json", "digest", bytes(1000))
    assert [name for name in "abcd" if kept.get(name, "json")] == ["a", "c", "d"]
    kept.put("d", "json", "other", bytes(2000))
    found = kept.get("d", "json")
    assert found is not None
    assert (found.digest, len(found.body)) == ("other", 2000)
    assert kept.get("d", "csv") is None
    kept.put("e", "json", "digest", bytes(1 << 20))
    assert kept.get("e", "json") is None, "too large"
    nothing = KeptAnswers(0, 60)
    nothing.put("a", "json", "digest", b"")
    assert nothing.get("a", "json") is None


def test_an_answer_is_kept_for_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr("service.api.context.time.monotonic", lambda: now)
    kept = KeptAnswers(5000, 60)
    kept.put("a", "json", "digest", b"{}")
    now = 59.0
    assert kept.get("a", "json") is not None
    now = 61.0
    assert kept.get("a", "json") is None


def asked_in_turn(*questions: tuple[str, bytes]) -> list[str]:
    """Returns which questions reach the application."""
    reached: list[str] = []
    answers = KeptAnswers(5000, 60)

    async def application(scope: Scope, receive: Receive, send: Send) -> None:
        body = (await receive())["body"]
        reached.append(body.decode())
        job_id = "po-" + body.hex()
        if answers.get(job_id, "json") is None:
            answers.put(job_id, "json", "digest", body)
        kept = answers.get(job_id, "json")
        assert kept is not None
        note_kept(scope, kept)
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": body})

    async def ask(layer: Repeats, path: str, body: bytes) -> None:
        async def receive() -> Message:
            return {"type": "http.request", "body": body}

        async def send(message: Message) -> None:
            assert message.get("body", body) == body

        size = [(b"content-length", str(len(body)).encode())]
        scope = {"type": "http", "method": "POST", "path": path, "query_string": b"", "headers": size}
        await layer(scope, receive, send)

    async def run() -> None:
        layer = Repeats(application, answers, lambda *_: None)
        for path, body in questions:
            await ask(layer, path, body)

    asyncio.run(run())
    return reached


def test_the_same_words_elsewhere_are_another_question() -> None:
    assert asked_in_turn(("/a", b"1"), ("/a", b"1"), ("/b", b"1"), ("/a", b"2")) == ["1", "1", "2"]


def test_a_long_question_is_read_each_time() -> None:
    assert len(asked_in_turn(*[("/a", bytes(1024))] * 3)) == 1
    assert len(asked_in_turn(*[("/a", bytes(1025))] * 3)) == 3


def test_the_questions_not_asked_for_the_longest_time_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("service.api.context._MOST_QUESTIONS", 2)
    words = [("/a", word) for word in (b"1", b"2", b"1", b"3", b"1", b"2")]
    assert asked_in_turn(*words) == ["1", "2", "3", "2"]


@pytest.fixture
def client(valkey: EmbeddedValkey, workers: Workers) -> Iterator[httpx.Client]:
    workers.start()
    with (
        serving(Settings(redis_url=valkey.url)) as url,
        httpx.Client(base_url=url, timeout=PATIENCE, headers={"Prefer": "wait=30"}) as client,
    ):
        yield client


def test_a_kept_answer_needs_no_redis_and_is_the_same(client: httpx.Client, redis: Redis) -> None:
    for path, body in (("/v1/cusp-tables", TABLE), ("/v1/poses", POSES)):
        first = client.post(path, json=body)
        link = first.headers["content-location"]
        result, floats = client.get(link), client.get(link, params={"numbers": "float"})
        redis.config_resetstat()
        again = client.post(path, json=body)
        calls = {name for name, _ in redis.info("commandstats").items()}
        assert not {"cmdstat_mget", "cmdstat_get"} & calls
        assert again.content == first.content == result.content == client.get(link).content
        for name in ("etag", "content-location", "cache-control", "content-type", "vary"):
            assert again.headers[name] == first.headers[name], name
        assert client.get(link, params={"numbers": "float"}).content == floats.content != first.content
        tag = {"If-None-Match": result.headers["etag"]}
        assert client.get(link, headers=tag).status_code == 304
        assert client.get(link, headers={"Accept": "image/png"}).status_code == 406


@pytest.fixture
def readings(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """The bodies that the API reads as questions."""
    found: list[bytes] = []

    def read(model: type[Question], body: bytes, limits: Limits) -> Asked:
        found.append(body)
        return question_in(model, body, limits)

    monkeypatch.setattr("service.api.answer.question_in", read)
    return found


def test_a_question_in_the_same_words_is_not_read_again(readings: list[bytes], client: httpx.Client) -> None:
    first, _, again = (client.post("/v1/poses", json=POSES) for _ in range(3))
    assert len(readings) == 2, "the second time it was noted that the answer is kept"
    assert again.content == first.content
    varying = ("x-request-id", "date", "preference-applied", "content-length", "content-encoding")
    assert {name: value for name, value in again.headers.items() if name not in varying} == {
        name: value for name, value in first.headers.items() if name not in varying
    }
    assert again.headers["x-request-id"] != first.headers["x-request-id"]
    assert client.post("/v1/poses", json={**POSES, "digits": 20}).json()["digits"] == 20
    assert client.post("/v1/poses", json=POSES, params={"numbers": "float"}).json() != first.json()
    assert client.post("/v1/poses", json=POSES, headers={"Accept": "image/png"}).status_code == 406
    plain = {"Content-Type": "text/plain"}
    body = again.request.content
    assert client.post("/v1/poses", content=body, headers=plain).status_code == 415
    assert client.post("/v1/cusp-tables", content=body).status_code == 415
    json_type = {"Content-Type": "application/json"}
    assert client.post("/v1/cusp-tables", content=body, headers=json_type).status_code == 422
    in_pieces = client.post("/v1/poses", content=iter((body[:10], body[10:])), headers=json_type)
    assert in_pieces.content == first.content


def test_repeated_questions_are_counted_and_limited(valkey: EmbeddedValkey, workers: Workers) -> None:
    workers.start()
    limits = Limits(max_requests_per_minute=5)
    settings = Settings(redis_url=valkey.url, trusted_proxies="127.0.0.1", limits=limits)
    other = {"X-Forwarded-For": "192.0.2.1", "Prefer": "wait=30"}
    with serving(settings) as url, httpx.Client(base_url=url, timeout=PATIENCE, headers=other) as client:
        statuses = [client.post("/v1/poses", json=POSES).status_code for _ in range(7)]
        assert statuses[:4] == [200] * 4
        assert statuses[-1] == 429
        metrics = httpx.get(f"{url}/metrics").text
    assert (
        f'rpr_cusps_answers_total{{answer="cached",kind="poses"}} {float(statuses.count(200) - 1)}' in metrics
    )
    assert f'route="/v1/poses",status="200"}} {float(statuses.count(200))}' in metrics


def test_keys_are_asked_for_before_what_is_kept(
    valkey: EmbeddedValkey, client: httpx.Client, redis: Redis
) -> None:
    del redis
    first = client.post("/v1/poses", json=POSES)
    settings = Settings(redis_url=valkey.url, require_keys="always")
    with serving(settings) as url, httpx.Client(base_url=url, timeout=PATIENCE) as other:
        assert [other.post("/v1/poses", json=POSES).status_code for _ in range(3)] == [401] * 3
        assert other.get(first.headers["content-location"]).status_code == 401


def test_an_answer_is_pinned_over_http(client: httpx.Client, redis: Redis) -> None:
    first = client.post("/v1/poses", json=POSES)
    job = first.headers["content-location"].split("/")[3]
    with ServiceClient(str(client.base_url)) as service:
        pinned = service.pin(job)
        assert pinned == {"id": job, "pinned": True, "links": {"result": f"/v1/jobs/{job}/result"}}
        for key in redis.keys("cusps:*"):
            if redis.ttl(key) >= 0:
                redis.delete(key)
        assert client.get(pinned["links"]["result"]).content == first.content
        assert service.pin(job, remove=True)["pinned"] is False
        for unknown in (job, "po-" + 40 * "0"):
            with pytest.raises(ServiceError, match="no pinned answer"):
                service.pin(unknown, remove=True)
