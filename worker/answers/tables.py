"""Cusp tables, whose slices are computed, kept and counted separately; by the article's algorithm, in one
piece. The slices of a complete table in the store are read in batches as JSON text,
never all at once."""

from __future__ import annotations

import hashlib
import json
import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import rpr_solver
from rpr_solver.contract import Progress, document_head
from rpr_solver.exact.rationals import exact_str
from worker.answers.cost import Sizes, elimination, one_slice
from worker.answers.kind import HELD_SLICES, Content, Document, JobRequest, Kind, SliceJson, Store, in_groups
from worker.answers.layout import Measured, dump, measured

if TYPE_CHECKING:  # the command line keeps nothing
    from worker.answers.store import ResultStore

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
        return document_head(self.request, self.request.digits, self.request.fixed_leg)

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
    for digits in () if len(found) == len(request.parts) else store.more_digits(request):
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


T = TypeVar("T")
Solve = Callable[[str], SliceJson]

log = logging.getLogger("rpr_cusps.worker")

GROUP_SECONDS = 0.04
"""Seconds of work on slices that are kept together: the most that is repeated if a work horse dies."""

GROUP_SLICES = 64

METHODS = ("fast", "article")
"""How slices are solved; the first is the usual."""

INTERNAL = "An unexpected error; the worker's log has the details."


def solved(
    request: JobRequest,
    store: Store,
    parts: Sequence[str] | None = None,
    *,
    eliminant: Callable[[], rpr_solver.Eliminant] | None = None,
    during: Callable[[str], AbstractContextManager[object]] = nullcontext,
) -> Iterator[SliceJson]:
    """Yields slices of a table in turn, the known ones and those that are solved; in the place of an answer
    there may be an error, which leaves the other slices unaffected.

    Args:
        request: the table.
        store: where slices are looked up.
        parts: the lengths; all of them if missing.
        eliminant: gives that of the manipulator, once it is needed.
        during: what is entered while a slice is solved.
    """
    solve: Solve | None = None
    parts = request.content["l1"] if parts is None else parts
    for some in in_groups(parts):
        known = store.get_slices(request, some) if request.kind.by_slices else {}
        for l1 in some:
            if l1 in known:
                yield known[l1]
                continue
            if solve is None:
                solve = slice_solver(
                    request, parts, eliminant or (lambda: store.eliminant(request, len(parts)))
                )
            with during(l1):
                value = solve(l1)
            yield value


def slice_solver(
    request: JobRequest, parts: Sequence[str], eliminant: Callable[[], rpr_solver.Eliminant]
) -> Solve:
    """Returns what solves slices of one table; together those of `parts` cost less than one by one."""
    if request.kind is ARTICLE_TABLE:
        return lambda l1: _by_article(request, [l1])["slices"][0]
    from rpr_solver.slices.cusp_table import SliceAnswers  # a start is to be quick

    answers = SliceAnswers(eliminant(), map(Fraction, parts), request.digits)

    def solve(l1: str) -> SliceJson:
        try:
            return answers(Fraction(l1))
        except Exception as error:
            if isinstance(error, MemoryError) or not request.kind.by_slices:
                raise
            log.exception("slice l1=%s of %s failed", l1, request.geometry_hash)
            return slice_error(request, l1, "internal-error", INTERNAL)

    return solve


def content(
    manipulator: rpr_solver.Manipulator, digits: int, lengths: Iterable[Fraction], fixed_leg: int | None
) -> Content:
    """The canonical form of a question: each length once. The article's method names no leg."""
    leg = {} if fixed_leg is None else {"fixed_leg": fixed_leg}
    slices = list(dict.fromkeys(map(exact_str, lengths)))
    return {"geometry": manipulator.to_json(), **leg, "digits": digits, "l1": slices}


def head(request: JobRequest) -> Document:
    """Returns the members of a table beside its slices."""
    if request.kind is ARTICLE_TABLE:
        return _by_article(request, [])
    return document_head(request, request.digits, request.fixed_leg)


def compute(request: JobRequest, store: Store, progress: Progress) -> Document:
    """Compute a table in one piece."""
    count = len(request.content["l1"])
    progress(0, count)
    slices = []
    for value in solved(request, store):
        slices.append(value)
        progress(len(slices), count)
    return {**head(request), "slices": slices}


def _by_article(request: JobRequest, l1: Sequence[str]) -> Document:
    from rpr_solver.article import article_document  # by those who compute: a service starts sooner

    return article_document(request.manipulator, [Fraction(x) for x in l1], request.digits)


def slice_error(request: JobRequest, l1: str, kind: str, detail: str) -> SliceJson:
    """A slice that has no answer."""
    return rpr_solver.slice_error_json(Fraction(l1), request.fixed_leg, kind, detail)


def look_up(request: JobRequest, store: ResultStore) -> tuple[list[str], dict[str, SliceJson]]:
    """Returns the slices that are not known, and the known errors of single slices by L1; renews the lifetime
    of the known ones."""
    absent: list[str] = []
    errors: dict[str, SliceJson] = {}
    for group in in_groups(request.parts):
        slices = store.get_slices(request, group)
        store.renew_slices(request, slices)
        absent += [x for x in group if x not in slices]
        errors |= {x: value for x, value in slices.items() if "error" in value}
    return absent, errors


class Group(Generic[T]):
    """Slices or items that are done and not kept yet: together they cost the store a fraction of one by one.

    Args:
        keep: keeps slices in the order in which they were added; gives False if the others are not wanted.
        one_by_one: whether each slice is stored as soon as it is solved.
        seconds: the work on those that are kept together.
    """

    def __init__(
        self,
        keep: Callable[[Sequence[T]], bool],
        *,
        one_by_one: bool = False,
        seconds: float = GROUP_SECONDS,
    ) -> None:
        self._keep = keep
        self._seconds = seconds
        self._most = 1 if one_by_one else GROUP_SLICES
        self._slices: list[T] = []
        self._began = time.monotonic()

    def add(self, value: T) -> bool:
        """Add a slice, and keep the group if it is large or old enough; False if no more are wanted."""
        self._slices.append(value)
        if len(self._slices) < self._most and time.monotonic() - self._began < self._seconds:
            return True
        return self.close()

    def close(self) -> bool:
        """Keep what is left, and begin a new group; returns False if no more are wanted."""
        kept, self._slices = self._slices, []
        is_wanted = self._keep(kept) if kept else True
        self._began = time.monotonic()
        return is_wanted


def _audit_of_each(size: Sizes) -> float:
    bits = size.geometry + size.lengths
    return (0.1 + 0.8 * size.is_special + 0.015 * bits + 0.0006 * bits**2) * size.count


CUSP_TABLE = Kind("cusp-table", "ct-", compute, one_slice, once=elimination, unit="slices", by_slices=True)
ARTICLE_TABLE = Kind(
    "article-table", "at-", compute, _audit_of_each, unit="slices", implied=("method", METHODS[1])
)
