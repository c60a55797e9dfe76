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
_TUNNELS = tuple(map(ipaddress.ip_network, ("64:ff9b::/96", "64:ff9b:1::/48", "2002::/16", "2001::/32")))


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
        port = parts.port or {"http": 80, "https": 443}[parts.scheme]
        host = (parts.hostname or "").lower()
    except ValueError:
        raise InputError.of(FIELD, f"is {shown}; its host or port cannot be read") from None
    if parts.scheme == "http" and not settings.webhook_allow_http:
        raise InputError.of(FIELD, f"is {shown}; it must be https:// (RPR_CUSPS_WEBHOOK_ALLOW_HTTP)")
    if "@" in parts.netloc or "#" in url:
        raise InputError.of(FIELD, f"is {shown}; it must have no user, password or fragment")
    if not any(_fits(host, pattern) for pattern in settings.hosts):
        raise InputError.of(
            FIELD, f"names the host {host[:80]!r}, which RPR_CUSPS_WEBHOOK_HOSTS does not allow"
        )
    path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    return Target(parts.scheme, host, port, path)


def _fits(host: str, pattern: str) -> bool:
    return host.endswith(pattern[1:]) if pattern.startswith("*.") else host == pattern.strip("[]")


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
    is_tunnel = any(ip in network for network in _TUNNELS if network.version == ip.version)
    return ip.is_global and not ip.is_multicast and not is_tunnel
