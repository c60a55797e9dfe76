"""Settings of the worker layer, from the environment (`RPR_CUSPS_…`) or given in code."""

from __future__ import annotations

import ipaddress
from collections.abc import Callable, Iterable
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BeforeValidator, Field, PositiveFloat, PositiveInt, ValidationError
from pydantic.fields import FieldInfo
from pydantic_settings import (
    BaseSettings,
    EnvSettingsSource,
    NoDecode,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
)

from rpr_solver import SOLVER_VERSION
from rpr_solver.errors import clipped, installing
from worker.limits import DEADLINE, Constant, Deadline, describe_fields, is_setting
from worker.logs import LogFormat

Duty = Literal["light", "all"]
"""What a worker takes: short chunks only, or all."""

DUTIES: tuple[Duty, ...] = get_args(Duty)


class _Variables(EnvSettingsSource):
    """The variables of the environment that are settings."""

    def get_field_value(self, field: FieldInfo, field_name: str) -> tuple[Any, str, bool]:
        if not is_setting(field):
            return None, field_name, False
        return super().get_field_value(field, field_name)


class EnvironmentSettings(BaseSettings):
    """Settings from the variables `RPR_CUSPS_…`, or given in code; constants are only given in code.

    What its docstring says of its attributes is the description of its fields.
    """

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    @classmethod
    def settings_customise_sources(
        cls,
        settings_cls: type[BaseSettings],
        init_settings: PydanticBaseSettingsSource,
        *_: PydanticBaseSettingsSource,
        **__: PydanticBaseSettingsSource,
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """Returns where values are looked for: what is given in code, then the environment."""
        return init_settings, _Variables(settings_cls)

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


_SECRET = ("URL", "PASSWORD", "SECRET", "KEY")
_ARCHIVES = ("file", "s3", "gs", "az")


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

    The API processes and workers of one installation must agree on `key_prefix`.

    Attributes:
        key_prefix: prefix of every Redis key, and of the RQ queues PREFIX-VERSION-LANE, with the version of
            the solver and small, heavy or batch
        max_backlog_seconds: estimated work of one lane of the queue, in seconds per worker, beyond which it
            is full
        memory_limit_mb: maximum address space of a work horse, in MiB
        result_ttl_seconds: lifetime of a result and of its job, in seconds
        archive_url: archive to which answers move, so that Redis keeps their addresses only: a folder, as
            `file:///var/lib/rpr-cusps/archive`, or a bucket, as `s3://NAME/PATH`, `gs://…` or `az://…`; needs
            the extra `archive`
        store_max_mb: memory of the store, in MiB; above 80 % of it the oldest results are removed. Without
            it, the embedded store may take a quarter of the memory of the computer or the container, and
            another Redis its `maxmemory`, if it has one
        log_level: log level; without it INFO for a worker by itself, WARNING for `serve`
        log_format: form of log lines: `text`, or `json` with one object a line
        task: dotted name of the function that runs a chunk
        shutdown_grace: time that a stopping worker leaves its running chunk, in seconds: most chunks end in
            it, and whoever stops a worker waits for it
        archive_after: age at which an answer moves to the archive, in seconds: most answers are asked for
            again soon or never
    """

    key_prefix: str = "cusps"
    max_backlog_seconds: PositiveFloat = 300.0
    deadline_seconds: Deadline = DEADLINE
    memory_limit_mb: int | None = Field(default=4096, ge=64)
    result_ttl_seconds: PositiveInt = 7 * 86400
    archive_url: Annotated[str | None, AfterValidator(_archive)] = None
    store_max_mb: int | None = Field(default=None, ge=16)
    log_level: str | None = None
    log_format: LogFormat = "text"

    task: Constant[str] = "worker.process.tasks.run_chunk"
    shutdown_grace: Constant[float] = 1.0
    archive_after: Constant[int] = 3600

    @property
    def solver_version(self) -> str:
        """The version of the solver, which the names of queues have."""
        return SOLVER_VERSION


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
