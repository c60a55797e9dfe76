"""Complete cusp tables in the store, whose slices are read in batches as JSON text, never all at once."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import rpr_solver
from rpr_solver.contract import document_head
from worker.answers import HELD_SLICES, JobRequest
from worker.answers.layout import Measured, measured
from worker.answers.store import ResultStore, dump

BATCH_BYTES = 256 << 10
"""The size of a batch; only a batch of one slice may be larger."""

_FEW = 8  # up to this number, slices are read at once instead of measured first
_FEW_DIGITS = 50  # of the slices of several tables that are held at once


class ResultLostError(Exception):
    """A result expired, or changed, while it was being read."""


@dataclass(frozen=True)
class StoredSlice:
    """A slice in the store.

    Attributes:
        l1: its length.
        measured: the size and the digest of its JSON.
        digits: with how many digits it is stored; it is shortened if the table has fewer.
        text: its JSON, if it is at hand.
    """

    l1: str
    measured: Measured
    digits: int
    text: bytes | None = None


@dataclass(frozen=True)
class StoredTable:
    """A table whose slices are all known."""

    request: JobRequest
    slices: tuple[StoredSlice, ...]
    store: ResultStore

    @property
    def head(self) -> dict[str, Any]:
        """The members of the document before the slices."""
        head = document_head(self.request, self.request.digits, self.request.fixed_leg)
        return {**head, "solver_version": self.request.version}

    @cached_property
    def size(self) -> int:
        """The bytes of all slices."""
        return sum(part.measured.size for part in self.slices)

    @property
    def has_errors(self) -> bool:
        """Whether a slice has an error in place of an answer."""
        return any(part.measured.is_error for part in self.slices)

    @property
    def is_at_hand(self) -> bool:
        """Whether every slice was read already."""
        return all(part.text is not None for part in self.slices)

    @cached_property
    def digest(self) -> str:
        """A digest of the content: equal digests are equal documents, byte for byte."""
        content = [self.head, [part.measured.digest for part in self.slices]]
        return hashlib.sha256(dump(content).encode()).hexdigest()

    def batches(self) -> Iterator[list[bytes]]:
        """Yields the JSON of the slices in their order.

        Raises:
            ResultLostError: a slice expired or changed since the table was looked up.
        """
        for batch in self._batches():
            texts = {part.l1: part.text for part in batch}
            for digits in {part.digits for part in batch if part.text is None}:
                absent = [part.l1 for part in batch if part.text is None and part.digits == digits]
                found = self.store.get_texts(self.request, absent, digits)
                texts |= _at_digits(found, digits, self.request.digits)
            yield [_unchanged(part, texts.get(part.l1)) for part in batch]

    def document(self) -> dict[str, Any]:
        """Returns the whole document.

        Raises:
            ResultLostError: a slice expired or changed since the table was looked up.
        """
        return {**self.head, "slices": [json.loads(text) for batch in self.batches() for text in batch]}

    def _batches(self) -> Iterator[list[StoredSlice]]:
        batch: list[StoredSlice] = []
        size = 0
        for part in self.slices:
            if batch and (size + part.measured.size > BATCH_BYTES or len(batch) == HELD_SLICES):
                yield batch
                batch, size = [], 0
            batch.append(part)
            size += part.measured.size
        yield batch


def stored_table(
    request: JobRequest, store: ResultStore, errors: Mapping[str, Any] | None = None
) -> StoredTable | None:
    """Returns the table if every slice is known, or has an error of the job, else None."""
    found: dict[str, StoredSlice] = {}
    for l1, error in (errors or {}).items():
        text = dump(error).encode()
        found[l1] = StoredSlice(l1, measured(text), request.digits, text)
    absent = [l1 for l1 in request.parts if l1 not in found]
    found |= _known(request, store, absent)
    is_complete = len(found) == len(request.parts) or request.version != rpr_solver.SOLVER_VERSION
    longer = iter([]) if is_complete else iter(store.more_digits(request))
    for digits in longer:
        absent = [l1 for l1 in request.parts if l1 not in found]
        found |= _shortened(request, store, absent, digits)
        if len(found) == len(request.parts):
            break
    if any(l1 not in found for l1 in request.parts):
        return None
    return StoredTable(request, tuple(found[l1] for l1 in request.parts), store)


def tables_at_hand(requests: Sequence[JobRequest], store: ResultStore) -> list[StoredTable | None]:
    """Returns those of several tables that are short and stored just as they are asked for, read at once."""
    are_short = [len(r.parts) <= _FEW and r.digits <= _FEW_DIGITS for r in requests]
    short = [request for request, is_short in zip(requests, are_short, strict=True) if is_short]
    found = iter(
        StoredTable(request, tuple(_at_hand(request, texts)), store)
        if len(texts) == len(request.parts)
        else None
        for request, texts in zip(short, store.get_all_texts(short), strict=True)
    )
    return [next(found) if is_short else None for is_short in are_short]


def _at_hand(request: JobRequest, texts: Mapping[str, bytes]) -> Sequence[StoredSlice]:
    return [StoredSlice(x, measured(text), request.digits, text) for x, text in texts.items()]


def _known(request: JobRequest, store: ResultStore, l1: Sequence[str]) -> dict[str, StoredSlice]:
    if len(l1) <= _FEW:
        return {part.l1: part for part in _at_hand(request, store.get_texts(request, l1, request.digits))}
    sizes = store.measure(request, l1)
    return {x: StoredSlice(x, size, request.digits) for x, size in sizes.items()}


def _shortened(
    request: JobRequest, store: ResultStore, l1: Sequence[str], digits: int
) -> dict[str, StoredSlice]:
    """The slices that are stored with more digits, if those suffice."""
    found: dict[str, StoredSlice] = {}
    for first in range(0, len(l1), _FEW):
        texts = store.get_texts(request, l1[first : first + _FEW], digits)
        for x, text in _at_digits(texts, digits, request.digits).items():
            found[x] = StoredSlice(x, measured(text), digits)
    return found


def _at_digits(texts: Mapping[str, bytes], have: int, digits: int) -> dict[str, bytes]:
    if have == digits:
        return dict(texts)
    values = {l1: json.loads(text) for l1, text in texts.items()}
    short = {
        l1: rpr_solver.shorten_slice(value, have, digits)
        for l1, value in values.items()
        if "error" not in value
    }
    return {l1: dump(value).encode() for l1, value in short.items() if value is not None}


def _unchanged(part: StoredSlice, text: bytes | None) -> bytes:
    if text is None or (text is not part.text and measured(text) != part.measured):
        raise ResultLostError(f"the slice {part.l1} expired while its table was being sent")
    return text
