"""The envelope of every request: id, HEAD, security headers, compression, metrics, log, unexpected errors;
and the conversion of exceptions to problem documents.

It is plain ASGI, since each layer slows down cached answers, which take a few milliseconds.
"""

from __future__ import annotations

import logging
import re
import secrets
import time
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from difflib import get_close_matches
from math import ceil
from typing import Any, Literal
from urllib.parse import quote

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.routing import iter_route_contexts
from redis.exceptions import RedisError
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import ClientDisconnect
from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rpr_solver.errors import InputError, clipped
from service.api.context import Context
from service.api.forms import media_range
from service.api.http.transport import IS_HEAD
from service.api.metrics import Metrics
from service.api.problems import ProblemError, ProblemType
from service.api.settings import RETRY_SECONDS, Settings, here, prefixed, without_prefix
from worker import tracing
from worker.answers.archive import ArchiveAwayError
from worker.connection import is_refusal
from worker.jobs import QueueFullError
from worker.logs import about

KEY_NAME = "rpr_cusps.key"
"""Where the ASGI scope has the name of the API key."""

_LONGEST_PATH = 200

_requests = logging.getLogger("rpr_cusps.access")


class AccessLog:
    """Logs requests according to the setting, independent of the level of other lines."""

    def __init__(self, wanted: Literal["all", "errors", "off"]) -> None:
        self._least_status = {"all": 0, "errors": 400, "off": 1000}[wanted]
        _requests.setLevel(logging.INFO)

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
        _requests.info(text, fields, extra={"fields": fields})


_SUFFIX = '-gzip"'


class Compression(GZipMiddleware):
    """Starlette's compression with correct ETags.

    Another encoding is another representation, so its strong validator must differ (RFC 9110, 8.8.1):
    compressed responses have an ETag with a suffix, which is removed again from `If-None-Match`.
    """

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = MutableHeaders(scope=scope)
        is_accepted = accepts_gzip(headers)
        headers["Accept-Encoding"] = "gzip" if is_accepted else "identity"
        known = ",".join(headers.getlist("If-None-Match"))
        if _SUFFIX in known:
            headers["If-None-Match"] = known.replace(_SUFFIX, '"')

        async def send_on(message: Message) -> None:
            if message["type"] == "http.response.start":
                answer = MutableHeaders(scope=message)
                tag = answer.get("ETag", "")
                packed = tag[:-1] + _SUFFIX
                if message["status"] == 304:
                    answer.add_vary_header("Accept-Encoding")
                    is_packed = packed in known and (is_accepted or tag not in known)
                else:
                    is_packed = answer.get("Content-Encoding") == "gzip"
                if tag and is_packed:
                    answer["ETag"] = packed
            await send(message)

        await super().__call__(scope, receive, send_on)


def accepts_gzip(headers: Headers) -> bool:
    """Whether the client accepts gzip."""
    ranges = map(media_range, ",".join(headers.getlist("Accept-Encoding")).split(","))
    qualities = dict(ranges)
    return qualities.get("gzip", qualities.get("*", 0.0)) > 0


log = logging.getLogger("rpr_cusps.service")

REQUEST_ID = "X-Request-ID"
_REQUEST_ID = re.compile(r"[A-Za-z0-9._\-]{1,64}", re.ASCII)
_CLIENT_GONE = 499  # as in nginx: the client left before there was an answer


class RequestEnvelope:
    """The outermost layer of the application."""

    def __init__(self, app: ASGIApp, metrics: Metrics, access_log: AccessLog, settings: Settings) -> None:
        self.app = app
        self.settings = settings
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
        prefix = self.settings.root_path
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
            scope = {**scope, "method": "GET", IS_HEAD: True}
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
            self.metrics.observe(scope, method, status, seconds)
            self.access_log.note(scope, method, status, size, seconds)
            if tracing.is_on():
                route = getattr(scope.get("route"), "path", "")
                attributes = {"http.route": route, "http.response.status_code": status}
                name = f"{method} {route}".rstrip()
                tracing.describe(name, {"rpr_cusps.request_id": request_id, **attributes})


def _span(scope: Scope) -> AbstractContextManager[object]:
    """The span of a request, which continues the trace of its client."""
    if not tracing.is_on():
        return nullcontext()
    method, headers = scope["method"], Headers(scope=scope)
    return tracing.span(method, headers, {"http.request.method": method}, is_server=True)


