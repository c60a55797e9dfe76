"""One way for every question: known answers at once, all others by a job, with or without waiting for it."""

from __future__ import annotations

from collections.abc import Callable

from fastapi import Request, Response

from service.api.body import json_of, read_body
from service.api.context import Context, in_thread
from service.api.job_view import job_json
from service.api.negotiation import JSON, Document, document_response, forms_of, json_bytes, negotiate
from service.api.prefer import parse_prefer
from service.api.problems import ProblemError
from service.schemas.limits import Limits
from worker import JobRequest, JobView
from worker.jobs.requests import kind_of

Read = Callable[[object, Limits], JobRequest]
"""Makes a request of what was posted; raises InputError."""


async def answer(
    request: Request, context: Context, read: Read, *, implied_wait: int | None = None
) -> Response:
    """Answer a question that was posted: 200 with the document, or 202 with the job that computes it.

    `implied_wait` is how many seconds to wait when the client does not say.
    """
    settings = context.settings
    body = await read_body(request, settings.limits.max_body_bytes)
    wanted = await in_thread(lambda: read(json_of(body), settings.limits))
    forms = forms_of(kind_of(wanted.job_id))
    negotiate(request.headers.getlist("accept"), tuple(dict.fromkeys((*forms, JSON))))
    prefer = parse_prefer(request.headers.getlist("prefer"))
    found = await in_thread(_begin, context, wanted)
    by_job = isinstance(found, JobView)
    waited: int | None = None
    if isinstance(found, JobView) and prefer.wait is not None:
        waited = min(prefer.wait, settings.limits.max_wait_seconds)
    seconds = waited
    if seconds is None and implied_wait is not None and not prefer.respond_async:
        seconds = min(implied_wait, settings.limits.max_wait_seconds)
    if isinstance(found, JobView) and seconds is not None:
        view = await context.events.wait(found.id, seconds) or found
        found = await in_thread(_finished, context, view)
    context.metrics.count_answer(kind_of(wanted.job_id), "job" if by_job else "cached")
    applied = prefer.applied(waited, isinstance(found, JobView))
    headers = {"Preference-Applied": applied} if applied else {}
    headers["Cache-Control"] = "no-store"
    if isinstance(found, JobView):
        headers |= {"Location": f"/v1/jobs/{found.id}", "Retry-After": str(settings.poll_seconds)}
        return Response(json_bytes(job_json(found)), 202, headers, media_type=JSON)
    return await in_thread(document_response, request, found, forms, headers=headers)


def _begin(context: Context, wanted: JobRequest) -> Document | JobView:
    known = context.queue.known(wanted)
    if known is not None:
        return known
    return _finished(context, context.queue.submit(wanted))


def _finished(context: Context, view: JobView) -> Document | JobView:
    """The answer of a job that has succeeded, the problem of one that will have none, else the job."""
    if view.status == "failed":
        raise ProblemError.of_job(view.id, view.error)
    if view.status == "canceled":
        raise ProblemError.of_cancel(view.id)
    document = context.queue.result(view.id) if view.status == "succeeded" else None
    return view if document is None else document
