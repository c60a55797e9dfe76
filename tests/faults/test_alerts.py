"""The causes of the alerts of docs/runbook.md, and what ends them."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from prometheus_client.parser import text_string_to_metric_families
from redis import Redis

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_document, a_request
from tests.support.processes import PATIENCE, Workers, completed, environment, stopped, until
from tests.support.service_server import GEOMETRY, serving
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings


@pytest.fixture
def api(valkey: EmbeddedValkey, redis: Redis) -> Iterator[httpx.Client]:  # noqa: ARG001
    with (
        serving(Settings(redis_url=valkey.url, redis_timeout_seconds=0.5)) as url,
        httpx.Client(base_url=url, timeout=PATIENCE) as client,
    ):
        yield client


def metric(api: httpx.Client, name: str, **labels: str) -> float | None:
    """The largest value of a metric with these labels, as Prometheus reads it."""
    found = [
        sample.value
        for family in text_string_to_metric_families(api.get("/metrics").text)
        for sample in family.samples
        if sample.name == f"rpr_cusps_{name}" and labels.items() <= sample.labels.items()
    ]
    return max(found, default=None)


def ask(api: httpx.Client, l1: str, **headers: str) -> httpx.Response:
    return api.post("/v1/cusp-tables", json={"geometry": GEOMETRY, "l1": l1, "digits": 15}, headers=headers)


def ready(api: httpx.Client) -> Any:
    return api.get("/readyz").json()


def test_redis_cannot_be_reached(api: httpx.Client, valkey: EmbeddedValkey) -> None:
    """Redis does not answer: `RedisUnreachable`, `ServerErrors`. Requests get 503 until it is there again."""
    assert metric(api, "up") == 1
    with stopped(valkey.pid):
        assert metric(api, "up") == 0
        assert metric(api, "queue_depth") is None
        assert ask(api, "3").status_code == 503
        assert (metric(api, "http_requests_total", status="503") or 0) >= 1
    until(lambda: metric(api, "up") == 1)


def test_no_worker_is_alive(api: httpx.Client, workers: Workers) -> None:
    """No worker is started: `NoWorkers`, `SmallJobsWait`, `QueueLong`. What waits is computed when one is
    started."""
    assert metric(api, "workers") == 0
    job = ask(api, "3", Prefer="respond-async").json()
    assert metric(api, "queue_depth", lane="small") == 1
    assert until(lambda: (metric(api, "queue_age_seconds", lane="small") or 0) > 0.5)
    assert ready(api)["status"] != "ready"
    workers.start()
    until(lambda: api.get(job["links"]["self"]).json()["status"] == "succeeded")
    assert metric(api, "workers") == 1
    assert metric(api, "queue_depth", lane="small") == 0
    assert ready(api)["status"] == "ready"


def test_redis_is_full(api: httpx.Client, redis: Redis, workers: Workers) -> None:
    """Redis has no room: `RedisFull`. New jobs get 503 until `maxmemory` is raised."""
    workers.start()
    [(_, before)] = redis.config_get("maxmemory").items()
    try:
        redis.config_set("maxmemory", 1_000_000)
        share = (metric(api, "redis_memory_bytes") or 0) / (metric(api, "redis_memory_limit_bytes") or 1)
        assert share > 0.95
        assert ask(api, "4").status_code == 503
    finally:
        redis.config_set("maxmemory", before)
    assert until(lambda: ask(api, "4", Prefer="wait=30").status_code == 200)


def test_chunks_are_lost_and_a_job_fails(api: httpx.Client, redis: Redis, workers: Workers) -> None:
    """The work horse of a job dies each time: `ChunksLost`, `JobsFail`. `rpr-cusps jobs --all` and the log
    name the job."""
    task = "tests.support.hard_tasks.killed"
    workers.start(task=task, log_level="INFO")
    view = JobQueue(redis, WorkerSettings(task=task)).submit(a_document())
    until(lambda: metric(api, "job_failures_total", reason="worker-crashed") == 1)
    assert metric(api, "chunks_lost_total", what="horse") == 3
    command = [sys.executable, "-m", "service", "jobs", "--all", "--url", str(api.base_url)]
    shown = completed(command, environment())
    assert view.id in shown.stdout
    assert re.search(rf" job={view.id}", workers.log.read_text())


def test_a_question_takes_longer_than_estimated(api: httpx.Client, redis: Redis, workers: Workers) -> None:
    """A question in the lane of small ones takes many times its estimate: `JobsDemoted`. It is heavy from
    then on, and the log of the worker names the job."""
    task = "tests.support.hard_tasks.endless"
    workers.start("light", task=task)
    queue = JobQueue(redis, WorkerSettings(task=task))
    view = queue.submit(a_request("3"))
    until(lambda: metric(api, "jobs_demoted_total", kind="cusp-table") == 1)
    assert metric(api, "queue_depth", lane="heavy") == 1
    assert re.search(rf"{view.id} takes longer than estimated", workers.log.read_text())
    queue.cancel(view.id)


def test_the_key_of_prometheus_has_not_the_scope(
    api: httpx.Client, valkey: EmbeddedValkey, redis: Redis, tmp_path: Path
) -> None:
    """The key of Prometheus is wrong: `NotScraped`. One with the scope `admin` is accepted."""
    keys = [sys.executable, "-m", "service", "keys", "create", "--redis-url", valkey.url]
    made = [
        completed([*keys, name, "--scope", scope], environment(), cwd=tmp_path).stdout.split()[-1]
        for name, scope in (("client", "submit"), ("prometheus", "admin"))
    ]
    until(lambda: scraped(api, "rpr_nothing") == 401)
    answers = [scraped(api, key) for key in made]
    redis.flushall()  # other tests of this server have no keys
    assert answers == [403, 200]


def scraped(api: httpx.Client, key: str) -> int:
    return api.get("/metrics", headers={"Authorization": f"Bearer {key}"}).status_code
