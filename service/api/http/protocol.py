"""HTTP connections with limits: on the time that a client may take, on header bytes, and on their number."""

from __future__ import annotations

import asyncio
import resource  # Windows has none, nor a service
from collections import OrderedDict
from functools import partial
from typing import Any, cast

import h11
from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from rpr_solver.errors import clipped
from service.api.http.framing import NOT_IMPLEMENTED, StrictConnection
from service.api.http.transport import CLIENT_ENDED, FOLLOWS, ClientTransport
from service.api.problems import MEDIA_TYPE, ProblemError, ProblemType
from service.api.settings import PEER, Settings, prefixed

_OTHER_FILES = 64  # log, listener, static files, …
_MIN_CONNECTIONS = 16
_MAX_DISCARDED = 64 << 20  # bytes of a body after its answer


def uvicorn_options(settings: Settings) -> dict[str, Any]:
    """Returns the options of uvicorn for connections with the limits of the settings."""
    return {
        "http": partial(LimitedProtocol, settings, Connections(most_connections(settings))),
        "timeout_keep_alive": settings.idle_seconds,
        "ws": "none",
    }


def most_connections(settings: Settings) -> int:
    """Returns how many connections there may be, so that file descriptors are left for Redis and the rest."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if files == resource.RLIM_INFINITY:
        return settings.max_connections
    left = files - _OTHER_FILES - settings.redis_connections - settings.stream_connections
    return min(settings.max_connections, max(_MIN_CONNECTIONS, left, files // 4))


class Connections:
    """The open connections. If there are too many, the one that is idle for the longest time is closed."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._busy: set[LimitedProtocol] = set()
        self._idle: OrderedDict[LimitedProtocol, None] = OrderedDict()

    def __len__(self) -> int:
        return len(self._busy) + len(self._idle)

    def set_idle(self, connection: LimitedProtocol) -> None:
        """A connection is new, or its request has been answered."""
        self._busy.discard(connection)
        self._idle.setdefault(connection)
        if len(self) > self._most:
            oldest, _ = self._idle.popitem(last=False)
            oldest.transport.abort()

    def set_busy(self, connection: LimitedProtocol) -> None:
        """A connection has a request that is being answered."""
        self._idle.pop(connection, None)
        self._busy.add(connection)

    def remove(self, connection: LimitedProtocol) -> None:
        """A connection is closed."""
        self._idle.pop(connection, None)
        self._busy.discard(connection)


class TimedProtocol(H11Protocol):
    """uvicorn's protocol with timers, which knows whether the client or the server must send next."""

    def __init__(self, settings: Settings, **options: Any) -> None:
        super().__init__(**options)
        self.settings = settings
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._has_client_ended = False

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        for name in list(self._timers):
            self._stop(name)

    def pause_writing(self) -> None:
        super().pause_writing()
        self._start("stall", self.settings.stall_seconds, self.transport.abort)

    def resume_writing(self) -> None:
        super().resume_writing()
        self._stop("stall")

    def _should_upgrade(self) -> bool:
        """No other protocol is spoken here; the request for one is ignored (RFC 9110, 7.8)."""
        return False

    def _is_answering(self) -> bool:
        return self.cycle is not None and not self.cycle.response_complete

    def _is_client_sending(self) -> bool:
        """Whether a request has begun, and has not ended."""
        if self._has_client_ended:
            return False
        if self.conn.their_state is h11.IDLE:
            return self.conn.trailing_data[0] != b""
        return self.conn.their_state in (h11.SEND_BODY, h11.ERROR)

    def _is_discarded(self) -> bool:
        """Whether incoming bytes belong to a request that has been answered."""
        is_answered = self.cycle is not None and self.cycle.response_complete
        return self.transport.is_closing() or (is_answered and self.conn.their_state is h11.SEND_BODY)

    def _start(self, name: str, seconds: float, then: Any) -> None:
        self._stop(name)
        self._timers[name] = self.loop.call_later(seconds, then)

    def _stop(self, name: str) -> None:
        if timer := self._timers.pop(name, None):
            timer.cancel()


