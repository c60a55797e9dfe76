"""The path prefix under which a reverse proxy shows the service, as in https://example.com/cusps/.

It is a setting, or the `X-Forwarded-Prefix` of a trusted proxy. Requests come with it or without, as the
proxy has it; inside, paths have none, and every link in an answer has it.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING

from worker.settings import Network

if TYPE_CHECKING:
    from starlette.types import Scope

HEADER = "x-forwarded-prefix"
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
    """Let links have a prefix as long as the block runs."""
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
        ValueError: it is none.
    """
    prefix = text.strip().removesuffix("/")
    if len(prefix) > _LONGEST or not _FORM.fullmatch(prefix):
        raise ValueError(f"{text[:60]!r} is not a path prefix such as /cusps")
    if prefix.split("/")[1:2] and prefix.split("/")[1] in _OWN:
        raise ValueError(f"{text[:60]!r} begins like the service's own paths; choose another, such as /cusps")
    return prefix


def forwarded_prefix(scope: Scope, proxies: Sequence[Network]) -> str | None:
    """Returns the prefix that a trusted proxy names, the outer one first if there are several; else None.

    Raises:
        ValueError: what it sends is none.
    """
    if not proxies:
        return None
    values = [value.decode("latin-1") for name, value in scope["headers"] if name == HEADER.encode()]
    peer = scope.get(PEER) or scope.get("client")
    if not values or peer is None or not _is_one_of(peer[0], proxies):
        return None
    parts = [part for value in values for part in value.split(",")]
    return "".join(read_prefix(part) for part in parts)


def without_prefix(path: str, prefix: str) -> str:
    """Returns a path as the service has it; a client that puts a link behind its own base sends it twice.

    >>> [without_prefix(path, "/cusps") for path in ("/v1/limits", "/cusps/v1/limits", "/cusps/cusps/docs")]
    ['/v1/limits', '/v1/limits', '/docs']
    """
    while prefix and path.startswith(f"{prefix}/"):
        path = path.removeprefix(prefix)
    return path


def _is_one_of(address: str, networks: Sequence[Network]) -> bool:
    try:
        ip = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return False
    ip = getattr(ip, "ipv4_mapped", None) or ip
    return any(ip in network for network in networks if network.version == ip.version)
