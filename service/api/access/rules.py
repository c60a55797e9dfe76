"""Which call needs which scope, in one table; those that compute are in it by the tables of operations."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from fastapi.routing import iter_route_contexts
from starlette.routing import BaseRoute

from service.api.access.caller import Caller
from service.api.access.keys import Scope, allows
from service.api.operations import OPERATIONS, QUERIES
from service.api.problems import ProblemError, ProblemType

CHALLENGE = 'Bearer realm="rpr-cusps"'

_CALLS: tuple[tuple[Scope | None, Iterable[str]], ...] = (
    (None, ("GET /", "GET /docs", "GET /openapi.json", "GET /openapi.yaml")),
    (None, ("GET /schemas/geometry.json", "GET /static/{path}")),
    (None, ("GET /problems", "GET /problems/{slug}", "GET /healthz", "GET /readyz")),
    ("read", ("GET /version", "GET /v1/limits")),
    ("read", ("GET /v1/jobs", "GET /v1/jobs/{job_id}", "GET /v1/batches", "GET /v1/batches/{batch_id}")),
    ("read", ("GET /v1/jobs/{job_id}/result", "GET /v1/batches/{batch_id}/results")),
    ("read", ("GET /v1/jobs/{job_id}/events", "GET /v1/batches/{batch_id}/events")),
    ("read", ("GET /v1/jobs/{job_id}/deliveries", "GET /v1/batches/{batch_id}/deliveries")),
    ("submit", (f"POST {operation.path}" for operation in OPERATIONS)),
    ("submit", (f"GET {operation.path}" for operation in QUERIES)),
    ("submit", ("POST /v1/batches", "DELETE /v1/batches/{batch_id}", "DELETE /v1/jobs/{job_id}")),
    ("admin", ("GET /metrics",)),
)

NEEDED: Mapping[str, Scope | None] = {call: scope for scope, calls in _CALLS for call in calls}
"""Call → the scope that it needs; None: anyone may call."""


class Rules:
    """The scopes of all routes of an application, found by the patterns by which it finds the routes.

    Raises:
        LookupError: a route has no scope; the service does not start with one that nobody thought of.
    """

    def __init__(self, routes: Sequence[BaseRoute]) -> None:
        self._rules: list[tuple[str, re.Pattern[str], Scope | None]] = []
        for route in iter_route_contexts(routes):
            for method in sorted(route.methods or {"GET"}):
                call = f"{method} {route.path_format}"
                if call not in NEEDED:
                    raise LookupError(f"{call} has no scope; give it one in {__name__}")
                self._rules.append((method, route.path_regex, NEEDED[call]))

    def scope_needed(self, method: str, path: str) -> Scope | None:
        """Returns the scope that a call needs: `read` where nothing is, so that nobody can look around."""
        fitting = (scope for known, pattern, scope in self._rules if known == method and pattern.match(path))
        return next(fitting, "read")


def check_scope(caller: Caller, needed: Scope) -> None:
    """Refuse a caller whose key does not allow so much.

    Raises:
        ProblemError: 403, it names the scope that is needed.
    """
    if not allows(caller.scope, needed):
        raise ProblemError(
            ProblemType.FORBIDDEN,
            f"This call needs a key with scope {needed}; the key {caller.name} has scope {caller.scope}.",
            headers={"WWW-Authenticate": f'{CHALLENGE}, error="insufficient_scope", scope="{needed}"'},
        )
