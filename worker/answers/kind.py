"""A request for a document in canonical form, the ids derived from it, the kinds of documents, and the one
way to an answer, with a store that keeps nothing."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeVar

import rpr_solver
from rpr_solver import SOLVER_VERSION, Manipulator
from rpr_solver.contract import Progress, silent
from rpr_solver.triangles import Canonical, Points, hash_of_canonical, identity_json, read_geometry
from worker.answers.cost import Cost, Sizes, fewer_parts, sizes_of

Content = Mapping[str, Any]
Document = dict[str, Any]
SliceJson = dict[str, Any]
T = TypeVar("T")

HELD_SLICES = 64
"""The number of slices that are held at once."""

_FIRST_PAUSE, _LONGEST_PAUSE = 0.005, 0.05
_CHEAP = 0.02  # seconds; what takes less may be computed twice, since a lock and a second look cost as much
_HASH = "content_hash"


class Kept(Document):
    """A document with the text by which it is kept, which is not written again; so it is never changed."""

    def __init__(self, text: bytes) -> None:
        super().__init__(json.loads(text))
        self.text = text


class Store:
    """A store that keeps nothing, so that every answer is computed; `ResultStore` is the one in Redis.

    Attributes:
        keeps: whether it is worth while to compute more than is asked for.
    """

    keeps = False

    def get_document(self, request: JobRequest) -> Document | None:
        """Returns a document that was computed in one piece, or None if it is not known."""
        return self.get_documents([request])[0]

    def get_documents(self, requests: Sequence[JobRequest]) -> list[Document | None]:
        """Returns the same for several requests, at once."""
        return [None] * len(requests)

    def put_document(self, request: JobRequest, document: Document) -> None:
        """Keep a document, the first of several."""

    def document(self, request: JobRequest, compute: Callable[[], Document]) -> Document:
        """Returns a document from the store, or computes and keeps it; only one worker at a time does so."""
        del request
        return compute()

    def answer_lock(self, request: JobRequest) -> AbstractContextManager[bool]:
        """Try to lock the answer to a question; gives False if another worker holds the lock."""
        del request
        return nullcontext(enter_result=True)

    def eliminant(self, request: JobRequest, slices: int = 1) -> rpr_solver.Eliminant:
        """Returns the manipulator's eliminant for a number of slices.

        It is computed in one worker at a time and stored, unless its coefficients are not worth their cost.
        """
        del slices
        return rpr_solver.eliminate(request.manipulator, request.fixed_leg)

    def note_census(self, family: JobRequest, digits: int) -> None:
        """Note that a census of this family is known with this number of digits."""

    def census_digits(self, family: JobRequest) -> list[int]:
        """Returns the numbers of digits of the kept censuses of this family, ascending."""
        del family
        return []

    def get_slices(self, request: JobRequest, l1: Sequence[str] | None = None) -> dict[str, SliceJson]:
        """Returns the known slices of a request (or those of `l1`), by L1."""
        del request, l1
        return {}


def _nothing(_request: JobRequest, _store: Store) -> Document | None:
    return None


def _as_measured(_content: Content, sizes: Sizes) -> Sizes:
    return sizes


def _none(_sizes: Sizes) -> float:
    return 0.0


@dataclass(frozen=True)
class Kind:
    """A kind of document: how it is computed, what that costs, and how its jobs are named and counted.

    Attributes:
        name: the name in jobs and their records.
        prefix: the prefix of job ids.
        compute: computes the document in one piece, and may keep others.
        cost: the estimated seconds of one core for each part.
        once: those that a job needs once for all its parts.
        derive: cuts the document from others that are kept, or returns None.
        measure: corrects the sizes of a question, see `worker.answers.cost`.
        fewer: the members of a question that can be reduced if it costs too much, beside those that all have:
            each with the sizes at best and what to do.
        unit: the unit of its jobs' progress.
        implied: members of the question that an item of this kind need not give; they distinguish it from
            other kinds that answer the same question.
        by_slices: whether each slice is computed, kept and counted separately.
        by_items: whether a job consists of questions of its own, as a batch does.
        shares: the number of chunks that compute a document together, if it is computed in one piece. All run
            `compute`, and share what they keep in the store; the first that is done ends the job.
    """

    name: str
    prefix: str
    compute: Callable[[JobRequest, Store, Progress], Document]
    cost: Callable[[Sizes], float]
    once: Callable[[Sizes], float] = _none
    derive: Callable[[JobRequest, Store], Document | None] = _nothing
    measure: Callable[[Content, Sizes], Sizes] = _as_measured
    fewer: Callable[[Content, Sizes], Mapping[str, tuple[Sizes, str]]] = fewer_parts
    unit: str = "steps"
    implied: tuple[str, str] | None = None
    by_slices: bool = False
    by_items: bool = False
    shares: int = 1

    @property
    def is_derived(self) -> bool:
        """Whether its documents can be put together from others that are kept, slices included."""
        return self.by_slices or self.by_items or self.derive is not _nothing

    def parts(self, content: Content) -> Sequence[str]:
        """Returns what is computed and counted separately: the slices, the positions of the items, or only
        the whole document."""
        if self.by_items:
            return [str(index) for index in range(content["count"])]
        parts: Sequence[str] = content["l1"] if self.by_slices else (self.name,) * self.shares
        return parts

    def cost_of(self, size: Sizes) -> Cost:
        """Returns the estimated cost of a question of these sizes."""
        return Cost(self.once(size), self.cost(size), size.count if self.by_slices else self.shares)


@dataclass(frozen=True)
class JobRequest:
    """A request for a document, which a job computes.

    `content` is canonical plain JSON, so equal questions are equal requests with one id. Of a request that is
    `cut`, the content has the hash alone, by which the answer is found. `points`: those by which triangles
    were given whose coordinates are not found from their sides; they are no part of the question, and no
    answer depends on them.
    """

    kind: Kind
    content: Content
    points: Points = field(default_factory=dict, compare=False)

    @property
    def geometry(self) -> Canonical:
        """The manipulator, with each number as canonical text."""
        geometry: Canonical = self.content["geometry"]
        return geometry

    @cached_property
    def geometry_hash(self) -> str:
        """The hash of the manipulator."""
        return hash_of_canonical(self.geometry)

    def identity_json(self) -> dict[str, object]:
        """Returns the geometry, its hash, and special shapes near it, as in the head of a document."""
        return identity_json(self.geometry, self.geometry_hash)

    @cached_property
    def manipulator(self) -> Manipulator:
        """The manipulator, for a computation; known answers do not need it."""
        geometry = read_geometry(self.geometry, max_digits=1 << 20)
        return Manipulator.of(geometry.with_points(self.points))

    @property
    def as_given(self) -> Manipulator:
        """The same, with the points in whose frame poses are told."""
        return Manipulator.of(self.manipulator.geometry.with_points(self.content.get("points", {})))

    @property
    def fixed_leg(self) -> int:
        """The leg with the fixed length."""
        return int(self.content["fixed_leg"])

    @property
    def digits(self) -> int:
        """Significant digits of the answer."""
        return int(self.content["digits"])

    @property
    def parts(self) -> Sequence[str]:
        """The parts that are computed and counted separately."""
        return self.kind.parts(self.content)

    @cached_property
    def sizes(self) -> Sizes:
        """The sizes that decide what the answer costs, taken once from the question."""
        return self.kind.measure(self.content, sizes_of(self.content, lambda: self.manipulator))

    @cached_property
    def cost(self) -> Cost:
        """The estimated cost of the answer."""
        return self.kind.cost_of(self.sizes)

    def of_slices(self, l1: Sequence[str]) -> JobRequest:
        """Returns the question for other slices of the same table."""
        return replace(self, content={**self.content, "l1": list(l1)})

    @cached_property
    def content_hash(self) -> str:
        """The hash of the question and the solver's version."""
        if self.is_cut:
            return str(self.content[_HASH])
        question: list[object] = [self.kind.name, self.content]
        if self.kind.by_slices:
            question = [self.geometry_hash, self.fixed_leg, self.digits, self.parts]
        elif self.kind.by_items:  # known before its items are
            question = [self.kind.name, self.content["batch"]]
        return hashlib.sha256(json.dumps([SOLVER_VERSION, *question], sort_keys=True).encode()).hexdigest()

    @property
    def is_cut(self) -> bool:
        """Whether only the hash of the question is left."""
        return _HASH in self.content

    def cut(self) -> JobRequest:
        """Returns the same without the question."""
        return replace(self, content={_HASH: self.content_hash}, points={})

    @property
    def job_id(self) -> str:
        """The id of the job that computes this document."""
        return self.kind.prefix + self.content_hash[:40]

    def to_json(self) -> str:
        """Returns the request as text for the job's record."""
        return json.dumps(self.record(), separators=(",", ":"))

    def record(self) -> dict[str, Any]:
        """Returns the kind, the content, and points if there are any."""
        points = {"points": self.points} if self.points else {}
        return {"kind": self.kind.name, "content": self.content, **points}


