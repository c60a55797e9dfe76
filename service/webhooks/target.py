"""Settings of webhooks, from the environment (`RPR_CUSPS_…`) and which addresses a callback may have."""

from __future__ import annotations

import base64
import binascii
import ipaddress
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated
from urllib.parse import urlsplit

from pydantic import Field, ValidationInfo, field_validator
from pydantic_settings import NoDecode

from rpr_solver.errors import InputError, clipped
from worker.limits import Constant
from worker.settings import EnvironmentSettings, Network, Networks, each, is_within

_PREFIX = "whsec_"
_LEAST_SECRET = 24  # bytes, as the specification asks for
_HOST = re.compile(r"(\*\.)?[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*|\[?[0-9A-Fa-f:.]+\]?")


class SecretError(ValueError):
    """The file of secrets cannot be used; the message does not quote it."""


def _host(text: str) -> str | None:
    return text.lower() if _HOST.fullmatch(text) else None


Hosts = Annotated[tuple[str, ...], NoDecode, each(_host, "is not the name of a host, or *. and a name")]


class WebhookSettings(EnvironmentSettings):
    """Who may be called, and how.

    Attributes:
        webhook_hosts: hosts that a `callback_url` may name, comma-separated; `*.example.com` for those below
            a name; without it there are no webhooks
        webhook_secret_file: file with the secrets that sign webhooks, one a line, each `whsec_` and 24 bytes
            or more in base64; each of them signs
        webhook_networks: private networks that webhooks may reach, comma-separated, such as `10.1.0.0/16`, in
            which a `callback_url` may be http://; all public addresses are allowed, with https://
        webhook_timeout_seconds: time for one attempt to deliver a webhook, in seconds: receivers answer first
            and work later
        webhook_retry_seconds: pauses between the attempts to deliver a webhook, in seconds: half a day in all
    """

    webhook_hosts: Hosts = ()
    webhook_secret_file: Path | None = Field(default=None, validate_default=True)
    webhook_networks: Networks = ()

    webhook_timeout_seconds: Constant[float] = 10.0
    webhook_retry_seconds: Constant[tuple[float, ...]] = (5, 30, 120, 600, 3600, 14400, 28800)

    @property
    def is_on(self) -> bool:
        """Whether there are webhooks."""
        return bool(self.webhook_hosts)

    def secrets(self) -> tuple[bytes, ...]:
        """Read the secrets, so that new ones count without a restart.

        Raises:
            SecretError: they cannot be read, or one is not of the form.
        """
        return _read(self.webhook_secret_file)

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


FIELD = "callback_url"
LONGEST = 2000
_FORM = re.compile(r"https?://[!-~]+")
_LABEL = re.compile(r"[a-z0-9_]([a-z0-9_-]{0,61}[a-z0-9_])?")
_LONGEST_NAME = 253
_LOOPBACK = ("127.0.0.1", "::1")

# The registries of special-purpose addresses of IANA (RFC 6890), as far as they are not global, with what was
# in them and is no longer. Python's own table depends on its version.
_SPECIAL = tuple(
    ipaddress.ip_network(network)
    for network in (
        *("0.0.0.0/8", "10.0.0.0/8", "100.64.0.0/10", "127.0.0.0/8", "169.254.0.0/16", "172.16.0.0/12"),
        *("192.0.0.0/24", "192.0.2.0/24", "192.88.99.0/24", "192.168.0.0/16", "198.18.0.0/15"),
        *("198.51.100.0/24", "203.0.113.0/24", "224.0.0.0/4", "240.0.0.0/4"),
        *("2001::/23", "2001:db8::/32", "2002::/16", "3ffe::/16", "3fff::/20"),
    )
)
# all else in IPv6 is local, embeds an IPv4 address, or is not assigned
_PUBLIC = (ipaddress.ip_network("0.0.0.0/0"), ipaddress.ip_network("2000::/3"))


