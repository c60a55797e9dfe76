"""Settings of the HTTP API, from the environment (`RPR_CUSPS_…`) or given in code; and the path
prefix under which a reverse proxy shows it, as in https://example.com/cusps/.

Requests come with the prefix or without, as the proxy has it; inside, paths have none, and every link in an
answer has it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, Field
from pydantic_settings import NoDecode

from rpr_solver.errors import clipped
from service.schemas.limits import Limits
from service.webhooks import WebhookSettings
from worker.limits import Constant
from worker.settings import EnvironmentSettings, each

PEER = "rpr_cusps.peer"
"""In the scope of a request: the address of the peer, even if the request is forwarded for another client."""

_FORM = re.compile(r"(/(?!\.\.?(/|$))[A-Za-z0-9._~-]+)*", re.ASCII)
_LONGEST = 200
_OWN = ("docs", "metrics", "problems", "schemas", "static", "v1", "version")
_PREFIX: ContextVar[str] = ContextVar("prefix", default="")


def here(path: str) -> str:
    """Returns the path of a link, for the client of the request that is being answered."""
    return _PREFIX.get() + path


@contextmanager
def prefixed(prefix: str) -> Iterator[None]:
    """Give links a prefix during the block."""
    token = _PREFIX.set(prefix)
    try:
        yield
    finally:
        _PREFIX.reset(token)


def read_prefix(text: str) -> str:
    """Returns a prefix without a slash at its end.

    >>> read_prefix("/cusps/"), read_prefix("/"), read_prefix("/tools/cusps")
    ('/cusps', '', '/tools/cusps')

    Raises:
        ValueError: it is not a prefix.
    """
    prefix = text.strip().removesuffix("/")
    if len(prefix) > _LONGEST or not _FORM.fullmatch(prefix):
        raise ValueError(f"{clipped(text, 60)!r} is not a path prefix such as /cusps")
    if prefix.removeprefix("/").partition("/")[0] in _OWN:
        raise ValueError(
            f"{clipped(text, 60)!r} begins like the service's own paths; choose another, such as /cusps"
        )
    return prefix


def without_prefix(path: str, prefix: str) -> str:
    """Returns a path as the service has it; a client that puts a link behind its own base sends it twice.

    >>> [without_prefix(path, "/cusps") for path in ("/v1/limits", "/cusps/v1/limits", "/cusps/cusps/docs")]
    ['/v1/limits', '/v1/limits', '/docs']
    """
    while prefix and path.startswith(f"{prefix}/"):
        path = path.removeprefix(prefix)
    return path


_ORIGIN = re.compile(r"https?://[^\s/?#@,*]+|\*", re.ASCII)
_SUCH_AS = "write one such as https://tools.example.com, or *"


def _origin(text: str) -> str | None:
    return text if _ORIGIN.fullmatch(text) else None


KeysPolicy = Literal["auto", "always", "never"]
"""Whether calls need a key."""

KeyScope = Literal["read", "submit", "admin"]

SCOPES: tuple[KeyScope, ...] = get_args(KeyScope)
"""What a key allows; each includes those before it."""


REDIS_CONNECTIONS = 64
"""Connections for short commands: more than there are threads for them."""

STREAM_CONNECTIONS = 256
"""Jobs that are waited for or followed at the same time: each takes a connection to Redis."""

RETRY_SECONDS = 2
"""`Retry-After` when Redis cannot be reached, or there is no room, in seconds: most such faults are short."""


class Settings(EnvironmentSettings):
    """How one API process runs.

    Attributes:
        redis_url: Redis or Valkey server that holds the queue and the results
        access_log: the requests that are logged; `errors`: those answered with 400 and above
        require_keys: whether calls need an API key; `auto`: once a key was made, and always if `serve`
            listens on an address that other computers reach
        allowed_hosts: names of the service, comma-separated, that a Host header may have beside addresses and
            localhost; `*.example.com` for those below a name, `*` for all
        cors_origins: origins of web pages that may call the service, comma-separated, such as
            `https://tools.example.com`; `*` for all; none if empty
        embed_origins: origins of web pages that may frame `/embed`, comma-separated; `*` for all; none if
            empty
        root_path: path under which a reverse proxy shows the service, such as `/cusps`; links begin so
        redis_timeout_seconds: time to wait for an answer of Redis, in seconds: it answers in milliseconds,
            and clients wait meanwhile
        header_seconds: time for the head of a request, from the opening of the connection, in seconds: what
            slow networks need, with a margin
        body_seconds: time for the body of a request, in seconds: a megabyte on a slow network
        idle_seconds: time between two requests of a connection, in seconds: less than proxies keep theirs
        stall_seconds: time in which a client must read some of an answer, and after one that closes the
            connection stop sending, in seconds
        keepalive_seconds: time between two keep-alive comments on an idle event stream, in seconds: proxies
            cut streams that are silent for 30 to 60
        longest_poll_seconds: greatest `Retry-After` of a job that waits in the queue, in seconds
        max_connections: maximum number of connections, and no more than open files allow; beyond it, the one
            that is idle for the longest time is closed. Each takes some 30 kB
        max_followers: maximum number of clients that follow events at the same time
        answer_cache_mb: memory for answers that were sent a moment ago, in MiB; those need no Redis. 0: none
        large_answers: maximum number of large results that are sent at the same time
    """

    redis_url: str = "redis://127.0.0.1:6379/0"
    access_log: Literal["all", "errors", "off"] = "all"
    require_keys: KeysPolicy = "auto"
    allowed_hosts: Annotated[tuple[str, ...], NoDecode, each(str)] = ()
    cors_origins: Annotated[tuple[str, ...], NoDecode, each(_origin, f"is no origin; {_SUCH_AS}")] = ()
    embed_origins: Annotated[tuple[str, ...], NoDecode, each(_origin, f"is no origin; {_SUCH_AS}")] = ("*",)
    root_path: Annotated[str, AfterValidator(read_prefix)] = ""
    limits: Constant[Limits] = Field(default_factory=Limits.of_environment)
    webhooks: Constant[WebhookSettings] = Field(default_factory=WebhookSettings)

    redis_timeout_seconds: Constant[float] = 2.0
    header_seconds: Constant[float] = 10.0
    body_seconds: Constant[float] = 30.0
    idle_seconds: Constant[int] = 15
    stall_seconds: Constant[float] = 30.0
    keepalive_seconds: Constant[float] = 15.0
    longest_poll_seconds: Constant[int] = 60
    max_connections: Constant[int] = 10_000
    max_followers: Constant[int] = 1000
    answer_cache_mb: Constant[int] = 32
    large_answers: Constant[int] = 32
