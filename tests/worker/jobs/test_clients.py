"""What clients want of jobs, and how much of them they may hold."""

from __future__ import annotations

import random
from concurrent.futures import ThreadPoolExecutor

import pytest
from redis import Redis

from tests.support.jobs import a_request, depth
from tests.support.processes import until
from worker.answers.documents import VERIFICATION
from worker.answers.kind import JobRequest
from worker.jobs import clients
from worker.jobs.clients import JobView, Quota, QuotaError, Subscriber
from worker.jobs.queue import JobQueue
from worker.jobs.upkeep import Inventory
from worker.settings import WorkerSettings

KEY, OTHER_KEY = Subscriber("key:a", is_known=True), Subscriber("key:b", is_known=True)


def stranger(address: str = "address:192.0.2.1", token: str | None = None) -> Subscriber:
    return Subscriber(address, False) if token is None else Subscriber(address, False, token)


@pytest.fixture
def queue(redis: Redis) -> JobQueue:
    return JobQueue(redis)


def withdrawn(queue: JobQueue, view: JobView, who: Subscriber) -> str:
    after = queue.withdraw(view.id, who)
    assert after is not None
    return after.status


def test_the_last_key_ends_the_job(queue: JobQueue) -> None:
    view = queue.submit_for(KEY, a_request("1"))
    assert queue.submit_for(OTHER_KEY, a_request("1")).run == view.run
    assert withdrawn(queue, view, KEY) == "queued"
    assert withdrawn(queue, view, KEY) == "queued"  # and no other's
    assert withdrawn(queue, view, Subscriber("key:never-asked", is_known=True)) == "queued"
    assert depth(queue) == 1
    assert withdrawn(queue, view, OTHER_KEY) == "canceled"
    assert depth(queue) == 0
    assert queue.submit_for(KEY, a_request("1")).status == "queued"


def test_a_key_asks_as_one(queue: JobQueue) -> None:
    for _ in range(3):
        view = queue.submit_for(Subscriber("key:a", is_known=True), a_request("1"))
    assert withdrawn(queue, view, KEY) == "canceled"


def test_a_request_that_waits_keeps_the_job(queue: JobQueue) -> None:
    waiting = Subscriber("key:a", is_known=True)
    view = queue.submit_for(waiting, a_request("1"), seconds=30)
    assert withdrawn(queue, view, KEY) == "queued"
    assert queue.subscriptions.add(view.id, waiting)  # it goes with the job in place of the answer
    assert withdrawn(queue, view, KEY) == "canceled"
    assert not queue.subscriptions.add(view.id, waiting)


def test_a_request_that_died_while_it_waited_keeps_nothing(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clients, "_MARGIN", -1)
    view = queue.submit_for(KEY, a_request("1"), seconds=0.5)
    assert withdrawn(queue, view, KEY) == "canceled"


def test_without_keys_each_question_is_its_own(queue: JobQueue) -> None:
    one, two = stranger(), stranger()
    view = queue.submit_for(one, a_request("1"))
    queue.submit_for(two, a_request("1"))
    for _ in range(2):
        assert withdrawn(queue, view, one) == "queued"
    assert withdrawn(queue, view, stranger(token="0" * 24)) == "queued"
    assert withdrawn(queue, view, two) == "canceled"


def test_without_its_token_a_question_is_known_by_its_address(queue: JobQueue) -> None:
    here, there = stranger(token=""), stranger("address:192.0.2.2", token="")
    view = queue.submit_for(stranger(), a_request("1"))
    queue.submit_for(stranger(), a_request("1"), seconds=30)
    assert withdrawn(queue, view, there) == "queued"
    assert withdrawn(queue, view, here) == "queued"
    assert withdrawn(queue, view, here) == "queued"  # the other one waits
    alone = queue.submit_for(stranger(), a_request("2"))
    assert withdrawn(queue, alone, there) == "queued"
    assert withdrawn(queue, alone, here) == "canceled"


def test_a_job_that_nobody_is_noted_for(queue: JobQueue) -> None:
    view = queue.submit(a_request("1"))
    assert withdrawn(queue, view, KEY) == "canceled"
    assert withdrawn(queue, view, KEY) == "canceled"
    assert queue.withdraw("ct-0", KEY) is None


def test_beyond_many_clients_nobody_ends_the_job(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clients, "MAX_RECORD_FIELDS", 20)
    strangers = [stranger() for _ in range(40)]
    for who in strangers:
        view = queue.submit_for(who, a_request("1"))
    assert queue.redis.hlen(queue.records.keys.job(view.id).record) <= 21
    for who in strangers:
        assert withdrawn(queue, view, who) == "queued"


