"""Batches in Redis: jobs whose parts are items, in a list beside the record.

Items are pushed to the list as they are received; once all are there, the job is made. An item that is not
valid carries its problem, and is no part of what is to be done. What an item leaves beside its result in the
store is in the hash of errors; a bit says that it is done.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, cast

from redis import Redis

from worker.answers.kinds import Item, Outcome, batch_request, item_from_json, outcome_from_json
from worker.jobs.attempts import ItemsLostError, is_done
from worker.jobs.keys import InRedis
from worker.jobs.plan import plan_batch
from worker.jobs.records import Client, JobRecords, NewJob
from worker.jobs.view import JobView
from worker.settings import WorkerSettings

INTAKE_TTL = 120
"""Seconds for which what was received of a batch is kept until more is."""

ItemState = Literal["open", "succeeded", "failed"]


@dataclass(frozen=True)
class StoredItem:
    """An item, and how it stands.

    Attributes:
        index: its position in the batch, from 0.
        item: what is asked, or the problem in its place.
        state: how it stands; `open` until it is done.
        outcome: what it has beside the results in the store.
    """

    index: int
    item: Item
    state: ItemState
    outcome: Outcome


class Batches(InRedis):
    """The batches of one installation."""

    def done(self, job_id: str) -> bytes:
        """Returns the bits of the items that are done, the first one in the highest bit of the first byte."""
        return cast("bytes | None", self.redis.get(self.keys.job(job_id).bits)) or b""

    def read(self, job_id: str, indices: Sequence[int]) -> list[StoredItem]:
        """Returns items of a batch, without those that are lost."""
        if not indices:
            return []
        keys, first = self.keys.job(job_id), min(indices)
        span = max(indices) + 1 - first
        with self.redis.pipeline(transaction=False) as pipe:
            if span == len(indices):
                pipe.lrange(keys.items, first, max(indices))
            else:
                for index in indices:
                    pipe.lindex(keys.items, index)
            pipe.get(keys.bits)
            pipe.hmget(keys.errors, [str(index) for index in indices])
            *texts, bits, outcomes = pipe.execute()
        if span == len(indices):
            [row] = texts
            texts = [row[index - first] if index - first < len(row) else None for index in indices]
        found = zip(indices, texts, outcomes, strict=True)
        return [_stored(i, item_from_json(text), bits or b"", o) for i, text, o in found if text]


class Reception(InRedis):
    """A batch that is being received.

    Args:
        redis: the store.
        settings: of the workers.
        token: of the batch.
    """

    def __init__(self, redis: Redis, settings: WorkerSettings, token: str) -> None:
        super().__init__(redis, settings)
        self.token = token
        self.job_id = batch_request(token).job_id
        self._records = JobRecords(redis, settings)
        self._items = self.keys.job(self.job_id).items

    def push(self, items: Sequence[str]) -> None:
        """Add items, by their :meth:`~worker.answers.kinds.Item.to_json`."""
        with self.redis.pipeline() as pipe:
            pipe.rpush(self._items, *items)
            pipe.expire(self._items, INTAKE_TTL)
            pipe.execute()

    def begin(self, count: int, costs: Mapping[int, float], by: Client | None = None) -> JobView:
        """Make the job of the batch.

        Args:
            count: the number of all items.
            costs: the estimated seconds of the valid ones, by their positions in ascending order.
            by: who asks for it.

        Raises:
            ItemsLostError: the items are not there.
            QueueFullError: its lane holds too much work.
        """
        if self.redis.llen(self._items) != count:
            raise ItemsLostError(self.job_id)
        plan = plan_batch(costs, self._records.chunks.workers("batch")[0])
        failed = [position for position in range(count) if position not in costs]
        view = self._records.create(NewJob(batch_request(self.token, count), plan, by=by, failed=failed))
        if view is None:
            raise ItemsLostError(self.job_id)
        return view

    def drop(self) -> None:
        """Forget a batch that does not begin."""
        self.redis.delete(self._items)


def _stored(index: int, item: Item, bits: bytes, outcome: bytes | None) -> StoredItem:
    kept = outcome_from_json(outcome)
    state: ItemState = "open"
    if item.problem is not None or kept.failure is not None:
        state = "failed"
    elif is_done(bits, index):
        state = "succeeded"
    return StoredItem(index, item, state, kept)
