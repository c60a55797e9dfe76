"""Content negotiation: the media type of a document, and its validators."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from service.api.problems import ProblemError, ProblemType
from service.api.table_forms import json_bytes, json_pieces, json_size
from worker.answers.stored_tables import StoredTable

Document = Mapping[str, Any]

JSON = "application/json"
CSV = "text/csv"
NDJSON = "application/x-ndjson"
SVG = "image/svg+xml"


def _no_pieces(_table: StoredTable) -> Iterator[bytes]:
    raise TypeError("only cusp tables are sent piece by piece")


def _no_size(_table: StoredTable) -> None:
    return None


@dataclass(frozen=True)
class Form:
    """The encoding of a document in one media type.

    Attributes:
        encode: returns a document in this form.
        description: in OpenAPI.
        pieces: yields a table that is read from the store in this form.
        size: returns the size of such a table in this form, if it is known beforehand.
        parameter: of the media type; distinguishes its forms.
    """

    encode: Callable[[Any], bytes]
    description: str = ""
    pieces: Callable[[StoredTable], Iterator[bytes]] = _no_pieces
    size: Callable[[StoredTable], int | None] = _no_size
    parameter: str = ""


Forms = Mapping[str, Form]
"""Media type → form of a document; the first is the default."""

JSON_FORM = Form(json_bytes, pieces=json_pieces, size=json_size)


def media_type_of(name: str, form: Form) -> str:
    """Returns the media type of a form, with its parameter."""
    return f"{name}; {form.parameter}" if form.parameter else name


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
