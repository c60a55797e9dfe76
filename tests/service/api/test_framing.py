"""Where a request begins and ends: raw bytes to a real server, and what RFC 9112 says of them."""

from __future__ import annotations

import asyncio
import re
import socket
import time
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
import uvicorn
from starlette.types import Receive, Scope, Send
from uvicorn.server import ServerState

from service.api.http.protocol import Connections, LimitedProtocol
from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE
from tests.support.service_server import serving

pytestmark = pytest.mark.quick

HOST = b"Host: localhost\r\n"
NEXT = b"GET /v1/version HTTP/1.1\r\n" + HOST + b"X-Request-ID: smuggled\r\n\r\n"
BODY = b'{"x":1}'


def get(path: bytes = b"/healthz", fields: bytes = HOST, version: bytes = b"1.1") -> bytes:
    return b"GET " + path + b" HTTP/" + version + b"\r\n" + fields + b"\r\n"


def post(fields: bytes, body: bytes = b"", version: bytes = b"1.1") -> bytes:
    fields += b"Content-Type: application/json\r\n"
    return b"POST /v1/poses HTTP/" + version + b"\r\n" + HOST + fields + b"\r\n" + body


def chunked(body: bytes, fields: bytes = b"Transfer-Encoding: chunked\r\n") -> bytes:
    return post(fields, body)


CHUNKS = b"7\r\n" + BODY + b"\r\n0\r\n"
LENGTH = b"Content-Length: %d\r\n" % len(BODY)
TE = b"Transfer-Encoding: "
ELSEWHERE = b"Host: evil.example\r\n"
UPGRADE = b"Connection: upgrade\r\nUpgrade: websocket\r\n"

