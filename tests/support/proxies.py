"""A reverse proxy on loopback: it shows a service under a path, as nginx does with `location /cusps/`."""

from __future__ import annotations

import re
import socket
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress

from tests.support.processes import PATIENCE


@contextmanager
def proxied(base: str, prefix: str, *, strips: bool) -> Iterator[str]:
    """Shows the service at `base` under a prefix; gives the URL that clients use.

    Args:
        base: the URL of the service.
        prefix: the path; all else is 502.
        strips: whether it takes the prefix from the paths that it passes on.
    """
    host, port = base.removeprefix("http://").split(":")

    def serve(client: socket.socket) -> None:
        with closing(client), suppress(OSError), socket.create_connection((host, int(port))) as service:
            client.settimeout(PATIENCE)
            head = b""
            while b"\r\n\r\n" not in head:
                if not (part := client.recv(1 << 16)):
                    return  # a browser opens connections ahead, and may need none
                head += part
            line, rest = head.split(b"\r\n", 1)
            method, path, version = line.split(b" ")
            if not path.startswith(prefix.encode()):
                client.sendall(b"HTTP/1.1 502 Bad Gateway\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
                return
            fields = b"Connection: close\r\nX-Forwarded-For: 192.0.2.1\r\n"
            rest = re.sub(rb"(?i)^connection:[^\r]*\r\n", b"", rest, flags=re.MULTILINE)
            path = path.removeprefix(prefix.encode()) or b"/" if strips else path
            service.sendall(b" ".join((method, path, version)) + b"\r\n" + fields + rest)
            threading.Thread(target=pump, args=(client, service), daemon=True).start()
            pump(service, client)

    def accept() -> None:
        with suppress(OSError):
            while True:
                client, _ = listener.accept()
                threading.Thread(target=serve, args=(client,), daemon=True).start()

    with socket.create_server(("127.0.0.1", 0), backlog=50) as listener:
        threading.Thread(target=accept, daemon=True).start()
        yield f"http://127.0.0.1:{listener.getsockname()[1]}{prefix}"
        listener.shutdown(socket.SHUT_RDWR)


def pump(source: socket.socket, sink: socket.socket) -> None:
    """Pass on what comes until it ends."""
    with suppress(OSError):
        while part := source.recv(1 << 16):
            sink.sendall(part)
