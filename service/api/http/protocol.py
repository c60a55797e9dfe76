"""HTTP connections: limits on the time that a client may take, on the bytes of a head, and on connections.

What could be read in two ways is refused, since behind a proxy that reads it differently, one request could
hide in the body of another. httptools refuses most of it; the rest is refused here.
"""

from __future__ import annotations

import asyncio
import re
import resource  # Windows has none, nor a service
from collections import OrderedDict
from collections.abc import Callable
from functools import partial
from typing import Any, NoReturn, cast

import httptools
from uvicorn._types import ASGI3Application, HTTPScope
from uvicorn.protocols.http.httptools_impl import STATUS_LINE, HttpToolsProtocol, RequestResponseCycle

from rpr_solver.errors import clipped
from service.api.http.transport import CLIENT_ENDED, FOLLOWS, ClientTransport
from service.api.problems import ProblemError, ProblemType
from service.api.settings import PEER, REDIS_CONNECTIONS, STREAM_CONNECTIONS, Settings, prefixed

_OTHER_FILES = 64  # log, listener, static files, …
_MIN_CONNECTIONS = 16
_MAX_DISCARDED = 64 << 20  # bytes of a body after its answer
_MAX_WAITING = 100  # requests of a connection that have been read, and wait for an answer before theirs
_MAX_HEADER_BYTES = 32 << 10  # twice what browsers and proxies send at most
_ABSOLUTE = re.compile(rb"https?://([^/?#@]+)(/[^?]*)?(\?.*)?", re.IGNORECASE | re.DOTALL)


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
    left = files - _OTHER_FILES - REDIS_CONNECTIONS - STREAM_CONNECTIONS
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


