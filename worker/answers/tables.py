"""Cusp tables, whose slices are computed, kept and counted separately; by the article's algorithm and with
full certificates, in one piece."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction
from typing import TYPE_CHECKING, Generic, TypeVar

import rpr_solver
from rpr_solver.contract import FULL, SHORT, Progress, document_head
from rpr_solver.exact.rationals import exact_str
from worker.answers import Content, Document, JobRequest, Kind, SliceJson, Store, in_groups
from worker.answers.cost import Sizes, elimination, one_slice

if TYPE_CHECKING:  # the command line keeps nothing
    from worker.answers.store import ResultStore

T = TypeVar("T")
Solve = Callable[[str], SliceJson]

log = logging.getLogger("rpr_cusps.worker")

GROUP_SECONDS = 0.04
"""Seconds of work on slices that are kept together; so much, at most, is repeated if a work horse dies."""

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

    certificate = FULL if request.kind is CERTIFIED_TABLE else SHORT
    answers = SliceAnswers(eliminant(), map(Fraction, parts), request.digits, certificate)

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
CERTIFIED_TABLE = Kind(
    "certified-table",
    "cf-",
    compute,
    lambda size: elimination(size) + 2 * one_slice(size) * size.count,
    unit="slices",
    implied=("certificate", FULL),
)
