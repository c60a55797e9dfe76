"""The response that carries an answer: its form, its validators, whole or piece by piece."""

from __future__ import annotations

import hashlib
from collections.abc import AsyncGenerator, Mapping
from dataclasses import dataclass

from starlette.requests import Request
from starlette.responses import Response

from service.api.answers.forms import Choice, is_known, media_type_of, negotiate
from service.api.answers.kept import tell
from service.api.context import Context
from service.api.http.transport import (
    IS_HEAD,
    LARGE,
    LargeAnswer,
    Slots,
    as_async,
    cut,
    made_in_threads,
    part_of,
    slices_of,
)
from service.api.problems import ProblemError, ProblemType
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

    def part_of(self, size: int | None) -> range | None:
        """Returns which of so many bytes are asked for; None: all, or their number is not known.

        Raises:
            ProblemError: 416, there are none of these.
        """
        request, ranges = self.request, self.request.headers.getlist("range")
        is_for_part = request.method == "GET" and IS_HEAD not in request.scope and len(ranges) == 1
        if size is None or not is_for_part or request.headers.get("if-range", self.tag) != self.tag:
            return None
        part = part_of(ranges[0], size)
        if part is not None and not part:
            raise ProblemError(
                ProblemType.RANGE_NOT_SATISFIABLE,
                f"Range {ranges[0][:40]!r} is beyond the {size} bytes of this answer.",
                headers={"Content-Range": f"bytes */{size}", "ETag": self.tag},
            )
        return part

    def framing(self, size: int | None, part: range | None) -> tuple[int, dict[str, str]]:
        """Returns the status and the header fields of so many bytes, or of a part of them."""
        if size is None:
            return 200, {**self.fields}
        accepts = {"Accept-Ranges": "bytes"} if self.request.method == "GET" else {}
        if part is None:
            return 200, {**self.fields, **accepts, "Content-Length": str(size)}
        where = {"Content-Range": f"bytes {part.start}-{part.stop - 1}/{size}"}
        return 206, {**self.fields, **accepts, **where, "Content-Length": str(len(part))}

    def response(self, body: bytes) -> Response:
        part = self.part_of(len(body))
        status, fields = self.framing(len(body), part)
        content = body if part is None else body[part.start : part.stop]
        return Response(content, status, {**fields, "Content-Type": self.media_type})

    def large(self, pieces: AsyncGenerator[bytes], size: int | None, slots: Slots, held: int) -> Response:
        part = self.part_of(size)
        status, fields = self.framing(size, part)
        content = pieces if part is None else cut(pieces, part)
        return LargeAnswer(content, fields, self.media_type, slots, held, status)

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

    A GET with `Range` gets that part.

    With `job_id` it is kept for the next one who asks.

    Raises:
        LimitError: it is larger than a result may be.
        ProblemError: 406, no form is acceptable; 410, the result expired just now; 416, it has none of the
            bytes that are asked for.
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
    rest = made_in_threads(first, pieces, context.redis)
    return head.large(rest, forms[form].size(answer), context.large_answers, _HELD_OF_A_TABLE)


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
    return head.large(as_async(slices_of(body)), len(body), context.large_answers, len(body))


def _encoded(form: Form, document: Document) -> tuple[bytes, str]:
    body = form.encode(document)
    return body, hashlib.sha256(body).hexdigest()


def _check_size(limits: Limits, size: int) -> None:
    if size > limits.max_result_bytes:
        raise LimitError.exceeded(limits, "max_result_bytes", f"the result has {size} bytes")


def _digest(form: str, digest: str) -> str:
    return hashlib.sha256(f"{form} {digest}".encode()).hexdigest()
