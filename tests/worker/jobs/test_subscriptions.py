"""A job belongs to those who asked for it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from redis import Redis

from tests.support.jobs import a_request
from worker.jobs import clients
from worker.jobs.clients import Subscriber
from worker.jobs.queue import JobQueue
from worker.jobs.views import JobView

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
    assert queue.depth() == 1
    assert withdrawn(queue, view, OTHER_KEY) == "canceled"
    assert queue.depth() == 0
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