# What is sent, before NEXT, and the status of the only answer.
REFUSED = {
    "length and coding (6.1)": (post(LENGTH + TE + b"chunked\r\n", b"0\r\n\r\n"), 400),
    "coding and length (6.1)": (post(TE + b"chunked\r\n" + LENGTH, b"0\r\n\r\n"), 400),
    "length 0 and coding (6.1)": (post(b"Content-Length: 0\r\n" + TE + b"chunked\r\n", b"0\r\n\r\n"), 400),
    "different lengths (6.3)": (post(LENGTH + b"Content-Length: 0\r\n", BODY), 400),
    "equal lengths (6.3)": (post(2 * LENGTH, BODY), 400),
    "a list of lengths (6.3)": (post(b"Content-Length: 7, 7\r\n", BODY), 400),
    "a length with a sign (6.2)": (post(b"Content-Length: +7\r\n", BODY), 400),
    "a negative length (6.2)": (post(b"Content-Length: -1\r\n", BODY), 400),
    "a hexadecimal length (6.2)": (post(b"Content-Length: 0x7\r\n", BODY), 400),
    "a length with a space (6.2)": (post(b"Content-Length: 7 7\r\n", BODY), 400),
    "an empty length (6.2)": (post(b"Content-Length:\r\n", BODY), 400),
    "a length of another script (6.2)": (post(b"Content-Length: \xd9\xa7\r\n", BODY), 400),
    "an endless length (6.3)": (post(b"Content-Length: " + b"9" * 30 + b"\r\n", BODY), 400),
    "an unknown coding before chunked (6.1)": (chunked(b"0\r\n\r\n", TE + b"gzip, chunked\r\n"), 501),
    "chunked is not the last (6.3)": (chunked(b"0\r\n\r\n", TE + b"chunked, gzip\r\n"), 400),
    "chunked twice (7)": (chunked(b"0\r\n\r\n", TE + b"chunked, chunked\r\n"), 400),
    "chunked in two fields (7)": (chunked(b"0\r\n\r\n", 2 * (TE + b"chunked\r\n")), 400),
    "no chunked (6.3)": (chunked(b"0\r\n\r\n", TE + b"gzip\r\n"), 400),
    "identity (7)": (chunked(b"0\r\n\r\n", TE + b"identity\r\n"), 400),
    "a coding that looks like chunked (7)": (chunked(b"0\r\n\r\n", TE + b"xchunked\r\n"), 400),
    "chunked in quotes (7)": (chunked(b"0\r\n\r\n", TE + b'"chunked"\r\n'), 400),
    "chunked after a vertical tab (5)": (chunked(b"0\r\n\r\n", TE + b"\x0bchunked\r\n"), 400),
    "an empty coding (7)": (chunked(b"0\r\n\r\n", TE + b"\r\n"), 400),
    "a coding in HTTP/1.0 (6.1)": (post(TE + b"chunked\r\n", b"0\r\n\r\n", b"1.0"), 400),
    "white space before the colon (5.1)": (post(b"Content-Length : 7\r\n", BODY), 400),
    "a folded line (5.2)": (get(fields=HOST + b"X: a\r\n b\r\n"), 400),
    "a folded coding (5.2)": (post(b"Transfer-Encoding:\r\n chunked\r\n", b"0\r\n\r\n"), 400),
    "white space before the first field (2.2)": (get(fields=b" X: a\r\n" + HOST), 400),
    "no colon (5)": (get(fields=HOST + b"X\r\n"), 400),
    "no name (5.1)": (get(fields=HOST + b": x\r\n"), 400),
    "a name with a bracket (5.1)": (get(fields=HOST + b"X[]: x\r\n"), 400),
    "NUL in a value (5.5 of RFC 9110)": (get(fields=HOST + b"X: a\0b\r\n"), 400),
    "LF alone after the request line (2.2)": (b"GET /healthz HTTP/1.1\n" + HOST + b"\r\n", 400),
    "LF alone after a field (2.2)": (get(fields=b"Host: localhost\nX: y\r\n"), 400),
    "LF alone everywhere (2.2)": (get().replace(b"\r", b""), 400),
    "LF alone at the end (2.2)": (get()[:-2] + b"\n", 400),
    "CR alone in a value (2.2)": (get(fields=HOST + b"X: a\rContent-Length: 7\r\n"), 400),
    "CR alone in the request line (2.2)": (get(b"/healthz\r"), 400),
    "CR CR LF (2.2)": (get(fields=b"Host: localhost\r\r\n"), 400),
    "a tab in the request line (3)": (b"GET\t/healthz HTTP/1.1\r\n" + HOST + b"\r\n", 400),
    "a space in the target (3.2)": (get(b"/heal thz"), 400),
    "a target that is no path (3.2)": (get(b"healthz"), 400),
    "an asterisk with GET (3.2.4)": (get(b"*"), 400),
    "a URL with a user (3.2.2)": (get(b"http://a@localhost/healthz"), 400),
    "a URL without a host (3.2.2)": (get(b"http:///healthz"), 400),
    "a URL of another scheme (3.2.2)": (get(b"ftp://localhost/healthz"), 400),
    "no Host (3.2)": (get(fields=b""), 400),
    "two Hosts (3.2)": (get(fields=2 * HOST), 400),
    "HTTP/1.2 (2.3)": (get(version=b"1.2"), 400),
    "HTTP/2.0 (2.3)": (get(version=b"2.0"), 400),
    "HTTP/0.9 (2.3)": (b"GET /healthz\r\n\r\n", 400),
    "the preface of HTTP/2 (2.3)": (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 400),
    "a lower-case version (2.3)": (get().replace(b"HTTP", b"http"), 400),
    "a negative chunk (7.1)": (chunked(b"-1\r\nx\r\n0\r\n\r\n"), 400),
    "a chunk with 0x (7.1)": (chunked(b"0x1\r\nx\r\n0\r\n\r\n"), 400),
    "a chunk of another length (7.1)": (chunked(b"2\r\nxyz\r\n0\r\n\r\n"), 400),
    "an endless chunk (7.1)": (chunked(b"f" * 30 + b"\r\nx"), 400),
    "no chunk size (7.1)": (chunked(b"\r\n\r\n"), 400),
    "a chunk that ends with LF (7.1)": (chunked(b"1\r\nx\n0\r\n\r\n"), 400),
    "a chunk size that ends with LF (7.1)": (chunked(b"1\nx\r\n0\r\n\r\n"), 400),
    "LF alone in a chunk extension (7.1.1)": (chunked(b"1;\nx\r\nx\r\n0\r\n\r\n"), 400),
    "CR alone in a chunk extension (7.1.1)": (chunked(b"1;a\rb\r\nx\r\n0\r\n\r\n"), 400),
    "a trailer that ends with LF (7.1.2)": (chunked(b"0\r\n\n"), 400),
    "a trailer with LF alone (7.1.2)": (chunked(b"0\r\nX: y\nZ: w\r\n\r\n"), 400),
    "a folded trailer (7.1.2)": (chunked(b"0\r\nX: y\r\n z\r\n\r\n"), 400),
}

