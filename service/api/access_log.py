"""A log line for each request."""

from __future__ import annotations

import logging
from typing import Literal
from urllib.parse import quote

from starlette.types import Scope

KEY_NAME = "rpr_cusps.key"
"""Where the ASGI scope has the name of the API key."""

_LONGEST_PATH = 200

log = logging.getLogger("rpr_cusps.access")


class AccessLog:
    """Logs the requests that are wanted, whatever the level of other lines."""

    def __init__(self, wanted: Literal["all", "errors", "off"]) -> None:
        self._least_status = {"all": 0, "errors": 400, "off": 1000}[wanted]
        log.setLevel(logging.INFO)

    def note(self, scope: Scope, method: str, status: int, size: int, seconds: float) -> None:
        """Log one request; `size`: bytes of the body that were sent."""
        if status < self._least_status:
            return
        fields = {
            "key": scope.get(KEY_NAME, "-"),
            "method": method,
            "path": quote(str(scope.get("path", "")), safe="/:,-_.~")[:_LONGEST_PATH],
            "status": status,
            "bytes": size,
            "duration_ms": round(1000 * seconds, 2),
        }
        text = "%(key)s %(method)s %(path)s %(status)d %(bytes)d B %(duration_ms).2f ms"
        log.info(text, fields, extra={"fields": fields})
