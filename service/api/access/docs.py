"""Keys and refusals in the OpenAPI document, from the table of rules."""

from __future__ import annotations

from typing import Any

from service.api.access.rules import NEEDED
from service.api.contract.operations import problems
from service.api.problems import ProblemType

_SCHEME = {
    "type": "http",
    "scheme": "bearer",
    "bearerFormat": "rpr_ID_SECRET",
    "description": "An API key, made by `rpr-cusps keys create`. A service on a loopback address asks for "
    "one once a key was made.",
}


def describe_access(contract: dict[str, Any]) -> None:
    """Add to every operation the key that it needs, and the answers of the guard.

    That a key may be sent is said once for all: generators of clients take an operation that says so itself
    for one that needs a key.
    """
    contract.setdefault("components", {})["securitySchemes"] = {"key": _SCHEME}
    contract["security"] = [{}, {"key": []}]
    for path, operations in contract["paths"].items():
        for method, operation in operations.items():
            needed = NEEDED[f"{method.upper()} {path}"]
            kinds = [ProblemType.UNKNOWN_HOST]
            if needed is not None:
                kinds += [ProblemType.UNAUTHORIZED, ProblemType.FORBIDDEN, ProblemType.TOO_MANY_REQUESTS]
                operation["description"] += f"\n\nOn a service that asks for keys: scope `{needed}`."
            else:
                operation["security"] = []
            answers: dict[str, Any] = {str(status): answer for status, answer in problems(*kinds).items()}
            operation["responses"] = dict(sorted({**answers, **operation["responses"]}.items()))
