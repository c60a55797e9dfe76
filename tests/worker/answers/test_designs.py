"""Designs as jobs: chunks share the censuses of one search, and what one leaves undone another does."""

from __future__ import annotations

import json
import sys
import threading
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from redis import Redis

from rpr_solver import Manipulator, Requirement, check, design
from rpr_solver.contract import silent
from rpr_solver.designs import design as module
from rpr_solver.designs.plan import Goal, Plan
from tests.support.jobs import SMALL, WISH, a_design
from tests.support.processes import completed, environment
from tests.support.sampling import long
from worker.answers.designs import DESIGN, SAMPLE, SHARES, Observer, _sample_of
from worker.answers.kind import JobRequest, Store
from worker.answers.store import ResultStore
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkRef
from worker.jobs.queue import JobQueue
from worker.process import tasks
from worker.settings import WorkerSettings

OPTIONS: dict[str, Any] = {"vary": "5%", "decimals": 2, "budget": 5}
PROGRAM = """
import json, sys
from rpr_solver import Manipulator, Requirement, census, check
best = Manipulator.from_json(json.loads(sys.argv[1]))
wish = Requirement.from_json(json.loads(sys.argv[2]))
report = check(best, wish, digits=15)
table = census(best, start=wish.start, stop=wish.stop, digits=15)
print(json.dumps([report.to_json(), table.to_json()]))
"""


def asked() -> JobRequest:
    return a_design(OPTIONS["budget"])


