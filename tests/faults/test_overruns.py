"""Wrong estimates, on a service with a worker reserved for short work."""

from __future__ import annotations

import os
import signal
import time

import httpx
import pytest
from redis import Redis

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_document, a_request, depth, ended, read_batch, submit_batch
from tests.support.processes import PATIENCE, Process, Workers, descendants, until
from tests.support.service_server import GEOMETRY, serving
from worker.answers.kind import JobRequest
from worker.answers.kinds import Item
from worker.jobs.installation import read_ends
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

SOON = {"overrun_factor": 0.1, "overrun_floor": 0.3, "beat_interval": 0.2}
NEVER = {"overrun_floor": PATIENCE, "beat_interval": 0.2}


def jobs(redis: Redis, task: str) -> JobQueue:
    return JobQueue(redis, WorkerSettings(task=f"tests.support.hard_tasks.{task}"))


def start_light(workers: Workers, queue: JobQueue, **settings: object) -> Process:
    return workers.start("light", **settings, task=queue.settings.task)


def start(workers: Workers, queue: JobQueue, **settings: object) -> Process:
    return workers.start(**settings, task=queue.settings.task)


def state(queue: JobQueue, job_id: str) -> tuple[str, int]:
    view = queue.get(job_id)
    assert view is not None
    return view.status, view.overruns


def test_wrong_estimates_hold_up_no_small_question(
    valkey: EmbeddedValkey, redis: Redis, workers: Workers
) -> None:
    """Eight questions with short estimates never end, on two workers. The worker reserved for short work
    still answers small questions at once; when it stops, it puts all eight back.
    """
    queue = jobs(redis, "endless")
    light = start_light(workers, queue, **NEVER)
    start(workers, queue, **NEVER)
    wrong = [queue.submit(a_request(str(n))).id for n in range(1, 9)]
    with (
        serving(Settings(redis_url=valkey.url)) as url,
        httpx.Client(base_url=url, timeout=PATIENCE) as client,
    ):
        for l1 in ("14.98", "27", "26"):
            body = {"geometry": GEOMETRY, "l1": l1, "digits": 15}
            answer = client.post("/v1/cusp-tables", json=body, headers={"Prefer": "wait=30"})
            assert answer.status_code == 200
    assert {state(queue, job) for job in wrong} == {("running", 0)}
    assert len(descendants(light.pid)) >= 7, "none of them had to end"
    light.terminate()
    assert light.wait(PATIENCE) == 0
    assert depth(queue) == 7
    assert not read_ends(redis.hgetall(queue.records.keys.ends)).lost
    for job in wrong:
        queue.cancel(job)
    assert ended(JobQueue(redis), JobQueue(redis).submit(a_request("1")).id).status == "succeeded"


def test_more_wrong_estimates_than_may_run_at_once(redis: Redis, workers: Workers) -> None:
    """There are more such questions than the worker reserved for short work can run at the same time. It
    gives back those that exceed their estimates most, and takes the next one.
    """
    queue = jobs(redis, "endless")
    start_light(workers, queue, **NEVER)
    start(workers, queue, **NEVER)
    wrong = [queue.submit(a_request(str(n))).id for n in range(1, 13)]
    usual = JobQueue(redis)
    assert ended(usual, usual.submit(a_request("14.98")).id).status == "succeeded"
    assert queue.chunks.depths()["heavy"] >= 1
    assert "given back to the lane heavy" in workers.log.read_text()
    for job in wrong:
        queue.cancel(job)


@pytest.mark.parametrize("request_", [a_request("1", "2"), a_document()], ids=["table", "document"])
def test_an_overrun_is_given_back_once(redis: Redis, workers: Workers, request_: JobRequest) -> None:
    """A chunk takes several times its estimate on the worker reserved for short work. When there is another
    worker, the chunk is given back, without a loss, and done there; the log and the job record this.
    """
    queue = jobs(redis, "slow_once")
    light = start_light(workers, queue, **SOON)
    job = queue.submit(request_).id
    until(lambda: state(queue, job) == ("running", 1))
    assert descendants(light.pid), "nobody else would take it"
    start(workers, queue, **SOON)
    view = ended(queue, job)
    assert (view.status, view.overruns) == ("succeeded", 1)
    until(lambda: not descendants(light.pid))
    ends = read_ends(redis.hgetall(queue.records.keys.ends))
    assert not ends.lost
    assert {what for (_, what), n in ends.overruns.items() if n} == {"left", "given-back"}
    told = workers.log.read_text()
    assert told.count("WARNING") == 2, told
    assert "overran; given back to the lane heavy; it has run for" in told
    assert told.count(f"job={job}") == 2


