"""Batches in Redis: jobs whose parts are items, in a list beside the record.

The items are pushed while they are received, before the job is made; until then the list has a short
lifetime. Beside it is a list with the whole of those that are long, which goes when the job ends. An item
that is not valid carries its problem, and is no part of what is to be done. What an item leaves beside the
results in the store is in the hash of errors, and its bit says that it is done.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, cast

from redis import Redis

from worker.answers.items import Item, Outcome, batch_request, item_from_json, outcome_from_json
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import Chunk, ChunkQueue, ChunkRef
from worker.jobs.clients import Bytes
from worker.jobs.installation import Roster
from worker.jobs.keys import Keys
from worker.jobs.lanes import plan_batch
from worker.jobs.records import JobRecords
from worker.jobs.views import JobView
from worker.lua import Scripts
from worker.settings import WorkerSettings

INTAKE_TTL = 120
"""Seconds for which the items of a batch are kept until more arrive or the batch starts."""

ItemState = Literal["open", "succeeded", "failed"]


class ItemsLostError(Exception):
    """Redis no longer has the items of a batch; or it took too long until it began."""


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


class Batches:
    """The batches of one installation. Instances are cheap and may be shared between threads."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self.redis = redis
        self.settings = settings
        self.keys = Keys.of(settings)
        self.records = JobRecords(redis, settings)
        self._run = Scripts(redis)

    # -- accepting ---------------------------------------------------------------------------------

    def push(self, token: str, items: Sequence[tuple[str, str]]) -> None:
        """Add items, by their :meth:`~worker.answers.items.Item.to_texts`, to a batch that has not begun."""
        with self.redis.pipeline() as pipe:
            for key, texts in zip(self._lists(token), zip(*items, strict=True), strict=False):
                pipe.rpush(key, *texts)
            for key in self._lists(token):
                pipe.expire(key, INTAKE_TTL)
            pipe.execute()

    def drop(self, token: str) -> None:
        """Forget the items of a batch that has not begun."""
        self.redis.delete(*self._lists(token))

    def begin(self, token: str, count: int, costs: Mapping[int, float], size: Bytes | None = None) -> JobView:
        """Make the job of a batch from its items.

        Args:
            token: its token.
            count: the number of all its items.
            costs: the estimated seconds of the valid ones, by their positions.
            size: the bytes of all of them.

        Raises:
            ItemsLostError: the items are not there.
            QueueFullError: its lane holds too much work.
        """
        request = batch_request(token, count)
        workers = len(Roster(self.redis, self.settings).names())
        plan = plan_batch(list(costs.values()), self.settings, workers)
        created = self.records.create(request, [str(index) for index in costs], "", plan, size=size)
        view = self.records.view(request.job_id)
        if created is None or view is None:
            raise ItemsLostError(request.job_id)
        with self.redis.pipeline(transaction=False) as pipe:
            ChunkQueue(self.redis, self.settings).enqueue(created.refs, plan.lane, pipe)
            pipe.execute()
        return view

    # -- computing ---------------------------------------------------------------------------------

    def items_of(self, ref: ChunkRef, chunk: Chunk) -> list[Item]:
        """Returns the items of a chunk.

        Raises:
            ItemsLostError: Redis no longer has them.
        """
        first, last = int(chunk.parts[0]), int(chunk.parts[-1])
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.lrange(self.keys.job(ref.job_id).questions, first, last)
            pipe.lrange(self._items(ref.job_id), first, last)
            whole, kept = cast("list[list[bytes]]", pipe.execute())
        whole = whole or [b""] * len(kept)  # of a batch that was made before there was such a list
        if not len(whole) == len(kept) == last - first + 1:
            raise ItemsLostError(ref.job_id)
        at = [int(part) - first for part in chunk.parts]
        items = [item_from_json(whole[i] or kept[i]) for i in at]
        if any(item.request is not None and item.request.is_cut for item in items):
            raise ItemsLostError(ref.job_id)
        return items

    def put_items(self, ref: ChunkRef, chunk: Chunk, offset: int, outcomes: Sequence[Outcome]) -> bool:
        """Count items of a chunk from `offset` on, whose results are kept; False if this attempt is over."""
        end = offset + len(outcomes)
        items = zip(chunk.parts[offset:end], outcomes, strict=True)
        counted = [(item, outcome.to_json(), int(outcome.failure is not None)) for item, outcome in items]
        reply = self._run(
            "put_items",
            self.keys.names(ref.job_id),
            vars(ref),
            offset=end - 1,
            is_last=end == len(chunk.parts),
            job_ttl=self.settings.job_ttl,
            outcomes=[value for values in counted for value in values],
        )
        return bool(reply == 1)

    def give_up_item(self, ref: ChunkRef, kind: str, detail: str) -> bool:
        """Record that the item at which a chunk is has no answer; returns False if there is none."""
        current = Attempts(self.redis, self.settings).current(ref)
        if current is None:
            return False
        entry, chunk = current
        self.put_items(ref, chunk, entry.offset, [Outcome({"type": kind, "detail": detail})])
        return True

    # -- reading -----------------------------------------------------------------------------------

    def done(self, job_id: str) -> bytes:
        """Returns the bits of the items that are done, the first one in the highest bit of the first byte."""
        return cast("bytes | None", self.redis.get(self.keys.job(job_id).bits)) or b""

    def read(self, job_id: str, indices: Sequence[int]) -> list[StoredItem]:
        """Returns items of a batch, without those that are lost."""
        keys = self.keys.job(job_id)
        with self.redis.pipeline(transaction=False) as pipe:
            for index in indices:
                pipe.lindex(self._items(job_id), index)
            pipe.get(keys.bits)
            pipe.hmget(keys.errors, [str(index) for index in indices])
            *texts, bits, outcomes = pipe.execute()
        found = zip(indices, texts, outcomes, strict=True)
        version = self.settings.solver_version
        return [_stored(i, item_from_json(text, version), bits or b"", o) for i, text, o in found if text]

    def _items(self, job_id: str) -> str:
        return self.keys.job(job_id).items

    def _lists(self, token: str) -> tuple[str, str]:
        job_id = batch_request(token).job_id
        return self._items(job_id), self.keys.job(job_id).questions


def is_done(bits: bytes, index: int) -> bool:
    """Whether the bit of an item is set."""
    return index // 8 < len(bits) and bool(bits[index // 8] & (0x80 >> index % 8))


def _stored(index: int, item: Item, bits: bytes, outcome: bytes | None) -> StoredItem:
    kept = outcome_from_json(outcome)
    state: ItemState = "open"
    if item.problem is not None or kept.failure is not None:
        state = "failed"
    elif is_done(bits, index):
        state = "succeeded"
    return StoredItem(index, item, state, kept)
