"""The results of a batch, line by line, as much at a time as its reader takes."""

from __future__ import annotations

import time
from collections.abc import AsyncGenerator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from service.api.context import Context
from service.api.http import made_in_threads
from service.api.problems import ProblemError
from service.schemas.answers import JSON_FORM, ascii_bytes, joined, json_bytes
from service.schemas.limits import LimitError
from worker.answers import in_groups
from worker.answers.kinds import known_answer
from worker.answers.tables import ResultLostError, StoredTable, tables_at_hand
from worker.jobs.attempts import is_done
from worker.jobs.batches import Batches, StoredItem
from worker.jobs.view import JobView

_GROUP = 32  # items that are read together
_PAUSE, _LONGEST_PAUSE = 0.05, 0.25  # seconds to the next look, so that many ends of items cost one
_SHARE = 0.05  # of the time that a client has waited already, for the next pause


@dataclass(frozen=True)
class Wanted:
    """Which results, and when.

    Attributes:
        first: the position of the first item.
        seconds: how long to wait for more; None: send what there is.
    """

    first: int = 0
    seconds: float | None = None


class BatchResults:
    """The results of one batch."""

    def __init__(self, context: Context, view: JobView) -> None:
        self.context = context
        self.queue = context.queue
        self.batches = Batches(self.queue.redis, self.queue.settings)
        self.view = view

    async def pieces(self, wanted: Wanted) -> AsyncGenerator[bytes]:
        """Yields the lines of the items that are done, or with a time to wait, that are done by then."""
        begin = time.monotonic()
        if wanted.seconds is None:
            bits = await self.context.redis(self.look)
            ready = [i for i in range(wanted.first, self.view.total) if self.is_over(bits, i)]
            async for piece in self._send(ready):
                yield piece
            return
        order, end = _Positions(self, wanted.first), begin + wanted.seconds
        async with self.context.events.tail(self.view.id) as tail:
            while True:
                newest, is_last = tail.newest, tail.is_over
                ready = await self.context.redis(order.ready)
                async for piece in self._send(ready):
                    yield piece
                left = end - time.monotonic()
                if order.is_complete or self.view.is_terminal or is_last or left <= 0:
                    return
                await tail.wait_beyond(newest, left)
                await tail.end(min(max(_PAUSE, _SHARE * (time.monotonic() - begin)), _LONGEST_PAUSE))

    def look(self) -> bytes:
        """Look at the batch again; returns the bits of what is done."""
        bits = self.batches.done(self.view.id)
        # the state comes last: once it is terminal, no more items are done
        view = self.queue.get(self.view.id)
        if view is None:
            raise ResultLostError("the batch expired while its results were being sent")
        if view.is_terminal and not self.view.is_terminal:
            bits = self.batches.done(self.view.id)
        self.view = view
        return bits

    def is_over(self, bits: bytes, index: int) -> bool:
        """Whether an item is done, or will never be."""
        return self.view.is_terminal or is_done(bits, index)

    def _send(self, indices: Sequence[int]) -> AsyncGenerator[bytes]:
        return made_in_threads(joined(self._lines(indices)), self.context.redis)

    def _lines(self, indices: Sequence[int]) -> Iterator[bytes]:
        for few in in_groups(indices, _GROUP):
            group = self.batches.read(self.view.id, few)
            tables = self._tables(group)
            for stored in group:
                yield from self._line(stored, tables.get(stored.index))

    def _tables(self, group: Sequence[StoredItem]) -> Mapping[int, StoredTable]:
        """Returns tables of items that can be read together, by their positions."""
        asked = {
            stored.index: stored.item.request
            for stored in group
            if stored.item.request is not None
            and stored.item.request.kind.by_slices
            and stored.state == "succeeded"
            and not stored.outcome.slices
        }
        found = tables_at_hand(list(asked.values()), self.queue.store)
        return {index: table for index, table in zip(asked, found, strict=True) if table is not None}

    def _line(self, stored: StoredItem, table: StoredTable | None) -> Iterator[bytes]:
        item, failure = stored.item, stored.outcome.failure
        if item.problem is not None:
            yield _without_result(stored, "failed", item.problem)
        elif failure is not None:
            problem = ProblemError.of_failure(failure["type"], failure["detail"])
            yield _without_result(stored, "failed", problem.document())
        elif stored.state == "succeeded":
            yield from self._result(stored, table)
        elif self.view.status == "canceled":
            yield _without_result(stored, "canceled")
        elif self.view.is_terminal:
            yield _without_result(stored, "failed", ProblemError.of_job(self.view).document())

    def _result(self, stored: StoredItem, table: StoredTable | None) -> Iterator[bytes]:
        request = stored.item.request
        assert request is not None
        start = _start(stored, "succeeded") + b',"result":'
        text = None if request.kind.by_slices else self.queue.store.get_text(request.content_hash)
        if text is not None:
            yield start + text + b"}\n"
            return
        answer = table or known_answer(request, self.queue.store, stored.outcome.slices)
        if answer is None:
            yield _without_result(stored, "failed", ProblemError.expired().document())
        elif not isinstance(answer, StoredTable):
            yield start + json_bytes(answer) + b"}\n"
        elif answer.size > (limits := self.context.settings.limits).max_result_bytes:
            sent = f"the result has {answer.size} bytes"
            problem = ProblemError.of_input(LimitError.exceeded(limits, "max_result_bytes", sent))
            yield _without_result(stored, "failed", problem.document())
        else:
            yield start
            yield from JSON_FORM.pieces(answer)
            yield b"}\n"


class _Positions:
    """Items in the order of the batch, each once all before it are done."""

    def __init__(self, results: BatchResults, first: int) -> None:
        self._results = results
        self._next = first

    @property
    def is_complete(self) -> bool:
        return self._next >= self._results.view.total

    def ready(self) -> list[int]:
        bits, first = self._results.look(), self._next
        while not self.is_complete and self._results.is_over(bits, self._next):
            self._next += 1
        return list(range(first, self._next))


async def as_array(lines: AsyncGenerator[bytes]) -> AsyncGenerator[bytes]:
    """Yields the pieces of lines as those of one JSON array."""
    before = b"["
    async for piece in lines:  # it ends with a line or within one; JSON itself has no line feed
        yield before + piece.removesuffix(b"\n").replace(b"\n", b",\n")
        before = b",\n" if piece.endswith(b"\n") else b""
    yield b"[]" if before == b"[" else b"]"


def _start(stored: StoredItem, status: str) -> bytes:
    item = stored.item
    kind = item.kind if item.request is None else item.request.kind.name
    return ascii_bytes({"index": stored.index, "id": item.id, "kind": kind, "status": status})[:-1]


def _without_result(stored: StoredItem, status: str, problem: Any = None) -> bytes:
    rest = b"" if problem is None else b',"problem":' + ascii_bytes(problem)
    return _start(stored, status) + rest + b"}\n"