@dataclass(frozen=True)
class Target:
    """A URL in its parts, read once so that what is checked is what is called."""

    scheme: str
    host: str
    port: int
    path: str

    @property
    def authority(self) -> str:
        """The value of the Host header."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return host if self.port == {"http": 80, "https": 443}[self.scheme] else f"{host}:{self.port}"


def target_of(url: str, settings: WebhookSettings) -> Target:
    """Read a callback URL.

    Raises:
        InputError: it may not be called; naming the field.
    """
    shown = repr(clipped(url, 100))
    if not settings.is_on:
        raise InputError.of(FIELD, "webhooks are disabled (RPR_CUSPS_WEBHOOK_HOSTS is not set); omit it")
    if len(url) > LONGEST:
        raise InputError.of(FIELD, f"has {len(url)} characters; at most {LONGEST} are allowed")
    if not _FORM.fullmatch(url) or "\\" in url:
        raise InputError.of(FIELD, f"is {shown}; give a URL such as https://example.com/hooks/cusps")
    target = _parts_of(url)
    if target is None:
        raise InputError.of(FIELD, f"is {shown}; its host or port cannot be read")
    if "@" in urlsplit(url).netloc or "#" in url:
        raise InputError.of(FIELD, f"is {shown}; it must have no user, password or fragment")
    if not any(fits(target.host, pattern) for pattern in settings.webhook_hosts):
        raise InputError.of(
            FIELD,
            f"names the host {clipped(target.host)!r}, which RPR_CUSPS_WEBHOOK_HOSTS does not allow",
        )
    _check_address(target, settings.webhook_networks)
    return target


def _check_address(target: Target, networks: tuple[Network, ...]) -> None:
    is_plain, setting = target.scheme == "http", "RPR_CUSPS_WEBHOOK_NETWORKS"
    if is_plain and not networks:
        raise InputError.of(FIELD, f"must be https://, since {setting} is not set")
    addresses = _addresses_of(target.host)
    if addresses and not any(is_allowed(address, networks, target.scheme) for address in addresses):
        what = "for http:// not in" if is_plain else "not a public address and not in"
        raise InputError.of(FIELD, f"names {target.host}, which is {what} {setting}")


def _addresses_of(host: str) -> Sequence[str]:
    """Returns the addresses of a host that are known without asking for its name."""
    if host == "localhost" or host.endswith(".localhost"):
        return _LOOPBACK
    try:
        return (str(ipaddress.ip_address(host)),)
    except ValueError:
        return ()


def _parts_of(url: str) -> Target | None:
    try:
        parts = urlsplit(url)
        port = {"http": 80, "https": 443}[parts.scheme] if parts.port is None else parts.port
        host = (parts.hostname or "").lower()
        if port == 0 or not _is_host(host, parts.netloc):
            return None
    except ValueError:
        return None
    path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    return Target(parts.scheme, host, port, path)


def fits(host: str, pattern: str) -> bool:
    """Whether a host is the one of a pattern, or one of those below `*.name`.

    >>> fits("a.example.com", "*.example.com"), fits("example.com", "*.example.com")
    (True, False)
    """
    if pattern.startswith("*."):
        return host.endswith(pattern[1:]) and host != pattern[1:]
    return host == pattern.strip("[]")


def _is_host(host: str, authority: str) -> bool:
    """Whether this is an address, or a name that can be looked up.

    Raises:
        ValueError: it is not.
    """
    if authority.startswith("[") or ":" in host:
        return ipaddress.IPv6Address(host).scope_id is None
    labels = host.split(".")
    for label in labels:
        if label.startswith("xn--"):
            label[4:].encode().decode("punycode")
    return len(host) <= _LONGEST_NAME and all(map(_LABEL.fullmatch, labels))


def is_allowed(address: str, networks: tuple[Network, ...], scheme: str = "https") -> bool:
    """Whether webhooks may reach an address: one in these networks, and with https a public one.

    >>> is_allowed("8.8.8.8", ()), is_allowed("10.1.2.3", ()), is_allowed("::ffff:127.0.0.1", ())
    (True, False, False)
    """
    is_public = scheme == "https" and is_within(address, _PUBLIC) and not is_within(address, _SPECIAL)
    return is_public or is_within(address, networks)
