"""Whether the API and Valkey do their work, asked again and again in threads that may hang."""

from __future__ import annotations

import socket
import threading
import time

_PAUSE = 1.0
_TIMEOUT = 2.0

_HEALTH = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
_HEALTHY = b"HTTP/1.1 200 "


class Pulse:
    """Asks one API process for `/healthz` over a connection of their own, which no other client can use up.

    It ends with the process.
    """

    def __init__(self, ours: socket.socket) -> None:
        self.last = 0.0
        """When it was last healthy (`time.monotonic()`, 0 for never)."""
        self._socket = ours
        ours.settimeout(_TIMEOUT)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        with self._socket:
            while self._ask():
                time.sleep(_PAUSE)

    def _ask(self) -> bool:
        """Ping, and read an answer, even a late one to an earlier ping; False if nothing listens."""
        try:
            self._socket.sendall(_HEALTH)
            answer = self._socket.recv(1 << 16)
        except TimeoutError:
            return True
        except OSError:
            return False
        if _HEALTHY in answer:
            self.last = time.monotonic()
        return bool(answer)


class ValkeyPing:
    """Pings a Valkey on new connections to its unix socket."""

    def __init__(self, path: str) -> None:
        self.last = 0.0
        """When it last answered anything (`time.monotonic()`, 0 for never)."""
        self.is_unreachable = False
        """Whether its socket is gone."""
        self._path = path
        self._is_over = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def stop(self) -> None:
        """Stop asking, soon."""
        self._is_over.set()

    def _run(self) -> None:
        while not self._is_over.wait(_PAUSE):
            answer = ping(self._path)
            self.is_unreachable = answer is None
            if answer:
                self.last = time.monotonic()


def ping(path: str) -> bytes | None:
    """Returns the answer of a Valkey, `b""` if there is none, and None if there is no such socket.

    While it loads its data, the answer is an error.
    """
    try:
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(_TIMEOUT)
            client.connect(path)
            client.sendall(b"PING\r\n")
            return client.recv(100)
    except FileNotFoundError:
        return None
    except OSError:
        return b""
