"""Connections that are many, slow, silent, or do not speak HTTP."""

from __future__ import annotations

import json
import re
import resource
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from typing import Any

import httpx
import pytest

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, Workers, environment, started, until
from tests.support.service_server import GEOMETRY, serving
from worker.process.processes import raise_file_limit

ASK = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
POST = ASK.replace(b"GET /healthz", b"POST /v1/poses")[:-2] + (
    b"Content-Type: application/json\r\nContent-Length: 100\r\n\r\n{"
)
OK = b'{"status":"ok"}'
HURRIED = {"header_seconds": 0.5, "body_seconds": 0.5, "idle_seconds": 1, "stall_seconds": 0.5}


@contextmanager
def api(valkey: EmbeddedValkey, **settings: Any) -> Iterator[tuple[str, int]]:
    """A service with short times."""
    with serving(Settings(redis_url=valkey.url, **{**HURRIED, **settings})) as url:
        host, port = url.removeprefix("http://").split(":")
        yield host, int(port)


def connection(address: tuple[str, int]) -> closing[socket.socket]:
    return closing(socket.create_connection(address, timeout=PATIENCE))


def read(client: socket.socket) -> bytes:
    """Read until the server closes."""
    parts = []
    try:
        while part := client.recv(1 << 16):
            parts.append(part)
    except ConnectionResetError:
        pass
    return b"".join(parts)


def is_open(client: socket.socket) -> bool:
    """Whether the server has not closed a silent connection."""
    client.setblocking(False)
    try:
        return client.recv(1) != b""
    except BlockingIOError:
        return True
    except ConnectionResetError:
        return False


def assert_problem(answer: bytes, status: int, slug: str) -> None:
    head, _, body = answer.partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 %d " % status)
    assert b"application/problem+json" in head
    assert json.loads(body)["type"] == f"/problems/{slug}"


