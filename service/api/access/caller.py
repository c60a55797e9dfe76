"""The caller of a request, as the routes and the log see it."""

from __future__ import annotations

from collections.abc import MutableMapping
from dataclasses import dataclass
from typing import Any

from service.api.access.hosts import is_loopback
from service.api.access.keys import Scope, allows
from service.api.access_log import KEY_NAME
from service.api.prefix import PEER
from worker.jobs.subscriptions import Subscriber

_IN_SCOPE = "rpr_cusps.caller"
_OF_PROXIES = {b"forwarded", b"via", b"x-forwarded-for", b"x-real-ip"}


@dataclass(frozen=True)
class Caller:
    """A key, or on an open service a network address.

    Attributes:
        id: distinguishes callers: `key:ID` or `address:IP`.
        name: the name of the key; None for a caller without a key.
        scope: what the caller may do.
    """

    id: str
    name: str | None
    scope: Scope

    @property
    def is_limited(self) -> bool:
        """Whether rates and quotas count for the caller: not for one without a key on the same computer."""
        return not (self.is_anonymous and is_loopback(self.id.removeprefix("address:")))

    @property
    def is_anonymous(self) -> bool:
        """Whether the caller has shown no key."""
        return self.name is None


def oversees(scope: MutableMapping[str, Any]) -> bool:
    """Whether the caller of an ASGI request may see and end what others have asked for.

    A key with scope `admin` may; on an open service, whoever calls from the same computer and by no proxy.
    """
    caller = caller_of(scope)
    if caller is None or not caller.is_anonymous:
        return caller is not None and allows(caller.scope, "admin")
    names = {name for name, _ in scope["headers"]}
    is_forwarded = scope.get(PEER, scope.get("client")) != scope.get("client") or names & _OF_PROXIES
    return not caller.is_limited and not is_forwarded


def caller_of(scope: MutableMapping[str, Any]) -> Caller | None:
    """Returns the caller of an ASGI request; None for calls that are open to all, and those refused."""
    caller: Caller | None = scope.get(_IN_SCOPE)
    return caller


def subscriber_of(caller: Caller | None, token: str | None = None) -> Subscriber:
    """Returns the caller as one who wants a job; `token`: of the request that is meant, "" for any."""
    client, is_known = ("unknown", False) if caller is None else (caller.id, not caller.is_anonymous)
    return Subscriber(client, is_known) if token is None else Subscriber(client, is_known, token)


def set_caller(scope: MutableMapping[str, Any], caller: Caller) -> None:
    """Note the caller in the ASGI request, where the log finds the name of its key."""
    scope[_IN_SCOPE] = caller
    if caller.name is not None:
        scope[KEY_NAME] = caller.name