_PAGE_METHODS = {"GET", "HEAD"}


def add_error_handlers(app: FastAPI) -> None:
    """Answer every error of the application as application/problem+json."""
    for kind in (
        ProblemError,
        InputError,
        QueueFullError,
        RedisError,
        HTTPException,
        RequestValidationError,
    ):
        app.add_exception_handler(kind, _answer)


async def _answer(request: Request, error: Exception) -> Response:
    return problem_of(request, error).response(request.url.path)


def problem_of(request: Request, error: Exception) -> ProblemError:
    """Returns the problem that an exception becomes; raises one that is unexpected."""
    if isinstance(error, ProblemError):
        return error
    if isinstance(error, InputError):
        problem = ProblemError.of_input(error)
        problem.in_body = request.method != "GET"
        return problem
    if isinstance(error, QueueFullError):
        wait = max(1, ceil(error.seconds))
        detail = f"The queue is full: it holds about {wait} s of work for its workers. Try again later."
        return ProblemError(ProblemType.QUEUE_FULL, detail, retry_s=wait)
    if isinstance(error, HTTPException):
        return _http_problem(request, error)
    if isinstance(error, RequestValidationError):
        faults = [_fault(e) for e in error.errors()]
        detail = "; ".join(f"{field}: {message}" for field, message in faults)
        return ProblemError(ProblemType.INVALID_REQUEST, detail, errors=faults)
    if not is_refusal(error):
        raise error
    context: Context = request.app.state.context
    context.refusals.log(error)
    what = "archive of answers" if isinstance(error, ArchiveAwayError) else "queue"
    return ProblemError(
        ProblemType.UNAVAILABLE,
        f"The {what} cannot be reached or accepts no more data at the moment; nothing was lost. Try again.",
        retry_s=RETRY_SECONDS,
    )


def _fault(fault: Mapping[str, Any]) -> tuple[str, str]:
    """Returns the parameter that FastAPI refuses, and why, as other messages say it."""
    place, *names = fault["loc"]
    field = ".".join(map(str, names)) or str(place)
    bounds, kind = fault.get("ctx", {}), fault["type"]
    if kind == "missing":
        return field, "is missing"
    advice = {
        "less_than_equal": f"give {bounds.get('le')} or less",
        "greater_than_equal": f"give {bounds.get('ge')} or more",
        "int_parsing": "give a whole number",
        "bool_parsing": "give true or false",
        "literal_error": f"give {str(bounds.get('expected')).replace(chr(39), '')}",
        "value_error": str(bounds.get("error")),
    }
    return field, f"is {clipped(str(fault['input']))!r}; {advice.get(kind, fault['msg'])}"


def _http_problem(request: Request, error: HTTPException) -> ProblemError:
    path, headers, detail = clipped(request.url.path, 200), dict(error.headers or {}), str(error.detail)
    if error.status_code == 404:
        near = _nearest(request.app, request.url.path)
        hint = "" if near is None else f"did you mean {here(near)}? "
        detail = f"There is nothing at {here(path)}; {hint}{here('/docs')} lists all endpoints."
    elif error.status_code == 405:
        headers["Allow"] = ", ".join(sorted(_methods(request.app, request.url.path)))
        detail = f"{request.method} is not allowed at {here(path)}; allowed are {headers['Allow']}."
    return ProblemError.of_status(error.status_code, detail, headers)


def _nearest(app: FastAPI, path: str) -> str | None:
    """Returns the path of a call that is probably meant; what stands for an id is kept."""
    parts = path[:_LONGEST_PATH].rstrip("/").split("/")
    known = []
    for route in iter_route_contexts(app.routes):
        names = (route.path_format or "").split("/")
        if len(names) == len(parts):
            pairs = zip(parts, names, strict=True)
            known.append("/".join(own if "{" in name else name for own, name in pairs))
    return next(iter(get_close_matches("/".join(parts), known, n=1, cutoff=0.75)), None)


def _methods(app: FastAPI, path: str) -> set[str]:
    """Returns the methods of a path, from all operations that share it."""
    methods: set[str] = set()
    for template, operations in app.openapi()["paths"].items():
        if re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", template), path):
            methods |= {name.upper() for name in operations}
    return methods | {"HEAD"} if "GET" in methods else methods or _PAGE_METHODS