def test_an_overrun_is_due_to_one_item(redis: Redis, workers: Workers) -> None:
    """An item of a batch takes several times the estimate of its chunk. The other worker does what is not
    kept yet, one by one, so that only this item fails.
    """
    queue = jobs(redis, "endless_at_13")
    start_light(workers, queue, **SOON)
    view = submit_batch(queue, [Item(request=a_request(n)) for n in ("1", "2", "13", "3")])
    until(lambda: state(queue, view.id) == ("running", 1))
    assert {item.state for item in read_batch(queue, view)[2:]} == {"open"}
    start(workers, queue, **SOON, deadline_seconds=1)
    done = ended(queue, view.id)
    assert (done.status, done.failed) == ("succeeded", 1)
    stored = read_batch(queue, view)
    assert [item.state for item in stored] == ["succeeded", "succeeded", "failed", "succeeded"]
    assert not read_ends(redis.hgetall(queue.records.keys.ends)).lost


@pytest.mark.parametrize("moment", [0.0, *(pytest.param(x, marks=pytest.mark.long) for x in (0.02, 0.1))])
def test_a_worker_is_killed_as_it_gives_back(redis: Redis, workers: Workers, moment: float) -> None:
    """The worker reserved for short work is killed while it gives a chunk back. The job is done by the other
    worker.
    """
    queue = jobs(redis, "slow_once")
    light = start_light(workers, queue, **SOON)
    job = queue.submit(a_request("1")).id
    until(lambda: state(queue, job) == ("running", 1))
    start(workers, queue, **SOON, sweep_interval=0.2, lost_grace=0.2, beat_ttl=2)
    until(lambda: redis.hexists(queue.records.keys.ends, "overruns:ct:given-back"))
    time.sleep(moment)
    light.kill()
    assert ended(queue, job).status == "succeeded"
    assert not read_ends(redis.hgetall(queue.records.keys.ends)).lost


def test_redis_hangs_as_a_chunk_is_given_back(redis: Redis, valkey: EmbeddedValkey, workers: Workers) -> None:
    """Redis hangs while a chunk overruns on the worker reserved for short work. The chunk is given back
    afterwards, without a loss.
    """
    queue = jobs(redis, "slow_once")
    start_light(workers, queue, **SOON)
    job = queue.submit(a_request("1")).id
    until(lambda: state(queue, job)[0] == "running")
    os.kill(valkey.pid, signal.SIGSTOP)
    try:
        time.sleep(2)  # the chunk overruns meanwhile; no heartbeat is missed for too long
    finally:
        os.kill(valkey.pid, signal.SIGCONT)
    start(workers, queue, **SOON)
    assert ended(queue, job).status == "succeeded"
    assert not read_ends(redis.hgetall(queue.records.keys.ends)).lost
    assert "Traceback" not in workers.log.read_text()


def test_a_chunk_that_waits_overruns_too(redis: Redis, workers: Workers) -> None:
    """A chunk waits for something without computing. It is given back after a longer time, and small
    questions are answered meanwhile.
    """
    queue, usual = jobs(redis, "gated"), JobQueue(redis)
    start_light(workers, queue, **SOON)
    job = queue.submit(a_request("1")).id
    until(lambda: redis.llen("begun") == 1)
    begun = time.monotonic()
    assert ended(usual, usual.submit(a_request("14.98")).id).status == "succeeded"
    until(lambda: state(queue, job) == ("running", 1))
    assert time.monotonic() - begun > 3 * SOON["overrun_floor"]
    start(workers, queue, **SOON)
    until(lambda: redis.lrange("begun", 0, -1) == [b"0", b"1"])
    redis.set("gate", 1)
    assert ended(queue, job).status == "succeeded"
