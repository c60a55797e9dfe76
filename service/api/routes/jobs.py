"""`/v1/jobs/{id}`: state, result, events, cancel; `/v1/batches`: many questions in one, with the same."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import APIRouter, Path, Query, Request, Response

from rpr_solver.errors import clipped
from service.api.answer import parse_prefer
from service.api.batches.intake import accept_batch
from service.api.batches.results import BatchResults, Wanted, as_array
from service.api.context import Context, ContextDep
from service.api.contract import batches as batch_doc
from service.api.contract import responses as doc
from service.api.forms import (
    answer_response,
    choice_of,
    kept_response,
    negotiate,
    one_of,
    state_response,
)
from service.api.http import LongAnswer
from service.api.http.transport import IS_HEAD, LARGE
from service.api.job_views import retry_after
from service.api.problems import ProblemError, ProblemType
from service.api.routes.parameters import CheckedRoute
from service.api.routes.routing import (
    LIST_RESPONSES,
    EndQuery,
    ListQuery,
    deliveries,
    end,
    follow,
    list_response,
)
from service.api.settings import here
from service.schemas import all_questions, by_kind
from service.schemas.answers import FORMATS, JSON, NDJSON, Forms
from service.schemas.resources import address
from worker.answers.kinds import BATCH, Answer, is_batch, kind_of_job
from worker.jobs.view import JobView

router = APIRouter(tags=["jobs"], route_class=CheckedRoute)

JobId = Annotated[str, Path(description="The id of the job.", examples=[doc.EXAMPLE_JOB_ID])]
_JOB_ID = re.compile(r"[A-Za-z0-9_\-]{1,80}", re.ASCII)


@router.get("/v1/jobs", summary="The jobs", responses=LIST_RESPONSES)
async def list_jobs(request: Request, context: ContextDep, wanted: ListQuery) -> Response:
    """Returns jobs, the newest first: those asked for with the caller's key, or without a key those asked for
    from the same network address. A key with scope `admin` gets all jobs, and so does the computer of a
    service without keys."""
    return await list_response(request, context, "jobs", wanted)


@router.get("/v1/jobs/{job_id}", summary="The state of a job", responses=doc.JOB_RESPONSES)
async def get_job(job_id: JobId, context: ContextDep) -> Response:
    """Returns the job's current state. Until it has ended, `Retry-After` says when to ask again. Afterwards
    `deliveries` has the log of its webhooks."""
    view = await context.redis(_job, context, job_id)
    return state_response(view, context, deliveries=await deliveries(context, view))


@router.delete("/v1/jobs/{job_id}", summary="Cancel a job", responses=doc.CANCEL_RESPONSES)
async def cancel_job(job_id: JobId, request: Request, context: ContextDep, wanted: EndQuery) -> Response:
    """Withdraws the caller's question, and returns the job: canceled if no other key has asked for it,
    otherwise queued or running as before. A job that has ended is unchanged.

    Equal questions share a job, so no key ends it for another. Without keys, anybody cancels it. A client
    that disconnects withdraws nothing. Computed slices are kept. The search for a design first ends with the
    best that it has found, as its answer, within seconds; canceled again, it ends at once.
    """
    view = await end(request, context, _job, job_id, wanted)
    return state_response(view, context)


def _forms_of(job_id: str) -> Forms:
    """Returns the forms of a job's result, or all forms if the id is not a job's."""
    kind = kind_of_job(job_id)
    question = None if kind is None else by_kind().get(kind.name)
    return (question or all_questions()[0]).forms


@router.get(
    "/v1/jobs/{job_id}/result",
    summary="The result of a job",
    responses=doc.RESULT_RESPONSES,
    openapi_extra=doc.RESULT_PARAMETERS,
)
async def get_result(job_id: JobId, request: Request, context: ContextDep) -> Response:
    """Returns the document that the job computed, in the form that `Accept` prefers: JSON, or another one of
    those with which its question is answered.

    The URL is also the `Content-Location` of an answer to a question, with or without a job.

    A result never changes, so it has a strong `ETag` and may be cached indefinitely.
    """
    choice = choice_of(request, _forms_of(job_id))
    kept = kept_response(context, request, job_id, choice)
    if kept is not None:
        return kept
    answer = await context.redis(_result, context, job_id)
    return await answer_response(context, request, answer, choice, job_id=job_id)


def _result(context: Context, job_id: str) -> Answer:
    if _JOB_ID.fullmatch(job_id) and not is_batch(job_id):
        answer = context.queue.result(job_id) or context.queue.kept_answer(job_id)
        if answer is not None:
            return answer
    view = _job(context, job_id)
    if not view.is_terminal:
        kind = kind_of_job(job_id)
        unit = "parts" if kind is None else kind.unit
        raise ProblemError(
            ProblemType.JOB_NOT_FINISHED,
            f"The job is {view.status}: {view.done} of {view.total} {unit} are done.",
            retry_s=retry_after(view, context.settings),
            extra={"job": here(address(job_id))},
        )
    if view.status != "succeeded":
        raise ProblemError.of_job(view)
    raise ProblemError.expired()


@router.get(
    "/v1/jobs/{job_id}/events",
    summary="Follow a job",
    responses=doc.EVENTS_RESPONSES,
    openapi_extra=doc.EVENTS_PARAMETERS,
)
async def get_events(job_id: JobId, request: Request, context: ContextDep) -> Response:
    """Server-sent events: `status` (the job), `slice` (a new slice, and progress) and `progress` (of a job
    that does not compute slices).

    The stream ends with the job. `Last-Event-ID` resumes it; 204 means that no events follow. Slices that
    were known before the job started appear only in its result.
    """
    return await follow(request, context, await context.redis(_job, context, job_id))


def _job(context: Context, job_id: str) -> JobView:
    if is_batch(job_id):
        raise ProblemError(ProblemType.NOT_FOUND, f"This is a batch: see {here(address(clipped(job_id)))}.")
    view = context.queue.get(job_id) if _JOB_ID.fullmatch(job_id) else None
    if view is None:
        detail = (
            f"There is no job {clipped(job_id)!r}, or it has expired; post the request again to start it."
        )
        raise ProblemError(ProblemType.NOT_FOUND, detail)
    return context.queue.with_position(view)


batches = APIRouter(tags=["batches"], route_class=CheckedRoute)

BatchId = Annotated[str, Path(description="The id of the batch.", examples=[batch_doc.EXAMPLE_ID])]
After = Annotated[
    int, Query(ge=-1, description="Only items after this position: the last one that was received.")
]
CallbackUrl = Annotated[
    str,
    Query(
        description="The URL to which an event is posted when the batch ends, for NDJSON or CSV; in a JSON "
        "object it is a member beside `items`. The service must allow its host."
    ),
]
_BATCH_ID = re.compile(r"ba-[0-9a-f]{40}", re.ASCII)


@batches.post(
    "/v1/batches",
    summary="Many questions of any kind in one",
    status_code=202,
    responses=batch_doc.POST_RESPONSES,
    openapi_extra=batch_doc.POST_BODY,
)
async def post_batch(request: Request, context: ContextDep, callback_url: CallbackUrl = "") -> Response:
    """Accepts a batch: as `{"items": […]}`, as lines of items (`application/x-ndjson`), or as CSV with one
    geometry in each row. An invalid item becomes a problem in its place; the others are computed. Questions
    that several batches or jobs have in common are computed once.

    With an `Idempotency-Key`, sending the same batch again within 24 hours gives the batch that was made
    first.
    """
    negotiate(request.headers.getlist("accept"), (JSON,))
    view, is_replayed = await accept_batch(request, context, callback_url or None)
    context.metrics.count_answer(BATCH.name, "job")
    view = await context.redis(context.queue.with_position, view)
    headers = {"Idempotent-Replayed": "true"} if is_replayed else {}
    return state_response(view, context, headers, is_asked_for=True)


@batches.get("/v1/batches", summary="The batches", responses=LIST_RESPONSES)
async def list_batches(request: Request, context: ContextDep, wanted: ListQuery) -> Response:
    """Returns batches, the newest first, by the same rules as `/v1/jobs`."""
    return await list_response(request, context, "batches", wanted)


@batches.get("/v1/batches/{batch_id}", summary="The state of a batch", responses=batch_doc.STATE_RESPONSES)
async def get_batch(batch_id: BatchId, context: ContextDep) -> Response:
    """Returns the state with the numbers of items by state. Until the batch has ended, `Retry-After` says
    when to ask again. Afterwards `deliveries` has the log of its webhooks."""
    view = await context.redis(_batch, context, batch_id)
    return state_response(view, context, deliveries=await deliveries(context, view))


@batches.get(
    "/v1/batches/{batch_id}/results",
    summary="The results of a batch",
    responses=batch_doc.RESULTS_RESPONSES,
    openapi_extra=batch_doc.RESULTS_PARAMETERS,
)
async def get_results(
    batch_id: BatchId, request: Request, context: ContextDep, after: After = -1
) -> Response:
    """Returns a line for each item that is done, in the order of the batch. Each `result` is, byte for byte,
    the answer to the same question outside a batch. While the batch is running, items that are not done are
    omitted.

    With `Prefer: wait=N` the response stays open for up to N seconds (see max_batch_wait_seconds in
    /v1/limits) and sends each line once all before it are sent; it ends with the batch. `after` resumes it.

    As `application/json` the lines are the elements of one array, for clients that do not read NDJSON.
    """
    media_type = _form_of(request)
    view = await context.redis(_batch, context, batch_id)
    prefer, longest = parse_prefer(request.headers.getlist("prefer")), context.settings.limits
    seconds = None if prefer.wait is None else min(prefer.wait, longest.max_batch_wait_seconds)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    if seconds is not None:
        headers["Preference-Applied"] = f"wait={seconds}"
        headers["Content-Encoding"] = "identity"  # compressed, lines would wait for each other
    if request.scope.get(IS_HEAD):
        return Response(headers=headers, media_type=media_type)
    pieces = BatchResults(context, view).pieces(Wanted(after + 1, seconds))
    if media_type == JSON:
        pieces = as_array(pieces)
    places = context.large_answers if seconds is None else context.followers
    return LongAnswer(pieces, headers, media_type, places, 0 if seconds is not None else LARGE)


@batches.get(
    "/v1/batches/{batch_id}/events",
    summary="Follow a batch",
    responses=batch_doc.EVENTS_RESPONSES,
    openapi_extra=doc.EVENTS_PARAMETERS,
)
async def get_batch_events(batch_id: BatchId, request: Request, context: ContextDep) -> Response:
    """Server-sent events: `status` (the batch) and `item` (an item that is done, and progress). The stream
    ends with the batch. `Last-Event-ID` resumes it; 204 means that no events follow.
    """
    return await follow(request, context, await context.redis(_batch, context, batch_id))


@batches.delete("/v1/batches/{batch_id}", summary="Cancel a batch", responses=batch_doc.CANCEL_RESPONSES)
async def cancel_batch(
    batch_id: BatchId,
    request: Request,
    context: ContextDep,
    wanted: EndQuery,
) -> Response:
    """Withdraws the caller's batch and returns its state. Items that are done can still be fetched; the
    others are `canceled`. A key withdraws only batches submitted with it; without keys, anybody cancels them.
    """
    view = await end(request, context, _batch, batch_id, wanted)
    return state_response(view, context)


def _form_of(request: Request) -> str:
    name = one_of(request, "format", batch_doc.RESULT_FORMATS)
    return negotiate(request.headers.getlist("accept"), (NDJSON, JSON)) if name is None else FORMATS[name]


def _batch(context: Context, batch_id: str) -> JobView:
    view = context.queue.get(batch_id) if _BATCH_ID.fullmatch(batch_id) else None
    if view is None:
        detail = f"There is no batch {clipped(batch_id)!r}, or it has expired."
        raise ProblemError(ProblemType.NOT_FOUND, detail)
    return context.queue.with_position(view)
