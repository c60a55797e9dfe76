"""The lanes of the queue: how a job is cut into chunks, where it waits, and when a lane is full."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from redis import Redis

from tests.support.jobs import a_document, a_heavy_document, a_request, depth
from tests.worker.jobs.test_queue import finish, refs, work
from worker.answers.cost import Cost
from worker.jobs.installation import Roster
from worker.jobs.plan import LANES, QueueFullError, QueuePosition, lanes_of, plan
from worker.jobs.queue import JobQueue
from worker.jobs.upkeep import Sweeper
from worker.lua.scripts import library
from worker.settings import WorkerSettings

SETTINGS = WorkerSettings(chunk_size=40, chunk_seconds=1.0, heavy_seconds=1.5)


@pytest.mark.parametrize(
    ("cost", "parts", "lane", "size", "count"),
    [
        (Cost(0.1, 0.01), 1, "small", 1, 1),
        (Cost(0.1, 0.01), 40, "small", 40, 1),
        (Cost(0.1, 0.01), 41, "bulk", 21, 2),  # as many slices as may be, and chunks of equal size
        (Cost(0.1, 0.1), 30, "bulk", 10, 3),  # a second of work each
        (Cost(0.1, 0.6), 3, "bulk", 1, 3),
        (Cost(0.1, 2.0), 1, "heavy", 1, 1),  # a document, or a slice in long numbers
        (Cost(0.0, 900.0), 3, "heavy", 1, 3),
        (Cost(5.0, 0.01), 100, "heavy", 34, 3),  # a long elimination
        (Cost(0.1, 0.01), 0, "small", 1, 0),
    ],
)
def test_the_plan_of_a_job(cost: Cost, parts: int, lane: str, size: int, count: int) -> None:
    job = plan(cost, parts, SETTINGS)
    assert (job.lane, job.chunk_size, job.chunk_count) == (lane, size, count)
    assert job.seconds == (cost.of(parts) if parts else 0)


def test_the_plan_of_a_job_whose_chunks_compute_the_same() -> None:
    assert plan(Cost(0.0, 9.0), 4, SETTINGS, is_shared=True).lane == "shared"
    assert plan(Cost(0.0, 0.1), 4, SETTINGS, is_shared=True).lane == "small"


def test_duties() -> None:
    light = lanes_of("light")
    assert all(set(order) == {"small", "bulk", "batch", "shared"} for order in light)
    orders = lanes_of("all")
    assert all(set(order) == set(LANES) for order in orders)
    assert {order[-1] for order in light} == {"shared"}, "when there is nothing else"
    assert {order[0] for order in (*light, *orders)} == {"small"}
    assert {order[1] for order in orders} == set(LANES) - {"small"}  # they take turns


def backlog(queue: JobQueue, lane: str) -> int:
    added, done = queue.redis.hmget(queue.records.keys.work, [f"{lane}:added", f"{lane}:done"])
    return int(added or 0) - int(done or 0)


def place(queue: JobQueue, job_id: str) -> QueuePosition | None:
    view = queue.get(job_id)
    assert view is not None
    return queue.with_position(view).place


def depths(queue: JobQueue) -> dict[str, int]:
    return {str(lane): depth for lane, depth in queue.chunks.depths().items() if depth}


def test_chunks_go_to_the_lane_of_their_cost(queue: JobQueue) -> None:
    queue.submit(a_request("1"))
    queue.submit(a_document())
    assert depths(queue) == {"small": 2}
    queue.submit(a_request("1", "2", "3", "4", fixed_leg=2))
    assert depths(queue) == {"small": 2, "bulk": 2}
    queue.submit(a_heavy_document())
    assert depths(queue) == {"small": 2, "bulk": 2, "heavy": 1}


def test_a_known_eliminant_makes_a_table_lighter(redis: Redis) -> None:
    queue = JobQueue(redis, WorkerSettings(chunk_seconds=0.05, heavy_seconds=0.05))
    request = a_request("1", "2")
    assert queue.plan(request, 2).lane == "heavy"
    redis.set(queue.store.keys.eliminant(request.geometry_hash, 1), "{}")
    assert queue.plan(request, 2).lane == "small"


def test_an_attempt_that_was_lost_goes_back_to_its_own_lane(queue: JobQueue) -> None:
    queue.submit(a_heavy_document())
    queue.redis.delete(queue.chunks.queues["heavy"].key)
    sweeper = Sweeper(queue.redis, queue.settings)
    while not depths(queue):
        time.sleep(0.002)
        sweeper.sweep()
    assert depths(queue) == {"heavy": 1}


def test_the_place_of_a_job(queue: JobQueue) -> None:
    views = [queue.submit(a_request(str(n))) for n in (1, 2, 3)]
    queue.submit(a_heavy_document())
    each = queue.plan(a_request("1"), 1).seconds
    for i, view in enumerate(views):
        spot = place(queue, view.id)
        assert spot is not None
        assert (spot.position, spot.seconds) == (i, pytest.approx(i * each, abs=0.01))
    work(queue, next(ref for ref in refs(queue) if ref.job_id == views[0].id))
    assert place(queue, views[0].id) is None
    third = place(queue, views[2].id)
    assert third is not None
    assert (third.position, third.seconds) == (1, pytest.approx(each, abs=0.01))
    queue.cancel(views[1].id)
    assert place(queue, views[2].id) == QueuePosition(0, 0.0)


def test_jobs_of_one_millisecond_have_an_order(redis: Redis) -> None:
    script = library("accounts") + "return rank('heavy-batch', ARGV[1])"
    ranks = [float(redis.eval(script, 0, f"1790000000.1234{k}0")) for k in range(10)]
    assert ranks == sorted(set(ranks))


def test_twice_the_workers_halve_the_wait(queue: JobQueue) -> None:
    views = [queue.submit(a_request(str(n))) for n in (1, 2)]
    alone = place(queue, views[1].id)
    roster = Roster(queue.redis, queue.settings)
    for name in ("a", "b"):
        roster.beat(name, is_light=name == "a")
    shared = place(queue, views[1].id)
    assert alone is not None
    assert shared is not None
    assert shared.seconds == pytest.approx(alone.seconds / 2, abs=0.002)
    first, second = (queue.submit(a_heavy_document(digits)) for digits in (30, 31))
    assert (first.status, second.status) == ("queued", "queued")
    heavy = place(queue, second.id)
    assert heavy is not None
    assert heavy.seconds == pytest.approx(queue.plan(a_heavy_document(), 1).seconds, abs=0.01), (
        "one takes heavy chunks"
    )


def test_work_is_counted_down_slice_by_slice(queue: JobQueue) -> None:
    queue.submit(a_document())  # goes on, so that nothing is forgotten
    queue.submit(a_request("1", "2", "3", "4", "5"))
    whole = backlog(queue, "bulk")
    first, second = (ref for ref in refs(queue) if ref.job_id.startswith("ct-"))
    work(queue, first, 2)
    assert backlog(queue, "bulk") == pytest.approx(whole * 3 / 5, abs=5)
    work(queue, first)
    work(queue, second)
    assert backlog(queue, "bulk") == 0
    assert backlog(queue, "small") > 0


@pytest.mark.parametrize("end", ["succeeded", "failed", "canceled"])
def test_nothing_is_left_of_a_job_that_ended(queue: JobQueue, end: str) -> None:
    queue.submit(a_document())
    view = queue.submit(a_request("1"), deadline_s=60)
    [ref] = [ref for ref in refs(queue) if ref.job_id == view.id]
    if end == "succeeded":
        work(queue, ref)
    elif end == "failed":
        queue.records.fail(ref, "solver-error", "undecided")
    else:
        queue.cancel(view.id)
    keys = queue.records.keys
    assert queue.redis.zscore(keys.queued, view.id) is queue.redis.zscore(keys.deadlines, view.id) is None
    assert backlog(queue, "small") == round(1000 * queue.plan(a_document(), 1).seconds)
    queue.cancel(a_document().job_id)
    assert not queue.redis.exists(keys.queued, keys.deadlines, keys.work)


def test_a_full_lane_refuses_jobs_and_others_do_not(redis: Redis) -> None:
    each = JobQueue(redis).plan(a_request("1"), 1).seconds
    queue = JobQueue(redis, WorkerSettings(max_backlog=3.5 * each))
    accepted = [queue.submit(a_request(str(n))) for n in (1, 2, 3)]
    with pytest.raises(QueueFullError) as full:
        queue.submit(a_request("4"))
    assert (full.value.lane, full.value.seconds) == ("small", pytest.approx(3 * each, abs=0.01))
    assert queue.get(a_request("4").job_id) is None
    assert queue.submit(a_request("2")) == accepted[1], "joining costs nothing"
    assert queue.submit(a_heavy_document()).status == "queued", (
        "another lane; a single job may be of any size"
    )
    finish(queue)
    assert queue.submit(a_request("4")).status == "queued"


def test_more_workers_have_more_room(redis: Redis) -> None:
    each = JobQueue(redis).plan(a_request("1"), 1).seconds
    queue = JobQueue(redis, WorkerSettings(max_backlog=1.6 * each))
    for name in ("a", "b"):
        Roster(redis, queue.settings).beat(name)
    for n in (1, 2, 3):
        queue.submit(a_request(str(n)))
    with pytest.raises(QueueFullError):
        queue.submit(a_request("4"))


def test_simultaneous_jobs_do_not_overfill_a_lane(redis: Redis) -> None:
    each = JobQueue(redis).plan(a_request("1"), 1).seconds
    queue = JobQueue(redis, WorkerSettings(max_backlog=10.5 * each))

    def is_accepted(n: int) -> bool:
        try:
            return queue.submit(a_request(str(n))).status == "queued"
        except QueueFullError:
            return False

    with ThreadPoolExecutor(16) as pool:
        assert sum(pool.map(is_accepted, range(1, 101))) == 10
    assert depth(queue) == 10


def test_a_queued_job_ends_at_its_deadline(queue: JobQueue, caplog: pytest.LogCaptureFixture) -> None:
    view = queue.submit(a_request("1"), deadline_s=0.05)
    other = queue.submit(a_request("2"))
    assert view.deadline_at is not None
    assert other.deadline_at is None
    sweeper = Sweeper(queue.redis, queue.settings)
    while not (view := queue.get(view.id) or view).is_terminal:
        time.sleep(0.005)
        sweeper.sweep()
    assert (view.status, view.error and view.error["type"]) == ("failed", "timeout")
    [told] = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert told.startswith(
        "cusp-table: timeout at the deadline of its request; it had not begun, the estimate "
    )
    assert depth(queue) == 1
    again = queue.submit(a_request("1"))
    assert (again.status, again.deadline_at) == ("queued", None)


@pytest.mark.parametrize("later", [3600.0, None])
def test_the_longest_deadline_counts(queue: JobQueue, later: float | None) -> None:
    first = queue.submit(a_request("1"), deadline_s=0.02)
    extended = queue.submit(a_request("1"), deadline_s=later)
    assert extended.id == first.id
    assert (extended.deadline_at is None) == (later is None)
    assert queue.submit(a_request("1"), deadline_s=0.01).deadline_at == extended.deadline_at
    time.sleep(0.03)
    Sweeper(queue.redis, queue.settings).sweep()
    view = queue.get(first.id)
    assert view is not None
    assert view.status == "queued"
