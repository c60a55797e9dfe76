"""A TLS front for a server on a unix socket: the embedded Valkey is built without TLS."""

from __future__ import annotations

import shutil
import socket
import socketserver
import ssl
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest


class Certificates:
    """An authority, and certificates by it for the server (at `host`) and a client, made with `openssl`."""

    def __init__(self, directory: Path, host: str = "127.0.0.1") -> None:
        if shutil.which("openssl") is None:
            pytest.skip("openssl is not installed, so there are no certificates")
        self.directory = directory
        self._openssl("req", "-x509", *self._new("authority"), "-days", "2", "-subj", "/CN=authority")
        for name in ("server", "client"):
            request = str(directory / f"{name}.csr")
            self._openssl("req", *self._new(name, out=request), "-subj", f"/CN={name}")
            extension = directory / f"{name}.ext"
            extension.write_text(f"subjectAltName=IP:{host}\n")
            self._openssl(
                *("x509", "-req", "-in", request, "-CA", self["authority.pem"]),
                *("-CAkey", self["authority.key"], "-CAcreateserial"),
                *("-days", "2", "-extfile", str(extension), "-out", self[f"{name}.pem"]),
            )

    def __getitem__(self, name: str) -> str:
        return str(self.directory / name)

    def _new(self, name: str, out: str | None = None) -> tuple[str, ...]:
        curve = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
        return (*curve, "-keyout", self[f"{name}.key"], "-out", out or self[f"{name}.pem"])

    def _openssl(self, *arguments: str) -> None:
        subprocess.run(["openssl", *arguments], check=True, capture_output=True)


@contextmanager
def tls_front(unix_socket: str, certificates: Certificates, host: str = "127.0.0.1") -> Iterator[int]:
    """Forwards TLS connections, of clients with a certificate only; gives the port."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificates["server.pem"], certificates["server.key"])
    context.load_verify_locations(certificates["authority.pem"])
    context.verify_mode = ssl.CERT_REQUIRED

    class Handler(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            with (
                suppress(OSError),
                context.wrap_socket(self.request, server_side=True) as client,
                socket.socket(socket.AF_UNIX) as server,
            ):
                server.connect(unix_socket)
                threading.Thread(target=_copy, args=(server, client), daemon=True).start()
                _copy(client, server)

    class Server(socketserver.ThreadingTCPServer):
        daemon_threads = True
        block_on_close = False

    with Server((host, 0), Handler) as front:
        thread = threading.Thread(target=front.serve_forever, args=(0.05,), daemon=True)
        thread.start()
        yield front.server_address[1]
        front.shutdown()
        thread.join()


def _copy(source: socket.socket, target: socket.socket) -> None:
    with suppress(OSError):
        while data := source.recv(1 << 16):
            target.sendall(data)
    for end in (source, target):
        with suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)
