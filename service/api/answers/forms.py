"""The forms of a document: how each is written, and which one a request gets, by Accept or by its query."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from starlette.requests import Request

from service.api.problems import ProblemError, ProblemType
from service.schemas.answers import FORMATS, JSON, Form, Forms, json_bytes
from worker.answers.stored_tables import StoredTable


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


NUMBERS = ("text", "float")

IN_FLOATS = "InFloats"
"""What the names of schemas of documents with JSON numbers end with."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,9})?|[+-]?\d+/\d+", re.ASCII)
NO_NUMBERS = frozenset({"solver_version", "geometry_hash", "certificate", "audit"})
"""The members in which text stays."""


@dataclass(frozen=True)
class Choice:
    """The forms that are left, what the client accepts of them, and the query that says so."""

    forms: Forms
    accept: Sequence[str]
    query: str = ""


def format_names(forms: Forms) -> tuple[str, ...]:
    """Returns the names of forms, as `format` gives them."""
    return tuple(name for name, media in FORMATS.items() if media in forms)


def choice_of(request: Request, forms: Forms) -> Choice:
    """Returns what `format`, `numbers` and Accept leave of the forms of an answer.

    Raises:
        ProblemError: 422, a value is not known.
    """
    numbers = one_of(request, "numbers", NUMBERS)
    chosen = {**forms, JSON: FLOATS} if numbers == "float" else forms
    name = one_of(request, "format", format_names(forms))
    said = [("format", name), ("numbers", "float" if numbers == "float" else None)]
    query = "&".join(f"{key}={value}" for key, value in said if value is not None)
    query = f"?{query}" if query else ""
    if name is None:
        return Choice(chosen, request.headers.getlist("accept"), query)
    media = FORMATS[name]
    return Choice({media: chosen[media]}, (), query)


def floats(value: Any) -> Any:
    """Returns a document with JSON numbers, rounded to double precision, in place of exact text.

    A number beyond the range of double precision stays text, and so do proofs.

    >>> floats({"l1": "426/25", "kind": "node", "alpha_deg": "-1e400"})
    {'l1': 17.04, 'kind': 'node', 'alpha_deg': '-1e400'}
    """
    if isinstance(value, dict):
        return {key: item if key in NO_NUMBERS else floats(item) for key, item in value.items()}
    if isinstance(value, list):
        return [floats(item) for item in value]
    if not isinstance(value, str) or not _NUMBER.fullmatch(value):
        return value
    try:
        number = float(Fraction(value)) if "/" in value else float(value)
    except (OverflowError, ZeroDivisionError):
        return value
    return number if abs(number) != float("inf") else value


def _float_pieces(table: StoredTable) -> Iterator[bytes]:
    before = json_bytes(floats(table.head))[:-1] + b',"slices":['
    for batch in table.batches():
        yield before + b",".join(json_bytes(floats(json.loads(text))) for text in batch)
        before = b","
    yield b"]}"


FLOATS = Form(
    lambda document: json_bytes(floats(document)),
    "The same document with JSON numbers instead of texts, rounded to double precision. Numbers in proofs, "
    "and numbers that a double cannot hold, remain texts.",
    pieces=_float_pieces,
    parameter="numbers=float",
)
"""JSON with numbers in place of text."""


def one_of(request: Request, name: str, known: Sequence[str]) -> str | None:
    """Returns the value of a parameter of a query, or None.

    Raises:
        ProblemError: 422, it is not one of these.
    """
    value = request.query_params.get(name)
    if value is None or value in known:
        return value
    message = f"is {value[:40]!r}; it must be one of {', '.join(known)}"
    raise ProblemError(ProblemType.INVALID_REQUEST, f"{name}: {message}", errors=[(name, message)])
