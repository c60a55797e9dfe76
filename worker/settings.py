"""Settings of the worker layer, from the environment (`RPR_CUSPS_…`) or given in code."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    NonNegativeFloat,
    NonNegativeInt,
    PositiveFloat,
    PositiveInt,
    ValidationError,
)
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from rpr_solver import SOLVER_VERSION
from rpr_solver.errors import clipped, installing
from worker.limits import DEADLINE, Deadline, describe_fields
from worker.logs import LogFormat

Duty = Literal["light", "all"]
"""What a worker takes: short chunks only, or all."""

DUTIES: tuple[Duty, ...] = get_args(Duty)


class EnvironmentSettings(BaseSettings):
    """Settings from the variables `RPR_CUSPS_…`, or given in code.

    What its docstring says of its attributes is the description of its fields.
    """

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        super().__pydantic_init_subclass__(**options)
        describe_fields(cls)


def each(read: Callable[[str], object], message: str = "") -> BeforeValidator:
    """Returns the reader of a comma-separated setting. A part is invalid if `read` fails or returns None."""

    def value_of(part: str) -> object:
        with suppress(ValueError):
            return read(part)
        return None

    def values(given: object) -> object:
        if not isinstance(given, str):
            return given
        found = [(part, value_of(part)) for raw in given.split(",") if (part := raw.strip())]
        if bad := [part for part, value in found if value is None]:
            raise ValueError("; ".join(f"{clipped(part, 60)!r} {message}" for part in bad))
        return tuple(value for _, value in found)

    return BeforeValidator(values)


def written(value: object) -> str:
    """Returns the value of a setting as the environment gives it."""
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


Network = ipaddress.IPv4Network | ipaddress.IPv6Network

Networks = Annotated[
    tuple[Network, ...],
    NoDecode,
    each(ipaddress.ip_network, "is not an address or network such as 10.1.0.0/16"),
]
"""A comma-separated setting."""


def is_within(address: str, networks: Iterable[Network]) -> bool:
    """Whether one of these networks has an address, which may be an IPv4 address as IPv6 writes it.

    >>> is_within("::ffff:10.1.2.3", [ipaddress.ip_network("10.1.0.0/16")])
    True

    Raises:
        ValueError: it is no address.
    """
    ip = ipaddress.ip_address(address.partition("%")[0])
    ip = getattr(ip, "ipv4_mapped", None) or ip
    return any(ip in network for network in networks)


_LIFETIME = re.compile(r"([a-z-]+)=([1-9]\d{0,9})", re.ASCII)
_SECRET = ("URL", "PASSWORD", "SECRET", "KEY")
_ARCHIVES = ("file", "s3", "gs", "az")


def _lifetime(text: str) -> tuple[str, int] | None:
    match = _LIFETIME.fullmatch(text)
    return match and (match[1], int(match[2]))


def _archive(url: str | None) -> str | None:
    if not url:
        return None
    scheme, _, rest = url.partition("://")
    if scheme not in _ARCHIVES or not rest or (scheme == "file" and not rest.startswith("/")):
        raise ValueError(
            f"{clipped(url, 60)!r} is no archive; give file:///FOLDER, s3://NAME, gs://NAME or az://NAME"
        )
    if find_spec("obstore") is None:
        raise ValueError(f"an archive needs obstore; {installing('archive')}")
    return url


class ConnectionSettings(EnvironmentSettings):
    """What every connection to Redis needs beside the address.

    Attributes:
        redis_password_file: file whose first line is the password of Redis, for an address without one
    """

    redis_password_file: Path | None = None


class WorkerSettings(EnvironmentSettings):
    """Settings of the queue, the store and the worker processes.

    The API processes and workers of one installation must agree on `key_prefix` and `queue_name`.

    Attributes:
        key_prefix: prefix of every Redis key
        queue_name: RQ queues: NAME-VERSION-LANE, with the version of the solver and small, heavy or batch
        task: dotted name of the function that runs a chunk
        max_backlog: estimated work of one lane of the queue, in seconds per worker, beyond which it is full
        memory_limit_mb: maximum address space of a work horse, in MiB
        niceness: by how much work horses leave the cores to other processes (nice)
        result_ttl: lifetime of a result, in seconds
        result_ttls: other lifetimes of results of a kind, comma-separated, such as `census=2592000`
        job_ttl: lifetime of a succeeded job, in seconds
        failure_ttl: lifetime of a failed or canceled job, in seconds
        error_ttl: lifetime of a slice's error, in seconds; until then other jobs reuse it
        eliminant_ttl: lifetime of an eliminant, in seconds
        archive_url: archive to which answers move, so that Redis keeps their addresses only: a folder, as
            `file:///var/lib/rpr-cusps/archive`, or a bucket, as `s3://NAME/PATH`, `gs://…` or `az://…`; needs
            the extra `archive`
        archive_after: age at which an answer moves to the archive, in seconds
        archive_bytes: size from which on an answer moves a minute after it was made, in bytes
        archive_ttl: lifetime of an answer in the archive, since it was moved or asked for last, in seconds
        archive_timeout: time to wait for an answer of the archive, in seconds
        store_max_mb: memory of the store, in MiB; above 80 % of it the oldest results are removed. Without
            it, the embedded store may take a quarter of the memory of the computer or the container, and
            another Redis its `maxmemory`, if it has one
        shutdown_grace: time that a stopping worker leaves its running chunk, in seconds
        log_level: log level; without it INFO for a worker by itself, WARNING for `serve`
        log_format: form of log lines: `text`, or `json` with one object a line
    """

    key_prefix: str = "cusps"
    queue_name: str = "cusps"
    task: str = "worker.process.tasks.run_chunk"

    max_backlog: PositiveFloat = 300.0
    deadline: Deadline = DEADLINE
    memory_limit_mb: int | None = Field(default=4096, ge=64)
    niceness: int = Field(default=10, ge=0, le=19)

    result_ttl: PositiveInt = 7 * 86400
    result_ttls: Annotated[
        tuple[tuple[str, int], ...], NoDecode, each(_lifetime, "is no lifetime such as census=2592000")
    ] = ()
    job_ttl: PositiveInt = 7 * 86400
    failure_ttl: PositiveInt = 86400
    error_ttl: PositiveInt = 600
    eliminant_ttl: PositiveInt = 30 * 86400

    archive_url: Annotated[str | None, AfterValidator(_archive)] = None
    archive_after: NonNegativeInt = 3600
    archive_bytes: PositiveInt = 1 << 16
    archive_ttl: PositiveInt = 365 * 86400
    archive_timeout: PositiveFloat = 5.0

    store_max_mb: int | None = Field(default=None, ge=16)

    shutdown_grace: NonNegativeFloat = 1.0
    log_level: str | None = None
    log_format: LogFormat = "text"

    @property
    def solver_version(self) -> str:
        """The version of the solver, which the names of queues have."""
        return SOLVER_VERSION

    def lifetime(self, kind: str) -> int:
        """The lifetime of results of a kind, in seconds."""
        own = [ttl for name, ttl in self.result_ttls if name == kind]
        return min(own, default=self.result_ttl)

    @property
    def lifetimes(self) -> list[int]:
        """All lifetimes that a result may have, in seconds, ascending."""
        of_archive = [self.archive_ttl] if self.archive_url else []
        return sorted({self.result_ttl, *(ttl for _, ttl in self.result_ttls), *of_archive})

    @property
    def longest_lifetime(self) -> int:
        """The longest of them."""
        return self.lifetimes[-1]


def settings_problem(error: ValidationError) -> str:
    """Returns one line with the invalid variables, their values unless these may be secret, and why."""
    faults = []
    for item in error.errors():
        name, value, message = (
            "_".join(map(str, item["loc"])).upper(),
            clipped(str(item["input"]), 60),
            item["msg"],
        )
        is_shown = repr(value) in message or any(word in name for word in _SECRET)
        faults.append(f"RPR_CUSPS_{name}: {message}" + ("" if is_shown else f" (it is {value!r})"))
    return "; ".join(faults)
