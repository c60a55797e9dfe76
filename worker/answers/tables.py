"""Cusp tables: each slice is computed, kept and counted separately."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import Generic, TypeVar

import rpr_solver
from worker.answers.requests import JobRequest, Kind
from worker.answers.single_flight import single_flight
from worker.answers.store import ResultStore, SliceJson
from worker.answers.stored_tables import in_groups

T = TypeVar("T")

log = logging.getLogger("rpr_cusps.worker")

KIND = Kind("cusp-table", "ct-", unit="slices", by_slices=True)

GROUP_SECONDS = 0.04
"""Seconds of work on slices that are kept together; so much, at most, is repeated if a work horse dies."""

GROUP_SLICES = 64

INTERNAL = "An unexpected error; the worker's log has the details."


def missing(request: JobRequest, store: ResultStore) -> Sequence[str]:
    """Returns the slices that are not known, and renews the lifetime of the known ones."""
    return look_up(request, store)[0]


def look_up(request: JobRequest, store: ResultStore) -> tuple[list[str], dict[str, SliceJson]]:
    """Returns the same, and the known errors of single slices by L1."""
    absent: list[str] = []
    errors: dict[str, SliceJson] = {}
    for group in in_groups(request.parts):
        slices = store.get_slices(request, group)
        store.renew_slices(request, slices)
        absent += [x for x in group if x not in slices]
        errors |= {x: value for x, value in slices.items() if "error" in value}
    return absent, errors


def eliminant_of(request: JobRequest, store: ResultStore) -> rpr_solver.Eliminant:
    """Returns the manipulator's eliminant from the store, or computes it, in one worker at a time."""

    def make() -> rpr_solver.Eliminant:
        eliminant = rpr_solver.eliminate(request.manipulator, request.fixed_leg)
        store.put_eliminant(request, eliminant)
        return eliminant

    return single_flight(lambda: store.get_eliminant(request), lambda: store.eliminant_lock(request), make)


class SliceSolver:
    """Solves slices of one table, one after the other.

    Args:
        eliminant: of its manipulator.
        request: the table.
        parts: the slices that will be asked for; together they cost less than one by one.
    """

    def __init__(self, eliminant: rpr_solver.Eliminant, request: JobRequest, parts: Iterable[str]) -> None:
        from rpr_solver.slices.answers import SliceAnswers  # a start is to be quick

        self._request = request
        self._answers = SliceAnswers(eliminant, map(Fraction, parts), request.digits)

    def __call__(self, l1: str) -> SliceJson:
        """Solve a slice. An error is reported in the slice's own entry; other slices are unaffected."""
        try:
            return self._answers(Fraction(l1))
        except MemoryError:
            raise
        except Exception:
            log.exception("slice l1=%s of %s failed", l1, self._request.geometry_hash)
            return error(self._request, l1, "internal-error", INTERNAL)


class Group(Generic[T]):
    """Slices that are solved and not kept yet: together they cost the store a fraction of one by one.

    Args:
        keep: keeps slices in the order in which they were added; gives False if the others are not wanted.
        one_by_one: whether each slice is kept as soon as it is solved.
    """

    def __init__(self, keep: Callable[[Sequence[T]], bool], *, one_by_one: bool = False) -> None:
        self._keep = keep
        self._most = 1 if one_by_one else GROUP_SLICES
        self._slices: list[T] = []
        self._began = time.monotonic()

    def add(self, value: T) -> bool:
        """Add a slice, and keep the group if it is large or old enough; False if no more are wanted."""
        self._slices.append(value)
        if len(self._slices) < self._most and time.monotonic() - self._began < GROUP_SECONDS:
            return True
        return self.close()

    def close(self) -> bool:
        """Keep what is left, and begin a new group; returns False if no more are wanted."""
        kept, self._slices = self._slices, []
        is_wanted = self._keep(kept) if kept else True
        self._began = time.monotonic()
        return is_wanted


def error(request: JobRequest, l1: str, kind: str, detail: str) -> SliceJson:
    """A slice that has no answer."""
    return rpr_solver.slice_error_json(Fraction(l1), request.fixed_leg, kind, detail)
