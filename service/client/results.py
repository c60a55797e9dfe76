"""The results of a batch, read over as many connections as it takes; without a connection itself."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal
from urllib.parse import quote

import httpx
from pydantic import BaseModel, ConfigDict

from service.client.conversation import Call, Conversation, OnProgress, Pause, Talk, as_object, silent
from service.client.questions import MODELS, Answer
from service.errors import ServiceError
from service.schemas.problems import ProblemDocument

_STREAM = 60
"""Seconds for which one response brings results: proxies close what is silent for longer."""

_MARGIN = 30
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


def item_result(line: bytes) -> ItemResult:
    """Reads a line of results; the document in it is kept as it was sent.

    >>> line = b'{"index":2,"id":null,"kind":"poses","status":"succeeded","result":{"count":4}}'
    >>> item_result(line).answer.content
    b'{"count":4}'
    """
    head, found, rest = line.partition(b',"result":')  # within a string its quotes would have backslashes
    members = json.loads(head + b"}" if found else head)
    kind, problem = members.get("kind"), members.get("problem")
    return ItemResult(
        index=members["index"],
        name=members["id"],
        kind=kind,
        status=members["status"],
        answer=Answer(rest[:-1], MODELS.get(kind, AnyDocument)) if found else None,
        problem=None if problem is None else ProblemDocument.model_validate(problem),
        line=line,
    )


class Reading:
    """One pass over the results of a batch: what is to be asked next, and what came.

    In the order asked, a new connection goes on after the last line. As they are done, it begins again, and
    what came before is left out.
    """

    def __init__(
        self,
        url: str,
        batch_id: str,
        *,
        wait: bool = True,
        as_done: bool = False,
        after: int = -1,
        on_progress: OnProgress = silent,
    ) -> None:
        self._talk = Conversation(url)
        self._path = f"/v1/batches/{quote(batch_id, safe='')}"
        self._wait, self._as_done, self._after = wait, as_done, after
        self._on_progress = on_progress
        self._seen = bytearray()
        self._count = 0
        self._held: list[bytes] = []  # the beginning of a line
        self._left = self._looks = _TRIES
        self._is_complete = False

    def begun(self) -> Talk[None]:
        """Look at the batch."""
        state = yield from self._state()
        self._seen = bytearray(state["total"])
        self._count = self._after + 1
        self._on_progress(self._count, len(self._seen))

    @property
    def is_complete(self) -> bool:
        """Whether all that was wanted came."""
        return self._is_complete or self._count >= len(self._seen)

    @property
    def call(self) -> Call:
        """What to ask next, as a stream."""
        prefer = [f"wait={_STREAM}"] if self._wait else []
        if self._as_done:
            prefer.append("order=completion")
        after = "" if self._as_done else f"?after={self._after}"
        return Call(
            "GET",
            f"{self._path}/results{after}",
            accept="application/x-ndjson",
            prefer=", ".join(prefer) or None,
            timeout=_STREAM + _MARGIN,
        )

    def taken(self, piece: bytes) -> Iterator[ItemResult]:
        """Yields the results that are complete with the next piece of the response."""
        self._held.append(piece)
        if b"\n" not in piece:
            return
        *lines, rest = b"".join(self._held).split(b"\n")
        self._held = [rest]
        for line in lines:
            result = item_result(line)
            if self._seen[result.index]:
                continue
            self._seen[result.index] = 1
            self._count += 1
            self._after = max(self._after, result.index)
            self._looks = _TRIES
            self._on_progress(self._count, len(self._seen))
            yield result

    def ended(self, response: httpx.Response) -> Talk[None]:
        """Take the end of a response.

        Raises:
            ServiceError: the service refused or failed, or does not have all results.
        """
        self._left -= 1
        if not (yield from self._talk.passed(response, self._left)):
            return
        self._left = _TRIES
        self._is_complete = not self._wait
        if not self.is_complete:
            yield from self._looked()

    def broken(self) -> Talk[None]:
        """Take the end of a connection that broke.

        Raises:
            ServiceError: the service cannot be reached any more, or does not have all results.
        """
        yield Pause(_PAUSE)
        yield from self._looked()

    def _looked(self) -> Talk[None]:
        """Be sure that more is to come, after a response that ended before all was there."""
        self._held = []
        if (yield from self._state())["finished_at"] is None:
            return
        self._looks -= 1
        if not self._looks:
            sent = f"{self._count} of {len(self._seen)}"
            raise ServiceError(f"{self._talk.url} has sent only {sent} results of the batch")
        yield Pause(_PAUSE)

    def _state(self) -> Talk[dict[str, Any]]:
        return as_object((yield from self._talk.sent(Call("GET", self._path))))
