"""Settings of the HTTP service, from the environment (`RPR_CUSPS_…`) or given in code."""

from __future__ import annotations

import re
from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, Field, NonNegativeInt, PositiveFloat, PositiveInt

from service.api.prefix import read_prefix
from service.schemas.limits import Limits
from service.webhooks.settings import WebhookSettings
from worker.settings import EnvironmentSettings, Network, Networks, each, listed, networks_of

_ORIGIN = re.compile(r"https?://[^\s/?#@,*]+|\*", re.ASCII)
_SUCH_AS = "write one such as https://tools.example.com, or *"

KeysPolicy = Literal["auto", "always", "never"]
"""Whether calls need a key."""

KeyScope = Literal["read", "submit", "admin"]

SCOPES: tuple[KeyScope, ...] = get_args(KeyScope)
"""What a key allows; each includes those before it."""


class Settings(EnvironmentSettings):
    """How one API process runs."""

    redis_url: str = Field(
        default="redis://127.0.0.1:6379/0",
        description="Redis or Valkey server that holds the queue and the results",
    )
    redis_connections: int = Field(
        default=64, ge=2, description="maximum number of connections for short commands"
    )
    redis_timeout_seconds: PositiveFloat = Field(
        default=2.0, description="time to wait for an answer of Redis, in seconds"
    )
    stream_connections: int = Field(
        default=256,
        ge=2,
        description="maximum number of jobs that are waited for or followed at the same time",
    )
    max_followers: PositiveInt = Field(
        default=1000, description="maximum number of clients that follow events at the same time"
    )
    threads: PositiveInt = Field(default=40, description="number of threads for work on Redis")
    poll_seconds: PositiveInt = Field(
        default=1, description="least `Retry-After` until a job has ended, in seconds"
    )
    longest_poll_seconds: PositiveInt = Field(
        default=60, description="greatest `Retry-After` of a job that waits in the queue, in seconds"
    )
    retry_seconds: PositiveInt = Field(
        default=2, description="`Retry-After` when Redis cannot be reached, in seconds"
    )
    keepalive_seconds: PositiveFloat = Field(
        default=15.0, description="time between two keep-alive comments on an idle event stream, in seconds"
    )
    gzip_bytes: NonNegativeInt = Field(
        default=1024, description="minimum size of a response to compress, in bytes"
    )
    access_log: Literal["all", "errors", "off"] = Field(
        default="all", description="the requests that are logged; `errors`: those answered with 400 and above"
    )
    require_keys: KeysPolicy = Field(
        default="auto",
        description="whether calls need an API key; `auto`: once a key was made, and always if `serve` "
        "listens on an address that other computers reach",
    )
    allowed_hosts: str = Field(
        default="",
        description="names of the service, comma-separated, that a Host header may have beside addresses and "
        "localhost; `*.example.com` for those below a name, `*` for all",
    )
    cors_origins: Annotated[str, each(_ORIGIN.fullmatch, f"is no origin; {_SUCH_AS}")] = Field(
        default="",
        description="origins of web pages that may call the service, comma-separated, such as "
        "`https://tools.example.com`; `*` for all; none if empty",
    )
    header_seconds: PositiveFloat = Field(
        default=10.0,
        description="time for the head of a request, from the opening of the connection, in seconds",
    )
    body_seconds: PositiveFloat = Field(
        default=30.0, description="time for the body of a request, in seconds"
    )
    idle_seconds: PositiveInt = Field(
        default=15, description="time between two requests of a connection, in seconds"
    )
    stall_seconds: PositiveFloat = Field(
        default=30.0,
        description="time in which a client must read some of an answer, and after one that closes the "
        "connection stop sending, in seconds",
    )
    max_header_bytes: PositiveInt = Field(
        default=32 << 10, description="maximum size of the header fields of a request, in bytes"
    )
    max_connections: PositiveInt = Field(
        default=10_000,
        description="maximum number of connections, and no more than open files allow; beyond it, the "
        "one that is idle for the longest time is closed",
    )
    answer_cache_mb: NonNegativeInt = Field(
        default=32,
        description="memory for answers that were sent a moment ago, in MiB; those need no Redis. 0: none",
    )
    answer_cache_seconds: PositiveFloat = Field(
        default=60.0, description="time for which such an answer is kept, in seconds"
    )
    large_answers: PositiveInt = Field(
        default=32, description="maximum number of large results that are sent at the same time"
    )
    large_answer_bytes: PositiveInt = Field(
        default=256 << 20, description="maximum memory of large results that are sent, in bytes, about"
    )
    root_path: Annotated[str, AfterValidator(read_prefix)] = Field(
        default="",
        description="path under which a reverse proxy shows the service, such as `/cusps`; links begin so",
    )
    trusted_proxies: Networks = Field(
        default="",
        description="addresses and networks of reverse proxies whose `X-Forwarded-Prefix` counts, "
        "comma-separated, such as `127.0.0.1,10.1.0.0/16`; none if empty",
    )
    limits: Limits = Field(default_factory=Limits.of_environment)
    webhooks: WebhookSettings = Field(default_factory=WebhookSettings)

    @property
    def proxies(self) -> tuple[Network, ...]:
        """The networks in `trusted_proxies`."""
        return networks_of(self.trusted_proxies)

    @property
    def origins(self) -> tuple[str, ...]:
        """The origins in `cors_origins`."""
        return listed(self.cors_origins)

    @property
    def host_names(self) -> tuple[str, ...]:
        """The names in `allowed_hosts`."""
        return listed(self.allowed_hosts)
