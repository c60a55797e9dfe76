"""Settings of webhooks, from the environment (`RPR_CUSPS_…`) or given in code."""

from __future__ import annotations

import base64
import binascii
import ipaddress
import re
from pathlib import Path

from pydantic import Field, PositiveFloat, ValidationInfo, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

Network = ipaddress.IPv4Network | ipaddress.IPv6Network

_PREFIX = "whsec_"
_LEAST_SECRET = 24  # bytes, as the specification asks for


class SecretError(ValueError):
    """The file of secrets cannot be used; the message does not quote it."""


class WebhookSettings(BaseSettings):
    """Who may be called, and how."""

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    webhook_hosts: str = Field(
        default="",
        description="hosts that a `callback_url` may name, comma-separated; `*.example.com` for those below "
        "a name; without it there are no webhooks",
    )
    webhook_secret_file: Path | None = Field(
        default=None,
        validate_default=True,
        description="file with the secrets that sign webhooks, one a line, each `whsec_` and 24 bytes or "
        "more in base64; each of them signs",
    )
    webhook_allow_http: bool = Field(default=False, description="whether a `callback_url` may be http://")
    webhook_networks: str = Field(
        default="",
        description="private networks that webhooks may reach, comma-separated, such as `10.1.0.0/16`; all "
        "public addresses are allowed",
    )
    webhook_timeout_seconds: PositiveFloat = Field(
        default=10.0, le=60, description="time for one attempt to deliver a webhook, in seconds"
    )
    webhook_retry_seconds: str = Field(
        default="5,30,120,600,3600,14400,28800",
        description="pauses between the attempts to deliver a webhook, comma-separated, in seconds",
    )

    @property
    def is_on(self) -> bool:
        """Whether there are webhooks."""
        return bool(self.hosts)

    @property
    def hosts(self) -> tuple[str, ...]:
        """The hosts that may be named, in lower case."""
        return tuple(host.lower() for host in _parts(self.webhook_hosts))

    @property
    def networks(self) -> tuple[Network, ...]:
        """The private networks that may be reached."""
        return tuple(map(ipaddress.ip_network, _parts(self.webhook_networks)))

    @property
    def pauses(self) -> tuple[float, ...]:
        """The pauses between the attempts, in seconds."""
        return tuple(map(float, _parts(self.webhook_retry_seconds)))

    def secrets(self) -> tuple[bytes, ...]:
        """Read the secrets, so that new ones count without a restart.

        Raises:
            SecretError: they cannot be read, or one is not of the form.
        """
        return _read(self.webhook_secret_file)

    @field_validator("webhook_hosts")
    @classmethod
    def _hosts(cls, value: str) -> str:
        for host in _parts(value):
            if not re.fullmatch(r"(\*\.)?[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*|\[?[0-9A-Fa-f:.]+\]?", host):
                raise ValueError(f"{host[:60]!r} is not the name of a host, or *. and a name")
        return value

    @field_validator("webhook_networks")
    @classmethod
    def _networks(cls, value: str) -> str:
        for part in _parts(value):
            try:
                ipaddress.ip_network(part)
            except ValueError:
                raise ValueError(f"{part[:60]!r} is not a network such as 10.1.0.0/16") from None
        return value

    @field_validator("webhook_retry_seconds")
    @classmethod
    def _pauses(cls, value: str) -> str:
        for part in _parts(value):
            if not re.fullmatch(r"[0-9]+(\.[0-9]+)?", part) or float(part) > 86400:
                raise ValueError(f"{part[:60]!r} is not a number of seconds up to 86400")
        if len(_parts(value)) > 20:
            raise ValueError("has more than 20 pauses")
        return value

    @field_validator("webhook_secret_file")
    @classmethod
    def _signed(cls, path: Path | None, info: ValidationInfo) -> Path | None:
        if info.data.get("webhook_hosts"):
            _read(path)
        return path


def _read(path: Path | None) -> tuple[bytes, ...]:
    if path is None:
        raise SecretError("is missing; webhooks are signed, so RPR_CUSPS_WEBHOOK_HOSTS needs it")
    try:
        lines = path.read_text(encoding="utf-8").split()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8"
        raise SecretError(f"{str(path)!r} cannot be read ({reason})") from None
    if not lines:
        raise SecretError(f"{str(path)!r} is empty")
    return tuple(_secret(line, number, path) for number, line in enumerate(lines, 1))


def _parts(text: str) -> tuple[str, ...]:
    return tuple(part for raw in text.split(",") if (part := raw.strip()))


def _secret(line: str, number: int, path: Path) -> bytes:
    try:
        secret = base64.b64decode(line.removeprefix(_PREFIX), validate=True)
    except (binascii.Error, ValueError):
        secret = b""
    if not line.startswith(_PREFIX) or len(secret) < _LEAST_SECRET:
        raise SecretError(
            f"{str(path)!r}: secret {number} is not {_PREFIX} and {_LEAST_SECRET} bytes or more in base64"
        )
    return secret
