"""The one place where exceptions become problem documents."""

from __future__ import annotations

import logging
import re

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from redis.exceptions import (
    BusyLoadingError,
    MaxConnectionsError,
    OutOfMemoryError,
    ReadOnlyError,
    RedisError,
    TryAgainError,
)
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.exceptions import TimeoutError as RedisTimeoutError
from starlette.exceptions import HTTPException

from rpr_solver.errors import InputError
from service.api.context import Context
from service.api.problems import ProblemError, ProblemType

log = logging.getLogger("rpr_cusps.service")

_PASSING = (
    BusyLoadingError,
    MaxConnectionsError,
    OutOfMemoryError,
    ReadOnlyError,
    RedisConnectionError,
    RedisTimeoutError,
    TryAgainError,
)
_PAGE_METHODS = {"GET", "HEAD"}


def add_error_handlers(app: FastAPI) -> None:
    """Answer every error of the application as application/problem+json."""
    app.add_exception_handler(ProblemError, _problem)
    app.add_exception_handler(InputError, _input_error)
    app.add_exception_handler(RedisError, _redis_error)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(RequestValidationError, _validation_error)


async def _problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, ProblemError)
    return error.response(request.url.path)


async def _input_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, InputError)
    return ProblemError.of_input(error).response(request.url.path)


async def _redis_error(request: Request, error: Exception) -> Response:
    if not isinstance(error, _PASSING):
        raise error
    log.warning("Redis: %s", error)
    context: Context = request.app.state.context
    problem = ProblemError(
        ProblemType.UNAVAILABLE,
        "The queue cannot be reached or takes no more data at the moment; nothing was lost. Try again.",
        headers={"Retry-After": str(context.settings.retry_seconds)},
    )
    return problem.response(request.url.path)


async def _http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    path, headers, detail = request.url.path, dict(error.headers or {}), str(error.detail)
    if error.status_code == 404:
        detail = f"There is nothing at {path[:200]}; /docs lists what there is."
    elif error.status_code == 405:
        headers["Allow"] = ", ".join(sorted(_methods(request.app, path)))
        detail = f"{request.method} is not allowed at {path[:200]}; allowed are {headers['Allow']}."
    return ProblemError.of_status(error.status_code, detail, headers).response(path)


async def _validation_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    faults = [(".".join(str(part) for part in e["loc"]), str(e["msg"])) for e in error.errors()]
    detail = "; ".join(f"{field}: {message}" for field, message in faults)
    return ProblemError(ProblemType.INVALID_REQUEST, detail, errors=faults).response(request.url.path)


def _methods(app: FastAPI, path: str) -> set[str]:
    """The methods of a path, from all operations that share it."""
    methods: set[str] = set()
    for template, operations in app.openapi()["paths"].items():
        if re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", template), path):
            methods |= {name.upper() for name in operations}
    return methods | {"HEAD"} if "GET" in methods else methods or _PAGE_METHODS
