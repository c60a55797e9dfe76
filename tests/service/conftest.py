from __future__ import annotations

import inspect
import itertools
from collections.abc import AsyncGenerator, Callable, Iterator
from contextlib import ExitStack
from typing import Any, Self

import httpx
import pytest
from anyio.from_thread import start_blocking_portal
from redis import Redis

from service.api.settings import Settings
from service.client import AsyncServiceClient, ServiceClient
from service.schemas.limits import Limits
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, until
from tests.support.service_server import serving
from tests.support.template import starts_forked
from tests.support.valkey import valkey
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.process.pool import WorkerPool

__all__ = ["valkey"]


@pytest.fixture(scope="session")
def worker(valkey: EmbeddedValkey) -> Iterator[None]:
    """One real worker process."""
    pool = WorkerPool(1, valkey.url)
    with starts_forked():
        pool.start()
    try:
        until(pool.is_ready)
        yield
    finally:
        pool.stop()


@pytest.fixture(scope="session")
def idle_url(valkey: EmbeddedValkey) -> Iterator[str]:
    """A service whose queue nobody works on, with small limits."""
    with connect(f"{valkey.url}?db=1") as client:
        client.flushdb()
    limits = Limits(
        max_slices=5,
        max_article_slices=2,
        max_samples=5,
        max_digits=100,
        max_number_digits=30,
        max_body_bytes=2000,
    )
    with serving(Settings(redis_url=f"{valkey.url}?db=1", keepalive_seconds=0.3, limits=limits)) as url:
        yield url


@pytest.fixture(scope="session")
def base_url(valkey: EmbeddedValkey, worker: None) -> Iterator[str]:  # noqa: ARG001
    with serving(Settings(redis_url=valkey.url)) as url:
        yield url


@pytest.fixture
def api(base_url: str) -> Iterator[httpx.Client]:
    """A client of a service with a worker; it waits for answers unless it says otherwise."""
    with httpx.Client(base_url=base_url, timeout=PATIENCE, headers={"Prefer": "wait=20"}) as client:
        yield client


@pytest.fixture
def idle(idle_url: str) -> Iterator[httpx.Client]:
    """A client of the service without a worker."""
    with httpx.Client(base_url=idle_url, timeout=PATIENCE) as client:
        yield client


@pytest.fixture
def idle_queue(valkey: EmbeddedValkey) -> Iterator[JobQueue]:
    """The queue behind `idle`."""
    with connect(f"{valkey.url}?db=1") as client:
        yield JobQueue(client)


@pytest.fixture
def redis(valkey: EmbeddedValkey) -> Iterator[Redis]:
    """A client of the server, which the service and its worker use at the same time."""
    with connect(valkey.url) as client:
        yield client


@pytest.fixture
def idle_redis(valkey: EmbeddedValkey) -> Iterator[Redis]:
    """A client of a database that no worker serves, empty at the start of each test."""
    with connect(f"{valkey.url}?db=2") as client:
        client.flushdb()
        yield client


_slices = itertools.count(20_000)


@pytest.fixture
def fresh() -> Callable[[], str]:
    """Gives a slice that no other test has asked for."""
    return lambda: f"{next(_slices) / 1000:.3f}"


class Awaited:
    """The asynchronous client in an event loop of its own, with the methods of the other one."""

    def __init__(self, url: str) -> None:
        self._stack = ExitStack()
        self._portal = self._stack.enter_context(start_blocking_portal())
        self._client = AsyncServiceClient(url)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._stack:
            self._portal.call(self._client.aclose)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        method = getattr(self._client, name)

        def call(*args: Any, **kwargs: Any) -> Any:
            if inspect.isasyncgen(items := method(*args, **kwargs)):
                return self._each(items)

            async def outcome() -> Any:
                return await items

            return self._portal.call(outcome)

        return call

    def _each(self, items: AsyncGenerator[Any]) -> Iterator[Any]:
        async def following() -> Any:
            return await anext(items, None)

        try:
            while (item := self._portal.call(following)) is not None:
                yield item
        finally:
            self._portal.call(items.aclose)


@pytest.fixture(params=[ServiceClient, Awaited], ids=["waiting", "awaited"])
def client_type(request: pytest.FixtureRequest) -> type:
    """Each of the two clients, as a class."""
    client: type = request.param
    return client
