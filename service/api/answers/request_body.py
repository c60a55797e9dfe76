"""Request bodies: limited in size and type, and read as questions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from starlette.requests import Request

from service.api.problems import ProblemError, ProblemType
from service.schemas.document import JsonError, Source, parse_json, read
from service.schemas.limits import LimitError, Limits
from service.schemas.questions import Question
from worker.answers.requests import JobRequest

JSON_TYPES = "application/json"


async def read_body(request: Request, max_bytes: int) -> bytes:
    """Read the body of a request, for :func:`json_of` (which may be slow, so outside the event loop).

    Raises:
        ProblemError: 415 for another content type, 413 for a body over the limit.
    """
    media_type_of(request, (JSON_TYPES,))
    declared = request.headers.get("content-length", "")
    if declared.isascii() and declared.isdigit() and (len(declared) > 18 or int(declared) > max_bytes):
        raise too_large("max_body_bytes", max_bytes, f"{declared[:40]} bytes were announced")
    body = bytearray()
    async for piece in request.stream():
        body += piece
        if len(body) > max_bytes:
            raise too_large("max_body_bytes", max_bytes, f"more than {max_bytes} bytes were sent")
    return bytes(body)


def json_of(body: bytes, limits: Limits) -> object:
    """Returns the JSON of a body.

    Raises:
        LimitError: the body has too many members; this takes far less time than parsing them.
        ProblemError: 400, the body is not strict JSON.
    """
    # An upper bound, which the few strings of a request cannot move far.
    members = sum(body.count(mark) for mark in (b",", b"[", b"{"))
    if members > limits.max_body_members:
        raise LimitError.exceeded(
            limits, "max_body_members", f"the body has about {members} members and elements", "body"
        )
    try:
        return parse_json(body)
    except JsonError as error:
        raise ProblemError(
            ProblemType.INVALID_JSON, error.detail, errors=[(error.field, error.detail)], in_body=True
        ) from None


def media_type_of(request: Request, accepted: Sequence[str]) -> str:
    """Returns the media type of a body, one of those that are accepted.

    Raises:
        ProblemError: 415, it is another one, or encoded.
    """
    sent = request.headers.get("content-type")
    media_type = (sent or "").partition(";")[0].strip().lower()
    if media_type.startswith("application/") and media_type.endswith("+json"):
        media_type = JSON_TYPES
    if media_type not in accepted:
        what = "has no Content-Type" if sent is None else f"is sent as {sent[:100]!r}"
        raise ProblemError(
            ProblemType.UNSUPPORTED_MEDIA_TYPE,
            f"The body {what}; send it as {' or '.join(accepted)}.",
            headers={"Accept-Post": ", ".join(accepted)},
        )
    encoding = request.headers.get("content-encoding", "identity").strip().lower()
    if encoding not in ("", "identity"):
        raise ProblemError(
            ProblemType.UNSUPPORTED_MEDIA_TYPE,
            f"The body is sent with Content-Encoding {encoding[:100]!r}; send it without one.",
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
    """A question, its deadline in seconds, and its callback URL."""

    request: JobRequest
    deadline_s: float | None
    callback_url: str | None = None


def asked_of(model: type[Question], document: object, limits: Limits) -> Asked:
    """Returns the question that a document asks.

    Raises:
        InputError: it asks none.
    """
    question = read(model, document, Source(limits))
    return Asked(question.job_request(), question.deadline_s, question.callback_url)


def question_in(model: type[Question], body: bytes, limits: Limits) -> Asked:
    """Returns the question that a body asks; may be slow, so outside the event loop.

    Raises:
        InputError: it asks none.
        ProblemError: it is not strict JSON.
    """
    return asked_of(model, json_of(body, limits), limits)
