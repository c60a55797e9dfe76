"""Health, readiness, version, limits and metrics."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from anyio import to_thread
from fastapi import APIRouter, Response

import rpr_solver
from service import __version__
from service.api.context import ContextDep
from service.api.contract import operations as doc
from service.api.metrics import CONTENT_TYPE
from service.api.problems import ProblemError, ProblemType
from service.commit import commit
from service.schemas.answers import JSON, json_bytes
from service.schemas.limits import Limits

router = APIRouter(tags=["operations"])

_LIBRARIES = ("python-flint", "fastapi", "rq", "redis")


@router.get("/healthz", summary="Whether this process is running", responses=doc.HEALTH_RESPONSES)
async def healthz() -> Response:
    """Answers while the process runs; independent of Redis and the workers."""
    return _json({"status": "ok"}, "no-store")


@router.get("/readyz", summary="Whether requests can be served", responses=doc.READY_RESPONSES)
async def readyz(context: ContextDep) -> Response:
    """Ready if jobs can run: Redis accepts data, and at least one worker of the same solver version is alive.
    `warnings` lists dangers for jobs: settings of Redis, or a lane of the queue that stands still, such as
    small questions that have waited for more than a minute although workers are alive.
    """
    state = await context.redis(context.queue.readiness)
    if state.workers:
        answer = {"status": "ready", "workers": state.workers, "warnings": state.warnings}
        return _json(answer, "no-store")
    detail = "No workers of this solver version are running; jobs would stay queued."
    retry = {"Retry-After": str(context.settings.retry_seconds)}
    raise ProblemError(ProblemType.NO_WORKER, detail, headers=retry)


@router.get(
    "/version",
    summary="Versions of the service, the solver and its libraries",
    responses=doc.VERSION_RESPONSES,
)
async def get_version() -> Response:
    """The software that computes the answers; `solver_version` changes whenever an answer may change."""
    return _json(
        {
            "service": __version__,
            "commit": await to_thread.run_sync(commit),
            "solver_version": rpr_solver.SOLVER_VERSION,
            "python": platform.python_version(),
            "libraries": {name: _version(name) for name in _LIBRARIES},
        }
    )


@router.get("/v1/limits", summary="The limits on requests", responses=doc.LIMITS_RESPONSES)
async def get_limits(context: ContextDep) -> Response:
    """Returns every limit by name, with its value and meaning."""
    limits = context.settings.limits
    return _json(
        {
            name: {"value": getattr(limits, name), "description": field.description}
            for name, field in Limits.model_fields.items()
        }
    )


@router.get("/metrics", summary="Metrics in the Prometheus text format", responses=doc.METRICS_RESPONSES)
async def get_metrics(context: ContextDep) -> Response:
    """Counts the requests of this process, and reads the queue and the workers at each scrape."""
    return Response(
        await context.scraping(context.metrics.text),
        headers={"Cache-Control": "no-store", "Content-Type": CONTENT_TYPE},
    )


def _json(document: object, cache: str = "no-cache") -> Response:
    return Response(json_bytes(document), headers={"Cache-Control": cache}, media_type=JSON)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
