"""The response that follows the events of a job or a batch."""

from __future__ import annotations

import re

from fastapi import Request, Response

from service.api.answers.large_answers import IS_HEAD, LongAnswer
from service.api.context import Context
from service.api.http.transport import FOLLOWS
from service.api.jobs.tail import EVENT_ID
from service.api.problems import ProblemError, ProblemType
from worker.jobs.views import JobView


async def follow(request: Request, context: Context, view: JobView, with_known: bool = False) -> Response:
    """Returns the stream of events, from after `Last-Event-ID` if it is sent; or 204 if none follows.

    With `with_known`, a stream from the beginning also has the slices that were known before the job.

    Raises:
        ProblemError: 400, the id is malformed.
    """
    last = request.headers.get("last-event-id", "0").strip() or "0"
    if not re.fullmatch(EVENT_ID, last, re.ASCII):
        raise ProblemError(
            ProblemType.INVALID_HEADER,
            f"Last-Event-ID {last[:60]!r} is not an event id of this stream.",
            errors=[("Last-Event-ID", "send the id of the last event received, or omit it")],
        )
    if view.is_terminal and last != "0" and not await context.events.after(view, last):
        return Response(status_code=204)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    if request.scope.get(IS_HEAD):
        return Response(headers=headers, media_type="text/event-stream")
    request.scope[FOLLOWS] = True
    stream = context.events.follow(view, last, with_known and last == "0")
    return LongAnswer(stream, headers, "text/event-stream", context.followers)
