"""Batches, when items, work horses, workers or the API fail."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import pytest
from redis import Redis

from tests.support.jobs import a_document, a_request, a_slice_of_curves, ended, read_batch, submit_batch
from tests.support.processes import PATIENCE, Workers, descendants, until
from tests.support.service_server import GEOMETRY
from tests.support.stack import Stack, running
from worker.answers.kinds import Item
from worker.jobs.batches import INTAKE_TTL
from worker.jobs.plan import Keys
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

SHORT = {"beat_interval": 0.2, "beat_ttl": 2, "sweep_interval": 0.2, "lost_grace": 0.2}


def jobs(redis: Redis, task: str = "", **settings: object) -> JobQueue:
    """The queue as an API process sees it; with `task`, its chunks run one of the hard tasks."""
    name = f"tests.support.hard_tasks.{task}" if task else "worker.process.tasks.run_chunk"
    return JobQueue(redis, WorkerSettings.model_validate({"task": name, **settings}))


def tables(*l1: str) -> list[Item]:
    return [Item(request=a_request(x)) for x in l1]


@pytest.mark.parametrize(
    ("task", "reason"),
    [
        ("crash", "worker-crashed"),
        ("leave", "worker-crashed"),
        ("greedy", "resource-exhausted"),
        ("greedy_python", "resource-exhausted"),
    ],
)
def test_an_item_whose_horse_dies_each_time(redis: Redis, workers: Workers, task: str, reason: str) -> None:
    """The work horse of one item crashes, leaves or runs out of memory at every attempt. That item fails; the
    others of its chunk are answered.
    """
    queue = jobs(redis, task)
    workers.start(task=queue.settings.task, memory_limit_mb=1024, max_losses=1, log_level="CRITICAL")
    view = ended(queue, submit_batch(queue, tables("1", "13", "2")).id)
    assert (view.status, view.done, view.failed) == ("succeeded", 3, 1)
    assert [stored.state for stored in read_batch(queue, view)] == ["succeeded", "failed", "succeeded"]
    failure = read_batch(queue, view)[1].outcome.failure
    assert failure is not None
    assert failure["type"] == reason


def test_an_item_that_never_ends(redis: Redis, workers: Workers) -> None:
    """An item hangs in C code. Its work horse ends at the deadline, and again after a whole deadline for the
    item; then the item fails, and the others are answered.
    """
    queue = jobs(redis, "endless_at_13")
    workers.start(task=queue.settings.task, deadline_seconds=0.7, log_level="CRITICAL")
    view = ended(queue, submit_batch(queue, tables("1", "13", "2")).id)
    assert (view.status, view.failed) == ("succeeded", 1)
    failure = read_batch(queue, view)[1].outcome.failure
    assert failure is not None
    assert failure["type"] == "timeout"
    assert view.started_at is not None
    assert view.ended_at is not None
    seconds = datetime.fromisoformat(view.ended_at) - datetime.fromisoformat(view.started_at)
    assert seconds.total_seconds() > 1.3


@pytest.mark.long
def test_the_worker_of_a_batch_is_killed(redis: Redis, workers: Workers) -> None:
    """The worker of a batch is killed. Another worker continues with the item that was being processed."""
    queue = jobs(redis, "slow")
    first = workers.start(task=queue.settings.task, **SHORT)
    view = submit_batch(queue, tables(*map(str, range(1, 13))))
    until(lambda: sum(stored.state == "succeeded" for stored in read_batch(queue, view)) >= 3)
    first.kill()
    first.wait(PATIENCE)
    workers.start(task=queue.settings.task, **SHORT)
    view = ended(queue, view.id)
    assert (view.status, view.done, view.failed) == ("succeeded", 12, 0)
    pids = [queue.store.get_slices(a_request(str(x)))[str(x)]["certificate"]["pid"] for x in range(1, 13)]
    assert len(set(pids)) == 2
    assert pids == sorted(pids, key=pids.index)


def test_redis_loses_the_items_of_a_batch(redis: Redis, workers: Workers) -> None:
    """Redis loses the items of a batch that waits. The batch fails with the reason, and the worker
    continues."""
    queue = jobs(redis)
    view = submit_batch(queue, tables("1", "2"))
    redis.delete(queue.records.keys.job(view.id).items)
    workers.start()
    view = ended(queue, view.id)
    assert view.status == "failed"
    assert view.error is not None
    assert view.error["type"] == "worker-lost"
    assert ended(queue, submit_batch(queue, [Item(request=a_document())]).id).status == "succeeded"


def test_batches_with_the_same_questions(redis: Redis, workers: Workers) -> None:
    """Three batches and a job ask the same at the same time, of a manipulator that was asked for before. One
    eliminates and keeps the coefficients, and the others use them.
    """
    for _ in range(2):
        workers.start(beat_ttl=1000)  # a computer may be so busy that a lock would end before its renewal
    queue = jobs(redis, "counted")
    ended(queue, queue.submit(a_request("15")).id)  # for the first few slices nobody keeps the coefficients
    assert redis.get("eliminations") is None
    items = [*tables("14.98", "27"), Item(request=a_document())]
    views = [submit_batch(queue, items) for _ in range(3)]
    ended(queue, queue.submit(a_request("27", "14.98")).id)
    for view in views:
        assert ended(queue, view.id).status == "succeeded"
    assert redis.get("eliminations") == b"1"


def test_a_batch_and_a_job_with_the_same_document(redis: Redis, workers: Workers) -> None:
    """A batch and a job ask for the same document at the same time, of more than 20 ms by its estimate. One
    worker computes it, and the other waits for it.
    """
    queue = jobs(redis, "gated")
    for _ in range(2):
        workers.start(task=queue.settings.task)
    batch = submit_batch(queue, [Item(request=a_slice_of_curves())])
    until(lambda: redis.llen("begun") == 1)
    job = queue.submit(a_slice_of_curves())
    until(lambda: (view := queue.get(job.id)) is not None and view.status == "running")
    redis.set("gate", 1)
    assert {ended(queue, view.id).status for view in (batch, job)} == {"succeeded"}
    assert redis.llen("begun") == 1


def test_a_document_whose_horse_dies_is_not_waited_for(redis: Redis, workers: Workers) -> None:
    """The work horse that computes a document of a job crashes each time. Its lock ends with it: no attempt
    waits for the previous one, and the job fails with the reason.
    """
    queue = jobs(redis, "crash")
    workers.start(task=queue.settings.task, max_losses=1, beat_ttl=1000, log_level="CRITICAL")
    view = ended(queue, queue.submit(a_document()).id)
    assert view.status == "failed"
    assert view.error is not None
    assert view.error["type"] == "worker-crashed"


def small_items(count: int) -> Iterator[bytes]:
    """Questions that take milliseconds, none twice: slices and poses of one manipulator."""
    for i in range(count):
        request = {"geometry": GEOMETRY, "digits": 15, "l1": f"{20 + i / 1000:.3f}"}
        if i % 2:
            request |= {"l2": "17", "l3": "21"}
        item = {"id": str(i), "kind": "poses" if i % 2 else "cusp-table", "request": request}
        yield json.dumps(item).encode() + b"\n"


def largest(pid: int) -> int:
    """The largest resident memory of a process so far, in KiB; 0 if it is gone."""
    try:
        [line] = [x for x in Path(f"/proc/{pid}/status").read_text().splitlines() if x.startswith("VmHWM")]
    except (OSError, ValueError):
        return 0
    return int(line.split()[1])


class Reader:
    """Reads the results of a batch as they come, and goes on where it stopped when the API is gone.

    `acts`: number of results → what to do as soon as so many are there.
    """

    def __init__(
        self, client: httpx.Client, batch: dict[str, Any], acts: dict[int, Callable[[], None]]
    ) -> None:
        self.client = client
        self.batch = batch
        self.acts = acts
        self.received: list[int] = []
        self.breaks = 0

    def read(self) -> None:
        """Read all."""
        while len(self.received) < self.batch["progress"]["total"]:
            try:
                self._read()
            except httpx.TransportError:
                self.breaks += 1
                time.sleep(0.1)

    def _read(self) -> None:
        path = f"{self.batch['links']['results']}?after={len(self.received) - 1}"
        with self.client.stream("GET", path, headers={"Prefer": "wait=20"}) as answer:
            assert answer.status_code == 200
            for line in answer.iter_lines():
                result = json.loads(line)
                assert result["status"] == "succeeded"
                assert result["id"] == str(result["index"])
                self.received.append(result["index"])
                self.acts.get(len(self.received), lambda: None)()


def kill(stack: Stack, part: str) -> None:
    """Kill a child of the supervisor, and wait for another in its place."""
    pid = stack.part(part)
    os.kill(pid, signal.SIGKILL)
    until(lambda: part_of(stack, part) not in (None, pid))


def part_of(stack: Stack, part: str) -> int | None:
    try:
        return stack.part(part)
    except ValueError:
        return None


def test_the_api_is_killed_while_it_receives_a_batch(tmp_path: Path) -> None:
    """The API is killed while it receives a batch of which the worker already has items. Once the time for
    more is over, nothing is left of it except answers. The same batch, sent again with its key, is answered
    as a whole.
    """
    count, keys = 200, Keys.of(WorkerSettings())
    headers = {"Content-Type": "application/x-ndjson", "Idempotency-Key": "again"}
    with (
        running(tmp_path / "data", workers=1, log_level="CRITICAL", sweep_interval=0.2) as stack,
        stack.redis() as redis,
        httpx.Client(base_url=stack.base, timeout=PATIENCE) as client,
    ):

        def broken() -> Iterator[bytes]:
            for number, line in enumerate(small_items(count)):
                yield line.replace(b"\n", b" " * 1000 + b"\n")
                if number == 150:  # 50 items were read by then, in pieces of 64 KiB
                    until(lambda: redis.zcard(keys.deadlines) == 1)
                    kill(stack, "api_process")

        with pytest.raises(httpx.TransportError):
            client.post("/v1/batches", content=broken(), headers=headers)
        [name] = redis.zrange(keys.deadlines, 0, -1)
        job_id = name.decode()
        job = keys.job(job_id)
        assert redis.hget(job.record, "receiving") == b"1"
        until(lambda: int(redis.hget(job.record, "done") or 0) > 0)
        assert client.get(f"/v1/batches/{job_id}").status_code == 404
        # its time is over: for what is kept of it, for its key, and for the job that has begun
        for key in (job.items, *redis.keys("*submission*")):
            assert 0 < redis.ttl(key) <= INTAKE_TTL
            redis.pexpire(key, 1)
        assert 0 < redis.zscore(keys.deadlines, name) - redis.time()[0] <= INTAKE_TTL + 1
        redis.zadd(keys.deadlines, {name: 1})
        redis.hset(job.record, "deadline", 1)
        until(lambda: not any(map(redis.zcard, (keys.active, keys.deadlines))))
        until(lambda: not [*redis.keys("*submission*"), *redis.keys(f"*{job_id}*")])
        assert client.get("/v1/batches").json()["items"] == []
        answer = client.post("/v1/batches", content=b"".join(small_items(count)), headers=headers)
        assert answer.status_code == 202
        reader = Reader(client, answer.json(), {})
        reader.read()
        assert reader.received == list(range(count))


@pytest.mark.long
@pytest.mark.timeout(480)
def test_ten_thousand_items(tmp_path: Path) -> None:
    """A worker and the API are killed, twice each, while a batch of 10,000 items runs and is read. None is
    lost or sent twice, and the API and each worker with its work horse stay below 300 MiB.
    """
    count = 10_000
    memory: dict[int, int] = {}

    def look(stack: Stack) -> None:
        table = subprocess.run(["ps", "-eo", "pid=,ppid="], capture_output=True, text=True, check=True).stdout
        children = [
            int(pid) for pid, parent in map(str.split, table.splitlines()) if int(parent) == stack.process.pid
        ]
        for pid in children:
            used = largest(pid) + sum(map(largest, descendants(pid)))
            memory[pid] = max(used, memory.get(pid, 0))

    with running(tmp_path / "data", workers=1, log_level="CRITICAL") as stack:
        client = httpx.Client(base_url=stack.base, timeout=PATIENCE)
        answer = client.post(
            "/v1/batches", content=small_items(count), headers={"Content-Type": "application/x-ndjson"}
        )
        assert answer.status_code == 202
        batch = answer.json()
        assert (batch["progress"]["total"], batch["failed"]) == (count, 0)
        acts = {n: partial(look, stack) for n in range(500, count + 1, 500)}
        acts |= {n: partial(kill, stack, "worker.__main__") for n in (1500, 6500)}
        acts |= {n: partial(kill, stack, "api_process") for n in (3250, 8250)}
        reader = Reader(client, batch, acts)
        reader.read()
        assert reader.received == list(range(count))
        assert reader.breaks >= 2
        state = client.get(batch["links"]["self"]).json()
        assert (state["status"], state["succeeded"], state["failed"]) == ("completed", count, 0)
        whole = client.get(batch["links"]["results"]).text.splitlines()
        assert [json.loads(line)["index"] for line in whole] == list(range(count))
        look(stack)
        assert 50 << 10 < max(memory.values()) < 300 << 10
        client.close()
