"""Request bodies: limited in size and type, and read as questions. The answer to any question: a known
document at once, otherwise a job, with or without waiting for it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from fastapi import Request, Response

from rpr_solver.errors import InputError, clipped
from service.api.caller import Admission, caller_of, client_of
from service.api.context import Context
from service.api.forms import answer_response, choice_of, kept_response, state_response
from service.api.problems import ProblemError, ProblemType
from service.api.settings import here
from service.schemas.answers import JSON
from service.schemas.document import JsonError, JsonNumber, Source, at, json_kind, parse_json, read
from service.schemas.limits import LimitError, Limits
from service.schemas.questions import Question, check_price
from service.webhooks import target_of
from service.webhooks.callbacks import MAX_CALLBACKS_PER_JOB, TooManyCallbacksError
from service.webhooks.target import FIELD
from worker.answers import JobRequest
from worker.answers.kinds import Answer
from worker.jobs.records import Client
from worker.jobs.view import JobView


async def read_body(request: Request, max_bytes: int) -> bytes:
    """Read the body of a request, for :func:`json_of` (which may be slow, so outside the event loop).

    Raises:
        ProblemError: 415 for another content type, 413 for a body over the limit.
    """
    media_type_of(request, (JSON,))
    declared = request.headers.get("content-length", "")
    if declared.isascii() and declared.isdigit() and (len(declared) > 18 or int(declared) > max_bytes):
        raise too_large("max_body_bytes", max_bytes, f"{clipped(declared)} bytes were announced")
    body = bytearray()
    async for piece in request.stream():
        body += piece
        if len(body) > max_bytes:
            raise too_large("max_body_bytes", max_bytes, f"more than {max_bytes} bytes were sent")
    return bytes(body)


def json_of(body: bytes, limits: Limits) -> object:
    """Returns the JSON of a body.

    Raises:
        LimitError: the body has too many members, which takes far less time than parsing them, or a number
            that is too long.
        ProblemError: 400, the body is not strict JSON.
    """
    # An upper bound, which the few strings of a request cannot move far.
    members = sum(body.count(mark) for mark in (b",", b"[", b"{"))
    if members > limits.max_body_members:
        raise LimitError.exceeded(
            limits, "max_body_members", f"the body has about {members} members and elements", "body"
        )
    try:
        return parse_json(body, limits=limits)
    except JsonError as error:
        if error.limit is not None:
            raise at(error.limit, error.field) from None
        raise ProblemError(
            ProblemType.INVALID_JSON, error.detail, errors=[(error.field, error.message)], in_body=True
        ) from None


def media_type_of(request: Request, accepted: Sequence[str]) -> str:
    """Returns the media type of a body, one of those that are accepted.

    Raises:
        ProblemError: 415, it is another one, or encoded.
    """
    sent = request.headers.get("content-type")
    media_type = (sent or "").partition(";")[0].strip().lower()
    if media_type.startswith("application/") and media_type.endswith("+json"):
        media_type = JSON
    if media_type not in accepted:
        what = "has no Content-Type" if sent is None else f"is sent as {clipped(sent, 100)!r}"
        raise ProblemError(
            ProblemType.UNSUPPORTED_MEDIA_TYPE,
            f"The body {what}; send it as {' or '.join(accepted)}.",
            headers={"Accept-Post": ", ".join(accepted)},
        )
    encoding = request.headers.get("content-encoding", "identity").strip().lower()
    if encoding not in ("", "identity"):
        raise ProblemError(
            ProblemType.UNSUPPORTED_MEDIA_TYPE,
            f"The body is sent with Content-Encoding {clipped(encoding, 100)!r}; send it without one.",
            headers={"Accept-Encoding": "identity"},
        )
    return media_type


def too_large(name: str, limit: int, sent: str) -> ProblemError:
    """Returns the problem of a body over the limit `name`."""
    return ProblemError(
        ProblemType.BODY_TOO_LARGE,
        f"The body may have at most {limit} bytes (limit {name}); {sent}.",
        errors=[("body", f"limit {name} is {limit}; {sent}")],
        headers={"Connection": "close"},
    )


class Asked(NamedTuple):
    """A question that was read, and the request for its job."""

    question: Question
    request: JobRequest


def asked_of(model: type[Question], document: object, limits: Limits) -> Asked:
    """Returns the question that a document asks.

    Raises:
        InputError: it is not a valid question.
    """
    question = read(model, document, Source(limits))
    return Asked(question, question.job_request())


def question_in(model: type[Question], body: bytes, limits: Limits) -> Asked:
    """Returns the question that a body asks; may be slow, so outside the event loop.

    Raises:
        InputError: it is not a valid question.
        ProblemError: it is not strict JSON.
    """
    return asked_of(model, json_of(body, limits), limits)


_TOKEN = r"[!#$%&'*+\-.^_`|~0-9A-Za-z]++"
_IN_QUOTES = r'"(?:[^"\\]|\\.)*+'
_PAIR = re.compile(rf'({_TOKEN})\s*+(?:=\s*+({_TOKEN}|{_IN_QUOTES}")?+)?+', re.ASCII)


@dataclass(frozen=True)
class Preferences:
    """The preferences of a client: a response without waiting, or the number of seconds to wait."""

    respond_async: bool = False
    wait: int | None = None

    def applied(self, waited: float | None, accepted: bool) -> str | None:
        """Returns the Preference-Applied header of a response after at most `waited` seconds."""
        parts = [f"wait={waited}"] if waited is not None else []
        if self.respond_async and accepted:
            parts.insert(0, "respond-async")
        return ", ".join(parts) or None


def parse_prefer(headers: Iterable[str]) -> Preferences:
    """Read all Prefer headers of a request.

    As the RFC requires, the first of repeated preferences counts, names are case-insensitive, and unknown or
    malformed preferences are ignored.

    >>> parse_prefer(['respond-async; x="1,2", Wait = 10', "wait=3"])
    Preferences(respond_async=True, wait=10)
    """
    preferences: dict[str, str] = {}
    for header in headers:
        for preference in _split(header, ","):
            first = _split(preference, ";")[0].strip()
            if match := _PAIR.fullmatch(first):
                preferences.setdefault(match[1].lower(), _unquoted(match[2] or ""))
    wait = preferences.get("wait", "")
    seconds = int(wait[:10]) if wait.isascii() and wait.isdigit() else None
    return Preferences("respond-async" in preferences, seconds)


def _split(text: str, separator: str) -> list[str]:
    """Split at separators outside quoted strings; one that is not closed reaches to the end."""
    return re.findall(rf'(?:[^{separator}"]|{_IN_QUOTES}\\?(?:"|\Z))++', text, re.DOTALL) or [""]


def _unquoted(value: str) -> str:
    return re.sub(r"\\(.)", r"\1", value[1:-1]) if value.startswith('"') else value


async def answer_question(request: Request, context: Context, question: type[Question]) -> Response:
    """Answer a posted question: 200 with the document, or 202 with the job that computes it."""
    limits = context.settings.limits
    body = await read_body(request, limits.max_body_bytes)
    asked = await context.parsing(question_in, question, body, limits)
    return await answer_asked(request, context, asked, parse_prefer(request.headers.getlist("prefer")))


async def answer_asked(request: Request, context: Context, asked: Asked, prefer: Preferences) -> Response:
    """Answer a question that was read: look the answer up or submit a job, wait, and respond."""
    question, job_request = asked
    settings, queue = context.settings, context.queue
    if question.callback_url is not None:
        target_of(question.callback_url, settings.webhooks)
    choice = choice_of(request, question.forms)
    link = here(f"/v1/jobs/{job_request.job_id}/result{choice.query}")
    of_post = {} if request.method == "GET" else {"Cache-Control": "no-store"}
    headers = {**of_post, "Content-Location": link}
    kept = kept_response(context, request, job_request.job_id, choice, headers)
    if kept is not None:
        context.metrics.count_answer(job_request.kind.name, "cached")
        return kept
    seconds = _patience(prefer, settings.limits.max_wait_seconds)
    caller = caller_of(request.scope)
    who = client_of(caller)

    def look_up_or_submit() -> tuple[Answer | JobView, bool]:
        known = queue.known(job_request)
        if known is not None:
            return known, queue.remember(job_request)
        check_price(job_request, settings.limits)
        Admission(caller, queue.quotas, settings.limits).admit(job_request.job_id, job_request.cost.whole)
        view = queue.submit(job_request, question.deadline_seconds, is_unknown=True, by=who)
        call_back(context, view.id, who, question.callback_url)
        outcome = _outcome(view, queue.result(view.id) if view.status == "succeeded" else None)
        return queue.with_position(outcome) if isinstance(
            outcome, JobView
        ) and seconds is None else outcome, True

    outcome, is_kept = await context.redis(look_up_or_submit)
    is_job = isinstance(outcome, JobView)
    if isinstance(outcome, JobView) and seconds is not None:
        outcome = await _wait(context, job_request, outcome, seconds)
    context.metrics.count_answer(job_request.kind.name, "job" if is_job else "cached")
    wanted = seconds if is_job and prefer.wait is not None else None
    applied = prefer.applied(wanted, isinstance(outcome, JobView))
    headers = {} if applied is None else {"Preference-Applied": applied}
    if isinstance(outcome, JobView):
        return state_response(outcome, context, headers, is_asked_for=True)
    headers |= of_post
    if is_kept:
        headers["Content-Location"] = link
    job_id = job_request.job_id if is_kept else None
    return await answer_response(context, request, outcome, choice, headers=headers, job_id=job_id)


async def _wait(context: Context, asked: JobRequest, job: JobView, seconds: float) -> Answer | JobView:
    """Returns the answer of a job, or its state after this number of seconds.

    Raises:
        ProblemError: the job failed or was canceled.
    """
    queue = context.queue
    has_ended = await context.events.wait(job, seconds)

    def look_again() -> Answer | JobView:
        known = queue.known(asked) if has_ended else None
        if known is not None:  # as most often after the end
            return known
        view, answer = queue.outcome(job.id)
        return _outcome(view or job, answer)

    outcome = await context.redis(look_again)
    return await context.redis(queue.with_position, outcome) if isinstance(outcome, JobView) else outcome


def _outcome(view: JobView, answer: Answer | None) -> Answer | JobView:
    """Returns the answer of a job, or the job if it has none yet.

    Raises:
        ProblemError: the job failed or was canceled.
    """
    if view.status in ("failed", "canceled"):
        raise ProblemError.of_job(view)
    return view if answer is None else answer


_BRIEF = 0.25  # seconds, in which most short questions are answered


def _patience(prefer: Preferences, longest: int) -> float | None:
    """Returns the seconds to wait for a job, as the client asked and as limited by the service."""
    if prefer.wait is not None:
        return min(prefer.wait, longest)
    return None if prefer.respond_async else _BRIEF


def allowed_url(context: Context, *sent: object) -> str | None:
    """Returns the callback URL of a batch, which is given in the query or in the body, or None.

    Raises:
        InputError: it may not be called, or there are two.
    """
    urls = [url for url in sent if url is not None]
    if len(urls) > 1:
        raise InputError.of(FIELD, "is given in the query and in the body; give it once")
    for url in urls:
        if not isinstance(url, str) or isinstance(url, JsonNumber):
            raise InputError.of(FIELD, f"is {json_kind(url)}; give a URL")
        target_of(url, context.settings.webhooks)
        return url
    return None


def call_back(context: Context, job_id: str, who: Client, url: str | None) -> None:
    """Have a URL, if there is one, called when the job of a client ends.

    Raises:
        InputError: the job has too many; a client with a key is withdrawn.
    """
    if url is None:
        return
    try:
        context.callbacks.add(job_id, url)
    except TooManyCallbacksError:
        if who.is_known:  # else it would be canceled for all
            context.queue.withdraw(job_id, who)
        text = f"the job has {MAX_CALLBACKS_PER_JOB} callbacks, the most that it may have"
        raise InputError.of(FIELD, text) from None
