"""`/v1/batches`: many questions in one, their state, results, events, and their end."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import APIRouter, Path, Query, Request, Response

from service.api.answers.answer import parse_prefer
from service.api.answers.forms import negotiate, one_of
from service.api.batches.intake import accept_batch
from service.api.batches.results import BatchResults, Wanted, as_array
from service.api.context import Context, ContextDep
from service.api.contract import batches as doc
from service.api.contract.operations import DELIVERIES_RESPONSES
from service.api.http.transport import IS_HEAD, LARGE, LargeAnswer
from service.api.jobs.views import state_response
from service.api.problems import ProblemError, ProblemType
from service.api.routes.shared import (
    LIST_RESPONSES,
    Before,
    Force,
    MostItems,
    StatusWanted,
    Subscription,
    deliveries,
    end,
    follow,
    list_response,
)
from service.schemas.answers import FORMATS, JSON, NDJSON
from worker.answers.kinds import BATCH
from worker.jobs.views import JobView

router = APIRouter(tags=["batches"])

BatchId = Annotated[str, Path(description="The id of the batch.", examples=[doc.EXAMPLE_ID])]
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


@router.post(
    "/v1/batches",
    summary="Many questions of any kind in one",
    status_code=202,
    responses=doc.POST_RESPONSES,
    openapi_extra=doc.POST_BODY,
)
async def post_batch(request: Request, context: ContextDep, callback_url: CallbackUrl = "") -> Response:
    """Accepts a batch: as `{"items": […]}`, as lines of items (`application/x-ndjson`), or as CSV with one
    geometry in each row. An invalid item becomes a problem in its place; the others are computed. Questions
    that several batches or jobs have in common are computed once.

    With an `Idempotency-Key`, sending the same batch again within 24 hours gives the batch that was made
    first.
    """
    negotiate(request.headers.getlist("accept"), (JSON,))
    view, who = await accept_batch(request, context, callback_url or None)
    context.metrics.count_answer(BATCH.name, "job")
    view = await context.redis(context.queue.placed, view)
    return state_response(view, context.settings, context.queue.settings, who)


@router.get("/v1/batches", summary="The batches", responses=LIST_RESPONSES)
async def list_batches(
    request: Request,
    context: ContextDep,
    status: StatusWanted = None,
    before: Before = "",
    limit: MostItems = 50,
) -> Response:
    """Returns batches, the newest first, by the same rules as `/v1/jobs`."""
    return await list_response(request, context, "batches", status, before, limit)


@router.get("/v1/batches/{batch_id}", summary="The state of a batch", responses=doc.STATE_RESPONSES)
async def get_batch(batch_id: BatchId, context: ContextDep) -> Response:
    """Returns the state with the numbers of items by state. Until the batch has ended, `Retry-After` says
    when to ask again."""
    view = await context.redis(_batch, context, batch_id)
    return state_response(view, context.settings, context.queue.settings)


@router.get(
    "/v1/batches/{batch_id}/results",
    summary="The results of a batch",
    responses=doc.RESULTS_RESPONSES,
    openapi_extra=doc.RESULTS_PARAMETERS,
)
async def get_results(
    batch_id: BatchId, request: Request, context: ContextDep, after: After = -1
) -> Response:
    """Returns a line for each item that is done, in the order of the batch. Each `result` is, byte for byte,
    the answer to the same question outside a batch. While the batch is running, items that are not done are
    omitted.

    With `Prefer: wait=N` the response stays open for up to N seconds (see max_batch_wait_seconds in
    /v1/limits) and sends each line once all before it are sent; it ends with the batch. `after` resumes it.
    With `Prefer: wait=N, order=completion` the lines come in the order in which the items are done.

    As `application/json` the lines are the elements of one array, for clients that do not read NDJSON.
    """
    media_type = _form_of(request)
    view = await context.redis(_batch, context, batch_id)
    prefer, longest = parse_prefer(request.headers.getlist("prefer")), context.settings.limits
    seconds = None if prefer.wait is None else min(prefer.wait, longest.max_batch_wait_seconds)
    if prefer.by_completion and after >= 0:
        raise ProblemError(
            ProblemType.INVALID_REQUEST,
            "after counts in the order of the batch; it cannot be combined with order=completion.",
            errors=[("after", "omit it with Prefer: order=completion")],
        )
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    applied = [] if seconds is None else [f"wait={seconds}"]
    if applied_all := [*applied, *(["order=completion"] if prefer.by_completion else [])]:
        headers["Preference-Applied"] = ", ".join(applied_all)
    if seconds is not None:
        headers["Content-Encoding"] = "identity"  # compressed, lines would wait for each other
    if request.scope.get(IS_HEAD):
        return Response(headers=headers, media_type=media_type)
    pieces = BatchResults(context, view).pieces(Wanted(after + 1, seconds, prefer.by_completion))
    if media_type == JSON:
        pieces = as_array(pieces)
    places = context.large_answers if seconds is None else context.followers
    return LargeAnswer(pieces, headers, media_type, places, 0 if seconds is not None else LARGE)


@router.get("/v1/batches/{batch_id}/events", summary="Follow a batch", responses=doc.EVENTS_RESPONSES)
async def get_batch_events(batch_id: BatchId, request: Request, context: ContextDep) -> Response:
    """Server-sent events: `status` (the batch) and `item` (an item that is done, and progress). The stream
    ends with the batch. `Last-Event-ID` resumes it; 204 means that no events follow.
    """
    return await follow(request, context, await context.redis(_batch, context, batch_id))


@router.get(
    "/v1/batches/{batch_id}/deliveries",
    summary="The webhooks of a batch",
    responses=DELIVERIES_RESPONSES,
)
async def get_batch_deliveries(batch_id: BatchId, context: ContextDep) -> Response:
    """Returns the log of the deliveries to every `callback_url` of the batch, with all attempts; kept for
    three days after the last one. Empty until the batch has ended."""
    return await deliveries(context, _batch, batch_id)


@router.delete("/v1/batches/{batch_id}", summary="Cancel a batch", responses=doc.CANCEL_RESPONSES)
async def cancel_batch(
    batch_id: BatchId,
    request: Request,
    context: ContextDep,
    subscription: Subscription = "",
    force: Force = False,
) -> Response:
    """Withdraws the caller's batch and returns its state. Items that are done can still be fetched; the
    others are `canceled`. The batch of another caller is unchanged: a key withdraws only batches submitted
    with it. Without keys, `links.cancel` of the answer to the submission withdraws the batch from anywhere.
    """
    view = await end(request, context, _batch, batch_id, subscription, force)
    return state_response(view, context.settings, context.queue.settings)


def _form_of(request: Request) -> str:
    name = one_of(request, "format", doc.RESULT_FORMATS)
    return negotiate(request.headers.getlist("accept"), (NDJSON, JSON)) if name is None else FORMATS[name]


def _batch(context: Context, batch_id: str) -> JobView:
    view = context.queue.get(batch_id) if _BATCH_ID.fullmatch(batch_id) else None
    if view is None:
        detail = f"There is no batch {batch_id[:80]!r}, or it has expired."
        raise ProblemError(ProblemType.NOT_FOUND, detail)
    return context.queue.placed(view)
