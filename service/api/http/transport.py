"""The socket of a client: what is written together is sent together, and whoever still sends is not cut off.

A client that is still sending its body has not read an answer yet, such as 413. If its connection were closed
at once, its system would drop that answer for a reset of the connection. So the service closes its own half,
and reads on until the client closes too (RFC 9112, 9.6), or its time or bytes are over.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

CLIENT_ENDED = "rpr_cusps.client_ended"
"""In the scope of a request whose client has ended its half of the connection; it may be gone altogether."""

FOLLOWS = "rpr_cusps.follows"
"""In the scope of a request for a stream; a client that ends its half while it is sent is taken as gone."""

_SENT_AT_ONCE = 64 << 10


class ClientTransport(asyncio.Transport):
    """A transport with these manners.

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
        """Close, once everything is sent; what a client sends that has not stopped yet is still received."""
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
        """Let the client wait with what it sends."""
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
