"""What is kept, and what is removed when it is too old or too much."""

from __future__ import annotations

import random

import pytest
from redis import Redis
from redis.exceptions import OutOfMemoryError

from tests.support.jobs import a_request
from worker.answers.kind import JobRequest
from worker.answers.layout import eliminant_ttl
from worker.answers.store import packed
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import ChunkRef
from worker.jobs.inventory import Inventory
from worker.jobs.queue import JobQueue
from worker.jobs.sweeper import Sweeper
from worker.settings import WorkerSettings

DAY = 86400


def put(queue: JobQueue, request: JobRequest, age: float, size: int = 100) -> list[str]:
    """Keep slices as if they had been computed some time ago."""
    ttl = int((queue.settings.result_ttl_seconds - age) * 1000)
    for key, l1 in zip(queue.store.slice_keys(request, request.parts), request.parts, strict=True):
        pad = random.Random(l1).randbytes(7 * size // 8).hex()  # which compression halves, nearly
        queue.redis.set(key, packed({"l1": l1, "cusps": [], "pad": pad}), px=ttl)
    return queue.store.slice_keys(request, request.parts)


@pytest.fixture
def inventory(redis: Redis, settings: WorkerSettings) -> Inventory:
    return Inventory(redis, settings)


def test_the_stock_by_kind(queue: JobQueue, inventory: Inventory) -> None:
    request = a_request("1", "2")
    put(queue, request, age=3 * DAY)
    queue.redis.set(queue.store.keys.eliminant("sha256:ab", 1), "{}", ex=eliminant_ttl(queue.settings))
    queue.redis.hset("cusps:keys", "a", "an API key")
    queue.redis.set("somebody-else", "1")
    queue.submit(a_request("7"))
    stock = inventory.stock()
    assert (stock["slice"].keys, stock["eliminant"].keys) == (2, 1)
    assert stock["slice"].size > 200
    assert stock["slice"].oldest == pytest.approx(3 * DAY, abs=60)
    assert stock["job"].oldest is None, "it is queued"
    assert stock["other"].keys == 5, "the API keys; the active jobs, the queued ones, their work, the list"


def test_what_is_older_is_removed(queue: JobQueue, inventory: Inventory) -> None:
    old, young = put(queue, a_request("1", "2"), 3 * DAY), put(queue, a_request("3"), DAY)
    queue.redis.hset("cusps:keys", "a", "an API key")
    pruned = inventory.prune(older_than=2 * DAY)
    assert (pruned.keys, pruned.needed) == (2, 0)
    assert pruned.size > 200
    assert not queue.redis.exists(*old)
    assert queue.redis.exists(*young, "cusps:keys") == 2


def test_the_oldest_are_removed_until_the_rest_fits(queue: JobQueue, inventory: Inventory) -> None:
    ages = [5, 1, 4, 2, 3]
    keys = [put(queue, a_request(str(age)), age * DAY, size=5000)[0] for age in ages]
    assert inventory.prune(max_bytes=2 * 6000).keys == 3
    assert [bool(queue.redis.exists(key)) for key in keys] == [False, True, False, True, False]
    assert inventory.prune(max_bytes=10**9).keys == 0


def test_what_an_active_job_has_found_or_computed_is_kept(queue: JobQueue, inventory: Inventory) -> None:
    found = a_request("1", "2", "3")
    put(queue, found, age=5 * DAY)
    view = queue.submit(a_request("1", "2", "3", "4"))  # renews what it finds
    assert view.status == "queued"
    other = put(queue, a_request("1", fixed_leg=2), age=5 * DAY)
    pruned = inventory.prune(older_than=0, max_bytes=0)
    assert not queue.redis.exists(*other), "no active job has found these"
    assert queue.redis.exists(*queue.store.slice_keys(found, found.parts)) == 3
    assert pruned.needed == 3
    ref = ChunkRef(view.id, view.run, 0, 0)
    attempts = Attempts(queue.redis, queue.settings)
    chunk = attempts.start(ref, 3, 3)
    assert chunk
    attempts.put_slices(ref, chunk, [3], [{"l1": "4", "cusps": []}])
    assert queue.get(view.id).status == "succeeded"
    assert queue.result(view.id) is not None
    assert inventory.prune(older_than=-1).needed == 0
    assert queue.get(view.id) is None


def test_what_is_found_meanwhile_is_kept(queue: JobQueue, inventory: Inventory) -> None:
    [key] = put(queue, a_request("1"), age=5 * DAY)
    [item] = inventory._items([key.encode()])
    queue.redis.expire(key, queue.settings.result_ttl_seconds)
    assert inventory._take([item]) == 0
    assert queue.redis.exists(key)


def test_the_sweeper_keeps_redis_below_its_bound(redis: Redis, queue: JobQueue) -> None:
    old = [put(queue, a_request(f"{i}"), 3 * DAY, size=100_000)[0] for i in range(1, 101)]
    young = [put(queue, a_request(f"{i}"), DAY, size=100_000)[0] for i in range(101, 201)]
    used = redis.info("memory")["used_memory"]
    megabytes = int((used - 3_000_000) / 0.8) // 2**20
    inventory = Inventory(redis, WorkerSettings(store_max_mb=megabytes))
    assert inventory.relieve() > 20
    assert redis.info("memory")["used_memory"] < 0.8 * megabytes * 2**20
    assert redis.exists(*old) < 80
    assert redis.exists(*young) == 100, "of each page, the older half goes first"
    before = redis.info("stats")["total_commands_processed"]
    assert inventory.relieve() == 0
    assert inventory.relieve() == 0
    assert redis.info("stats")["total_commands_processed"] - before <= 2, "it looks again after a while"


def test_a_server_with_a_limit_of_its_own_bounds_the_store(redis: Redis, queue: JobQueue) -> None:
    for i in range(1, 61):
        put(queue, a_request(f"{i}"), 3 * DAY, size=100_000)
    inventory = Inventory(redis, WorkerSettings())
    assert inventory.relieve() == 0, "there is no bound"
    inventory = Inventory(redis, WorkerSettings())
    redis.config_set("maxmemory", redis.info("memory")["used_memory"])
    try:
        assert inventory.relieve() > 0
    finally:
        redis.config_set("maxmemory", 0)


def test_the_sweeper_makes_room_where_none_is_left(redis: Redis, queue: JobQueue) -> None:
    for i in range(1, 61):
        put(queue, a_request(f"{i}"), 3 * DAY, size=100_000)
    redis.config_set("maxmemory", redis.info("memory")["used_memory"] - 500_000)
    try:
        with pytest.raises(OutOfMemoryError):
            redis.set("one more", 1)
        sweeper = Sweeper(redis, WorkerSettings())
        with pytest.raises(OutOfMemoryError):
            sweeper.sweep()  # there is no place for its lock
        assert redis.set("one more", 1)
        assert sweeper.sweep() == 0
    finally:
        redis.config_set("maxmemory", 0)