class LimitedProtocol(HttpToolsProtocol):
    """uvicorn's protocol for a client that may be slow, silent, or none at all.

    The client sends nothing, a head or a body (`_part`). Meanwhile one request that it has sent is answered
    (`_answered`), and others wait for that (`pipeline`).
    """

    def __init__(self, settings: Settings, connections: Connections, **options: Any) -> None:
        super().__init__(**options)
        self.settings = settings
        self.all = connections
        self._part = ""
        self._begun = 0  # heads that began in the bytes received last
        self._head_bytes = 0
        self._answered: RequestResponseCycle | None = None
        self._fault: ProblemError | None = None
        self._has_client_ended = False
        self._discarded = 0
        self._awaited: object = None
        self._timers: dict[str, asyncio.TimerHandle] = {}

    # -- what asyncio calls ------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(ClientTransport(transport, self._is_client_sending))
        self._await("head")
        self._count()

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        for name in list(self._timers):
            self._stop(name)
        self.all.remove(self)

    def data_received(self, data: bytes) -> None:
        is_over = self.transport.is_closing() or self._fault is not None
        is_rest = self._part == "body" and self.cycle.response_complete
        self._discarded = self._discarded + len(data) if is_over or is_rest else 0
        if self._discarded > _MAX_DISCARDED:
            self.transport.abort()
        elif not is_over:
            self._read(data)
            self._limit_time()

    def eof_received(self) -> bool:  # type: ignore[override]
        """The client sends no more. It may have disconnected, or wait for the answer to its request."""
        self._has_client_ended = True
        if self.transport.is_closing():
            return False
        if self._part and not (self._part == "body" and self.cycle.response_started):
            self._refuse(
                ProblemType.MALFORMED_REQUEST, "The client ended the request before it was complete."
            )
        elif self._answered is not None and self._is_answering():
            _note(self._answered.scope, CLIENT_ENDED, True)
            return FOLLOWS not in self._answered.scope
        else:
            self.transport.close()  # and not by the event loop, which would drop what is not sent yet
        return True

    def pause_writing(self) -> None:
        super().pause_writing()
        self._start("stall", self.settings.stall_seconds, self.transport.abort)

    def resume_writing(self) -> None:
        super().resume_writing()
        self._stop("stall")

    # -- what is read ------------------------------------------------------------------------------

    def _read(self, data: bytes) -> None:
        part, self._begun = self._part, 0
        try:
            self.parser.feed_data(data)
        except httptools.HttpParserUpgrade as upgrade:
            # no other protocol is spoken here; the request for one is passed over (RFC 9110, 7.8)
            self._read(self._head_without_upgrade() + data[upgrade.args[0] :])
            return
        except httptools.HttpParserError as error:
            if self._fault is None:
                why = clipped(f"{error}", 200)
                self._refuse(ProblemType.MALFORMED_REQUEST, f"The request cannot be read: {why}.")
            else:
                self._say_fault()
            return
        if self._part == "head" and self._begun == (not part):  # else a part of the bytes was another request
            self._head_bytes += len(data)
            if self._head_bytes > _MAX_HEADER_BYTES:
                self._refuse(ProblemType.HEADERS_TOO_LARGE, self._too_large())

    def on_message_begin(self) -> None:
        self._part, self._head_bytes = "head", 0
        self._begun += 1
        self._unset_keepalive_if_required()
        super().on_message_begin()
        _note(self.scope, PEER, self.client)
        if len(self.pipeline) >= _MAX_WAITING:
            self._fail("too many requests before it have no answer yet")

    def on_header(self, name: bytes, value: bytes) -> None:
        if self._part == "head":  # and no trailer
            super().on_header(name, value.strip(b" \t"))

    def on_headers_complete(self) -> None:
        self._check_head()
        if not self.parser.should_upgrade():
            super().on_headers_complete()
            self._part = "body"

    def on_message_complete(self) -> None:
        if not self.parser.should_upgrade():
            self._part = ""
            super().on_message_complete()

    def _check_head(self) -> None:
        """Refuse a head whose body could end at two places, or whose host could be another one."""
        version, fields = self.parser.get_http_version(), self.headers
        size = len(self.url) + sum(len(name) + len(value) + len(": \r\n") for name, value in fields)
        if size > _MAX_HEADER_BYTES:
            self._fail(self._too_large(), ProblemType.HEADERS_TOO_LARGE)
        if version not in ("1.0", "1.1"):
            self._fail("its version of HTTP is not 1.1 or 1.0")
        self._check_coding(version)
        hosts = [value for name, value in fields if name == b"host"]
        if len(hosts) > 1 or (version == "1.1" and not hosts):
            self._fail("it needs one Host")
        if self.parser.get_method() == b"CONNECT":
            self._fail("this is no proxy")
        if not self.url.startswith(b"/"):
            self._take_host()

    def _check_coding(self, version: str) -> None:
        """Refuse a body whose end is not that of its length or its chunks."""
        sent = b",".join(value for name, value in self.headers if name == b"transfer-encoding")
        *others, last = (coding.strip(b" \t").lower() for coding in sent.split(b","))
        if sent and (last != b"chunked" or version == "1.0"):
            self._fail("its Transfer-Encoding does not end with chunked, or HTTP/1.0 has none")
        if others:
            only = "the only Transfer-Encoding that is understood is chunked"
            self._fail(only, ProblemType.TRANSFER_CODING_NOT_SUPPORTED)

    def _take_host(self) -> None:
        """Take the host of a target that is a URL; it replaces that of Host (RFC 9112, 3.2)."""
        match = _ABSOLUTE.fullmatch(self.url)
        if match is None:
            self._fail("its target is neither a path nor a URL")
        self.url = (match[2] or b"/") + (match[3] or b"")
        self.headers[:] = [(b"host", match[1]), *(field for field in self.headers if field[0] != b"host")]

    def _head_without_upgrade(self) -> bytes:
        version = self.parser.get_http_version().encode()
        lines = [b"%s %s HTTP/%s" % (self.parser.get_method(), self.url, version)]
        lines += [b"%s: %s" % field for field in self.headers if field[0] != b"upgrade"]
        return b"\r\n".join([*lines, b"", b""])

    def _fail(self, why: str, kind: ProblemType = ProblemType.MALFORMED_REQUEST) -> NoReturn:
        """End the reading of a head."""
        self._fault = ProblemError(kind, f"The request cannot be read: {why}.")
        raise ValueError(why)

    def _too_large(self) -> str:
        return f"the header fields may have {_MAX_HEADER_BYTES} bytes (max_header_bytes)"

    # -- what is answered --------------------------------------------------------------------------

    def _start_asgi_task(self, cycle: RequestResponseCycle, app: ASGI3Application) -> None:
        self._answered = cycle
        if self._has_client_ended:
            _note(cycle.scope, CLIENT_ENDED, True)
        super()._start_asgi_task(cycle, app)

    def on_response_complete(self) -> None:
        super().on_response_complete()
        if self._fault is not None:
            self._say_fault()
        elif self._has_client_ended and not self._is_answering():
            self.transport.close()
        self._limit_time()

    def timeout_keep_alive_handler(self) -> None:
        super().timeout_keep_alive_handler()
        self._end_soon()

    def _is_answering(self) -> bool:
        cycle = self._answered
        return cycle is not None and not cycle.response_complete and not cycle.disconnected

    def _is_client_sending(self) -> bool:
        """Whether a request has begun, and has not ended."""
        return bool(self._part) and not self._has_client_ended

    def _refuse(self, kind: ProblemType, detail: str) -> None:
        """Answer what is being received with a problem; only close the connection if an answer has begun."""
        if self._part == "body":
            cycle = self.cycle
            if cycle.response_started:
                (self.transport.close if cycle.response_complete else self.transport.abort)()
                return
            if self.pipeline and self.pipeline[0][0] is cycle:
                self.pipeline.popleft()
            cycle.disconnected = True
            cycle.message_event.set()
        self._fault = ProblemError(kind, detail)
        self._say_fault()

    def _say_fault(self) -> None:
        """Send the problem after the answers to the requests before, and close."""
        if self._fault is None or self._is_answering() or self.transport.is_closing():
            return
        with prefixed(self.settings.root_path):
            answer = self._fault.response()
        fields = [*answer.raw_headers, (b"connection", b"close")]
        head = b"".join(b"%s: %s\r\n" % field for field in fields)
        self.transport.write(STATUS_LINE[answer.status_code] + head + b"\r\n" + bytes(answer.body))
        self.transport.close()
        self._end_soon()

    # -- the limits --------------------------------------------------------------------------------

    def _limit_time(self) -> None:
        """Limit the time for what the client must send next."""
        self._count()
        if self.transport.is_closing():
            self._await(None)
            self._end_soon()
        elif self._part == "body" and self.cycle is self._answered:
            self._await(self.cycle)
        elif self._is_answering():
            self._await(None)
        elif self._part:
            self._await("head")
        elif self.cycle is not None:
            self._await(None)
            if self.timeout_keep_alive_task is None:  # it was stopped for the rest of a body
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
            self._start("await", seconds, partial(self._time_out, seconds))

    def _time_out(self, seconds: float) -> None:
        if self._part:
            self._refuse(
                ProblemType.REQUEST_TIMEOUT, f"The {self._part} did not arrive within {seconds:g} s."
            )
        else:
            self.transport.close()

    def _end_soon(self) -> None:
        """A closed connection lives until everything is sent and received, but not longer than this."""
        if self.client is not None:
            self.all.set_idle(self)
        self._start("end", self.settings.stall_seconds, self.transport.abort)

    def _start(self, name: str, seconds: float, then: Callable[[], object]) -> None:
        self._stop(name)
        self._timers[name] = self.loop.call_later(seconds, then)

    def _stop(self, name: str) -> None:
        if timer := self._timers.pop(name, None):
            timer.cancel()


def _note(scope: HTTPScope, name: str, value: object) -> None:
    """Note in a request what only this service knows."""
    cast(dict[str, object], scope)[name] = value
