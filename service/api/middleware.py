"""The envelope of every request: an id, HEAD, security headers, metrics, and the answer to unexpected errors.

It is plain ASGI, since each layer slows down cached answers, which take a few milliseconds.
"""

from __future__ import annotations

import logging
import re
import secrets
import time

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.metrics import Metrics
from service.api.problems import ProblemError, ProblemType

log = logging.getLogger("rpr_cusps.service")

REQUEST_ID = "X-Request-ID"
_REQUEST_ID = re.compile(r"[A-Za-z0-9._\-]{1,64}", re.ASCII)
IS_HEAD = "rpr_cusps.head"


class RequestEnvelope:
    """The outermost layer of the application."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self.app = app
        self.metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        start = time.perf_counter()
        sent_id = Headers(scope=scope).get(REQUEST_ID, "")
        request_id = sent_id if _REQUEST_ID.fullmatch(sent_id) else secrets.token_hex(8)
        is_head = scope["method"] == "HEAD"
        if is_head:
            scope["method"], scope[IS_HEAD] = "GET", True
        status = 500
        started = False

        async def send_on(message: Message) -> None:
            nonlocal status, started
            if message["type"] == "http.response.start":
                status, started = message["status"], True
                headers = MutableHeaders(scope=message)
                headers[REQUEST_ID] = request_id
                headers.setdefault("X-Content-Type-Options", "nosniff")
            elif is_head and message["type"] == "http.response.body":
                if message.get("more_body"):
                    return
                message = {"type": "http.response.body", "body": b""}
            await send(message)

        try:
            await self.app(scope, receive, send_on)
        except ClientDisconnect:
            log.debug("request %s: the client disconnected", request_id)
        except Exception:
            log.exception("request %s failed: %s %s", request_id, scope["method"], scope["path"])
            if started:
                raise
            detail = (
                f"An unexpected error; the service's log has the details under the request id {request_id}."
            )
            response = ProblemError(ProblemType.INTERNAL_ERROR, detail).response(scope["path"])
            await response(scope, receive, send_on)
        finally:
            self.metrics.observe(
                scope, "HEAD" if is_head else scope["method"], status, time.perf_counter() - start
            )
