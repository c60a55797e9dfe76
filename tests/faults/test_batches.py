"""Batches, when items, work horses, workers or the API fail."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import pytest
from redis import Redis

import rpr_solver
from tests.support.jobs import a_document, a_request, a_slice_of_curves, ended, read_batch, submit_batch
from tests.support.processes import PATIENCE, Workers, descendants, until
from tests.support.sampling import long
from tests.support.service_server import GEOMETRY
from tests.support.stack import Stack, running
from worker.answers.kinds import Item
from worker.jobs.batches import INTAKE_TTL
from worker.jobs.keys import Keys
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

INNOCENTI = rpr_solver.EXAMPLES["innocenti"]


def jobs(redis: Redis, task: str = "", **settings: float) -> JobQueue:
    """The queue as an API process sees it; with `task`, its chunks run one of the hard tasks."""
    name = f"tests.support.hard_tasks.{task}" if task else "worker.process.tasks.run_chunk"
    return JobQueue(redis, WorkerSettings.model_validate({"task": name, **settings}))


def tables(*l1: str) -> list[Item]:
    return [Item(request=a_request(x)) for x in l1]


@pytest.mark.parametrize(
    ("task", "reason"),
    [
        ("crash", "worker-crashed"),
        long("leave", "worker-crashed"),
        ("greedy", "resource-exhausted"),
        long("greedy_python", "resource-exhausted"),
    ],
)
def test_an_item_whose_horse_dies_each_time(redis: Redis, workers: Workers, task: str, reason: str) -> None:
    """The work horse of one item crashes, leaves or runs out of memory at every attempt. That item fails; the
    others of its chunk are answered.
    """
    queue = jobs(redis, task)
    workers.start(task=queue.settings.task, memory_limit_mb=1024, log_level="CRITICAL")
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
    queue = jobs(redis, "endless_at_13", deadline_seconds=1)
    workers.start(task=queue.settings.task, deadline_seconds=1, log_level="CRITICAL")
    view = ended(queue, submit_batch(queue, tables("1", "13", "2")).id)
    assert (view.status, view.failed) == ("succeeded", 1)
    failure = read_batch(queue, view)[1].outcome.failure
    assert failure is not None
    assert failure["type"] == "timeout"
    assert view.started_at is not None
    assert view.ended_at is not None
    seconds = datetime.fromisoformat(view.ended_at) - datetime.fromisoformat(view.started_at)
    assert seconds.total_seconds() > 1.9


@pytest.mark.long
def test_each_item_has_a_deadline_of_its_own(redis: Redis, workers: Workers) -> None:
    """The items of a chunk take far longer together than one may take. None is given up."""
    queue = jobs(redis, "slow", deadline_seconds=1)
    workers.start(task=queue.settings.task, deadline_seconds=1)
    view = ended(queue, submit_batch(queue, tables(*map(str, range(1, 101)))).id)
    assert (view.status, view.done, view.failed) == ("succeeded", 100, 0)


@pytest.mark.long
def test_the_worker_of_a_batch_is_killed(redis: Redis, workers: Workers) -> None:
    """The worker of a batch is killed. Another one continues after 5 to 9 s, with the items that were not
    stored.
    """
    queue = jobs(redis, "slow")
    first = workers.start(task=queue.settings.task)
    view = submit_batch(queue, tables(*map(str, range(1, 31))))
    until(lambda: sum(stored.state == "succeeded" for stored in read_batch(queue, view)) >= 3)
    first.kill()
    first.wait(PATIENCE)
    workers.start(task=queue.settings.task)
    view = ended(queue, view.id)
    assert (view.status, view.done, view.failed) == ("succeeded", 30, 0)
    pids = [queue.store.get_slices(a_request(str(x)))[str(x)]["certificate"]["pid"] for x in range(1, 31)]
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
        workers.start()
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
        self.results: list[dict[str, Any]] = []
        self.breaks = 0

    def read(self) -> None:
        """Read all."""
        while len(self.results) < self.batch["progress"]["total"]:
            try:
                self._read()
            except httpx.TransportError:
                self.breaks += 1
                time.sleep(0.1)

    def _read(self) -> None:
        path = f"{self.batch['links']['results']}?after={len(self.results) - 1}"
        with self.client.stream("GET", path, headers={"Prefer": "wait=20"}) as answer:
            if answer.status_code == 503:  # Valkey was killed
                return
            assert answer.status_code == 200
            for line in answer.iter_lines():
                result = json.loads(line)
                assert result["status"] == "succeeded"
                assert result["id"] == str(result["index"])
                self.results.append(result)
                self.acts.get(len(self.results), lambda: None)()


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
    """The API is killed while it receives a batch. No batch is made, and its key is free again after
    two minutes. The same batch, sent again with its key, is answered as a whole.
    """
    count, keys = 200, Keys.of(WorkerSettings())
    headers = {"Content-Type": "application/x-ndjson", "Idempotency-Key": "again"}
    with (
        running(tmp_path / "data", workers=1, log_level="CRITICAL") as stack,
        stack.redis() as redis,
        httpx.Client(base_url=stack.base, timeout=PATIENCE) as client,
    ):

        def broken() -> Iterator[bytes]:
            for number, line in enumerate(small_items(count)):
                yield line.replace(b"\n", b" " * 1000 + b"\n")
                if number == 150:
                    until(lambda: redis.keys("*submission*"))
                    kill(stack, "api_process")

        with pytest.raises(httpx.TransportError):
            client.post("/v1/batches", content=broken(), headers=headers)
        [key] = redis.keys("*submission*")
        assert 0 < redis.ttl(key) <= INTAKE_TTL
        redis.delete(key)  # its time is over
        assert not redis.exists(keys.active)
        assert client.get("/v1/batches").json()["items"] == []
        answer = client.post("/v1/batches", content=b"".join(small_items(count)), headers=headers)
        assert answer.status_code == 202
        reader = Reader(client, answer.json(), {})
        reader.read()
        assert [result["index"] for result in reader.results] == list(range(count))


def kill_horse(stack: Stack) -> None:
    """Kill a work horse, if one is there."""
    for pid in descendants(stack.part("worker.__main__")):
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def is_right(result: dict[str, Any]) -> bool:
    """Whether a result is that of the library."""
    [*_, item] = small_items(result["index"] + 1)
    asked = json.loads(item)["request"]
    if "l2" in asked:
        own = rpr_solver.poses(INNOCENTI, asked["l1"], asked["l2"], asked["l3"], digits=15).to_json()
        return bool(result["result"]["poses"] == own["poses"])
    slice_ = rpr_solver.slice_json(rpr_solver.eliminate(INNOCENTI), asked["l1"], digits=15)
    [found] = result["result"]["slices"]
    return bool(found["cusps"] == slice_["cusps"])


@pytest.mark.slow
def test_each_process_is_killed_during_a_batch(tmp_path: Path) -> None:
    """A work horse, the worker, the API and Valkey are killed, one after the other, while a batch of 400
    items runs and is read. None is lost, none is sent twice, and none is wrong.
    """
    count = 400
    with (
        running(tmp_path / "data", workers=1, log_level="CRITICAL") as stack,
        httpx.Client(base_url=stack.base, timeout=PATIENCE) as client,
    ):
        headers = {"Content-Type": "application/x-ndjson"}
        batch = client.post("/v1/batches", content=small_items(count), headers=headers).json()
        with stack.redis() as redis:
            redis.waitaof(1, 0, 5000)
        acts = {50: partial(kill_horse, stack)}
        parts = enumerate(("worker.__main__", "api_process", "valkey-server"), 1)
        acts |= {100 * n: partial(kill, stack, part) for n, part in parts}
        reader = Reader(client, batch, acts)
        reader.read()
        assert [result["index"] for result in reader.results] == list(range(count))
        assert all(map(is_right, reader.results[::23]))
        until(lambda: client.get(batch["links"]["self"]).json()["status"] == "completed")
        state = client.get(batch["links"]["self"]).json()
        assert (state["succeeded"], state["failed"]) == (count, 0)
        whole = [json.loads(line) for line in client.get(batch["links"]["results"]).text.splitlines()]
        assert whole == reader.results


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
        assert [result["index"] for result in reader.results] == list(range(count))
        assert reader.breaks >= 2
        state = client.get(batch["links"]["self"]).json()
        assert (state["status"], state["succeeded"], state["failed"]) == ("completed", count, 0)
        whole = client.get(batch["links"]["results"]).text.splitlines()
        assert [json.loads(line)["index"] for line in whole] == list(range(count))
        look(stack)
        assert 50 << 10 < max(memory.values()) < 300 << 10
        client.close()