@pytest.fixture
def examined(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often each geometry is examined; margins are left out."""
    counts: Counter[str] = Counter()
    examine = module.examined

    def counted(manipulator: Manipulator, goal: Goal) -> Mapping[str, Any] | None:
        counts[manipulator.geometry_hash] += 1
        return examine(manipulator, goal)

    monkeypatch.setattr(module, "examined", counted)
    monkeypatch.setattr(module, "margin", lambda *_, **__: None)
    return counts


def test_chunks_share_a_search_and_one_continues_where_another_died(
    redis: Redis, settings: WorkerSettings, examined: Counter[str]
) -> None:
    class KilledError(Exception):
        pass

    def killed(done: int, _total: int) -> None:
        if done == 3:
            raise KilledError

    with pytest.raises(KilledError):
        DESIGN.compute(asked(), ResultStore(redis, settings, holder="first"), killed)
    assert len(examined) == 3
    answers: dict[str, Any] = {}

    def run(holder: str) -> None:
        store = ResultStore(redis, settings, holder=holder)
        answers[holder] = DESIGN.compute(asked(), store, silent)

    threads = [threading.Thread(target=run, args=(name,)) for name in ("second", "third")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(examined) == OPTIONS["budget"]
    assert set(examined.values()) == {1}, "what is known is not examined again"
    assert answers["second"] == answers["third"]
    best = answers["second"]["best"]
    arguments = [json.dumps(best["geometry"]), json.dumps(WISH.to_json())]
    command = [sys.executable, "-c", PROGRAM, *arguments]
    fresh = json.loads(completed(command, environment()).stdout)
    assert fresh == [best["check"], best["census"]]


@pytest.mark.long
def test_without_a_store_it_is_the_answer_of_the_library(examined: Counter[str]) -> None:
    told: list[dict[str, Any]] = []

    class Hearing(Observer):
        improved = staticmethod(told.append)

        def __call__(self, done: int, total: int) -> None:
            assert done <= total == OPTIONS["budget"]

    answer = DESIGN.compute(asked(), Store(), Hearing(silent))
    assert set(examined.values()) == {1}
    assert answer == design(SMALL, "longest-range", WISH, **OPTIONS).to_json()
    assert told == answer["trace"]


def test_a_job_has_several_chunks_and_tells_an_improvement_once(redis: Redis, queue: JobQueue) -> None:
    view = queue.submit(asked())
    plan = queue.plan(asked(), range(SHARES))
    assert (len(plan.chunks), plan.lane) == (SHARES, "heavy")
    attempts = Attempts(redis, queue.settings)
    refs = [ChunkRef(view.id, view.run, index, 0) for index in range(SHARES)]
    for ref in refs[:2]:
        assert attempts.start(ref, ref.index, ref.index) is not None
        attempts.put_improvement(ref, 1, {"census": 1})
    attempts.put_improvement(refs[1], 4, {"census": 4})
    attempts.put_improvement(refs[0], 3, {"census": 3})
    attempts.put_document(refs[1], asked(), {"best": {}})
    attempts.put_improvement(refs[0], 5, {"census": 5})
    events = redis.xrange(queue.records.keys.job(view.id).events)
    told = [json.loads(fields[b"improvement"]) for _, fields in events if fields[b"type"] == b"improvement"]
    assert told == [{"census": 1}, {"census": 4}]
    ended = queue.get(view.id)
    assert ended is not None
    assert ended.status == "succeeded"


def run(queue: JobQueue, job_id: str) -> None:
    """Runs the first chunk of a job here."""
    view = queue.get(job_id)
    assert view is not None
    tasks.set_context(tasks.Context(queue.redis, queue.settings, is_horse=True))
    tasks.run_chunk(job_id, view.run, 0, 0, 0, 0)


def stop_at(monkeypatch: pytest.MonkeyPatch, number: int, act: Callable[[], object]) -> None:
    """Does something once so many geometries have been examined."""
    examine, done = module.examined, 0

    def counted(manipulator: Manipulator, goal: Goal) -> Mapping[str, Any] | None:
        nonlocal done
        done += 1
        if done == number:
            act()
        return examine(manipulator, goal)

    monkeypatch.setattr(module, "examined", counted)
    monkeypatch.setattr(module, "margin", lambda *_, **__: None)


@pytest.mark.parametrize("why", [long("canceled"), "deadline"])
def test_a_search_that_is_stopped_has_the_best_found_so_far(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch, why: str
) -> None:
    first = queue.submit(asked())

    def stop() -> None:
        if why == "canceled":
            view = queue.cancel(first.id)
            assert view is not None
            assert view.status == "running", "it is asked to end with what it has found"
        else:
            queue.redis.hset(queue.records.keys.job(first.id).record, "deadline", "1")

    stop_at(monkeypatch, 3, stop)
    run(queue, first.id)
    view, answer = queue.outcome(first.id)
    assert view is not None
    assert view.status == "succeeded"
    assert isinstance(answer, dict)
    assert answer["stopped"] == why
    assert answer["censuses"] == 1, "that of the only generation that was complete"
    assert answer["best"]["geometry"] == SMALL.to_json()
    assert answer["best"]["check"] == check(SMALL, WISH, digits=15).to_json()
    assert queue.known(asked()) is None, "it is not the answer of the whole question"
    again = queue.submit(asked())
    assert not again.is_terminal
    assert queue.result(first.id) is None
    run(queue, again.id)
    assert queue.known(asked()) == queue.result(first.id)


def test_a_search_that_is_canceled_twice_ends_at_once(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    view = queue.submit(asked())
    stop_at(monkeypatch, 3, lambda: [queue.cancel(view.id) for _ in range(2)])
    run(queue, view.id)
    ended, answer = queue.outcome(view.id)
    assert ended is not None
    assert ended.status == "canceled"
    assert answer is None
    waiting = queue.submit(asked())
    queue.cancel(waiting.id)
    ended = queue.get(waiting.id)
    assert ended is not None
    assert ended.status == "canceled", "it had found nothing"


def test_a_candidate_is_examined_once_for_all_searches_that_need_the_same() -> None:
    def sample(limits: dict[str, Any] | None = None, **constraints: Any) -> JobRequest:
        wish = Requirement(start=28, stop=32, max_cusps=6, limits=limits)
        return _sample_of(Plan.of(SMALL, "longest-range", wish, **constraints), SMALL)

    usual = sample()
    assert sample(loop="required").content_hash == usual.content_hash, "its counts tell"
    aspects = sample(max_aspects=2)
    assert usual.content_hash != aspects.content_hash == sample(min_aspects=1).content_hash
    limits = {"l2": (5, 20)}
    hashes = {sample(limits, **x).content_hash for x in ({}, {"loop": "required"}, {"loop": "excluded"})}
    assert len(hashes) == 2
    found = SAMPLE.compute(aspects, Store(), silent)["document"]
    assert found["intervals"][0]["aspects"] is not None
