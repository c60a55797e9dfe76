"""Which call needs which scope, in one table."""

from __future__ import annotations

import re
from dataclasses import dataclass

from service.api.access.keys import Scope

_GET = "GET|HEAD|OPTIONS"


@dataclass(frozen=True)
class Rule:
    """The scope that calls need; None: anyone may call."""

    methods: str
    paths: str
    scope: Scope | None


RULES = (
    Rule(_GET, r"/|/docs|/openapi\.json|/problems(/.*)?|/schemas/.*|/static/.*", None),
    Rule(_GET, r"/healthz|/readyz", None),
    Rule(_GET, r"/metrics", "admin"),
    Rule(_GET, r"/v1/(cusp-tables|censuses)", "submit"),
    Rule(_GET, r".*", "read"),
    Rule(r".*", r".*", "submit"),
)
"""The first that fits counts."""


def scope_needed(method: str, path: str) -> Scope | None:
    """Returns the scope that a call needs.

    >>> scope_needed("POST", "/v1/censuses"), scope_needed("GET", "/healthz")
    ('submit', None)
    """
    for rule in RULES:
        if re.fullmatch(rule.methods, method) and re.fullmatch(rule.paths, path, re.DOTALL):
            return rule.scope
    return "admin"
