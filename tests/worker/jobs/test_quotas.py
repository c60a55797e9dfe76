"""No client holds more of the queue than its quota."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest

from tests.support.jobs import a_request
from worker.jobs import quotas
from worker.jobs.queue import JobQueue
from worker.jobs.quotas import Quota, QuotaError
from worker.jobs.subscriptions import Subscriber

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
    monkeypatch.setattr(quotas, "_GRACE", 0)
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
