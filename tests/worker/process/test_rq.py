"""What RQ's own tools and workers see of ours, and what they can do."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest
from redis import Redis
from rq import Queue
from rq.command import send_shutdown_command, send_stop_job_command
from rq.job import Job, Retry
from rq.registry import FailedJobRegistry, FinishedJobRegistry, StartedJobRegistry
from rq.serializers import JSONSerializer
from rq.suspension import resume, suspend
from rq.worker import Worker as RqWorker

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_document, a_request, ended, open_chunks, table_of
from tests.support.processes import PATIENCE, ROOT, Workers, completed, environment, until
from worker.jobs.queue import JobQueue
from worker.process.program import WorkerError, run_worker
from worker.settings import WorkerSettings

HARD = "tests.support.hard_tasks."
RQ = (sys.executable, "-m", "rq.cli")


def rq(valkey: EmbeddedValkey, *words: str) -> str:
    """What a command of RQ prints; it must succeed."""
    done = completed([*RQ, *words, "--url", valkey.url, "-S", "rq.serializers.JSONSerializer"], environment())
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_state_of_queues_workers_and_jobs(
    queue: JobQueue, valkey: EmbeddedValkey, workers: Workers
) -> None:
    workers.start()
    ended(queue, queue.submit(a_request("1")).id)
    small = queue.chunks.queues["small"]
    until(lambda: FinishedJobRegistry(queue=small).count == 1)
    shown = rq(valkey, "info")
    assert f"{small.name} | 0, 0 executing, 1 finished, 0 failed" in shown
    assert "idle" in shown
    assert "1 workers" in shown


def test_a_failed_chunk_is_requeued_and_the_question_stays_ended(
    redis: Redis, valkey: EmbeddedValkey, workers: Workers
) -> None:
    """What it computes is found when the question is asked again."""
    broken = JobQueue(redis, WorkerSettings(task=HARD + "broken"))
    workers.start(task=HARD + "broken")
    view = ended(broken, broken.submit(a_request("1", "2")).id)
    assert view.status == "failed"
    small = broken.chunks.queues["small"]
    [name] = until(lambda: FailedJobRegistry(queue=small).get_job_ids())
    job = Job.fetch(name, connection=redis, serializer=JSONSerializer)
    assert "cusp-table" in (job.description or "")
    assert view.id in name
    workers.stop()
    redis.hset(
        job.key,
        "data",
        Job.create(
            "worker.process.tasks.run_chunk", args=job.args, connection=redis, serializer=JSONSerializer
        ).data,
    )  # as if the fault had been mended
    queue = JobQueue(redis)
    workers.start()
    rq(valkey, "requeue", "--queue", small.name, name)
    until(lambda: len(queue.store.get_slices(a_request("1", "2"))) == 2)
    now = queue.get(view.id)
    assert now is not None
    assert (now.status, now.run) == ("failed", view.run)
    again = ended(queue, queue.submit(a_request("1", "2")).id)
    assert (again.id, again.status) == (view.id, "succeeded")
    assert len(table_of(queue, view.id)["slices"]) == 2


def test_workers_pause_and_go_on(redis: Redis, queue: JobQueue, workers: Workers) -> None:
    workers.start()
    suspend(redis)
    until(lambda: [worker.get_state() for worker in RqWorker.all(redis)] == ["suspended"])
    view = queue.submit(a_request("1"))
    time.sleep(0.3)
    assert queue.get(view.id) == view
    resume(redis)
    assert ended(queue, view.id).status == "succeeded"


def test_a_command_of_rq_ends_a_job(redis: Redis, workers: Workers) -> None:
    queue = JobQueue(redis, WorkerSettings(task=HARD + "endless"))
    workers.start(task=HARD + "endless")
    view = queue.submit(a_document())
    [ref] = open_chunks(queue)
    until(lambda: redis.hget(f"rq:job:{ref.rq_id}", "status") == b"started")
    until(lambda: redis.hexists(Job.key_for(ref.rq_id), "worker_name"))
    send_stop_job_command(redis, ref.rq_id, JSONSerializer)
    assert ended(queue, view.id).status == "canceled"


def test_a_command_of_rq_ends_a_worker(redis: Redis, workers: Workers) -> None:
    worker = workers.start()
    [name] = [worker.name for worker in RqWorker.all(redis)]
    send_shutdown_command(redis, name)
    assert worker.wait(PATIENCE) == 0


def test_a_foreign_job_is_refused_and_disturbs_nothing(
    queue: JobQueue, redis: Redis, workers: Workers
) -> None:
    small = queue.chunks.queues["small"]
    small.enqueue("os.getpid")
    Queue(small.name, connection=redis).enqueue("os.getpid", job_id="pickled")  # by RQ's usual serializer
    workers.start()
    assert ended(queue, queue.submit(a_request("1")).id).status == "succeeded"
    assert len(FailedJobRegistry(queue=small).get_job_ids()) == 2
    assert "not a chunk of rpr-cusps" in workers.log.read_text()


def test_a_worker_of_rq_alone_computes_chunks(
    queue: JobQueue, valkey: EmbeddedValkey, tmp_path: Path
) -> None:
    """From another folder, with its own fork for each job."""
    table, document = queue.submit(a_request("1", "2")), queue.submit(a_document())
    command = [*RQ, "worker", queue.chunks.queues["small"].name, "--burst", "--url", valkey.url]
    options = ["-S", "rq.serializers.JSONSerializer"]
    variables = {**environment(), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [*command, *options], cwd=tmp_path, env=variables, capture_output=True, timeout=PATIENCE, check=False
    )
    assert done.returncode == 0, done.stderr
    for view in (table, document):
        assert ended(queue, view.id).status == "succeeded"


def test_rq_repeats_an_abandoned_job_wrongly(redis: Redis) -> None:
    """RQ 2.12 loses count of a job that was abandoned, with `Retry` left, and done at the second attempt.

    As soon as this test fails, RQ is mended, and `worker.jobs.chunks` may use its `Retry` in place of
    attempts with ids of their own.
    """
    queue = Queue("abandoned", connection=redis, serializer=JSONSerializer)
    job = queue.enqueue("os.getpid", retry=Retry(max=2))
    first, second = (
        RqWorker([queue], connection=redis, serializer=JSONSerializer, name=name) for name in ("a", "b")
    )
    queue.pop_job_id()
    first.prepare_execution(job)
    first.prepare_job_execution(job)
    StartedJobRegistry(queue=queue).cleanup(time.time() + 3600)
    second.work(burst=True, logging_level="CRITICAL")
    ends = [job.get_status(refresh=True), len(FailedJobRegistry(queue=queue)), len(job.get_executions())]
    assert ends != ["finished", 0, 0]


def test_another_version_of_rq_is_refused(valkey: EmbeddedValkey, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("worker.process.program.VERSION", "3.0.0")
    with pytest.raises(WorkerError, match=r"needs RQ 2\.12, and RQ 3\.0\.0 is installed"):
        run_worker(valkey.url)
