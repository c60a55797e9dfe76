"""The form of an answer that a query asks for: `format` and `numbers`, beside Accept."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from starlette.requests import Request

from service.api.negotiation import CSV, JSON, NDJSON, SVG, Form, Forms
from service.api.problems import ProblemError, ProblemType
from service.api.table_forms import json_bytes
from worker.answers.stored_tables import StoredTable

FORMATS = {"json": JSON, "csv": CSV, "ndjson": NDJSON, "svg": SVG}
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
    "The same document with JSON numbers in place of text, rounded to double precision. Text is left in "
    "proofs, and where a number is beyond that.",
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