def test_who_asks_while_the_others_withdraw_keeps_the_job(queue: JobQueue) -> None:
    """Whatever the order of two requests, a client that asked and did not withdraw has an active job."""

    def ask_and_withdraw(n: int) -> None:
        who = Subscriber(f"key:{n}", is_known=True)
        for _ in range(10):
            queue.withdraw(queue.submit_for(who, a_request("1")).id, who)

    with ThreadPoolExecutor(4) as pool:
        others = [pool.submit(ask_and_withdraw, n) for n in range(3)]
        for _ in range(10):
            view = queue.submit_for(KEY, a_request("1"))
            now = queue.get(view.id)
            assert now is not None
            assert now.status == "queued"
            queue.withdraw(view.id, KEY)
        for other in others:
            other.result()
    assert queue.records.open_chunks() == []


ME, OTHER = Subscriber("key:a", is_known=True), Subscriber("key:b", is_known=True)


def ask(queue: JobQueue, l1: str, quota: Quota, who: Subscriber = ME, seconds: float = 1.0) -> str:
    request = a_request(l1)
    queue.quotas.admit(who.client, request.job_id, seconds, quota)
    return queue.submit_for(who, request).id


def test_a_number_of_jobs(queue: JobQueue) -> None:
    two = Quota(jobs=2)
    first = ask(queue, "1", two)
    ask(queue, "2", two)
    with pytest.raises(QuotaError) as refused:
        ask(queue, "3", two)
    assert (refused.value.jobs, refused.value.seconds) == (2, 2.0)
    assert ask(queue, "1", two) == first  # it is one of the two
    ask(queue, "3", two, OTHER)
    queue.withdraw(first, ME)
    ask(queue, "3", two)


def test_an_amount_of_work(queue: JobQueue) -> None:
    ten = Quota(seconds=10)
    ask(queue, "1", ten, seconds=60)  # one is always allowed
    with pytest.raises(QuotaError):
        ask(queue, "2", ten, seconds=1)
    ask(queue, "2", ten, OTHER, seconds=5)
    ask(queue, "3", ten, OTHER, seconds=5)
    with pytest.raises(QuotaError):
        ask(queue, "4", ten, OTHER, seconds=0.001)


def test_jobs_that_ended_do_not_count(queue: JobQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clients, "_GRACE", 0)
    one = Quota(jobs=1)
    for l1 in ("1", "2", "3"):
        queue.cancel(ask(queue, l1, one))
    assert queue.redis.hlen(queue.quotas.keys.client(ME.client)) == 1


def test_simultaneous_questions_do_not_pass_the_quota(queue: JobQueue) -> None:
    def try_it(n: int) -> bool:
        try:
            ask(queue, str(n), Quota(jobs=3))
        except QuotaError:
            return False
        return True

    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(try_it, range(1, 17))) == 3


def test_no_quota(queue: JobQueue) -> None:
    for n in range(1, 4):
        ask(queue, str(n), Quota())
    assert not queue.redis.exists(queue.quotas.keys.client(ME.client))


def long(n: int, size: int = 10_000) -> JobRequest:
    """A question of which the record keeps the hash alone."""
    head = {"geometry": a_request("1").geometry, "digits": 20}
    return JobRequest(VERIFICATION, {**head, "document": {**head, "padding": f"x{n:03}".ljust(size, "x")}})


def submit(queue: JobQueue, request: JobRequest, quota: Quota, who: Subscriber = ME) -> str:
    queue.quotas.admit(who.client, request.job_id, 1.0, quota, len(request.to_json()))
    return queue.submit_for(who, request).id


def kept(queue: JobQueue, who: Subscriber = ME) -> int:
    """The bytes that count for a client, as a refusal tells them."""
    with pytest.raises(QuotaError) as refused:
        queue.quotas.admit(who.client, "none", 1.0, Quota(kept_bytes=1), 10**9)
    assert refused.value.kept_bytes is not None
    return refused.value.kept_bytes


def test_bytes_of_questions(queue: JobQueue) -> None:
    """While a job is active its question counts, then what its record keeps of it, until that is gone."""
    some = Quota(kept_bytes=25_000)
    ids = [submit(queue, long(n), some) for n in range(2)]
    assert 20_000 < kept(queue) < 22_000
    with pytest.raises(QuotaError) as refused:
        submit(queue, long(3), some)
    assert refused.value.retry_s == 0, "one must end"
    submit(queue, long(3), some, OTHER)
    submit(queue, long(0), some)  # it is one of them
    queue.submit_for(OTHER, long(1))  # who joins does not pay
    for job_id in ids:
        queue.cancel(job_id)
    assert 150 < kept(queue) < 400
    assert 10_000 < kept(queue, OTHER) < 11_000
    submit(queue, long(3, 20_000), some)


