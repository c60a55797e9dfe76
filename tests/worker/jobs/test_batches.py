"""The life of a batch, with the test acting as the worker."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from rpr_solver import EXAMPLES
from tests.support.jobs import a_document, a_request, depth
from worker.answers.censuses import CENSUS
from worker.answers.documents import POSES
from worker.answers.kind import ALL_LENGTHS, JobRequest
from worker.answers.kinds import Item, ItemSolver, Outcome, batch_request, new_batch, new_manipulators
from worker.answers.tables import CUSP_TABLE
from worker.jobs.batches import Batches, ItemsLostError, Reception, StoredItem
from worker.jobs.chunks import ChunkEntry, ChunkRef
from worker.jobs.clients import JobView
from worker.jobs.plan import LANES, lanes_of, plan_batch
from worker.jobs.queue import JobQueue
from worker.jobs.upkeep import Interruptions
from worker.settings import WorkerSettings

BAD = Item("bad", problem={"type": "/problems/invalid-request", "status": 422})
FAILED = Outcome({"type": "solver-error", "detail": "undecided"})


@pytest.fixture
def batches(queue: JobQueue) -> Batches:
    return Batches(queue.redis, queue.settings)


def begin(batches: Batches, items: Sequence[Item]) -> JobView:
    reception = Reception(batches.redis, batches.settings, new_batch())
    for first in range(0, len(items), 2):
        reception.push([item.to_texts() for item in items[first : first + 2]])
    costs = {i: 0.01 for i, item in enumerate(items) if item.problem is None}
    return reception.begin(len(items), costs)


def questions(*l1: str) -> list[Item]:
    return [Item(f"item {x}", a_request(x)) for x in l1]


def entries(queue: JobQueue) -> list[ChunkEntry]:
    return sorted(queue.records.open_chunks(), key=lambda entry: entry.ref.index)


def work(queue: JobQueue, batches: Batches, ref: ChunkRef, *outcomes: Outcome) -> None:
    """Count the next items of a chunk."""
    chunk = queue.attempts.start(ref)
    assert chunk is not None
    for offset, outcome in enumerate(outcomes, chunk.offset):
        batches.put_items(ref, chunk, offset, [outcome])


def states(batches: Batches, view: JobView) -> list[str]:
    return [stored.state for stored in batches.read(view.id, range(view.total))]


def now(queue: JobQueue, view: JobView) -> JobView:
    current = queue.get(view.id)
    assert current is not None
    return current


def test_from_queued_to_succeeded(queue: JobQueue, batches: Batches) -> None:
    items = [*questions("1", "2"), BAD, *questions("3", "4", "5")]
    view = begin(batches, items)
    assert view.id.startswith("ba-")
    assert (view.status, view.done, view.total, view.failed) == ("queued", 1, 6, 1)
    assert queue.redis.ttl(batches.keys.job(view.id).items) == -1
    first, second = (entry.ref for entry in entries(queue))
    chunk = queue.attempts.start(first)
    assert chunk is not None
    assert chunk.parts == ("0", "1", "3")
    assert [item.id for item in batches.items_of(first, chunk)] == ["item 1", "item 2", "item 3"]
    work(queue, batches, first, Outcome(), FAILED)
    assert states(batches, view) == ["succeeded", "failed", "failed", "open", "open", "open"]
    assert (now(queue, view).done, now(queue, view).failed) == (3, 2)
    work(queue, batches, first, Outcome(slices={"3": {"l1": "3", "error": {}}}))
    work(queue, batches, second, Outcome(), Outcome())
    done = now(queue, view)
    assert (done.status, done.done, done.failed) == ("succeeded", 6, 2)
    assert states(batches, view) == ["succeeded", "failed", "failed", *["succeeded"] * 3]
    stored = batches.read(view.id, [1, 2, 3])
    assert stored[0].outcome == FAILED
    assert stored[1] == StoredItem(2, BAD, "failed", Outcome())
    assert stored[2].outcome.slices == {"3": {"l1": "3", "error": {}}}
    for key in batches.keys.job(view.id)[2:6]:
        assert queue.redis.ttl(key) > 0


def test_an_item_is_counted_once_and_only_by_the_current_attempt(queue: JobQueue, batches: Batches) -> None:
    view = begin(batches, questions("1", "2"))
    [entry] = entries(queue)
    work(queue, batches, entry.ref, Outcome())
    chunk = queue.attempts.start(entry.ref)
    assert chunk is not None
    assert batches.put_items(entry.ref, chunk, 0, [FAILED])
    assert (now(queue, view).done, now(queue, view).failed) == (1, 0)
    assert queue.attempts.reopen(entry.ref) != "stale"
    assert not batches.put_items(entry.ref, chunk, 1, [Outcome()])
    assert now(queue, view).done == 1


def test_what_kills_a_horse_costs_one_item(queue: JobQueue, batches: Batches) -> None:
    view = begin(batches, questions("1", "2", "3"))
    interruptions = Interruptions(queue.redis, queue.settings)
    work(queue, batches, entries(queue)[0].ref, Outcome())
    for _ in range(queue.settings.max_losses + 1):
        [entry] = entries(queue)
        assert queue.attempts.start(entry.ref) is not None
        assert interruptions.run_again(entry.ref, "horses", "worker-crashed", "again")
    assert states(batches, view) == ["succeeded", "failed", "open"]
    [entry] = entries(queue)
    assert queue.attempts.start(entry.ref) is not None
    assert not interruptions.give_up(entry.ref, "timeout", "too long")
    view = now(queue, view)
    assert (view.status, view.failed) == ("succeeded", 2)
    assert [s.outcome.failure for s in batches.read(view.id, [1, 2])] == [
        {"type": "worker-crashed", "detail": "again"},
        {"type": "timeout", "detail": "too long"},
    ]


def test_a_canceled_batch_keeps_what_is_done(queue: JobQueue, batches: Batches) -> None:
    view = begin(batches, questions("1", "2", "3", "4"))
    work(queue, batches, entries(queue)[0].ref, FAILED, Outcome())
    canceled = queue.cancel(view.id)
    assert canceled is not None
    assert (canceled.status, canceled.done, canceled.failed) == ("canceled", 2, 1)
    assert states(batches, view) == ["failed", "succeeded", "open", "open"]
    assert depth(queue) == 1  # what was begun


def test_all_items_bad_is_done_at_once(batches: Batches) -> None:
    view = begin(batches, [BAD, BAD])
    assert (view.status, view.done, view.failed) == ("succeeded", 2, 2)


def test_items_that_are_missing(queue: JobQueue, batches: Batches) -> None:
    reception = Reception(queue.redis, queue.settings, new_batch())
    reception.push([questions("1")[0].to_texts()])
    with pytest.raises(ItemsLostError):
        reception.begin(2, {0: 1.0, 1: 1.0})
    reception.drop()
    assert queue.redis.keys("cusps:job*") == []
    view = begin(batches, questions("1"))
    queue.redis.delete(batches.keys.job(view.id).items)
    chunk = queue.attempts.start(entries(queue)[0].ref)
    assert chunk is not None
    with pytest.raises(ItemsLostError):
        batches.items_of(entries(queue)[0].ref, chunk)
    assert batches.read(view.id, [0]) == []


def test_a_batch_is_one_submission() -> None:
    one, another = new_batch(), new_batch()
    assert batch_request(one).job_id == batch_request(one, 7).job_id != batch_request(another).job_id
    assert batch_request(one, 3).parts == ["0", "1", "2"]


def answer(solver: ItemSolver, request: JobRequest) -> Outcome:
    """Answer a question, and keep what was found at once."""
    outcome = solver.solve(request)
    solver.keep()
    return outcome


def test_an_answer_is_computed_once_and_renewed(queue: JobQueue) -> None:
    solver = ItemSolver(queue.store)
    table, document = a_request("14.98", "27"), a_document()
    for request in (table, document):
        assert queue.known(request) is None
        assert answer(solver, request) == Outcome()
        assert queue.known(request) is not None
    kept = [*queue.store.slice_keys(table, table.parts), queue.store.keys.document(document.content_hash)]
    for key in kept:
        queue.redis.expire(key, 5)
    before = queue.redis.info("commandstats")["cmdstat_set"]["calls"]  # type: ignore[index]
    assert answer(solver, table) == answer(solver, document) == Outcome()
    assert all(queue.redis.ttl(key) > 5 for key in kept)
    assert queue.redis.info("commandstats")["cmdstat_set"]["calls"] == before  # type: ignore[index]


def test_slices_of_several_tables_are_kept_together(queue: JobQueue) -> None:
    """What was solved is kept with the others, or before slices of the same manipulator are looked for."""
    solver, one = ItemSolver(queue.store), EXAMPLES["innocenti"].to_json()
    other = JobRequest(CUSP_TABLE, {**a_request("27").content, "geometry": {**one, "d1": "17.05"}})
    for request in (a_request("14.98"), other):
        assert solver.solve(request) == Outcome()
        assert queue.known(request) is None
    assert solver.solve(a_request("14.98", "20")) == Outcome()
    assert queue.known(a_request("14.98")) is not None
    assert queue.known(other) is not None
    assert queue.known(a_request("20")) is None
    solver.keep()
    assert queue.known(a_request("20", "14.98")) is not None


def test_items_are_counted_together(queue: JobQueue, batches: Batches) -> None:
    view = begin(batches, questions("1", "2", "3"))
    [entry] = entries(queue)
    chunk = queue.attempts.start(entry.ref)
    assert chunk is not None
    batches.put_items(entry.ref, chunk, 0, [Outcome()])
    assert batches.put_items(entry.ref, chunk, 0, [Outcome(), FAILED])
    assert states(batches, view) == ["succeeded", "failed", "open"]
    assert (now(queue, view).done, now(queue, view).failed) == (2, 1)
    batches.put_items(entry.ref, chunk, 2, [Outcome()])
    assert (now(queue, view).status, now(queue, view).failed) == ("succeeded", 1)


def test_manipulators_are_looked_up_together(queue: JobQueue) -> None:
    """Of a new one nothing is looked for; one that was asked for before, or is kept, is no new one."""
    request = a_request("14.98")
    solver = ItemSolver(queue.store, [request, a_request("27"), a_document()])
    before = queue.redis.info("commandstats").get("cmdstat_mget", {"calls": 0})["calls"]  # type: ignore[union-attr]
    assert answer(solver, request) == Outcome()
    assert queue.redis.info("commandstats").get("cmdstat_mget", {"calls": 0})["calls"] == before  # type: ignore[union-attr]
    assert queue.known(request) is not None
    assert new_manipulators(queue.store, [request]) == set()
    [use] = queue.redis.keys("*eliminant-use*")
    queue.redis.delete(use)
    assert new_manipulators(queue.store, [request]) == set()  # its slice is kept
    assert answer(solver, a_request("14.98", "27")) == Outcome()


def test_a_slice_without_an_answer_is_an_error_of_its_table(queue: JobQueue) -> None:
    error = {"l1": "5", "error": {"type": "solver-error", "detail": "undecided"}}
    queue.store.put_slices(a_request("5"), {"5": error})
    assert answer(ItemSolver(queue.store), a_request("14.98", "5")) == Outcome(slices={"5": error})


@pytest.mark.parametrize(
    ("costs", "lane", "size"),
    [
        ([0.01] * 100, "batch", 34),  # at most 40, and about as many in each
        ([0.5] * 10, "batch", 2),
        ([2.0] * 10, "heavy-batch", 1),
        ([0.01] * 99 + [2.0], "heavy-batch", 25),
        ([0.9] * 5000, "heavy-batch", 5),  # no more than a thousand chunks
        ([100.0] * 5000, "heavy-batch", 1),  # far below the deadline
    ],
)
def test_chunks_by_price(costs: list[float], lane: str, size: int) -> None:
    plan = plan_batch(costs, WorkerSettings(chunk_size=40))
    assert plan.lane == lane
    assert plan.chunk_count * plan.chunk_size >= len(costs) > (plan.chunk_count - 1) * plan.chunk_size
    assert plan.chunk_size * max(costs) < WorkerSettings().deadline
    assert plan.chunk_size == size
    assert plan.seconds == pytest.approx(sum(costs))


@pytest.mark.parametrize(
    ("costs", "workers", "count"),
    [([0.01] * 85, 2, 2), ([0.01] * 85, 8, 8), ([0.01] * 12, 8, 2), ([0.01] * 4, 8, 1), ([0.5] * 3, 8, 3)],
)
def test_each_worker_gets_a_chunk_if_it_is_worth_while(costs: list[float], workers: int, count: int) -> None:
    plan = plan_batch(costs, WorkerSettings(), workers)
    assert plan.chunk_count == count
    assert plan.chunk_size == -(-len(costs) // count)


def test_no_lane_waits_for_a_batch() -> None:
    """Of any two lanes that hold work, each comes first as often; small jobs always do."""
    orders = lanes_of("all")
    assert all(order[0] == "small" and set(order) == set(LANES) for order in orders)
    assert all("heavy" not in lane for order in lanes_of("light") for lane in order)
    for one in LANES[1:]:
        for other in set(LANES[1:]) - {one}:
            assert sum(order.index(one) < order.index(other) for order in orders) * 2 == len(orders)


def test_a_whole_census_is_computed_and_its_parts_are_kept(queue: JobQueue) -> None:
    """The computation of a census keeps the whole one under a lock, which must not be the item's own."""
    geometry = EXAMPLES["zein-flat"].to_json()
    whole = {"geometry": geometry, "fixed_leg": 1, "digits": 15, "range": ALL_LENGTHS}
    part = {**whole, "range": {"from": "20", "to": "30"}}
    for content in (whole, part):
        request = JobRequest(CENSUS, content)
        assert answer(ItemSolver(queue.store), request) == Outcome()
        assert queue.store.get_document(request) is not None
    assert queue.redis.keys("cusps:*lock*") == []


