"""The forms of a cusp table that is read batch by batch. The bytes are those of the whole document."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import rpr_solver
from service.schemas.forms import SHARED, compact, ndjson_line
from worker.answers.stored_tables import StoredTable


def json_bytes(document: object) -> bytes:
    """Returns a document as compact JSON."""
    return compact(document).encode()


def ndjson_bytes(table: Mapping[str, Any]) -> bytes:
    """Returns the slices of a table, one JSON object per line, each with the head of the table."""
    return b"".join(ndjson_line(table, part).encode() for part in table["slices"])


def json_pieces(table: StoredTable) -> Iterator[bytes]:
    """Yields a table as compact JSON."""
    before = _json_start(table)
    for batch in table.batches():
        yield before + b",".join(batch)
        before = b","
    yield b"]}"


def json_size(table: StoredTable) -> int:
    """Returns the size of a table as compact JSON."""
    return len(_json_start(table)) + table.size + len(table.slices) - 1 + len(b"]}")


def ndjson_pieces(table: StoredTable) -> Iterator[bytes]:
    """Yields a table as lines of JSON."""
    start = _line_start(table)
    for batch in table.batches():
        yield b"".join(start + text[1:] + b"\n" for text in batch)


def ndjson_size(table: StoredTable) -> int:
    """Returns the size of a table as lines of JSON."""
    return table.size + len(table.slices) * len(_line_start(table))


def csv_pieces(table: StoredTable) -> Iterator[bytes]:
    """Yields a table as CSV."""
    for number, batch in enumerate(table.batches()):
        lines = rpr_solver.table_csv({**table.head, "slices": [json.loads(text) for text in batch]})
        yield (lines.partition("\n")[2] if number else lines).encode()


def _json_start(table: StoredTable) -> bytes:
    return json_bytes(table.head)[:-1] + b',"slices":['


def _line_start(table: StoredTable) -> bytes:
    return json_bytes({key: table.head[key] for key in SHARED})[:-1] + b","
