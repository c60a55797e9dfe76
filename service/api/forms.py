"""The forms of a document: how each is written, and which one a request gets, by Accept or by its query; and
the response that carries an answer: its form, its validators, whole or piece by piece; or the state of a job
in its place."""

from __future__ import annotations

import hashlib
from collections.abc import AsyncGenerator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from starlette.requests import Request
from starlette.responses import Response

from rpr_solver.errors import clipped
from service.api.context import Context
from service.api.http import LongAnswer, Slots, in_pieces, made_in_threads
from service.api.http.transport import LARGE
from service.api.job_views import delivery_json, retry_after, state_json
from service.api.problems import ProblemError, ProblemType
from service.api.settings import here
from service.schemas.answers import CSV, FORMATS, JSON, SVG, Form, Forms, json_bytes
from service.schemas.limits import LimitError, Limits
from service.schemas.resources import address
from service.webhooks.callbacks import Delivery
from worker.answers import Document
from worker.answers.designs import was_stopped
from worker.answers.kinds import Answer
from worker.answers.tables import ResultLostError, StoredTable
from worker.jobs.view import JobView


def negotiate(accept: Sequence[str], offered: Sequence[str]) -> str:
    """Returns the offered media type with the highest quality in the Accept headers, the first of equals.

    Raises:
        ProblemError: 406, none is acceptable.
    """
    ranges = [media_range(part) for header in accept for part in header.split(",") if part.strip()]
    if not ranges:
        return offered[0]
    best = max(offered, key=lambda kind: (_quality(kind, ranges), -offered.index(kind)))
    if _quality(best, ranges) <= 0:
        raise ProblemError(
            ProblemType.NOT_ACCEPTABLE,
            f"Accept {clipped(', '.join(accept), 200)!r} matches none of {', '.join(offered)}.",
        )
    return best


def is_known(headers: Sequence[str], tag: str) -> bool:
    """Whether a tag is among those of `If-None-Match` headers."""
    sent = {part.strip().removeprefix("W/") for header in headers for part in header.split(",")}
    return not sent.isdisjoint({tag, "*"})


def media_range(text: str) -> tuple[str, float]:
    """Returns the range and the quality of an element of an `Accept…` header."""
    kind, *parameters = (part.strip().lower() for part in text.split(";"))
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        if name.strip() == "q":
            try:
                return kind, min(1.0, max(0.0, float(value)))
            except ValueError:
                return kind, 0.0
    return kind, 1.0


def _quality(kind: str, ranges: Sequence[tuple[str, float]]) -> float:
    """Returns the quality of a media type by the most specific range."""
    for pattern in (kind, f"{kind.partition('/')[0]}/*", "*/*"):
        for candidate, quality in ranges:
            if candidate == pattern:
                return quality
    return 0.0


@dataclass(frozen=True)
class Choice:
    """The form of an answer that a request gets.

    Attributes:
        media_type: its name.
        form: how it is written.
        query: what asks for it at the URL of the result.
    """

    media_type: str
    form: Form
    query: str = ""


def format_names(forms: Forms) -> tuple[str, ...]:
    """Returns the names of forms, as `format` gives them."""
    return tuple(name for name, media in FORMATS.items() if media in forms)


def choice_of(request: Request, forms: Forms) -> Choice:
    """Returns the form of an answer that `format` names, or else the one that Accept prefers.

    Raises:
        ProblemError: 422, a value is not known; 406, no form is acceptable.
    """
    name = one_of(request, "format", format_names(forms))
    if name is None:
        media = negotiate(request.headers.getlist("accept"), tuple(forms))
        return Choice(media, forms[media])
    media = FORMATS[name]
    return Choice(media, forms[media], f"?format={name}")


def one_of(request: Request, name: str, known: Sequence[str]) -> str | None:
    """Returns the value of a parameter of a query, or None.

    Raises:
        ProblemError: 422, it is not one of these.
    """
    value = request.query_params.get(name)
    if value is None or value in known:
        return value
    message = f"is {clipped(value)!r}; it must be one of {', '.join(known)}"
    raise ProblemError(ProblemType.INVALID_REQUEST, f"{name}: {message}", errors=[(name, message)])


def json_answer(
    document: object, cache: str = "no-store", headers: Mapping[str, str] | None = None
) -> Response:
    """Returns a response with a JSON document."""
    return Response(
        json_bytes(document), headers={"Cache-Control": cache, **(headers or {})}, media_type=JSON
    )


def state_response(
    view: JobView,
    context: Context,
    headers: Mapping[str, str] | None = None,
    *,
    deliveries: Sequence[Delivery] = (),
    is_asked_for: bool = False,
) -> Response:
    """Returns the state of a job or a batch: 202 to the client that has asked for it, else 200."""
    fields = {"Cache-Control": "no-store", **(headers or {})}
    if is_asked_for:
        fields["Location"] = here(address(view.id))
    if not view.is_terminal:
        fields["Retry-After"] = str(retry_after(view, context.settings))
    log = {"deliveries": [delivery_json(delivery) for delivery in deliveries]} if deliveries else {}
    body = json_bytes({**state_json(view, context.queue.settings), **log})
    return Response(body, 202 if is_asked_for else 200, fields, media_type=JSON)


