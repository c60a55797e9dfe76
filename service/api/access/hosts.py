"""The names of the service, against DNS rebinding.

A page of another site can let its own name lead to this service's address, and then use it as a page of that
site. Such a request has the name of that site in its Host header, never an address or `localhost`.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Collection

_HOST = re.compile(r"(\[[^\]]*\]|[^:]*)(:\d*)?")


def host_of(header: str) -> str | None:
    """Returns the host of a Host header in lower case, or None if it is malformed.

    >>> host_of("Queue.Example:8000"), host_of("[::1]:80"), host_of("a:b")
    ('queue.example', '[::1]', None)
    """
    match = _HOST.fullmatch(header.strip())
    return None if match is None else match[1].lower().removesuffix(".")


def is_known(header: str, names: Collection[str]) -> bool:
    """Whether a Host header names this service: by address, as localhost, or by one of its names.

    In `names`, `*` stands for every name, and `*.example.com` for the names below example.com.

    >>> [is_known(host, ["queue.example"]) for host in ("10.1.2.3:80", "queue.example", "evil.example")]
    [True, True, False]
    """
    if "*" in names:
        return True
    host = host_of(header)
    if not host:
        return False
    if host == "localhost" or host.endswith(".localhost") or _is_address(host):
        return True
    return any(
        host.endswith(name[1:]) and host != name[1:] if name.startswith("*.") else host == name
        for name in map(str.lower, names)
    )


def is_loopback(address: str) -> bool:
    """Whether a network address is one of this computer alone.

    >>> is_loopback("127.0.0.1"), is_loopback("::1"), is_loopback("192.0.2.1"), is_loopback("unknown")
    (True, True, False, False)
    """
    try:
        return ipaddress.ip_address(address.partition("%")[0]).is_loopback
    except ValueError:
        return False


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host[1:-1] if host.startswith("[") else host)
    except ValueError:
        return False
    return True