class LimitedProtocol(TimedProtocol):
    """uvicorn's protocol for a client that may be slow, silent, or none at all."""

    def __init__(self, settings: Settings, connections: Connections, **options: Any) -> None:
        super().__init__(settings, **options)
        self.all = connections
        self.app = partial(_with_short_headers, self.app, self.settings.max_header_bytes)
        self._awaited: object = None
        self._discarded = 0
        self.conn = self._framing = StrictConnection(self.settings.max_header_bytes)

    # -- what asyncio and uvicorn call -------------------------------------------------------------

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(ClientTransport(transport, self._is_client_sending))
        self._await("head")
        self._count()

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self.all.remove(self)

    def data_received(self, data: bytes) -> None:
        if self._is_discarded():
            self._discarded += len(data)
            if self._discarded > _MAX_DISCARDED:
                self.transport.abort()
        else:
            self._discarded = 0
        if not self.transport.is_closing():
            super().data_received(data)
            self._limit_time()

    def eof_received(self) -> bool:  # type: ignore[override]
        """The client sends no more. It may have disconnected, or wait for the answer to its request."""
        self._has_client_ended = True
        if self.transport.is_closing():
            return False
        if not (self._is_answering() or self.conn.trailing_data[0]):
            self.transport.close()  # and not by the event loop, which would drop what is not sent yet
            return True
        has_begun = self.conn.our_state not in (h11.IDLE, h11.SEND_RESPONSE)
        if not self._is_answering() or (self.conn.their_state is h11.SEND_BODY and not has_begun):
            self._refuse(
                ProblemType.MALFORMED_REQUEST, "The client ended the request before it was complete."
            )
            return True
        cast(dict[str, object], self.scope)[CLIENT_ENDED] = True
        return FOLLOWS not in self.scope

    def on_response_complete(self) -> None:
        super().on_response_complete()
        if self._has_client_ended and not self._is_answering():
            self.transport.close()
        self._limit_time()

    def timeout_keep_alive_handler(self) -> None:
        super().timeout_keep_alive_handler()
        self._end_soon()

    def send_400_response(self, msg: str) -> None:
        """Answer what is not HTTP, or has a header that is too long, as any other error."""
        why = "" if self._framing.fault is None else clipped(f"{self._framing.fault}", 200)
        if len(self.conn.trailing_data[0]) > self.settings.max_header_bytes:
            self._refuse(ProblemType.HEADERS_TOO_LARGE, _too_large(self.settings.max_header_bytes))
        elif self._framing.fault is not None and self._framing.fault.error_status_hint == NOT_IMPLEMENTED:
            self._refuse(ProblemType.TRANSFER_CODING_NOT_SUPPORTED, f"The request cannot be read: {why}.")
        else:
            self._refuse(ProblemType.MALFORMED_REQUEST, f"The request cannot be read: {why}." if why else msg)

    # -- the limits --------------------------------------------------------------------------------

    def _limit_time(self) -> None:
        """Limit the time for what the client must send next."""
        self._count()
        if self.transport.is_closing():
            self._await(None)
            self._end_soon()
        elif self.conn.their_state is h11.SEND_BODY:
            self._await(self.cycle)
        elif self._is_answering():
            self._await(None)
        elif self.conn.trailing_data[0]:
            self._await("head")
        elif self.cycle is not None:
            self._await(None)
            if self.timeout_keep_alive_task is None:  # uvicorn has stopped it for the rest of a body
                seconds = self.timeout_keep_alive
                self.timeout_keep_alive_task = self.loop.call_later(seconds, self.timeout_keep_alive_handler)

    def _count(self) -> None:
        if self.client is None:
            return  # not from the network
        if self._is_answering():
            self.all.set_busy(self)
        else:
            self.all.set_idle(self)

    def _await(self, what: object) -> None:
        """Await the head of a request, the body of a cycle, or nothing."""
        if what is self._awaited:
            return
        self._awaited = what
        self._stop("await")
        if what is not None:
            is_head = what == "head"
            seconds = self.settings.header_seconds if is_head else self.settings.body_seconds
            self._start("await", seconds, partial(self._time_out, is_head))

    def _time_out(self, is_head: bool) -> None:
        if is_head and not self.conn.trailing_data[0]:
            self.transport.close()
        else:
            what, limit = ("head", "header_seconds") if is_head else ("body", "body_seconds")
            seconds = getattr(self.settings, limit)
            self._refuse(ProblemType.REQUEST_TIMEOUT, f"The {what} did not arrive within {seconds:g} s.")

    def _refuse(self, kind: ProblemType, detail: str) -> None:
        """Send a problem and close the connection; only close it if an answer has begun."""
        if self.conn.our_state not in (h11.IDLE, h11.SEND_RESPONSE):
            self.transport.abort()
            return
        if self._is_answering():
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        with prefixed(self.settings.root_path):
            answer = ProblemError(kind, detail).response()
        headers = [
            ("content-type", MEDIA_TYPE),
            ("content-length", str(len(answer.body))),
            ("connection", "close"),
        ]
        for event in (
            h11.Response(status_code=answer.status_code, headers=headers),
            h11.Data(data=bytes(answer.body)),
            h11.EndOfMessage(),
        ):
            self.transport.write(self.conn.send(event) or b"")
        self.transport.close()
        self._end_soon()

    def _end_soon(self) -> None:
        """A closed connection lives until everything is sent and received, but not longer than this."""
        if self.client is not None:
            self.all.set_idle(self)
        self._start("end", self.settings.stall_seconds, self.transport.abort)


async def _with_short_headers(app: ASGIApp, most: int, scope: Scope, receive: Receive, send: Send) -> None:
    scope[PEER] = scope["client"]
    if sum(len(name) + len(value) + len(": \r\n") for name, value in scope["headers"]) <= most:
        await app(scope, receive, send)
        return
    error = ProblemError(ProblemType.HEADERS_TOO_LARGE, _too_large(most), headers={"Connection": "close"})
    await error.response(scope["path"])(scope, receive, send)


def _too_large(most: int) -> str:
    return f"The header fields may have {most} bytes (max_header_bytes)."
