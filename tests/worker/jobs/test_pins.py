"""Answers that are kept for ever."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from redis import Redis

from tests.support.jobs import a_pose_table, a_request
from worker.answers.archive import archive_of
from worker.answers.kind import JobRequest
from worker.jobs.archiving import Mover
from worker.jobs.queue import JobQueue, NotPinnableError, Pins
from worker.jobs.upkeep import Inventory
from worker.settings import WorkerSettings

PAD = random.Random(1).randbytes(500).hex()
TABLE, OTHER, DOCUMENT = a_request("1", "2"), a_request("2", "3"), a_pose_table("14.98")


@pytest.fixture
def queue(redis: Redis, tmp_path: Path) -> JobQueue:
    """A queue that knows the answers to three questions, asked without jobs."""
    queue = JobQueue(redis, WorkerSettings(archive_url=f"file://{tmp_path}/archive"))
    for request in (TABLE, OTHER):
        queue.store.put_slices(request, {l1: {"l1": l1, "cusps": [PAD]} for l1 in request.parts})
    queue.store.put_document(DOCUMENT, {"poses": [PAD]})
    for request in (TABLE, OTHER, DOCUMENT):
        assert queue.remember(request)
    return queue


def lifetimes(queue: JobQueue, request: JobRequest) -> list[int]:
    """Those of the question and of its results."""
    store = queue.store
    keys = (
        store.slice_keys(request, request.parts)
        if request.kind.by_slices
        else [store.keys.document(request.content_hash)]
    )
    return [queue.redis.ttl(key) for key in (store.keys.question(request.job_id), *keys)]


@pytest.mark.parametrize("request_", [TABLE, DOCUMENT], ids=["table", "document"])
def test_a_pinned_answer_has_no_end(queue: JobQueue, request_: JobRequest) -> None:
    pins = Pins(queue)
    pins.pin(request_.job_id)
    assert set(lifetimes(queue, request_)) == {-1}
    assert pins.ids() == [request_.job_id]
    assert JobQueue(queue.redis, queue.settings).remember(request_)
    queue.store.put_document(DOCUMENT, {"poses": []})
    queue.store.renew_document(DOCUMENT)
    queue.store.renew_slices(TABLE, queue.store.get_slices(TABLE))
    assert set(lifetimes(queue, request_)) == {-1}
    Inventory(queue.redis, queue.settings).prune(older_than=0, max_bytes=0)
    assert queue.kept_answer(request_.job_id) is not None
    assert pins.unpin(request_.job_id)
    assert min(lifetimes(queue, request_)) > 0
    assert not pins.unpin(request_.job_id)


def test_a_pinned_answer_stays_so_in_the_archive(queue: JobQueue) -> None:
    Pins(queue).pin(TABLE.job_id)
    mover = Mover(queue.redis, queue.settings, archive_of(queue.settings))
    assert mover.move(1, everything=True) == 4
    assert set(lifetimes(queue, TABLE)) == {-1}
    assert max(lifetimes(queue, DOCUMENT)) > 300 * 86400
    Pins(queue).pin(DOCUMENT.job_id)
    assert set(lifetimes(queue, DOCUMENT)) == {-1}
    for key in queue.redis.keys("*"):
        if queue.redis.ttl(key) >= 0:
            queue.redis.delete(key)
    assert mover.collect(older_than=-1) == 0
    assert queue.kept_answer(TABLE.job_id) is not None
    assert queue.kept_answer(DOCUMENT.job_id) == {"poses": [PAD]}
    assert queue.kept_answer(OTHER.job_id) is None


def test_slices_that_two_pinned_tables_share_stay_with_the_other(queue: JobQueue) -> None:
    pins = Pins(queue)
    for request in (TABLE, OTHER):
        pins.pin(request.job_id)
    assert pins.unpin(TABLE.job_id)
    assert set(lifetimes(queue, OTHER)) == {-1}
    assert lifetimes(queue, TABLE)[1] > 0


def test_what_is_not_there_or_may_change_cannot_be_pinned(queue: JobQueue) -> None:
    unknown, failed = a_request("7"), a_request("8")
    error = {"l1": "8", "error": {"type": "solver-error", "detail": "undecided"}}
    queue.store.put_slices(failed, {"8": error})
    queue.remember(failed)
    queue.redis.delete(queue.store.keys.document(DOCUMENT.content_hash))
    for request in (unknown, failed, DOCUMENT):
        with pytest.raises(NotPinnableError):
            Pins(queue).pin(request.job_id)
    assert Pins(queue).ids() == []
    assert not any(queue.redis.ttl(key) == -1 for key in queue.redis.keys("cusps:*"))
