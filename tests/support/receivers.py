"""A receiver of webhooks: a real server that notes what comes and answers as it is told, also by TLS."""

from __future__ import annotations

import socket
import ssl
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from tests.support.tls import Certificates

Reply = tuple[int, Mapping[str, str]]


@dataclass
class Receiver:
    """What came, and the URL to which it came."""

    url: str = ""
    received: list[tuple[dict[str, str], bytes]] = field(default_factory=list)


@contextmanager
def silent() -> Iterator[str]:
    """The URL of a receiver that accepts connections, as many as the system lets it, and never answers."""
    with socket.create_server(("127.0.0.1", 0), backlog=200) as listener:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}/"


@contextmanager
def receiving(
    *replies: int | Reply, slow_seconds: float = 0.0, certificates: Certificates | None = None
) -> Iterator[Receiver]:
    """A receiver that gives these answers, the last one again and again (204 without any).

    With `slow_seconds`, it takes that long to answer the first one; with certificates, it speaks TLS.
    """
    receiver = Receiver()
    answers: Sequence[int | Reply] = replies or (204,)

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            number = len(receiver.received)
            receiver.received.append(({k.lower(): v for k, v in self.headers.items()}, body))
            if number == 0:
                time.sleep(slow_seconds)
            answer = answers[min(number, len(answers) - 1)]
            status, headers = answer if isinstance(answer, tuple) else (answer, {})
            self.send_response(status)
            for name, value in headers.items():
                self.send_header(name, value)
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_: object) -> None:
            pass

    class Server(ThreadingHTTPServer):
        def handle_error(self, *_: object) -> None:  # a sender that was killed reads no answer
            pass

    with Server(("127.0.0.1", 0), Handler) as server:
        if certificates is not None:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(certificates["server.pem"], certificates["server.key"])
            server.socket = context.wrap_socket(server.socket, server_side=True)
        scheme = "http" if certificates is None else "https"
        receiver.url = f"{scheme}://127.0.0.1:{server.server_port}/hook?for=cusps"
        thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        try:
            yield receiver
        finally:
            server.shutdown()
            thread.join(10)
