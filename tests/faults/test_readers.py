"""Many, slow or disconnected readers of large results and of events."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager

import httpx
import pytest
from redis import Redis

from benchmarks import readers
from benchmarks import stack as benchmark
from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.large_table import keep_table, run_job
from tests.support.processes import PATIENCE, until
from tests.support.service_server import serving
from worker.jobs.queue import JobQueue

MANY = 400  # slices: more than the buffers of a connection take


@contextmanager
def api(url: str, **settings: float) -> Iterator[httpx.Client]:
    with serving(Settings(redis_url=url, **settings)) as base, httpx.Client(base_url=base) as client:  # type: ignore[arg-type]
        client.headers["Accept-Encoding"] = "identity"
        client.timeout = httpx.Timeout(PATIENCE)
        yield client


def silent(client: httpx.Client, path: str) -> socket.socket:
    """A client that asks, and reads only the beginning of the answer."""
    host, port = client.base_url.host, client.base_url.port
    connection = socket.create_connection((host, port or 80), timeout=PATIENCE)
    connection.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    assert connection.recv(15) == b"HTTP/1.1 200 OK"
    return connection


@pytest.mark.parametrize("form", ["application/json"])
def test_a_result_expires_while_it_is_sent(valkey: EmbeddedValkey, redis: Redis, form: str) -> None:
    """A result expires while it is being sent. The connection is closed before the end, so that truncation is
    visible to the client; after that the result is 410.
    """
    queue = JobQueue(redis)
    job_id, table = keep_table(queue, MANY)
    record = queue.records.request(job_id)
    assert record is not None
    path = f"/v1/jobs/{job_id}/result"
    with api(valkey.url) as client:
        with client.stream("GET", path, headers={"Accept": form}) as answer:
            assert answer.status_code == 200
            pieces = answer.iter_raw()
            next(pieces)
            keys = queue.store.slice_keys(record[1], [part["l1"] for part in table["slices"]])
            redis.delete(*keys[MANY // 2 :])
            with pytest.raises(httpx.RemoteProtocolError):
                list(pieces)
        assert client.get(path).status_code == 410


def test_too_many_large_results_at_once(valkey: EmbeddedValkey, redis: Redis) -> None:
    """More large results are requested at once than allowed. A request beyond the limit gets 503 with
    Retry-After; when another ends, the next is sent.
    """
    job_id, _ = keep_table(JobQueue(redis), MANY)
    path = f"/v1/jobs/{job_id}/result"
    with api(valkey.url, large_answers=2) as client:
        with ExitStack() as readers:
            for _ in range(2):
                readers.enter_context(closing(silent(client, path)))
            refused = client.get(path)
            assert (refused.status_code, refused.json()["type"]) == (503, "/problems/busy")
            assert int(refused.headers["retry-after"]) >= 1
            assert client.get(f"/v1/jobs/{job_id}").status_code == 200
        until(lambda: client.get(path).status_code == 200)


def test_a_reader_that_stops_reading(valkey: EmbeddedValkey, redis: Redis) -> None:
    """A client requests a large result and does not read it. Its connection is closed, and its place is
    free."""
    job_id, _ = keep_table(JobQueue(redis), MANY)
    path = f"/v1/jobs/{job_id}/result"
    with api(valkey.url, large_answers=1, stall_seconds=0.5) as client, closing(silent(client, path)):
        assert client.get(path).status_code == 503
        until(lambda: client.get(path).status_code == 200)


def calls(redis: Redis, command: str) -> int:
    """How often a command was called so far."""
    stats: dict[str, dict[str, int]] = redis.info("commandstats")  # type: ignore[assignment]
    return stats.get(f"cmdstat_{command}", {"calls": 0})["calls"]


def readers_of_events(redis: Redis) -> int:
    """How many connections wait for events; one that has waited still names its last command."""
    return sum(client["cmd"] == "xread" and "b" in client["flags"] for client in redis.client_list())


def events_of(client: httpx.Client, job_id: str) -> list[str]:
    """Follow a job to its end; returns the ids of the events."""
    with client.stream("GET", f"/v1/jobs/{job_id}/events") as stream:
        return [line for line in stream.iter_lines() if line.startswith("id: ")]


def test_many_follow_one_job(valkey: EmbeddedValkey, redis: Redis) -> None:
    """Forty clients follow one job, and one of them reads only after its end. All get every event, but
    Redis is read once for all.
    """
    queue = JobQueue(redis)
    slices, followers = 60, 40
    work = run_job(queue, slices)
    job_id = next(work)
    with api(valkey.url, redis_timeout_seconds=20) as client, ThreadPoolExecutor(followers) as pool:
        before = calls(redis, "xrange")
        late = silent(client, f"/v1/jobs/{job_id}/events")
        follows = [pool.submit(events_of, client, job_id) for _ in range(followers - 1)]
        until(lambda: readers_of_events(redis) == 1)
        for _ in work:
            assert readers_of_events(redis) <= 1
        [ids] = {tuple(follow.result(PATIENCE)) for follow in follows}
        assert len(ids) == slices + 3  # queued, running, the slices, succeeded
        assert calls(redis, "xrange") - before < 4 * slices
        with closing(late):
            text = b""
            while b'"succeeded"' not in text:
                text += late.recv(1 << 20)
        assert text.count(b"\nid: ") == len(ids)


@pytest.mark.long
def test_two_hundred_follow_one_job(valkey: EmbeddedValkey, redis: Redis) -> None:
    """Two hundred clients follow one job of 200 slices. All get every event, and the memory of the API grows
    by less than 100 MiB meanwhile.
    """
    queue, count = JobQueue(redis), 200
    with benchmark.serving("--workers", "0", "--redis-url", valkey.url) as api:
        rest = readers.memory(api.pid)
        job_id, run = readers.running_job(queue, count, 300)
        clients = readers.Readers(api.port, f"/v1/jobs/{job_id}/events", count)
        with closing(clients):
            threads = clients.read()
            until(lambda: readers_of_events(redis) == 1)
            work = threading.Thread(target=run)
            work.start()
            highest = readers.peak(api.pid, lambda: not any(thread.is_alive() for thread in threads))
            for thread in (work, *threads):
                thread.join(PATIENCE)
        assert len(clients.done) == count
        assert min(clients.done) > 0.95 * max(clients.done) > 1 << 20
        assert highest - rest < 100, f"{rest:.0f} MiB at rest, {highest:.0f} MiB at most"


def test_followers_leave(valkey: EmbeddedValkey, redis: Redis, caplog: pytest.LogCaptureFixture) -> None:
    """Clients disconnect in the middle of a stream of events. The stream ends without a line in the log."""
    *_, job_id = run_job(JobQueue(redis), 60)
    with api(valkey.url) as client:
        for _ in range(5):
            with closing(silent(client, f"/v1/jobs/{job_id}/events")) as follower:
                follower.recv(300)
        until(lambda: readers_of_events(redis) == 0)
        until(lambda: client.get("/healthz").status_code == 200)
    assert not [record for record in caplog.records if record.name == "asyncio"]


def test_too_many_followers(valkey: EmbeddedValkey, redis: Redis) -> None:
    """More clients follow events than allowed. A request beyond the limit gets 503 with Retry-After."""
    job_id = next(run_job(JobQueue(redis), 1))
    path = f"/v1/jobs/{job_id}/events"
    with api(valkey.url, max_followers=2) as client, ExitStack() as followers:
        for _ in range(2):
            followers.enter_context(closing(silent(client, path)))
        refused = client.get(path)
        assert (refused.status_code, refused.json()["type"]) == (503, "/problems/busy")
        assert int(refused.headers["retry-after"]) >= 1