def test_slow_bodies_cost_their_bytes(valkey: EmbeddedValkey, workers: Workers) -> None:
    """Twelve batches have started with a long string, or line, and continue byte by byte. Other clients are
    answered at once, with known and new answers, and the processor has little work.
    """
    workers.start()
    question = {"geometry": GEOMETRY, "l1": "14.98", "l2": "15", "l3": "30"}
    body = b'{"items":[{"id":"' + b"a" * 900_000
    kinds = [(b"application/json", body), (b"application/x-ndjson", body), (b"text/csv", body)]
    with (
        api(valkey, body_seconds=PATIENCE) as address,
        ExitStack() as clients,
        httpx.Client(base_url="http://{}:{}".format(*address), timeout=PATIENCE) as other,
    ):
        slow = [clients.enter_context(connection(address)) for _ in range(12)]
        for client, (kind, start) in zip(slow, kinds * 4, strict=True):
            head = b"POST /v1/batches HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5000000\r\n"
            client.sendall(head + b"Content-Type: " + kind + b"\r\n\r\n" + start)
        assert other.post("/v1/poses", json=question).status_code == 200
        times: dict[str, list[float]] = {"health": [], "known": [], "new": []}

        def take(name: str, ask: Callable[[], httpx.Response]) -> None:
            since = time.monotonic()
            assert ask().status_code == 200
            times[name].append(time.monotonic() - since)

        begin = time.process_time()
        for turn in range(150):
            for client in slow:
                client.sendall(b"a")
            time.sleep(0.01)
            if turn % 15 == 0:
                new = {**question, "l2": str(16 + turn)}
                take("health", lambda: other.get("/healthz"))
                take("known", lambda: other.post("/v1/poses", json=question))
                take("new", lambda: other.post("/v1/poses", json=new))  # noqa: B023
        # each of the 1800 bytes took a millisecond or more when the string was read from its start
        assert time.process_time() - begin < 2
        for name, seconds in times.items():
            assert sorted(seconds)[len(seconds) // 2] < PATIENCE / 10, name


def test_slow_clients(valkey: EmbeddedValkey) -> None:
    """A client sends nothing, or half a head, or half a body, or is idle after its answer. Its connection is
    closed in time, with 408 if a request had started.
    """
    with api(valkey) as address, ExitStack() as clients:
        nothing, head, body, idle, again = (clients.enter_context(connection(address)) for _ in range(5))
        head.sendall(ASK[:30])
        body.sendall(POST)
        idle.sendall(ASK)
        again.sendall(ASK)
        answer = b""
        while not answer.endswith(OK):
            answer += again.recv(1 << 16)
        again.sendall(ASK[:10])
        assert read(nothing) == b""
        assert_problem(read(head), 408, "request-timeout")
        assert_problem(read(body), 408, "request-timeout")
        assert_problem(read(again), 408, "request-timeout")
        assert read(idle).endswith(OK)


def test_a_body_that_never_ends(valkey: EmbeddedValkey) -> None:
    """A client sends its body byte by byte. It reaches the time limit nevertheless: 408."""
    with api(valkey) as address, connection(address) as client:
        client.sendall(POST)
        client.setblocking(False)
        until(lambda: _answer_after_a_byte(client).startswith(b"HTTP/1.1 408 "))


def _answer_after_a_byte(client: socket.socket) -> bytes:
    try:
        client.send(b" ")
        return client.recv(1 << 16)
    except BlockingIOError:
        return b""


@pytest.mark.parametrize("length", [b"Content-Length: 8388608", b"Transfer-Encoding: chunked"])
def test_an_answer_to_a_body_that_is_still_sent(valkey: EmbeddedValkey, length: bytes) -> None:
    """A body over the limit is refused while the client still sends it, and reads nothing meanwhile. The
    client receives the answer, 413, and no reset of the connection.
    """
    with api(valkey) as address, connection(address) as client:
        client.sendall(POST.replace(b"Content-Length: 100", length)[:-1])
        for _ in range(128):
            client.sendall((b"10000\r\n" + b" " * 65536 + b"\r\n") if b"chunked" in length else b" " * 65536)
        client.shutdown(socket.SHUT_WR)
        answer = b""
        while part := client.recv(1 << 16):
            answer += part
    assert_problem(answer, 413, "body-too-large")


def test_the_rest_of_a_body_and_the_next_request(valkey: EmbeddedValkey) -> None:
    """A body is refused for its type before it is read. The rest of the body is discarded; the connection
    serves the next request, and is closed when it is idle.
    """
    with api(valkey) as address, connection(address) as client:
        client.sendall(POST.replace(b"application/json", b"text/plain").replace(b": 100\r", b": 1000000\r"))
        first = client.recv(1 << 16)
        client.sendall(b" " * 999_999 + ASK)
        answers = first + read(client)
    assert answers.startswith(b"HTTP/1.1 415 ")
    assert answers.endswith(OK)


@pytest.mark.parametrize("limit", ["bytes", "seconds"])
def test_a_client_that_never_stops_sending(
    valkey: EmbeddedValkey, monkeypatch: pytest.MonkeyPatch, limit: str
) -> None:
    """A client that has its answer keeps sending. Its connection is closed after a limit of bytes or time."""
    if limit == "bytes":
        monkeypatch.setattr("service.api.http.protocol._MAX_DISCARDED", 1 << 20)
    settings = {"stall_seconds": PATIENCE if limit == "bytes" else 0.5, "body_seconds": 60}
    with api(valkey, **settings) as address, connection(address) as client:
        client.sendall(POST.replace(b": 100\r", b": 99999999999\r"))
        assert_problem(client.recv(1 << 16), 413, "body-too-large")
        part = b" " * 65536 if limit == "bytes" else b" "
        until(lambda: _is_refused(client, part))


def _is_refused(client: socket.socket, part: bytes) -> bool:
    try:
        client.sendall(part)
    except (ConnectionResetError, BrokenPipeError):
        return True
    return False


@pytest.mark.parametrize(
    ("sent", "status", "slug"),
    [
        (b"\x16\x03\x01\x02\x00\x01\x00", 400, "malformed-request"),
        (b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"y" * 70_000, 431, "headers-too-large"),
    ],
    ids=["TLS", "long"],
)
def test_what_is_not_http(valkey: EmbeddedValkey, sent: bytes, status: int, slug: str) -> None:
    """A client sends something other than HTTP, or very many or long header fields. A problem document says
    so."""
    with api(valkey) as address, connection(address) as client:
        client.sendall(sent)
        answer = read(client)
    assert_problem(answer, status, slug)


def test_more_connections_than_allowed(valkey: EmbeddedValkey) -> None:
    """More connections are opened than allowed. Those that have been idle longest are closed."""
    with api(valkey, max_connections=20, header_seconds=60) as address, ExitStack() as stack:
        clients = [stack.enter_context(connection(address)) for _ in range(40)]
        with httpx.Client(base_url=f"http://{address[0]}:{address[1]}", timeout=PATIENCE) as client:
            assert client.get("/healthz").status_code == 200
        states = [is_open(client) for client in clients]
        assert sum(states) <= 20
        assert states == sorted(states)  # the oldest are closed
        assert states[-1]


@pytest.mark.long
def test_ten_thousand_idle_and_six_hundred_slow_connections(valkey: EmbeddedValkey) -> None:
    """Ten thousand connections are idle and six hundred are slow, or as many as this process may open. Others
    are served at once.
    """
    command = [sys.executable, "-m", "service", "serve", "--port", "0", "--workers", "0"]
    with (
        started(
            [*command, "--redis-url", valkey.url], stdout=subprocess.PIPE, env=environment(), text=True
        ) as stack,
        ExitStack() as clients,
    ):
        match = re.search(r":(\d+) \(", stack.stdout.readline())
        assert match
        address = ("127.0.0.1", int(match[1]))
        raise_file_limit()
        for i in range(min(10_600, resource.getrlimit(resource.RLIMIT_NOFILE)[0] - 200)):
            client = clients.enter_context(connection(address))
            if i % 17 == 0:
                client.sendall(POST if i % 2 else ASK[:20])
        with httpx.Client(base_url=f"http://127.0.0.1:{address[1]}", timeout=PATIENCE) as client:
            for path in ("/healthz", "/docs", "/v1/limits", "/metrics"):
                begin = time.monotonic()
                assert client.get(path).status_code == 200
                assert time.monotonic() - begin < PATIENCE / 2
