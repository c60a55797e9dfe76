"""The conversion of exceptions to problem documents."""

from __future__ import annotations

import re
from math import ceil

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from redis.exceptions import RedisError
from starlette.exceptions import HTTPException

from rpr_solver.errors import InputError
from service.api.context import Context
from service.api.prefix import here
from service.api.problems import ProblemError, ProblemType
from worker.answers.archive import ArchiveAwayError
from worker.connection import is_refusal
from worker.jobs.lanes import QueueFullError

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
        return ProblemError(ProblemType.QUEUE_FULL, detail, headers={"Retry-After": str(wait)})
    if isinstance(error, HTTPException):
        return _http_problem(request, error)
    if isinstance(error, RequestValidationError):
        faults = [(".".join(str(part) for part in e["loc"]), str(e["msg"])) for e in error.errors()]
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
        headers={"Retry-After": str(context.settings.retry_seconds)},
    )


def _http_problem(request: Request, error: HTTPException) -> ProblemError:
    path, headers, detail = request.url.path[:200], dict(error.headers or {}), str(error.detail)
    if error.status_code == 404:
        detail = f"There is nothing at {here(path)}; {here('/docs')} lists all addresses."
    elif error.status_code == 405:
        headers["Allow"] = ", ".join(sorted(_methods(request.app, request.url.path)))
        detail = f"{request.method} is not allowed at {here(path)}; allowed are {headers['Allow']}."
    return ProblemError.of_status(error.status_code, detail, headers)


def _methods(app: FastAPI, path: str) -> set[str]:
    """Returns the methods of a path, from all operations that share it."""
    methods: set[str] = set()
    for template, operations in app.openapi()["paths"].items():
        if re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", template), path):
            methods |= {name.upper() for name in operations}
    return methods | {"HEAD"} if "GET" in methods else methods or _PAGE_METHODS
