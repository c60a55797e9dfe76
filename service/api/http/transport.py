"""The way to a client: its socket, and large answers that are sent in pieces."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncGenerator, Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

import anyio
from redis.exceptions import RedisError
from starlette.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

from service.api.problems import ProblemError, ProblemType
from service.api.threads import RedisAccess
from worker.answers.tables import BATCH_BYTES, ResultLostError

CLIENT_ENDED = "rpr_cusps.client_ended"
"""In the scope of a request whose client has closed its half of the connection, or the whole connection."""

FOLLOWS = "rpr_cusps.follows"
"""In the scope of a request for a stream; a client that closes its half is treated as disconnected."""

_SENT_AT_ONCE = 64 << 10


class ClientTransport(asyncio.Transport):
    """A transport that joins small writes, and closes so that a client that still sends gets its answer.

    Args:
        inner: the transport of the event loop.
        is_sending: whether the client has not sent all of its request yet.
    """

    def __init__(self, inner: asyncio.Transport, is_sending: Callable[[], bool]) -> None:
        super().__init__()
        self._inner = inner
        self._loop = asyncio.get_running_loop()
        self._is_sending = is_sending
        self._held: list[bytes] = []
        self._size = 0
        self._is_closing = False

    def write(self, data: bytes | bytearray | memoryview[Any]) -> None:
        """Send bytes, together with what else is written in this turn of the event loop."""
        if not data or self.is_closing():
            return
        if not self._held:
            self._loop.call_soon(self._flush)
        self._held.append(bytes(data))
        self._size += len(data)
        if self._size > _SENT_AT_ONCE:
            self._flush()

    def close(self) -> None:
        """Close once everything is sent; a client that still sends is read until it stops."""
        if self.is_closing():
            return
        self._flush()
        self._is_closing = True
        if not self._is_sending():
            self._inner.close()
            return
        if self._inner.can_write_eof():
            self._inner.write_eof()
        self._inner.resume_reading()

    def abort(self) -> None:
        """Close at once."""
        self._is_closing = True
        self._inner.abort()

    def is_closing(self) -> bool:
        """Whether nothing more can be sent."""
        return self._is_closing or self._inner.is_closing()

    def pause_reading(self) -> None:
        """Let the client wait before it sends more."""
        self._inner.pause_reading()

    def resume_reading(self) -> None:
        """Let it go on."""
        self._inner.resume_reading()

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        """Returns what the event loop knows of the connection."""
        return self._inner.get_extra_info(name, default)

    def set_protocol(self, protocol: asyncio.BaseProtocol) -> None:
        """Hand the connection to another protocol."""
        self._inner.set_protocol(protocol)

    def _flush(self) -> None:
        data, self._size = b"".join(self._held), 0
        self._held.clear()
        if data and not self._inner.is_closing():
            self._inner.write(data)


log = logging.getLogger("rpr_cusps.service")

T = TypeVar("T")

LARGE = BATCH_BYTES
"""Bytes of an answer that is sent in pieces."""

IS_HEAD = "rpr_cusps.head"
"""Set in the scope of a request whose method is HEAD."""

_PIECE = 64 << 10


class Slots:
    """The long answers of one sort that are being sent.

    Args:
        what: what they are, for the message.
        count: how many there may be.
        retry_seconds: `Retry-After` of what is refused.
        size: how many bytes they may hold together.
    """

    def __init__(self, what: str, count: int, retry_seconds: int, size: int = 0) -> None:
        self._what = what
        self._count = count
        self._size = size
        self._retry_seconds = retry_seconds
        self._held: list[int] = []

    @contextmanager
    def occupied(self, held: int) -> Iterator[None]:
        """Count the bytes of an answer during the block.

        Raises:
            ProblemError: 503, there are enough.
        """
        if len(self._held) >= self._count or (self._held and sum(self._held) + held > self._size):
            raise ProblemError(
                ProblemType.BUSY,
                f"{len(self._held)} {self._what} are being sent at the moment; try again.",
                retry_s=self._retry_seconds,
            )
        self._held.append(held)
        try:
            yield
        finally:
            self._held.remove(held)


class LongAnswer(StreamingResponse):
    """An answer that occupies one of the slots while it is sent.

    If a piece is lost on the way, the connection is closed before the end, so that no client takes a part
    for the whole.

    Args:
        pieces: the body.
        headers: the header fields.
        media_type: of the body.
        slots: those for answers of its sort.
        held: the bytes that it holds meanwhile.
    """

    def __init__(
        self,
        pieces: AsyncGenerator[bytes],
        headers: Mapping[str, str],
        media_type: str,
        slots: Slots,
        held: int = 0,
    ) -> None:
        super().__init__(pieces, 200, headers, media_type)
        self._pieces = pieces
        self._slots = slots
        self._held = held
        self._is_head = False
        self._path = ""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the answer, or the problem that there are too many."""
        self._is_head, self._path = IS_HEAD in scope, scope["path"]
        try:
            with self._slots.occupied(0 if self._is_head else self._held):
                await super().__call__(scope, receive, send)
        except ProblemError as error:
            await error.response(self._path)(scope, receive, send)
        finally:
            with anyio.CancelScope(shield=True):
                await self._pieces.aclose()  # else it would hold what it has until it is collected

    async def stream_response(self, send: Send) -> None:
        """Send the pieces as they are produced; only the first one if the client does not read."""
        await send({"type": "http.response.start", "status": self.status_code, "headers": self.raw_headers})
        try:
            async for piece in self.body_iterator:
                await send({"type": "http.response.body", "body": piece, "more_body": True})
                if self._is_head:
                    break
        except (ResultLostError, RedisError) as error:
            log.warning("the response of %s was truncated: %s", self._path, error)
            return  # without its end, for which the server closes the connection
        await send({"type": "http.response.body", "body": b"", "more_body": False})


async def in_pieces(body: bytes) -> AsyncGenerator[bytes]:
    """Yields a body in pieces."""
    for first in range(0, len(body), _PIECE):
        yield body[first : first + _PIECE]


async def made_in_threads(pieces: Iterator[bytes], access: RedisAccess) -> AsyncGenerator[bytes]:
    """Yields pieces, each of which is made in a thread when it is wanted."""
    while (piece := await access(next, pieces, None)) is not None:
        yield piece
