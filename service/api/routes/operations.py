"""Health, readiness, version, limits and metrics."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from fastapi import APIRouter, Response
from redis.exceptions import RedisError

import rpr_solver
from service import __version__
from service.api import operation_docs as doc
from service.api.context import ContextDep
from service.api.metrics import CONTENT_TYPE
from service.api.negotiation import JSON, json_bytes
from service.api.problems import ProblemError, ProblemType
from service.schemas.limits import Limits

router = APIRouter(tags=["operations"])

_LIBRARIES = ("python-flint", "fastapi", "rq", "redis")


@router.get("/healthz", summary="Whether this process runs", responses=doc.HEALTH_RESPONSES)
async def healthz() -> Response:
    """Answers as long as the process can answer; says nothing about Redis or the workers."""
    return _json({"status": "ok"}, "no-store")


@router.get("/readyz", summary="Whether requests can be served", responses=doc.READY_RESPONSES)
def readyz(context: ContextDep) -> Response:
    """Ready when Redis answers and at least one worker is alive."""
    retry = {"Retry-After": str(context.settings.retry_seconds)}
    try:
        context.queue.redis.ping()
        workers = context.queue.workers()
    except RedisError as error:
        raise ProblemError(
            ProblemType.UNAVAILABLE, f"Redis cannot be reached: {error}", headers=retry
        ) from error
    if workers < 1:
        raise ProblemError(
            ProblemType.UNAVAILABLE, "No worker is alive; jobs would only be queued.", headers=retry
        )
    return _json({"status": "ready", "workers": workers}, "no-store")


@router.get(
    "/version",
    summary="Versions of the service, the solver and its libraries",
    responses=doc.VERSION_RESPONSES,
)
async def get_version() -> Response:
    """What computed the answers: `solver_version` changes whenever an answer could."""
    return _json(
        {
            "service": __version__,
            "solver_version": rpr_solver.SOLVER_VERSION,
            "python": platform.python_version(),
            "libraries": {name: _version(name) for name in _LIBRARIES},
        }
    )


@router.get("/v1/limits", summary="The limits of requests", responses=doc.LIMITS_RESPONSES)
async def get_limits(context: ContextDep) -> Response:
    """Every limit by its name, with its value and what it bounds."""
    limits = context.settings.limits
    return _json(
        {
            name: {"value": getattr(limits, name), "description": field.description}
            for name, field in Limits.model_fields.items()
        }
    )


@router.get("/metrics", summary="Metrics in the Prometheus text format", responses=doc.METRICS_RESPONSES)
def get_metrics(context: ContextDep) -> Response:
    """Requests of this process as counted, queue and workers as they are now."""
    return Response(
        context.metrics.text(), headers={"Cache-Control": "no-store", "Content-Type": CONTENT_TYPE}
    )


def _json(document: object, cache: str = "no-cache") -> Response:
    return Response(json_bytes(document), headers={"Cache-Control": cache}, media_type=JSON)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
