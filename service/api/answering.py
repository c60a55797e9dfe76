"""The answer to any question: a known document at once, otherwise a job, with or without waiting for it."""

from __future__ import annotations

from fastapi import Request, Response

from service.api.body import json_of, read_body
from service.api.context import Context
from service.api.job_view import job_json
from service.api.negotiation import JSON, Document, document_response, json_bytes, negotiate
from service.api.operations import Operation
from service.api.prefer import parse_prefer
from service.api.problems import ProblemError
from service.schemas.document import Source, read
from service.schemas.limits import Limits
from worker.answers.requests import JobRequest
from worker.jobs.records import JobView


async def answer_question(request: Request, context: Context, operation: Operation) -> Response:
    """Answer a question: 200 with the document, or 202 with the job that computes it."""
    settings = context.settings
    body = await read_body(request, settings.limits.max_body_bytes)
    job_request = await context.parsing(_question, operation, body, settings.limits)
    negotiate(request.headers.getlist("accept"), tuple(dict.fromkeys((*operation.forms, JSON))))
    prefer = parse_prefer(request.headers.getlist("prefer"))
    outcome = await context.redis(_begin, context, job_request)
    way, waited = "cached", None
    if isinstance(outcome, JobView):
        way, longest = "job", settings.limits.max_wait_seconds
        implied = None if prefer.respond_async else operation.implied_wait
        waited = None if prefer.wait is None else min(prefer.wait, longest)
        seconds = waited if waited is not None or implied is None else min(implied, longest)
        if seconds is not None:
            view = await context.events.wait(outcome.id, seconds) or outcome
            outcome = await context.redis(_finished, context, view)
    context.metrics.count_answer(job_request.kind.name, way)
    headers = {"Cache-Control": "no-store"}
    if applied := prefer.applied(waited, isinstance(outcome, JobView)):
        headers["Preference-Applied"] = applied
    if isinstance(outcome, JobView):
        headers |= {"Location": f"/v1/jobs/{outcome.id}", "Retry-After": str(settings.poll_seconds)}
        return Response(json_bytes(job_json(outcome)), 202, headers, media_type=JSON)
    return await context.parsing(document_response, request, outcome, operation.forms, headers=headers)


def _question(operation: Operation, body: bytes, limits: Limits) -> JobRequest:
    return read(operation.question, json_of(body, limits), Source(limits)).job_request()


def _begin(context: Context, job_request: JobRequest) -> Document | JobView:
    known = context.queue.known(job_request)
    return _finished(context, context.queue.submit(job_request)) if known is None else known


def _finished(context: Context, view: JobView) -> Document | JobView:
    """Returns the document of a job that has succeeded, else the job.

    Raises:
        ProblemError: the job failed or was canceled.
    """
    if view.status in ("failed", "canceled"):
        raise ProblemError.of_job(view)
    document = context.queue.result(view.id) if view.status == "succeeded" else None
    return view if document is None else document
