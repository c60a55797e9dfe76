"""What jobs and batches have in common for their callers: their end, and the log of their webhooks."""

from __future__ import annotations

from collections.abc import Callable

from fastapi import Request, Response

from service.api.access.caller import caller_of, oversees, subscriber_of
from service.api.context import Context
from service.api.jobs.callbacks import deliveries_json
from service.api.negotiation import JSON
from service.api.problems import ProblemError, ProblemType
from service.api.table_forms import json_bytes
from worker.jobs.views import JobView

Find = Callable[[Context, str], JobView]
"""Returns the job or batch of an id, or raises 404."""


async def end(
    request: Request, context: Context, find: Find, job_id: str, subscription: str, force: bool
) -> JobView:
    """Withdraw the caller from a job or batch, or with `force` cancel it for all; returns its state.

    Raises:
        ProblemError: 404, or 403 if the caller may not cancel it for all.
    """
    caller = caller_of(request.scope)
    if force and not oversees(request.scope):
        raise ProblemError(
            ProblemType.FORBIDDEN,
            "Only a key with scope admin, or on a service without keys a call from its own computer, can end "
            "what others have asked for (force).",
        )

    def act() -> JobView:
        find(context, job_id)
        queue = context.queue.of(job_id)
        ended = queue.cancel(job_id) if force else queue.withdraw(job_id, subscriber_of(caller, subscription))
        return ended or find(context, job_id)

    return await context.redis(act)


async def deliveries(context: Context, find: Find, job_id: str) -> Response:
    """Returns the log of the deliveries to every `callback_url` of a job or batch."""
    body = json_bytes(
        deliveries_json(await context.redis(lambda: context.callbacks.of_job(find(context, job_id).id)))
    )
    return Response(body, headers={"Cache-Control": "no-store"}, media_type=JSON)
