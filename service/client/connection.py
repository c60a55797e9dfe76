"""Connections to a service: where and with which key, and HTTP with or without an event loop."""

from __future__ import annotations

import ssl
import time
from collections.abc import AsyncGenerator, AsyncIterator, Coroutine, Iterable, Mapping
from contextlib import aclosing, asynccontextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

import anyio
import httpx
from pydantic import Field, SecretStr
from pydantic_settings import BaseSettings, SettingsConfigDict

from service.client.bodies import Body, Later
from service.errors import ServiceError

T = TypeVar("T")

Lines = AsyncGenerator[bytes, None]

_LOOPBACK = ("127.0.0.1", "localhost", "::1")
_CONNECT_TIMEOUT = 5.0
_TIMEOUT = httpx.Timeout(60.0, connect=_CONNECT_TIMEOUT)
_WITHDRAWAL_TIMEOUT = 2.0


class ClientSettings(BaseSettings):
    """What a client reads from the environment, since others can see a command line."""

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    api_key: SecretStr | None = Field(default=None, description="API key that clients and `--url` send")


@dataclass(frozen=True)
class Call:
    """An HTTP request; `body` is that of a batch, `key` its idempotency key, `timeout` is in seconds."""

    method: str
    path: str
    json: object = None
    accept: str = "application/json"
    prefer: str | None = None
    body: Body | None = None
    key: str | None = None
    timeout: float | None = None

    @property
    def options(self) -> dict[str, Any]:
        """The arguments of `httpx`, except the body."""
        fields = {
            "Accept": self.accept,
            "Prefer": self.prefer,
            "Content-Type": None if self.body is None else self.body.media_type,
            "Idempotency-Key": self.key,
        }
        options: dict[str, Any] = {"method": self.method, "url": self.path}
        options["headers"] = {name: value for name, value in fields.items() if value is not None}
        if self.json is not None:
            options["json"] = self.json
        if self.timeout is not None:
            options["timeout"] = httpx.Timeout(self.timeout, connect=_CONNECT_TIMEOUT)
        return options


class Connection:
    """HTTP with one service, on asyncio or trio.

    Raises:
        ServiceError: the URL is not an HTTP address.
    """

    def __init__(self, url: str, *, with_key: bool) -> None:
        self.url = url
        self._open(_options(url, with_key=with_key))

    def _open(self, options: Mapping[str, Any]) -> None:
        self._http = httpx.AsyncClient(**options)

    async def send(self, call: Call) -> httpx.Response:
        """Send a request; returns the whole response."""
        content = None if call.body is None else Later(call.body)
        return await self._http.request(content=content, **call.options)

    @asynccontextmanager
    async def stream(self, call: Call) -> AsyncIterator[tuple[httpx.Response, Lines]]:
        """Send a request; gives the response and, on success, the lines of its body as they arrive."""
        async with self._http.stream(**call.options) as response:
            if not response.is_success:
                await response.aread()
            async with aclosing(_lines(response, response.aiter_bytes())) as lines:
                yield response, lines

    async def sleep(self, seconds: float) -> None:
        """Wait."""
        await anyio.sleep(seconds)

    async def close(self) -> None:
        """Close all connections."""
        await self._http.aclose()

    def is_interruption(self, error: BaseException) -> bool:
        """Whether an exception cancels the task, or is Ctrl-C if the connection blocks."""
        return isinstance(error, anyio.get_cancelled_exc_class())

    async def withdraw(self, withdrawal: Coroutine[Any, Any, T]) -> T | None:
        """Withdraw a question after an interruption, for which a canceled task still has a moment."""
        if self._http.is_closed:
            withdrawal.close()
            return None
        with anyio.CancelScope(shield=True), anyio.move_on_after(_WITHDRAWAL_TIMEOUT):
            return await withdrawal
        return None


class BlockingConnection(Connection):
    """The same without an event loop: no method ever suspends, so that :func:`finished` can run them."""

    def _open(self, options: Mapping[str, Any]) -> None:
        self._blocking = httpx.Client(**options)

    async def send(self, call: Call) -> httpx.Response:
        """Send a request; returns the whole response."""
        return self._blocking.request(content=call.body, **call.options)

    @asynccontextmanager
    async def stream(self, call: Call) -> AsyncIterator[tuple[httpx.Response, Lines]]:
        """Send a request; gives the response and, on success, the lines of its body as they arrive."""
        with self._blocking.stream(**call.options) as response:
            if not response.is_success:
                response.read()
            async with aclosing(_lines(response, _each(response.iter_bytes()))) as lines:
                yield response, lines

    async def sleep(self, seconds: float) -> None:
        """Wait."""
        time.sleep(seconds)

    async def close(self) -> None:
        """Close all connections."""
        self._blocking.close()

    def is_interruption(self, error: BaseException) -> bool:
        """Whether this is Ctrl-C."""
        return isinstance(error, KeyboardInterrupt)

    async def withdraw(self, withdrawal: Coroutine[Any, Any, T]) -> T | None:
        """Withdraw a question."""
        return await withdrawal


def finished(step: Coroutine[Any, Any, T]) -> T:
    """Returns what a coroutine returns that never suspends, because its connection blocks."""
    try:
        step.send(None)
    except StopIteration as end:
        value: T = end.value
        return value
    raise AssertionError("a blocking connection never suspends")


async def _each(pieces: Iterable[bytes]) -> AsyncIterator[bytes]:
    for piece in pieces:
        yield piece


async def _lines(response: httpx.Response, pieces: AsyncIterator[bytes]) -> Lines:
    """Yields the complete lines of a body, without their ends; none if the response is no success."""
    held: list[bytes] = []
    if not response.is_success:
        return
    async for piece in pieces:
        held.append(piece)
        if b"\n" in piece:
            *lines, rest = b"".join(held).split(b"\n")
            held = [rest]
            for line in lines:
                yield line


def _options(url: str, *, with_key: bool) -> dict[str, Any]:
    try:
        parsed = httpx.URL(url)
    except (httpx.InvalidURL, TypeError) as error:
        raise ServiceError(f"{url!r} is not an address: {error}", is_input=True) from None
    if parsed.scheme not in ("http", "https") or not parsed.host:
        raise ServiceError(
            f"{url!r} is not an HTTP address; give for example http://127.0.0.1:8000", is_input=True
        )
    key = ClientSettings().api_key if with_key else None
    return {
        "base_url": url,
        "headers": {} if key is None else {"Authorization": f"Bearer {key.get_secret_value()}"},
        "timeout": _TIMEOUT,
        "trust_env": parsed.host not in _LOOPBACK,  # proxies of the environment are not for this machine
        # without TLS no authority is needed; to read them all takes 30 ms
        "verify": parsed.scheme == "https" or ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT),
    }
