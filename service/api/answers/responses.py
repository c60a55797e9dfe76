"""The response that carries an answer: its form, its validators, whole or piece by piece."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass

from starlette.requests import Request
from starlette.responses import Response

from service.api.answers.forms import Choice, is_known, media_type_of, negotiate
from service.api.answers.kept import tell
from service.api.context import Context
from service.api.http.transport import LARGE, LargeAnswer, as_async, made_in_threads, slices_of
from service.api.problems import ProblemError
from service.schemas.answers import CSV, SVG, Form
from service.schemas.limits import LimitError, Limits
from worker.answers.designs import was_stopped
from worker.answers.kinds import Answer
from worker.answers.requests import Document
from worker.answers.stored_tables import ResultLostError, StoredTable

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
        search that was stopped another one."""
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
        return Response(body, headers={**self.fields, "Content-Type": self.media_type})

    def not_modified(self) -> Response:
        return Response(status_code=304, headers=self.fields)


def kept_response(
    context: Context, request: Request, job_id: str, choice: Choice, headers: Mapping[str, str] | None = None
) -> Response | None:
    """Returns an answer that was sent a moment ago, as `answer_response` does; None if it is not kept."""
    try:
        form = negotiate(choice.accept, tuple(choice.forms))
    except ProblemError:  # it may become a job, whose state is acceptable
        return None
    kept = context.kept.get(job_id, media_type_of(form, choice.forms[form]))
    if kept is None:
        return None
    tell(request.scope, job_id, kept)
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
    """Returns an answer in the negotiated form with a strong ETag, or 304 if the client has it already.

    With `job_id` it is kept for the next one who asks.

    Raises:
        LimitError: it is larger than a result may be.
        ProblemError: 406, no form is acceptable; 410, the result expired just now.
    """
    forms = choice.forms
    form = negotiate(choice.accept, tuple(forms))
    if not isinstance(answer, StoredTable):
        return await _document_response(context, request, answer, form, forms[form], headers, job_id)
    _check_size(context.settings.limits, answer.size)
    kind = media_type_of(form, forms[form])
    head = _Head.of(request, kind, _digest(kind, answer.digest), answer.has_errors, headers)
    if head.is_known:
        return head.not_modified()
    pieces = forms[form].pieces(answer)
    try:
        if answer.size <= LARGE:
            is_quick = answer.size <= _QUICK and answer.is_at_hand
            body = b"".join(pieces) if is_quick else await context.redis(b"".join, pieces)
            if job_id is not None and not answer.has_errors:
                context.kept.put(job_id, kind, _digest(kind, answer.digest), body)
            return head.response(body)
        first = await context.redis(next, pieces)
    except ResultLostError:
        raise ProblemError.expired() from None
    size = forms[form].size(answer)
    fields = {**head.fields, **({} if size is None else {"Content-Length": str(size)})}
    rest = made_in_threads(first, pieces, context.redis)
    return LargeAnswer(rest, fields, head.media_type, context.large_answers, _HELD_OF_A_TABLE)


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
    kind = media_type_of(form, encoding)
    head = _Head.of(request, kind, digest, may_change, headers)
    if job_id is not None and not may_change:
        context.kept.put(job_id, kind, digest, body)
    if head.is_known:
        return head.not_modified()
    if len(body) <= LARGE:
        return head.response(body)
    fields = {**head.fields, "Content-Length": str(len(body))}
    return LargeAnswer(as_async(slices_of(body)), fields, head.media_type, context.large_answers, len(body))


def _encoded(form: Form, document: Document) -> tuple[bytes, str]:
    body = form.encode(document)
    return body, hashlib.sha256(body).hexdigest()


def _check_size(limits: Limits, size: int) -> None:
    if size > limits.max_result_bytes:
        raise LimitError.exceeded(limits, "max_result_bytes", f"the result has {size} bytes")


def _digest(form: str, digest: str) -> str:
    return hashlib.sha256(f"{form} {digest}".encode()).hexdigest()
