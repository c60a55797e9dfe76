"""Batches in Redis: jobs whose parts are items, in a list beside the record.

The items are pushed to the list as they are received; beside it is one with the whole of those that are long,
which goes when the job ends. An item that is not valid carries its problem, and is no part of what is to be
done. What an item leaves beside its result in the store is in the hash of errors; a bit says that it is done.

What was received is given to the workers piece by piece. Until the last piece is given, nobody else sees the
job: its id is not known, it is in no list, and its record is shown to nobody. It has a deadline, which moves
with every push. If the process that receives it dies, the search for lost chunks ends it, and nothing stays
but answers, which are valid whoever asks for them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Literal, cast

from redis import Redis

from worker.answers.kinds import Item, Outcome, batch_request, item_from_json, outcome_from_json
from worker.jobs.attempts import Attempts
from worker.jobs.chunks import Chunk, ChunkQueue, ChunkRef
from worker.jobs.clients import Bytes, JobView, Subscriptions
from worker.jobs.installation import Roster
from worker.jobs.plan import InRedis, Lane, Plan, QueueFullError, plan_batch
from worker.jobs.records import JobRecords, work_arguments
from worker.settings import WorkerSettings

INTAKE_TTL = 120
"""Seconds for which what was received of a batch is kept until more is."""

_MOST_CHUNKS = 125  # of a piece that is given before all is received
_LAST_SHARE = 4  # by which the last chunks of a long batch are shorter, so that its workers end together

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


class Batches(InRedis):
    """The batches of one installation."""

    def items_of(self, ref: ChunkRef, chunk: Chunk) -> list[Item]:
        """Returns the items of a chunk.

        Raises:
            ItemsLostError: Redis no longer has them.
        """
        first, last = int(chunk.parts[0]), int(chunk.parts[-1])
        with self.redis.pipeline(transaction=False) as pipe:
            pipe.lrange(self.keys.job(ref.job_id).questions, first, last)
            pipe.lrange(self.keys.job(ref.job_id).items, first, last)
            whole, kept = cast("list[list[bytes]]", pipe.execute())
        whole = whole or [b""] * len(kept)  # Redis has lost the list; short questions are in the other one
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
        version = self.settings.solver_version
        return [_stored(i, item_from_json(text, version), bits or b"", o) for i, text, o in found if text]


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
        self._chunks = ChunkQueue(redis, settings)
        self._its_run = ""  # of the job, once workers have items of it

    def push(self, items: Sequence[tuple[str, str]]) -> None:
        """Add items, by their :meth:`~worker.answers.kinds.Item.to_texts`."""
        with self.redis.pipeline() as pipe:
            for key, texts in zip(self._lists, zip(*items, strict=True), strict=False):
                pipe.rpush(key, *texts)
            for key in self._lists:
                pipe.expire(key, INTAKE_TTL)
            pipe.execute()
        if self._its_run:
            Subscriptions(self.redis, self.settings).extend_deadline(self.job_id, INTAKE_TTL)

    def give(self, count: int, costs: Mapping[int, float], size: Bytes) -> bool:
        """Give the workers items that were pushed, unless their chunks are long, or the lane is full; these
        can wait until all items are known. Returns whether they were given.

        Args:
            count: the number of all items so far.
            costs: the estimated seconds of the valid ones that were not given yet, by their positions.
            size: the bytes of all of them.

        Raises:
            ItemsLostError: the items are not there any more.
        """
        plan = self._plan(costs)
        if not costs or plan.lane != "batch" or plan.chunk_count > _MOST_CHUNKS:
            return False
        with suppress(QueueFullError):
            self._add(count, costs, plan, size, is_last=False)
            return True
        return False

    def begin(self, count: int, costs: Mapping[int, float], size: Bytes | None = None) -> JobView:
        """Give what is left, and make the batch a job like others.

        Args:
            count: the number of all items.
            costs: the estimated seconds of the valid ones that were not given yet, by their positions.
            size: the bytes of all of them.

        Raises:
            ItemsLostError: the items are not there.
            QueueFullError: its lane holds too much work.
        """
        plan = self._plan(costs, _LAST_SHARE if self._its_run else 1)
        self._add(count, costs, plan, size or Bytes(0, 0), is_last=True)
        view = self._records.view(self.job_id)
        if view is None:
            raise ItemsLostError(self.job_id)
        return view

    def drop(self) -> None:
        """Forget a batch that does not begin, and end the work on it."""
        if self._its_run:
            self._chunks.withdraw(self._records.cancel(self.job_id) or [])
        self.redis.delete(*self._lists)

    @property
    def _lists(self) -> tuple[str, str]:
        keys = self.keys.job(self.job_id)
        return keys.items, keys.questions

    def _plan(self, costs: Mapping[int, float], share: int = 1) -> Plan:
        workers = len(Roster(self.redis, self.settings).names())
        short = self.settings.model_copy(update={"chunk_seconds": self.settings.chunk_seconds / share})
        return plan_batch(list(costs.values()), short, workers)

    def _add(self, count: int, costs: Mapping[int, float], plan: Plan, size: Bytes, *, is_last: bool) -> None:
        todo = [str(index) for index in costs]
        add = self._extend if self._its_run else self._create
        refs, lane = add(count, todo, plan, size, None if is_last else INTAKE_TTL)
        self._chunks.enqueue(refs, lane)

    def _create(
        self, count: int, todo: Sequence[str], plan: Plan, size: Bytes, seconds: float | None
    ) -> tuple[Sequence[ChunkRef], Lane]:
        request = batch_request(self.token, count)
        created = self._records.create(request, todo, "", plan, seconds, size=size)
        if created is None:
            raise ItemsLostError(self.job_id)
        if seconds is not None:
            self._its_run = created.refs[0].run
        return created.refs, plan.lane

    def _extend(
        self, count: int, todo: Sequence[str], plan: Plan, size: Bytes, seconds: float | None
    ) -> tuple[Sequence[ChunkRef], Lane]:
        outcome, *more = self._run(
            "extend_batch",
            self.keys.names(self.job_id),
            size.arguments(self.keys),
            work_arguments(plan, todo, seconds, self.settings),
            job_id=self.job_id,
            run=self._its_run,
            total=count,
            request=batch_request(self.token, count).to_json(),
        )
        if outcome == -1:
            raise QueueFullError(plan.lane, more[0] / 1000)
        if not outcome:
            raise ItemsLostError(self.job_id)
        first, lane = more
        refs = [ChunkRef(self.job_id, self._its_run, first + i, 0) for i in range(plan.chunk_count)]
        return refs, lane.decode()


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
