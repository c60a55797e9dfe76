"""Content negotiation: the media type of a document, and its validators."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from service.api.problems import ProblemError, ProblemType

Document = Mapping[str, Any]

JSON = "application/json"
CSV = "text/csv"
NDJSON = "application/x-ndjson"
IMMUTABLE = "public, max-age=31536000, immutable"
REVALIDATE = "no-cache"


def json_bytes(document: object) -> bytes:
    """Returns a document as compact JSON."""
    return json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode()


def ndjson_bytes(table: Document) -> bytes:
    """Returns the slices of a table, one JSON object per line, each with the head of the table."""
    shared = {
        key: table[key] for key in ("geometry_hash", "fixed_leg", "digits", "solver_version") if key in table
    }
    return b"".join(json_bytes({**shared, **part}) + b"\n" for part in table["slices"])


@dataclass(frozen=True)
class Form:
    """The encoding of a document in one media type, and its description in OpenAPI."""

    encode: Callable[[Any], bytes]
    description: str = ""


Forms = Mapping[str, Form]
"""Media type → form of a document; the first is the default."""

JSON_FORM = Form(json_bytes)


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
            f"Accept {', '.join(accept)[:200]!r} matches none of {', '.join(offered)}.",
        )
    return best


def document_response(
    request: Request,
    document: Document,
    forms: Forms,
    *,
    headers: Mapping[str, str] | None = None,
) -> Response:
    """Returns a document in the negotiated form with a strong ETag, or 304 if the client has it already.

    Documents never change, except that a slice with an error may have an answer next time.
    """
    form = negotiate(request.headers.getlist("accept"), tuple(forms))
    body = forms[form].encode(document)
    tag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
    has_errors = any("error" in part for part in document.get("slices", ()))
    fields = {
        "ETag": tag,
        "Cache-Control": REVALIDATE if has_errors else IMMUTABLE,
        "Vary": "Accept",
        **(headers or {}),
    }
    if request.method == "GET" and _is_known(request.headers.getlist("if-none-match"), tag):
        return Response(status_code=304, headers=fields)
    if form == CSV:
        return Response(body, headers={**fields, "Content-Type": "text/csv; charset=utf-8; header=present"})
    return Response(body, headers=fields, media_type=form)


def _is_known(headers: Sequence[str], tag: str) -> bool:
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
