"""Answers that are read piece by piece: the results of a batch, and the slices of a table."""

from __future__ import annotations

import json
from collections.abc import AsyncGenerator, Iterator, Mapping, Sequence
from contextlib import aclosing
from dataclasses import dataclass
from typing import Any, Literal
from urllib.parse import quote

import httpx
from pydantic import BaseModel, ConfigDict

from rpr_solver.contract import Progress
from service.client.bodies import Answer, Asked
from service.client.connection import Call, Connection
from service.client.conversation import Conversation, as_object
from service.errors import ServiceError
from service.schemas import by_kind
from service.schemas.answers import ProblemDocument
from service.schemas.tables import CuspTable, CuspTableRequest

_STREAM_SECONDS = 60
"""The time for which one response brings results: proxies close what is silent for longer."""

_TIMEOUT = _STREAM_SECONDS + 30
_TRIES = 5
_PAUSE = 0.25


class AnyDocument(BaseModel):
    """A document of a kind that this version of the client does not know."""

    model_config = ConfigDict(extra="allow")


@dataclass(frozen=True)
class ItemResult:
    """What became of one item of a batch.

    Attributes:
        index: its position in the batch, from 0.
        name: the name that its sender gave it.
        kind: the kind of its document; None if the item names none.
        status: how it ended.
        answer: the document, if it succeeded.
        problem: why there is none, if it failed.
        line: all this as the service sent it, without the end of the line.
    """

    index: int
    name: str | None
    kind: str | None
    status: Literal["succeeded", "failed", "canceled"]
    answer: Answer[Any] | None
    problem: ProblemDocument | None
    line: bytes

    @property
    def reason(self) -> str:
        """Why there is no answer."""
        return self.status if self.problem is None else self.problem.detail


def item_result(line: bytes) -> ItemResult:
    """Reads a line of results; the document in it is kept as it was sent.

    >>> line = b'{"index":2,"id":null,"kind":"poses","status":"succeeded","result":{"count":4}}'
    >>> item_result(line).answer.content
    b'{"count":4}'
    """
    head, found, rest = line.partition(b',"result":')  # within a string its quotes would have backslashes
    members = json.loads(head + b"}" if found else head)
    kind, problem = members.get("kind"), members.get("problem")
    known = by_kind().get(kind)
    return ItemResult(
        index=members["index"],
        name=members["id"],
        kind=kind,
        status=members["status"],
        answer=Answer(rest[:-1], AnyDocument if known is None else known.answer) if found else None,
        problem=None if problem is None else ProblemDocument.model_validate(problem),
        line=line,
    )


