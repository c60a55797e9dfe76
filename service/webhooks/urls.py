"""Which addresses a callback may have."""

from __future__ import annotations

import ipaddress
import re
from dataclasses import dataclass
from urllib.parse import urlsplit

from rpr_solver.errors import InputError
from service.webhooks.settings import Network, WebhookSettings

FIELD = "callback_url"
LONGEST = 2000
_FORM = re.compile(r"https?://[!-~]+")
_LABEL = re.compile(r"[a-z0-9_]([a-z0-9_-]{0,61}[a-z0-9_])?")
_LONGEST_NAME = 253

# The registries of special-purpose addresses of IANA (RFC 6890), as far as they are not global, with what was
# in them and is no longer. Python's own table depends on its version.
_SPECIAL = tuple(
    ipaddress.IPv4Network(network)
    for network in (
        *("0.0.0.0/8", "10.0.0.0/8", "100.64.0.0/10", "127.0.0.0/8", "169.254.0.0/16", "172.16.0.0/12"),
        *("192.0.0.0/24", "192.0.2.0/24", "192.88.99.0/24", "192.168.0.0/16", "198.18.0.0/15"),
        *("198.51.100.0/24", "203.0.113.0/24", "224.0.0.0/4", "240.0.0.0/4"),
    )
)
_GLOBAL = ipaddress.IPv6Network("2000::/3")  # all else is local, embeds an IPv4 address, or is not assigned
_SPECIAL_IN_GLOBAL = tuple(
    ipaddress.IPv6Network(network)
    for network in ("2001::/23", "2001:db8::/32", "2002::/16", "3ffe::/16", "3fff::/20")
)


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
    shown = repr(url[:100])
    if not settings.is_on:
        raise InputError.of(FIELD, "webhooks are off here (RPR_CUSPS_WEBHOOK_HOSTS is not set); leave it out")
    if len(url) > LONGEST:
        raise InputError.of(FIELD, f"has {len(url)} characters; at most {LONGEST} are allowed")
    if not _FORM.fullmatch(url) or "\\" in url:
        raise InputError.of(FIELD, f"is {shown}; give a URL such as https://example.com/hooks/cusps")
    try:
        parts = urlsplit(url)
        port = {"http": 80, "https": 443}[parts.scheme] if parts.port is None else parts.port
        host = (parts.hostname or "").lower()
        is_host = port > 0 and _is_host(host, parts.netloc)
    except ValueError:
        is_host = False
    if not is_host:
        raise InputError.of(FIELD, f"is {shown}; its host or port cannot be read")
    if parts.scheme == "http" and not settings.webhook_allow_http:
        raise InputError.of(FIELD, f"is {shown}; it must be https:// (RPR_CUSPS_WEBHOOK_ALLOW_HTTP)")
    if "@" in parts.netloc or "#" in url:
        raise InputError.of(FIELD, f"is {shown}; it must have no user, password or fragment")
    if not any(fits(host, pattern) for pattern in settings.hosts):
        raise InputError.of(
            FIELD, f"names the host {host[:80]!r}, which RPR_CUSPS_WEBHOOK_HOSTS does not allow"
        )
    path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    return Target(parts.scheme, host, port, path)


def fits(host: str, pattern: str) -> bool:
    """Whether a host is the one of a pattern, or one of those below `*.name`.

    >>> fits("a.example.com", "*.example.com"), fits("example.com", "*.example.com")
    (True, False)
    """
    return host.endswith(pattern[1:]) if pattern.startswith("*.") else host == pattern.strip("[]")


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


def is_allowed(address: str, networks: tuple[Network, ...]) -> bool:
    """Whether webhooks may reach an address: a public one, or one in these networks.

    >>> is_allowed("8.8.8.8", ()), is_allowed("10.1.2.3", ()), is_allowed("::ffff:127.0.0.1", ())
    (True, False, False)
    """
    ip = ipaddress.ip_address(address.partition("%")[0])
    if isinstance(ip, ipaddress.IPv6Address) and ip.ipv4_mapped is not None:
        ip = ip.ipv4_mapped
    if any(ip in network for network in networks if network.version == ip.version):
        return True
    if isinstance(ip, ipaddress.IPv4Address):
        return not any(ip in network for network in _SPECIAL)
    return ip in _GLOBAL and not any(ip in network for network in _SPECIAL_IN_GLOBAL)
