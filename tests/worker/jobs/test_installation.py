"""The state of an installation, and its lists of jobs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

import pytest

from tests.support.chunks import refs, work
from tests.support.jobs import a_heavy_document, a_pose_table, a_request, submit_batch
from worker.answers.kinds import Item
from worker.jobs import clients, installation
from worker.jobs.clients import ACTIVE, Listed, Status, Subscriber, What
from worker.jobs.installation import Roster
from worker.jobs.queue import JobQueue
from worker.lua.scripts import library


def test_a_small_job_that_nobody_begins(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    queue.submit(a_request("1"))
    assert queue.readiness().warnings == (), "there is no worker at all, which is worse"
    Roster(queue.redis, queue.settings).beat("worker")
    assert queue.readiness().warnings == ()
    monkeypatch.setattr(installation, "STILL", -1.0)
    [warning] = queue.readiness().warnings
    assert warning.startswith("the lane small stands still: its first job was submitted ")


def test_a_small_job_whose_record_is_gone(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installation, "STILL", 0.5)
    queue.redis.delete(queue.records.keys.job(queue.submit(a_request("1")).id).record)
    Roster(queue.redis, queue.settings).beat("worker")
    assert queue.readiness().warnings == ()


def test_heavy_chunks_without_a_worker_for_them(queue: JobQueue) -> None:
    queue.submit(a_heavy_document())
    roster = Roster(queue.redis, queue.settings)
    roster.beat("light", is_light=True)
    [warning] = queue.readiness().warnings
    assert "the lane heavy stands still: all workers have light duty" in warning
    roster.beat("strong")
    assert queue.readiness().warnings == ()


ALL = frozenset(get_args(Status))
ANN, BEN = Subscriber("key:ann", True), Subscriber("address:192.0.2.1", False)


def listed(
    queue: JobQueue,
    what: What = "jobs",
    client: str | None = None,
    statuses: frozenset[Status] = ALL,
    limit: int = 2,
) -> list[Listed]:
    """All pages of a list."""
    found: list[Listed] = []
    before: str | None = ""
    while before is not None:
        page = queue.listing.page(what, client, statuses, before, limit)
        assert len(page.items) <= limit
        found += page.items
        before = page.before
    return found


def ids(items: Sequence[Listed]) -> list[str]:
    return [item.view.id for item in items]


def test_the_newest_come_first(queue: JobQueue) -> None:
    jobs = [queue.submit(a_pose_table(str(n))).id for n in range(10, 15)]
    batch = submit_batch(queue, [Item(request=a_request("1"))]).id
    assert ids(listed(queue)) == jobs[::-1]
    assert ids(listed(queue, "batches")) == [batch]
    queue.cancel(jobs[1])
    assert ids(listed(queue, statuses=ACTIVE)) == [jobs[4], jobs[3], jobs[2], jobs[0]]
    assert ids(listed(queue, statuses=frozenset({"canceled"}))) == [jobs[1]]
    assert queue.submit(a_pose_table("11")).id == jobs[1]
    assert ids(listed(queue)) == [jobs[1], *jobs[:1:-1], jobs[0]], "it began again"


def test_what_is_said_of_a_job(queue: JobQueue) -> None:
    request = a_request("1", "2")
    queue.submit_for(ANN, request)
    [waiting] = listed(queue)
    assert (waiting.view.status, waiting.runs_s, waiting.maker) == ("queued", None, "key:ann")
    assert waiting.view.estimate_s == pytest.approx(queue.plan(request, 2).seconds, abs=0.001)
    work(queue, refs(queue)[0], 1)
    [runs] = listed(queue)
    assert runs.runs_s is not None
    assert runs.runs_s >= 0
    work(queue, refs(queue)[0])
    [done] = listed(queue)
    assert (done.view.status, done.runs_s) == ("succeeded", done.view.run_seconds)


def test_each_client_has_its_own(queue: JobQueue) -> None:
    first, shared, last = (a_request(n) for n in ("1", "2", "3"))
    queue.submit_for(ANN, first)
    queue.submit_for(ANN, shared)
    queue.submit_for(BEN, shared)
    queue.submit_for(BEN, last)
    queue.withdraw(first.job_id, ANN)
    assert ids(listed(queue, client="key:ann")) == [shared.job_id, first.job_id]
    assert ids(listed(queue, client="key:ann", statuses=ACTIVE)) == [shared.job_id]
    assert ids(listed(queue, client=BEN.client)) == [last.job_id, shared.job_id]
    assert ids(listed(queue, client="key:other")) == []
    assert {item.view.id: item.maker for item in listed(queue)}[shared.job_id] == "key:ann"


def test_what_is_gone_is_not_listed(queue: JobQueue) -> None:
    jobs = [queue.submit(a_pose_table(str(n))).id for n in (10, 11)]
    queue.redis.delete(queue.records.keys.job(jobs[0]).record)
    assert ids(listed(queue)) == [jobs[1]]


def test_lists_are_bounded(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    """In length, and a page in what it looks at: one may be empty and not the last."""
    script = library("listing") + "\nfor i = 1, 20 do list_in(KEYS[1], 'ct-' .. i, 5) end"
    queue.redis.eval(script, 1, "index")
    assert queue.redis.zcard("index") <= 5
    monkeypatch.setattr(clients, "_STEP", 2)
    monkeypatch.setattr(clients, "_STEPS", 2)
    jobs = [queue.submit(a_pose_table(str(n))).id for n in range(10, 19)]
    queue.cancel(jobs[0])
    page = queue.listing.page("jobs", None, frozenset({"canceled"}), "", 10)
    assert page.items == []
    assert page.before is not None
    assert ids(listed(queue, statuses=frozenset({"canceled"}))) == [jobs[0]]
