"""The caller of a request, the names of the service it may use, the scope that each call needs, and
whether one more job may be computed for it."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Collection, Iterable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from fastapi.routing import iter_route_contexts
from starlette.routing import BaseRoute

from service.api.http.middleware import KEY_NAME
from service.api.keys import allows
from service.api.problems import ProblemError, ProblemType
from service.api.settings import PEER, KeyScope
from service.schemas import all_questions, queries
from service.schemas.limits import Limits
from service.webhooks import fits
from worker.jobs.quotas import Quota, QuotaError, Quotas
from worker.jobs.records import Client

_HOST = re.compile(r"(\[[^\]]*\]|[^:]*)(:\d*)?")


def is_known(header: str, names: Collection[str]) -> bool:
    """Whether a Host header names this service: by address, as localhost, or by one of its names.

    In `names`, `*` stands for every name, and `*.example.com` for the names below example.com.

    >>> hosts = ("10.1.2.3:80", "Queue.Example:8000", "[::1]:80", "evil.example", "a:b")
    >>> [is_known(host, ["queue.example"]) for host in hosts]
    [True, True, True, False, False]
    """
    if "*" in names:
        return True
    match = _HOST.fullmatch(header.strip())
    host = "" if match is None else match[1].lower().removesuffix(".")
    if not host:
        return False
    if host == "localhost" or host.endswith(".localhost") or _is_address(host):
        return True
    return any(fits(host, name.lower()) for name in names)


@lru_cache(1000)
def is_loopback(address: str) -> bool:
    """Whether a network address is one of this computer alone.

    >>> is_loopback("127.0.0.1"), is_loopback("::1"), is_loopback("192.0.2.1"), is_loopback("unknown")
    (True, True, False, False)
    """
    try:
        return ipaddress.ip_address(address.partition("%")[0]).is_loopback
    except ValueError:
        return False


@lru_cache(1000)
def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host[1:-1] if host.startswith("[") else host)
    except ValueError:
        return False
    return True


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
    scope: KeyScope

    @property
    def is_limited(self) -> bool:
        """Whether rates and quotas count for the caller: not for one without a key on the same computer."""
        return not (self.is_anonymous and is_loopback(self.id.removeprefix("address:")))

    @property
    def is_anonymous(self) -> bool:
        """Whether the caller has shown no key."""
        return self.name is None


def oversees(scope: MutableMapping[str, Any]) -> bool:
    """Whether the caller of an ASGI request may see and cancel the jobs of others.

    A key with scope `admin` may; on an open service, a client on the same computer without a proxy.
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


def client_of(caller: Caller | None) -> Client:
    """Returns the caller as a client of jobs."""
    return Client("unknown", is_known=False) if caller is None else Client(caller.id, not caller.is_anonymous)


def set_caller(scope: MutableMapping[str, Any], caller: Caller) -> None:
    """Note the caller in the ASGI request, where the log finds the name of its key."""
    scope[_IN_SCOPE] = caller
    if caller.name is not None:
        scope[KEY_NAME] = caller.name


CHALLENGE = 'Bearer realm="rpr-cusps"'

_CALLS: tuple[tuple[KeyScope | None, Iterable[str]], ...] = (
    (None, ("GET /", "GET /docs", "GET /embed", "GET /openapi.json", "GET /openapi.yaml")),
    (None, ("GET /schemas/geometry.json", "GET /static/{path}")),
    (None, ("GET /problems", "GET /problems/{slug}", "GET /healthz", "GET /readyz")),
    ("read", ("GET /v1/version", "GET /v1/limits")),
    ("read", ("GET /v1/jobs", "GET /v1/jobs/{job_id}", "GET /v1/batches", "GET /v1/batches/{batch_id}")),
    ("read", ("GET /v1/jobs/{job_id}/result", "GET /v1/batches/{batch_id}/results")),
    ("read", ("GET /v1/jobs/{job_id}/events", "GET /v1/batches/{batch_id}/events")),
    ("submit", (f"POST {question.path}" for question in all_questions())),
    ("submit", (f"GET {question.path}" for question in queries())),
    ("submit", ("POST /v1/batches", "DELETE /v1/batches/{batch_id}", "DELETE /v1/jobs/{job_id}")),
    ("admin", ("GET /metrics",)),
)

NEEDED: Mapping[str, KeyScope | None] = {call: scope for scope, calls in _CALLS for call in calls}
"""Call → the scope that it needs; None: anyone may call."""


class Rules:
    """The scopes of all routes of an application, found by the patterns by which it finds the routes.

    Raises:
        LookupError: a route has no scope; the service does not start with such a route.
    """

    def __init__(self, routes: Sequence[BaseRoute]) -> None:
        self._rules: list[tuple[str, re.Pattern[str], KeyScope | None]] = []
        for route in iter_route_contexts(routes):
            for method in sorted(route.methods or {"GET"}):
                call = f"{method} {route.path_format}"
                if call not in NEEDED:
                    raise LookupError(f"{call} has no scope; give it one in {__name__}")
                self._rules.append((method, route.path_regex, NEEDED[call]))

    def scope_needed(self, method: str, path: str) -> KeyScope | None:
        """Returns the scope that a call needs: `read` for unknown paths, so that they cannot be probed."""
        fitting = (scope for known, pattern, scope in self._rules if known == method and pattern.match(path))
        return next(fitting, "read")


def check_scope(caller: Caller, needed: KeyScope) -> None:
    """Refuse a caller whose key does not have the scope.

    Raises:
        ProblemError: 403, it names the scope that is needed.
    """
    if not allows(caller.scope, needed):
        raise ProblemError(
            ProblemType.FORBIDDEN,
            f"This call needs a key with scope {needed}; the key {caller.name} has scope {caller.scope}.",
            headers={"WWW-Authenticate": f'{CHALLENGE}, error="insufficient_scope", scope="{needed}"'},
        )


_RETRY_S = 5


@dataclass(frozen=True)
class Admission:
    """Counts what is computed for a caller, as `Limits` bound it."""

    caller: Caller | None
    quotas: Quotas
    limits: Limits

    def admit(self, job_id: str, work: float) -> None:
        """Count a job, with its estimated work in seconds.

        Raises:
            ProblemError: the caller has as much as it may have, or may not compute.
        """
        if self.caller is None:
            return
        check_scope(self.caller, "submit")  # independent of the route
        if not self.caller.is_limited:
            return
        quota = Quota(self.limits.max_active_jobs, self.limits.max_active_seconds)
        try:
            self.quotas.admit(self.caller.id, job_id, work, quota)
        except QuotaError as error:
            raise _too_much(error, quota) from None


def _too_much(error: QuotaError, quota: Quota) -> ProblemError:
    is_number = 0 < quota.jobs <= error.jobs
    name, value = ("max_active_jobs", quota.jobs) if is_number else ("max_active_seconds", quota.seconds)
    return ProblemError.too_many(
        f"You have {error.jobs} active jobs with about {error.seconds:.0f} s of estimated work; the limit "
        f"{name} is {value}. Wait for some of them, or withdraw them (DELETE).",
        limit=name,
        value=value,
        retry_s=_RETRY_S,
    )
