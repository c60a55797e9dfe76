"""The envelope of every request: id, HEAD, security headers, metrics, log, and answers to unexpected errors.

It is plain ASGI, since each layer slows down cached answers, which take a few milliseconds.
"""

from __future__ import annotations

import logging
import re
import secrets
import time
from contextlib import AbstractContextManager, nullcontext

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect
from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.access_log import AccessLog
from service.api.answers.large_answers import IS_HEAD
from service.api.metrics import Metrics
from service.api.prefix import forwarded_prefix, prefixed, without_prefix
from service.api.problems import ProblemError, ProblemType
from service.api.settings import Settings
from worker import tracing
from worker.logs import about

log = logging.getLogger("rpr_cusps.service")

REQUEST_ID = "X-Request-ID"
_REQUEST_ID = re.compile(r"[A-Za-z0-9._\-]{1,64}", re.ASCII)
UNCOUNTED = "rpr_cusps.uncounted"
"""In the scope of requests that are in no log and no metrics: those of the supervisor."""
_CLIENT_GONE = 499  # as nginx has it: the client left before there was an answer


class RequestEnvelope:
    """The outermost layer of the application."""

    def __init__(self, app: ASGIApp, metrics: Metrics, access_log: AccessLog, settings: Settings) -> None:
        self.app = app
        self.root_path, self.proxies = settings.root_path, settings.proxies
        self.metrics = metrics
        self.access_log = access_log

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        sent_id = Headers(scope=scope).get(REQUEST_ID, "")
        request_id = sent_id if _REQUEST_ID.fullmatch(sent_id) else secrets.token_hex(8)
        with about(request_id=request_id), self.metrics.in_flight.track_inprogress(), _span(scope):
            prefix, app = self._found(scope)
            with prefixed(prefix):
                await self._answer(app, request_id, scope, receive, send)

    def _found(self, scope: Scope) -> tuple[str, ASGIApp]:
        """Take the prefix from the path; returns it, and what answers."""
        try:
            forwarded = forwarded_prefix(scope, self.proxies)
        except ValueError as error:
            return self.root_path, ProblemError(
                ProblemType.INVALID_HEADER, f"X-Forwarded-Prefix: {error}"
            ).response()
        prefix = self.root_path if forwarded is None else forwarded
        if prefix and scope["path"] == prefix:
            scope["path"] = "/"
            return prefix, RedirectResponse(f"{prefix}/", 308)
        scope["path"] = without_prefix(scope["path"], prefix)
        return prefix, self.app

    async def _answer(
        self, app: ASGIApp, request_id: str, scope: Scope, receive: Receive, send: Send
    ) -> None:
        start = time.perf_counter()
        is_head = scope["method"] == "HEAD"
        if is_head:
            scope["method"], scope[IS_HEAD] = "GET", True
        status, size = 500, 0
        started = follows = False

        async def send_on(message: Message) -> None:
            nonlocal status, size, started, follows
            if message["type"] == "http.response.start":
                status, started = message["status"], True
                headers = MutableHeaders(scope=message)
                if headers.get("content-type", "").startswith("text/event-stream"):
                    follows = True
                    self.metrics.followers.inc()
                headers[REQUEST_ID] = request_id
                headers.setdefault("X-Content-Type-Options", "nosniff")
            elif is_head and message["type"] == "http.response.body":
                if message.get("more_body"):
                    return
                message = {"type": "http.response.body", "body": b""}
            if message["type"] == "http.response.body":
                size += len(message.get("body", b""))
            await send(message)

        try:
            await app(scope, receive, send_on)
        except ClientDisconnect:
            status = status if started else _CLIENT_GONE
        except Exception:
            log.exception("failed: %s %r", scope["method"], scope["path"])
            if started:
                raise
            detail = (
                f"An unexpected error; the service's log has the details under the request id {request_id}."
            )
            response = ProblemError(ProblemType.INTERNAL_ERROR, detail).response(scope["path"])
            await response(scope, receive, send_on)
        finally:
            method, seconds = "HEAD" if is_head else scope["method"], time.perf_counter() - start
            if follows:
                self.metrics.followers.dec()
            if UNCOUNTED not in scope:
                self.metrics.observe(scope, method, status, seconds)
                self.access_log.note(scope, method, status, size, seconds)
            if tracing.is_on():
                route = getattr(scope.get("route"), "path", "")
                attributes = {"http.route": route, "http.response.status_code": status}
                name = f"{method} {route}".rstrip()
                tracing.describe(name, {"rpr_cusps.request_id": request_id, **attributes})


def _span(scope: Scope) -> AbstractContextManager[object]:
    """The span of a request, which goes on with the trace of its client."""
    if not tracing.is_on() or UNCOUNTED in scope:
        return nullcontext()
    method, headers = scope["method"], Headers(scope=scope)
    return tracing.span(method, headers, {"http.request.method": method}, is_server=True)