IMMUTABLE = "public, max-age=31536000, immutable"
REVALIDATE = "no-cache"

_PICTURES = "default-src 'none'; style-src 'unsafe-inline'"

_QUICK = 16 << 10  # bytes of a table at hand that are in their form before a thread would have begun
_HELD_OF_A_TABLE = 4 * LARGE  # a batch as it is read, in its form, compressed, and being sent


@dataclass(frozen=True)
class _Head:
    """The form of an answer, and its header fields."""

    request: Request
    form: str
    tag: str
    fields: Mapping[str, str]

    @classmethod
    def of(
        cls, request: Request, form: str, digest: str, may_change: bool, headers: Mapping[str, str] | None
    ) -> _Head:
        """Documents never change, except that a slice with an error may have an answer next time, and a
        search that was stopped a better one."""
        tag = f'"{digest[:32]}"'
        cache = REVALIDATE if may_change else IMMUTABLE
        policy = {"Content-Security-Policy": _PICTURES} if form == SVG else {}
        fields = {"ETag": tag, "Cache-Control": cache, "Vary": "Accept", **policy, **(headers or {})}
        return cls(request, form, tag, fields)

    @property
    def media_type(self) -> str:
        return "text/csv; charset=utf-8; header=present" if self.form == CSV else self.form

    @property
    def is_known(self) -> bool:
        """Whether the client has the document already."""
        sent = self.request.headers.getlist("if-none-match")
        return self.request.method == "GET" and is_known(sent, self.tag)

    def response(self, body: bytes) -> Response:
        fields = {**self.fields, "Content-Length": str(len(body)), "Content-Type": self.media_type}
        return Response(body, headers=fields)

    def large(self, pieces: AsyncGenerator[bytes], size: int | None, slots: Slots, held: int) -> Response:
        length = {} if size is None else {"Content-Length": str(size)}
        return LongAnswer(pieces, {**self.fields, **length}, self.media_type, slots, held)

    def not_modified(self) -> Response:
        return Response(status_code=304, headers=self.fields)


def kept_response(
    context: Context, request: Request, job_id: str, choice: Choice, headers: Mapping[str, str] | None = None
) -> Response | None:
    """Returns an answer that was sent a moment ago, as `answer_response` does; None if it is not kept."""
    kept = context.kept.get(job_id, choice.media_type)
    if kept is None:
        return None
    head = _Head.of(request, kept.form, kept.digest, False, headers)
    return head.not_modified() if head.is_known else head.response(kept.body)


async def answer_response(
    context: Context,
    request: Request,
    answer: Answer,
    choice: Choice,
    *,
    headers: Mapping[str, str] | None = None,
    job_id: str | None = None,
) -> Response:
    """Returns an answer in its form with a strong ETag, or 304 if the client has it already.

    With `job_id` it is kept for the next client that asks.

    Raises:
        LimitError: it is larger than a result may be.
        ProblemError: 410, the result expired just now.
    """
    form = choice.media_type
    if not isinstance(answer, StoredTable):
        return await _document_response(context, request, answer, form, choice.form, headers, job_id)
    _check_size(context.settings.limits, answer.size)
    digest = _digest(form, answer.digest)
    head = _Head.of(request, form, digest, answer.has_errors, headers)
    if head.is_known:
        return head.not_modified()
    pieces = choice.form.pieces(answer)
    try:
        if answer.size <= LARGE:
            is_quick = answer.size <= _QUICK and answer.is_at_hand
            body = b"".join(pieces) if is_quick else await context.redis(b"".join, pieces)
            if job_id is not None and not answer.has_errors:
                context.kept.put(job_id, form, digest, body)
            return head.response(body)
        first = await context.redis(next, pieces)
    except ResultLostError:
        raise ProblemError.expired() from None
    content = made_in_threads(chain((first,), pieces), context.redis)
    return head.large(content, choice.form.size(answer), context.large_answers, _HELD_OF_A_TABLE)


async def _document_response(
    context: Context,
    request: Request,
    document: Document,
    form: str,
    encoding: Form,
    headers: Mapping[str, str] | None,
    job_id: str | None,
) -> Response:
    body, digest = await context.parsing(_encoded, encoding, document)
    _check_size(context.settings.limits, len(body))
    may_change = was_stopped(document) or any("error" in part for part in document.get("slices", ()))
    head = _Head.of(request, form, digest, may_change, headers)
    if job_id is not None and not may_change:
        context.kept.put(job_id, form, digest, body)
    if head.is_known:
        return head.not_modified()
    if len(body) <= LARGE:
        return head.response(body)
    return head.large(in_pieces(body), len(body), context.large_answers, len(body))


def _encoded(form: Form, document: Document) -> tuple[bytes, str]:
    body = form.encode(document)
    return body, hashlib.sha256(body).hexdigest()


def _check_size(limits: Limits, size: int) -> None:
    if size > limits.max_result_bytes:
        raise LimitError.exceeded(limits, "max_result_bytes", f"the result has {size} bytes")


def _digest(form: str, digest: str) -> str:
    return hashlib.sha256(f"{form} {digest}".encode()).hexdigest()