ALL_LENGTHS: Mapping[str, str | None] = {"from": "0", "to": None}
"""The unbounded range in a request's content."""


def content_range(content: Content) -> tuple[Fraction, Fraction | None]:
    """Returns the range in a request's content."""
    start, stop = content["range"]["from"], content["range"]["to"]
    return Fraction(start), None if stop is None else Fraction(stop)


def in_groups(items: Sequence[T], size: int = HELD_SLICES) -> Iterable[Sequence[T]]:
    """Yields the items in groups, by default small enough to be held at once."""
    return (items[first : first + size] for first in range(0, len(items), size))


def known_document(request: JobRequest, store: Store) -> Document | None:
    """Returns a document in one piece if it is in the store or follows from stored documents, else None."""
    return store.get_document(request) or request.kind.derive(request, store)


def answer(
    request: JobRequest,
    store: Store,
    progress: Progress = silent,
    keep: Callable[[JobRequest, Document], object] | None = None,
    *,
    is_unknown: bool = False,
) -> Document:
    """Returns a document in one piece: the known one, or it is computed, in one worker at a time.

    `keep` keeps it, by default in the store. `is_unknown`: it was not known a moment ago.

    Raises:
        InputError: the question has no answer.
        SolverError: it could not be decided.
    """

    def kept(document: Document) -> Document:
        (keep or store.put_document)(request, document)
        return document

    if is_unknown and request.cost.whole < _CHEAP:
        return kept(request.kind.compute(request, store, progress))

    def known() -> Document | None:
        document = known_document(request, store)
        return None if document is None else kept(document)

    return single_flight(
        known,
        lambda: store.answer_lock(request),
        lambda: kept(request.kind.compute(request, store, progress)),
        is_unknown=is_unknown,
    )


def in_turn(progress: Progress) -> tuple[Progress, Progress]:
    """Returns the progress of two stages, of which the second goes on where the first has ended."""
    steps = 0

    def first(done: int, total: int) -> None:
        nonlocal steps
        steps = total
        progress(done, total)

    return first, lambda done, total: progress(steps + done, steps + total)


def single_flight(
    known: Callable[[], T | None],
    lock: Callable[[], AbstractContextManager[bool]],
    make: Callable[[], T],
    *,
    is_unknown: bool = False,
) -> T:
    """Returns the known result, or makes it, or waits for the worker that holds the lock.

    `make` must keep its result, so that `known` returns it afterwards. `is_unknown`: there was none a moment
    ago, so that it is not looked for before the lock is held.
    """
    pause = _FIRST_PAUSE
    while True:
        result = None if is_unknown else known()
        if result is not None:
            return result
        is_unknown = False
        with lock() as held:
            if held:
                result = known()  # made between the look and the lock?
                return make() if result is None else result
        time.sleep(pause)
        pause = min(2 * pause, _LONGEST_PAUSE)