# What is sent, before NEXT, and the statuses of all answers.
ACCEPTED = {
    "a path": (get(), [200, 200]),
    "a URL (3.2.2)": (get(b"http://LOCALHOST:80/healthz"), [200, 200]),
    "a URL without a path (3.2.2)": (get(b"http://localhost?x=1"), [200, 200]),
    "a URL, whose host counts (3.2.2)": (get(b"http://evil.example/healthz"), [421, 200]),
    "a URL, and Host does not (3.2.2)": (get(b"http://localhost/healthz", ELSEWHERE), [200, 200]),
    "an empty line before (2.2)": (b"\r\n" + get(), [200, 200]),
    "white space around values (5.1)": (get(fields=b"Host: \t localhost \t\r\n"), [200, 200]),
    "a name in capitals (5.1)": (post(LENGTH.upper(), BODY), [422, 200]),
    "zeros before a length (6.2)": (post(b"Content-Length: 007\r\n", BODY), [422, 200]),
    "a length (6.2)": (post(LENGTH, BODY), [422, 200]),
    "a GET with a body (6)": (get(fields=HOST + LENGTH) + BODY, [200, 200]),
    "chunks (7.1)": (chunked(b'3\r\n{"x\r\n04;a=b\r\n":1}\r\n0\r\n\r\n'), [422, 200]),
    "chunked in capitals (7)": (chunked(b"7\r\n" + BODY + b"\r\n0\r\n\r\n", TE + b"CHUNKED\r\n"), [422, 200]),
    "a trailer (7.1.2)": (chunked(b"7\r\n" + BODY + b"\r\n0\r\nX: y\r\n\r\n"), [422, 200]),
    "HTTP/1.0, which ends (9.3)": (get(version=b"1.0"), [200]),
    "close, which ends (9.6)": (get(fields=HOST + b"Connection: close\r\n"), [200]),
    "an upgrade, which is passed over": (get(fields=HOST + UPGRADE), [200, 200]),
    "an upgrade with a body": (post(UPGRADE + LENGTH, BODY), [422, 200]),
    "an upgrade with chunks": (
        chunked(b"7\r\n" + BODY + b"\r\n0\r\n\r\n", UPGRADE + TE + b"chunked\r\n"),
        [422, 200],
    ),
}


@pytest.fixture(scope="module")
def address(valkey: EmbeddedValkey) -> Iterator[tuple[str, int]]:
    with serving(Settings(redis_url=valkey.url, idle_seconds=1)) as url:
        host, port = url.removeprefix("http://").split(":")
        yield host, int(port)


def answers(address: tuple[str, int], sent: bytes, *, ends: bool = False) -> bytes:
    """Returns what comes until the server closes."""
    with closing(socket.create_connection(address, timeout=PATIENCE)) as client:
        client.sendall(sent)
        if ends:
            client.shutdown(socket.SHUT_WR)
        received = b""
        try:
            while part := client.recv(1 << 16):
                received += part
        except ConnectionResetError:
            pass
        return received


def statuses(received: bytes) -> list[int]:
    return [int(status) for status in re.findall(rb"HTTP/1\.1 (\d{3}) ", received)]


@pytest.mark.parametrize("name", REFUSED)
def test_what_could_be_read_in_two_ways_is_refused(address: tuple[str, int], name: str) -> None:
    sent, status = REFUSED[name]
    received = answers(address, sent + NEXT)
    assert statuses(received) == [status]
    assert b"connection: close" in received.lower()
    assert b"smuggled" not in received
    assert b"application/problem+json" in received


@pytest.mark.parametrize("name", ACCEPTED)
def test_what_can_be_read_in_one_way_is_answered(address: tuple[str, int], name: str) -> None:
    sent, expected = ACCEPTED[name]
    assert statuses(answers(address, sent + NEXT, ends=True)) == expected


