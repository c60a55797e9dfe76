"""`POST /v1/cusp-tables`: a table at once when it is known, a job when it is not."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from service import documentation as doc
from service.context import Context, ContextDep, in_thread
from service.job_view import job_json
from service.json_body import parse_json, read_json_body
from service.prefer import parse_prefer
from service.problems import ProblemError
from service.representation import FORMS, JSON, Table, choose, json_bytes, table_response
from service.table_requests import table_request
from worker import JobView

router = APIRouter(tags=["cusp tables"])


@router.post(
    "/v1/cusp-tables",
    summary="The cusps of one manipulator in one or many slices",
    status_code=200,
    responses=doc.CUSP_TABLES_RESPONSES,
    openapi_extra=doc.CUSP_TABLES_EXTRA,
)
async def post_cusp_table(request: Request, context: ContextDep) -> Response:
    """Answers 200 with the table when every slice is known already. Otherwise answers 202 with a job that
    computes the missing slices; follow its `Location`. With `Prefer: wait=N` the answer waits up to N seconds
    for the job and is 200 when it ends in that time.

    The same request twice is one job, at the same time or later, and slices that other requests have in
    common with this one are computed once. Numbers are exact: `17.04` is 426/25, never a binary float.
    """
    settings = context.settings
    choose(request.headers.getlist("accept"), (*FORMS, JSON))
    body = await read_json_body(request, settings.limits.max_body_bytes)
    prefer = parse_prefer(request.headers.getlist("prefer"))
    found = await in_thread(_begin, context, body)
    waited: int | None = None
    if isinstance(found, JobView) and prefer.wait is not None:
        waited = min(prefer.wait, settings.limits.max_wait_seconds)
        view = await context.events.wait(found.id, waited) or found
        found = await in_thread(_finished, context, view)
    accepted = isinstance(found, JobView)
    context.metrics.tables.labels("job" if accepted or waited is not None else "cached").inc()
    applied = prefer.applied(waited, accepted)
    headers = {"Preference-Applied": applied} if applied else {}
    if isinstance(found, JobView):
        headers |= {
            "Location": f"/v1/jobs/{found.id}",
            "Retry-After": str(settings.poll_seconds),
            "Cache-Control": "no-store",
        }
        return Response(json_bytes(job_json(found)), 202, headers, media_type=JSON)
    headers["Cache-Control"] = "no-store"
    return await in_thread(table_response, request, found, headers=headers, min_gzip=settings.gzip_bytes)


def _begin(context: Context, body: bytes) -> Table | JobView:
    wanted = table_request(parse_json(body), context.settings.limits)
    table = context.queue.table(wanted)
    if table is not None:
        return table
    return _finished(context, context.queue.submit(wanted))


def _finished(context: Context, view: JobView) -> Table | JobView:
    """The table of a job that has succeeded, the problem of one that will have none, else the job."""
    if view.status == "failed":
        raise ProblemError.of_job(view.id, view.error)
    if view.status == "canceled":
        raise ProblemError.of_cancel(view.id)
    table = context.queue.result(view.id) if view.status == "succeeded" else None
    return view if table is None else table