def test_what_is_kept_counts_until_it_expires(redis: Redis) -> None:
    queue = JobQueue(redis, WorkerSettings(failure_ttl=2))
    tables = [a_request(*(f"{n}.{k}" for k in range(1, 300))) for n in range(3)]
    some = Quota(kept_bytes=6_000)
    for request in tables[:2]:
        queue.cancel(submit(queue, request, some))
    before = kept(queue)
    assert 4_000 < before < 6_000
    with pytest.raises(QuotaError) as refused:
        submit(queue, tables[2], some)
    assert 1 <= refused.value.retry_s <= 4
    until(lambda: kept(queue) == 0)
    submit(queue, tables[2], some)


def test_what_is_removed_or_asked_again_leaves_the_ledger(queue: JobQueue) -> None:
    table = a_request(*(str(k) for k in range(1, 300)))
    no_bound = Quota(kept_bytes=10**9)
    for _ in range(3):
        queue.cancel(submit(queue, table, no_bound))
    once = kept(queue)
    assert 1_000 < once < 4_000, "it is the same record, made anew"
    pruned = Inventory(queue.redis, queue.settings).prune(older_than=-1.0)
    assert pruned.keys > 0
    assert kept(queue) == 0
    queue.cancel(submit(queue, table, no_bound))
    assert kept(queue) == once


def test_a_store_that_was_emptied_counts_nothing(queue: JobQueue) -> None:
    submit(queue, long(1), Quota(kept_bytes=10**9))
    queue.redis.delete(queue.records.keys.job(long(1).job_id).record)
    assert kept(queue) <= len(long(1).to_json()), "for some seconds it may be about to be made"
    queue.redis.flushall()
    assert kept(queue) == 0


def test_questions_that_come_count_until_their_job_is_made(queue: JobQueue) -> None:
    some = Quota(kept_bytes=25_000)
    queue.quotas.receive(ME.client, "ba-1", 10_000, some, 60)
    queue.quotas.receive(ME.client, "ba-1", 20_000, some, 60)
    assert kept(queue) == 20_000
    with pytest.raises(QuotaError):
        queue.quotas.receive(ME.client, "ba-2", 10_000, some, 60)
    with pytest.raises(QuotaError):
        submit(queue, long(1), some)
    queue.quotas.forget_received(ME.client, "ba-1")
    assert kept(queue) == 0
    queue.quotas.receive(ME.client, "ba-3", 20_000, some, 0.01)  # and whoever received it died
    until(lambda: kept(queue) == 0)


def test_simultaneous_questions_do_not_pass_the_bytes(queue: JobQueue) -> None:
    def try_it(n: int) -> bool:
        try:
            submit(queue, long(n), Quota(kept_bytes=35_000))
        except QuotaError:
            return False
        return True

    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(try_it, range(16))) == 3


@pytest.mark.parametrize("seed", range(3))
def test_the_ledger_is_what_the_records_say(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    """Whatever happens to jobs, in whatever order, and wherever a process dies on the way."""
    monkeypatch.setattr(clients, "_GRACE", 0)
    draw, inventory, some = (
        random.Random(seed),
        Inventory(queue.redis, queue.settings),
        Quota(kept_bytes=10**9),
    )
    requests = [long(n, 2000) for n in range(4)] + [a_request(*map(str, range(1, 200 + n))) for n in range(4)]
    for _ in range(60):
        request = draw.choice(requests)
        record = queue.records.keys.job(request.job_id).record
        act = draw.choice(["submit", "submit", "die", "cancel", "end", "prune"])
        if act == "submit":
            submit(queue, request, some)
        elif act == "die":
            queue.quotas.admit(ME.client, request.job_id, 1.0, some, len(request.to_json()))
        elif act == "cancel":
            queue.withdraw(request.job_id, ME) if draw.random() < 0.5 else queue.cancel(request.job_id)
        elif act == "end":
            for entry in [e for e in queue.records.open_chunks() if e.ref.job_id == request.job_id]:
                queue.attempts.start(entry.ref)
                queue.records.fail(entry.ref, "solver-error", "undecided")
        elif queue.redis.ttl(record) > 0:
            inventory._take(list(inventory._items([record.encode()])))
        records = [name for name in queue.redis.keys("cusps:job*") if name.count(b":") == 2]
        said = [queue.redis.hmget(name, "ledger", "bytes") for name in records]
        by_records = sum(int(size) for ledger, size in said if ledger is not None)
        until(lambda expected=by_records: kept(queue) == expected)  # a question goes a millisecond later
