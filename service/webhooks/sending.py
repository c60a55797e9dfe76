"""One attempt to deliver: a signed POST to a checked address; only the head of the answer is read."""

from __future__ import annotations

import base64
import hmac
import socket
import ssl
import threading
import time
from collections.abc import Iterable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from email.utils import parsedate_to_datetime

import httpcore

from service import __version__
from service.webhooks.settings import Target, WebhookSettings, is_allowed
from worker.settings import Network

_MOST_ADDRESSES = 6


class RefusedError(Exception):
    """The host has no address that may be reached."""


@dataclass(frozen=True)
class Answer:
    """The head of an answer; `retry_after` in seconds."""

    status: int
    retry_after: float | None


def signature(secrets: Iterable[bytes], message_id: str, timestamp: int, body: bytes) -> str:
    """Returns the signatures of a message, one of each secret, after the Standard Webhooks specification.

    >>> signature([b"secret"], "msg_1", 1, b"{}")
    'v1,kW+83cjD04uWm7Qber/sPiCRVJ9ljbsrg8ALKAx2qMc='
    """
    content = f"{message_id}.{timestamp}.".encode() + body
    digests = (hmac.digest(secret, content, "sha256") for secret in secrets)
    return " ".join(f"v1,{base64.b64encode(digest).decode()}" for digest in digests)


def post(target: Target, message_id: str, body: bytes, settings: WebhookSettings) -> Answer:
    """Send a message once, within the time-out for the whole attempt. Redirects are not followed.

    Raises:
        RefusedError: the address may not be reached.
        SecretError: there is nothing to sign with.
        httpcore.NetworkError, httpcore.ProtocolError, httpcore.TimeoutException, OSError: no answer came.
    """
    now = int(time.time())
    headers = {
        "Host": target.authority,
        "Content-Type": "application/json",
        "Content-Length": str(len(body)),
        "User-Agent": f"rpr-cusps/{__version__}",
        "webhook-id": message_id,
        "webhook-timestamp": str(now),
        "webhook-signature": signature(settings.secrets(), message_id, now, body),
    }
    backend = _Backend(settings.networks, time.monotonic() + settings.webhook_timeout_seconds)
    url = httpcore.URL(
        scheme=target.scheme.encode(),
        host=target.host.encode(),
        port=target.port,
        target=target.path.encode(),
    )
    context = ssl.create_default_context() if target.scheme == "https" else None
    with (
        httpcore.ConnectionPool(ssl_context=context, network_backend=backend) as pool,
        pool.stream("POST", url, headers=list(headers.items()), content=body) as response,
    ):
        fields = {name.lower(): value for name, value in response.headers}
        return Answer(response.status, _seconds(fields))


def _seconds(fields: Mapping[bytes, bytes]) -> float | None:
    text = fields.get(b"retry-after", b"").decode("latin-1").strip()
    if text.isascii() and text.isdigit():
        return float(text[:9])
    try:
        return max(0.0, parsedate_to_datetime(text).timestamp() - time.time())
    except (ValueError, TypeError, OverflowError):
        return None


class _Backend(httpcore.NetworkBackend):
    """Connects to the address that was checked, so that a second look at the name cannot give another."""

    def __init__(self, networks: tuple[Network, ...], end: float) -> None:
        self._inner = httpcore.SyncBackend()
        self._networks = networks
        self._end = end

    def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,  # noqa: ARG002  # that of the whole attempt counts
        local_address: str | None = None,
        socket_options: Iterable[httpcore.SOCKET_OPTION] | None = None,
    ) -> httpcore.NetworkStream:
        addresses = _look_up(host, port, _left(self._end))
        allowed = [address for address in addresses if is_allowed(address, self._networks)][:_MOST_ADDRESSES]
        if not allowed:
            raise RefusedError(f"{host} is {addresses[0]}, which is not a public address")
        while True:
            address, *allowed = allowed
            time_for_one = _left(self._end) / (1 + len(allowed))
            try:
                stream = self._inner.connect_tcp(address, port, time_for_one, local_address, socket_options)
                return _Stream(stream, self._end)
            except (httpcore.ConnectError, httpcore.ConnectTimeout):
                if not allowed:
                    raise


def _look_up(host: str, port: int, seconds: float) -> list[str]:
    """Returns the addresses of a host, each once, within a time that the system's resolver does not know.

    Raises:
        ConnectTimeout: it takes longer.
        OSError: there are none.
    """
    answer: Future[list[str]] = Future()

    def ask() -> None:
        try:
            found = socket.getaddrinfo(host.encode(), port, type=socket.SOCK_STREAM)
            answer.set_result(list(dict.fromkeys(str(entry[4][0]) for entry in found)))
        except Exception as error:
            answer.set_exception(error)

    threading.Thread(target=ask, name="look-up", daemon=True).start()
    try:
        return answer.result(seconds)
    except TimeoutError:
        raise httpcore.ConnectTimeout(f"the name {host} was not resolved in time") from None


class _Stream(httpcore.NetworkStream):
    """A connection that counts the time of the whole attempt."""

    def __init__(self, inner: httpcore.NetworkStream, end: float) -> None:
        self._inner = inner
        self._end = end

    def read(self, max_bytes: int, timeout: float | None = None) -> bytes:  # noqa: ARG002
        return self._inner.read(max_bytes, _left(self._end))

    def write(self, buffer: bytes, timeout: float | None = None) -> None:  # noqa: ARG002
        self._inner.write(buffer, _left(self._end))

    def close(self) -> None:
        self._inner.close()

    def start_tls(
        self,
        ssl_context: ssl.SSLContext,
        server_hostname: str | None = None,
        timeout: float | None = None,  # noqa: ARG002
    ) -> httpcore.NetworkStream:
        return _Stream(self._inner.start_tls(ssl_context, server_hostname, _left(self._end)), self._end)

    def get_extra_info(self, info: str) -> object:
        return self._inner.get_extra_info(info)


def _left(end: float) -> float:
    left = end - time.monotonic()
    if left <= 0:
        raise httpcore.ReadTimeout("the attempt exceeded its time limit")
    return left
