"""`/v1/jobs/{id}`: state, result, events, cancel."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import APIRouter, Path, Request, Response
from starlette.responses import StreamingResponse

from service.api import operation_docs as doc
from service.api.context import Context, ContextDep, in_thread
from service.api.job_view import job_json
from service.api.middleware import IS_HEAD
from service.api.negotiation import JSON, document_response, json_bytes, negotiate
from service.api.operations import forms_of
from service.api.problems import ProblemError, ProblemType
from worker.answers.kinds import kind_of_job
from worker.jobs.records import JobView

router = APIRouter(tags=["jobs"])

JobId = Annotated[str, Path(description="the id of a job", examples=[doc.EXAMPLE_JOB_ID])]
_JOB_ID = re.compile(r"[A-Za-z0-9_\-]{1,80}", re.ASCII)
_EVENT_ID = re.compile(r"\d{1,20}(-\d{1,20})?", re.ASCII)


@router.get("/v1/jobs/{job_id}", summary="The state of a job", responses=doc.JOB_RESPONSES)
def get_job(job_id: JobId, context: ContextDep) -> Response:
    """The job as it is now. While it is not finished, `Retry-After` says when to look again."""
    return _job_response(context, _job(context, job_id))


@router.delete("/v1/jobs/{job_id}", summary="Cancel a job", responses=doc.CANCEL_RESPONSES)
def cancel_job(job_id: JobId, context: ContextDep) -> Response:
    """Cancels a job that is queued or running, and answers with the job. A job that has ended stays as it is.

    A job may be shared: whoever posts the same request has the same job. Slices that were done stay known.
    """
    _job(context, job_id)
    view = context.queue.cancel(job_id)
    if view is None:
        raise _not_found(job_id)
    return _job_response(context, view)


@router.get("/v1/jobs/{job_id}/result", summary="The result of a job", responses=doc.RESULT_RESPONSES)
def get_result(job_id: JobId, request: Request, context: ContextDep) -> Response:
    """What the job was asked for. A cusp table comes as JSON, as CSV (a cusp a line) or as NDJSON (a slice a
    line), as `Accept` says; other documents as JSON.

    A result never changes, so it carries a strong `ETag` and may be cached for ever.
    """
    forms = forms_of(job_id)
    negotiate(request.headers.getlist("accept"), tuple(forms))
    view = _job(context, job_id)
    if not view.is_terminal:
        wait = str(context.settings.poll_seconds)
        raise ProblemError(
            ProblemType.NOT_FINISHED,
            f"The job is {view.status}: {view.done} of {view.total} {_unit(job_id)} are done.",
            headers={"Retry-After": wait},
            extra={"job": f"/v1/jobs/{job_id}"},
        )
    if view.status == "failed":
        raise ProblemError.of_job(job_id, view.error)
    if view.status == "canceled":
        raise ProblemError.of_cancel(job_id)
    document = context.queue.result(job_id)
    if document is None:
        raise ProblemError(
            ProblemType.RESULT_EXPIRED, "The result of this job is no longer kept; post the request again."
        )
    return document_response(request, document, forms)


@router.get("/v1/jobs/{job_id}/events", summary="Follow a job", responses=doc.EVENTS_RESPONSES)
async def get_events(job_id: JobId, request: Request, context: ContextDep) -> Response:
    """Server-sent events: `status` (the job), `slice` (progress, and a slice as soon as it is computed) and
    `progress` (of a job that computes no slices).

    The stream ends with the job. `Last-Event-ID` resumes it; 204 says that nothing more will come. Slices
    that were known when the job was made are in its result only.
    """
    view = await in_thread(_job, context, job_id)
    last = request.headers.get("last-event-id", "0").strip() or "0"
    if not _EVENT_ID.fullmatch(last):
        raise ProblemError(
            ProblemType.INVALID_HEADER,
            f"Last-Event-ID {last[:60]!r} is not the id of an event of this stream.",
            errors=[("Last-Event-ID", "send the id of the last event that arrived, or leave it out")],
        )
    if view.is_terminal and last != "0" and not await context.events.after(job_id, last):
        return Response(status_code=204)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    if request.scope.get(IS_HEAD):
        return Response(headers=headers, media_type="text/event-stream")
    return StreamingResponse(
        context.events.follow(job_id, last), headers=headers, media_type="text/event-stream"
    )


def _job(context: Context, job_id: str) -> JobView:
    view = context.queue.get(job_id) if _JOB_ID.fullmatch(job_id) else None
    if view is None:
        raise _not_found(job_id)
    return view


def _not_found(job_id: str) -> ProblemError:
    return ProblemError(
        ProblemType.NOT_FOUND,
        f"There is no job {job_id[:80]!r}, or it is no longer kept; post the request again to have it made.",
    )


def _unit(job_id: str) -> str:
    kind = kind_of_job(job_id)
    return "parts" if kind is None else kind.unit


def _job_response(context: Context, view: JobView) -> Response:
    headers = {"Cache-Control": "no-store"}
    if not view.is_terminal:
        headers["Retry-After"] = str(context.settings.poll_seconds)
    return Response(json_bytes(job_json(view)), headers=headers, media_type=JSON)