class ResultReader:
    """Reads the results of a batch in the order of its items, over as many connections as it takes.

    A new connection continues after the last line.

    Args:
        connection: the connection to the service.
        batch_id: the id of the batch.
        on_progress: called as `on_progress(received, total)`.
        wait: read until all are done; otherwise only those that are done now.
        after: only items after this position.
    """

    def __init__(
        self,
        connection: Connection,
        batch_id: str,
        on_progress: Progress,
        *,
        wait: bool,
        after: int,
    ) -> None:
        self._connection = connection
        self._conversation = Conversation(connection)
        self._path = f"/v1/batches/{quote(batch_id, safe='')}"
        self._on_progress = on_progress
        self._wait, self._after = wait, after
        self._seen = bytearray()
        self._count = 0
        self._tries = self._looks = _TRIES

    async def results(self) -> AsyncGenerator[ItemResult, None]:
        """Yields the results as they arrive.

        Raises:
            ServiceError: the service refused or failed, cannot be reached any more, or does not have all.
        """
        total = (await self._state())["progress"]["total"]
        self._seen, self._count = bytearray(total), self._after + 1
        self._on_progress(self._count, total)
        while self._count < total:
            try:
                async with self._connection.stream(self._call()) as (response, lines):
                    async for line in lines:
                        if (result := self._new(line)) is not None:
                            yield result
            except httpx.HTTPError:
                await self._connection.sleep(_PAUSE)
                await self._check_that_more_comes()
                continue
            self._tries -= 1
            if await self._conversation.is_final(response, self._tries):
                self._tries = _TRIES
                if not self._wait:
                    return
                if self._count < total:
                    await self._check_that_more_comes()

    def _call(self) -> Call:
        return Call(
            "GET",
            f"{self._path}/results?after={self._after}",
            accept="application/x-ndjson",
            prefer=f"wait={_STREAM_SECONDS}" if self._wait else None,
            timeout=_TIMEOUT,
        )

    def _new(self, line: bytes) -> ItemResult | None:
        """Returns the result in a line, unless it was yielded before."""
        result = item_result(line)
        if self._seen[result.index]:
            return None
        self._seen[result.index] = 1
        self._count += 1
        self._after = max(self._after, result.index)
        self._looks = _TRIES
        self._on_progress(self._count, len(self._seen))
        return result

    async def _check_that_more_comes(self) -> None:
        """Look at the batch after a response that ended before all results were there."""
        if (await self._state())["ended_at"] is None:
            return
        self._looks -= 1
        if not self._looks:
            sent = f"{self._count} of {len(self._seen)}"
            raise ServiceError(f"{self._connection.url} has sent only {sent} results of the batch")
        await self._connection.sleep(_PAUSE)

    async def _state(self) -> dict[str, Any]:
        return await self._conversation.object(Call("GET", self._path))


async def slices_of(
    conversation: Conversation, asked: Asked[CuspTable]
) -> AsyncGenerator[Mapping[str, Any], None]:
    """Yields the slices of a table in the order of the question, each once all before it are computed.

    Those that were known before the job, and all after them, come with its result.

    Raises:
        ServiceError: the service refused, failed, or cannot be reached.
    """
    question = asked.question
    assert isinstance(question, CuspTableRequest)
    ready = InOrder(question.content()["l1"])
    response = await conversation.post(asked, "respond-async")
    if conversation.job is not None:
        async with aclosing(_events(conversation, f"l{question.fixed_leg}")) as events:
            async for length, part in events:
                for ready_part in ready.take(length, part):
                    yield ready_part
        response = await conversation.result_of_job()
    for part in as_object(response)["slices"]:
        for ready_part in ready.take(part[f"l{question.fixed_leg}"], part):
            yield ready_part


async def _events(
    conversation: Conversation, leg: str
) -> AsyncGenerator[tuple[str, Mapping[str, Any]], None]:
    """Yields the slices of a job as they are computed; its result also has those that were known before.

    It ends early if the connection breaks: the result has all slices.
    """
    assert conversation.job is not None
    call = Call("GET", conversation.job["links"]["events"], accept="text/event-stream")
    fields: dict[str, str] = {}
    try:
        async with conversation.connection.stream(call) as (_, lines):
            async for line in lines:
                if line:
                    name, _, value = line.decode().partition(":")
                    fields[name] = value.removeprefix(" ")
                    continue
                data = json.loads(fields["data"]) if fields.get("event") == "slice" else {}
                fields = {}
                if data.get("slice") is not None:  # one that has expired meanwhile is not sent
                    yield data[leg], data["slice"]
    except httpx.HTTPError:
        return


class InOrder:
    """Holds slices back until all before them are known.

    >>> slices = InOrder(["1", "2", "3"])
    >>> [list(slices.take(length, {"l1": length})) for length in ("2", "1", "3")]
    [[], [{'l1': '1'}, {'l1': '2'}], [{'l1': '3'}]]
    """

    def __init__(self, lengths: Sequence[str]) -> None:
        self._left = iter(lengths)
        self._next = next(self._left, None)
        self._held: dict[str, Mapping[str, Any]] = {}

    def take(self, length: str, part: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """Take a slice; yields all that are ready."""
        self._held.setdefault(length, part)
        while self._next in self._held:
            yield self._held[self._next]
            self._next = next(self._left, None)