@pytest.mark.parametrize("is_canceled", [False, True])
def test_long_questions_go_with_the_end(queue: JobQueue, batches: Batches, is_canceled: bool) -> None:
    long = [JobRequest(POSES, {"l1": f"{n}{'9' * 100_000}"}) for n in range(3)]
    items = [*questions("1"), BAD, *(Item(f"long {n}", request) for n, request in enumerate(long))]
    view = begin(batches, items)
    keys = batches.keys.job(view.id).questions, batches.keys.job(view.id).items
    assert [queue.redis.ttl(key) for key in keys] == [-1, -1]
    for ref in [entry.ref for entry in entries(queue)]:
        chunk = queue.attempts.start(ref)
        assert chunk is not None
        asked = [items[int(part)] for part in chunk.parts]
        assert batches.items_of(ref, chunk) == asked
        if is_canceled:
            queue.cancel(view.id)
            break
        for item in asked:
            assert item.request is not None
            queue.store.put_document(item.request, {"answer": item.id})
        work(queue, batches, ref, *[Outcome()] * len(asked))
    assert not queue.redis.exists(keys[0])
    assert (queue.redis.memory_usage(keys[1], samples=0) or 0) < 3000
    stored = batches.read(view.id, range(view.total))
    assert [one.item.id for one in stored] == [item.id for item in items]
    if not is_canceled:
        for request, one in zip(long, stored[2:], strict=True):
            assert one.item.request is not None
            assert queue.known(one.item.request) == queue.known(request) == {"answer": one.item.id}


def test_a_batch_that_lost_its_long_questions(queue: JobQueue, batches: Batches) -> None:
    view = begin(batches, [Item("long", JobRequest(POSES, {"l1": "9" * 5000}))])
    queue.redis.delete(batches.keys.job(view.id).questions)
    [entry] = entries(queue)
    chunk = queue.attempts.start(entry.ref)
    assert chunk is not None
    with pytest.raises(ItemsLostError):
        batches.items_of(entry.ref, chunk)


def test_what_is_dropped_before_it_begins(queue: JobQueue) -> None:
    reception = Reception(queue.redis, queue.settings, new_batch())
    reception.push([Item("long", JobRequest(POSES, {"l1": "9" * 5000})).to_texts()])
    names = queue.redis.keys("cusps:job*")
    assert len(names) == 2
    assert all(queue.redis.ttl(name) > 0 for name in names)
    reception.drop()
    assert not queue.redis.keys("cusps:job*")