class Wire(asyncio.Transport):
    """Nowhere: what a protocol writes is kept, and it is closed at once."""

    def __init__(self) -> None:
        super().__init__({"peername": ("127.0.0.1", 1)})
        self.is_closed = False
        self.written = b""

    def write(self, data: bytes | bytearray | memoryview[Any]) -> None:
        self.written += data

    def close(self) -> None:
        self.is_closed = True

    abort = close

    def is_closing(self) -> bool:
        return self.is_closed

    def can_write_eof(self) -> bool:
        return False

    def pause_reading(self) -> None: ...

    def resume_reading(self) -> None: ...


async def read(sent: bytes, size: int) -> list[str]:
    """Returns what the application gets of bytes that come in pieces of a size."""
    found: list[str] = []

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        body, more = b"", True
        while more:
            message = await receive()
            body, more = body + message.get("body", b""), message.get("more_body", False)
            if message["type"] == "http.disconnect":
                return
        found.append(f"{scope['method']} {scope['path']} {body!r} {scope['headers']}")
        await send({"type": "http.response.start", "status": 204, "headers": []})
        await send({"type": "http.response.body"})

    wire = Wire()
    protocol = LimitedProtocol(
        Settings(),
        Connections(9),
        config=uvicorn.Config(app, lifespan="off"),
        server_state=ServerState(),
        app_state={},
    )
    protocol.connection_made(wire)
    for first in range(0, len(sent), size):
        protocol.data_received(sent[first : first + size])
    while protocol.tasks:
        await asyncio.gather(*protocol.tasks)
        await asyncio.sleep(0)
    await asyncio.sleep(0)
    protocol.connection_lost(None)
    return [*found, *(str(status) for status in statuses(wire.written) if status >= 400)]


def test_a_request_that_is_refused_waits_for_the_answers_before_it(address: tuple[str, int]) -> None:
    bad = get(fields=HOST + b"X: a\r\n b\r\n")
    assert statuses(answers(address, get() + post(LENGTH, BODY) + bad + NEXT)) == [200, 422, 400]
    *answered, last = statuses(answers(address, get() * 1000))
    assert set(answered) == {200}
    assert (len(answered), last) < (200, 401), "so many are not read before they are answered"


def test_a_trailer_is_no_header(address: tuple[str, int]) -> None:
    received = answers(address, chunked(CHUNKS + b"X-Request-ID: trailer\r\n\r\n"), ends=True)
    assert statuses(received) == [422]
    assert b"trailer" not in received


@pytest.mark.parametrize("name", [*REFUSED, *ACCEPTED])
def test_it_does_not_matter_how_the_bytes_are_cut(name: str) -> None:
    sent = {**REFUSED, **ACCEPTED}[name][0] + NEXT
    whole, *cut = [asyncio.run(read(sent, size)) for size in (len(sent), 1, 2, 3, 7)]
    assert cut == [whole] * 4
    assert (whole[-1] in ("400", "501")) == (name in REFUSED)
    assert any("smuggled" in request for request in whole) == (ACCEPTED.get(name, ("", []))[1][1:] == [200])


def test_a_client_that_ends_its_half_gets_its_answer(address: tuple[str, int]) -> None:
    """As `nc -N` does; all that was asked is answered, and the connection ends then."""
    start = time.monotonic()
    assert statuses(answers(address, get() * 5, ends=True)) == [200] * 5
    assert statuses(answers(address, post(LENGTH, BODY), ends=True)) == [422]
    large = answers(address, get(b"/static/jsxgraph/jsxgraphcore.mjs"), ends=True)
    head, _, body = large.partition(b"\r\n\r\n")
    assert b"content-length: %d\r\n" % len(body) in head.lower() + b"\r\n"
    assert time.monotonic() - start < PATIENCE


@pytest.mark.parametrize("sent", [get()[:-2], get()[:10], post(LENGTH, BODY[:-1]), chunked(b"3\r\nab")])
def test_a_client_that_ends_its_half_too_soon_is_told(address: tuple[str, int], sent: bytes) -> None:
    received = answers(address, sent, ends=True)
    assert statuses(received) == [400]
    assert b"before it was complete" in received


def test_a_client_that_asks_nothing(address: tuple[str, int]) -> None:
    assert answers(address, b"", ends=True) == b""
    assert answers(address, b"\r\n", ends=True) == b""
