"""Answers that the API keeps for a while."""

from __future__ import annotations

from collections.abc import Iterator

import httpx
import pytest
from redis import Redis

from service.api.context import KeptAnswers
from service.api.settings import Settings
from service.schemas.limits import Limits
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
        result = client.get(link)
        redis.config_resetstat()
        again = client.post(path, json=body)
        calls = {name for name, _ in redis.info("commandstats").items()}
        assert not {"cmdstat_mget", "cmdstat_get"} & calls
        assert again.content == first.content == result.content == client.get(link).content
        for name in ("etag", "content-location", "cache-control", "content-type", "vary"):
            assert again.headers[name] == first.headers[name], name
        tag = {"If-None-Match": result.headers["etag"]}
        assert client.get(link, headers=tag).status_code == 304
        assert client.get(link, headers={"Accept": "image/png"}).status_code == 406


def test_repeated_questions_are_counted_and_limited(valkey: EmbeddedValkey, workers: Workers) -> None:
    workers.start()
    limits = Limits(max_requests_per_minute=5)
    settings = Settings(redis_url=valkey.url, limits=limits)
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
