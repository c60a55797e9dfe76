"""The same question has the same answer, byte for byte, whatever was asked before."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from random import Random
from typing import Any

import pytest
from redis import Redis

from rpr_solver import InputError, SolverError
from service.api.batches.rows import read_item
from service.schemas.limits import Limits
from tests.support import same_answers
from worker.answers.kind import JobRequest, Store, answer
from worker.answers.kinds import ItemSolver, known_answer
from worker.answers.layout import dump
from worker.answers.store import ResultStore
from worker.answers.tables import StoredTable, compute
from worker.settings import WorkerSettings

KINDS = {
    "cusp-tables": ("cusp-table", 12),
    "poses": ("poses", 3),
    "censuses": ("census", 6),
    "checks": ("check", 3),
    "cusp-curves": ("cusp-curves", 2),
    "singular-curves": ("singular-curves", 1),
    "assembly-modes": ("assembly-modes", 1),
    "pose-connections": ("pose-connections", 1),
    "paths": ("path", 1),
    "plots": ("plot", 1),
    "margins": ("margin", 1),
    "aspects": ("aspects", 1),
    "workspaces": ("workspace", 1),
    "designs": ("design", 0.3),
}
"""Path of the operation → the kind of an item, and how often it is asked here."""
CHEAP = ("cusp-tables", "poses")
LENGTHS = ("3", "14.98", "26.5", "27", "100/7")
GEOMETRIES = 6


def questions(count: int, seed: int, kinds: tuple[str, ...]) -> Iterator[JobRequest]:
    """Random questions about few manipulators, so that answers are put together from those of others."""
    rng = Random(seed)
    pool = [same_answers.geometry(rng) for _ in range(GEOMETRIES)]
    weights = [KINDS[kind][1] for kind in kinds]
    while count:
        path, of = rng.choices(kinds, weights)[0], rng.choice(pool)
        body = same_answers.QUESTIONS[path][1](rng, of)
        if path == "cusp-tables":
            leg = f"l{body['fixed_leg']}"
            body |= {leg: rng.sample(LENGTHS, rng.randint(1, 4)), "digits": rng.choice((15, 16, 25, 40))}
        item = {"kind": KINDS[path][0], "request": {"geometry": of, **body}}
        request = read_item(json.dumps(item).encode(), 0, Limits()).request
        if request is not None:
            count -= 1
            yield request


def kept(request: JobRequest, store: ResultStore) -> bytes:
    """The answer of a service: computed by a worker, kept, and read from the store."""
    solver = ItemSolver(store, [request])
    try:
        outcome = solver.solve(request)
        solver.keep()
    except (InputError, SolverError) as error:
        return f"{type(error).__name__} {error}".encode()
    found = known_answer(request, store, outcome.slices)
    return dump(found.document() if isinstance(found, StoredTable) else found).encode()


def alone(request: JobRequest) -> bytes:
    """The answer where nothing is known."""
    try:
        document: Any = compute(request, Store(), lambda *_: None) if request.kind.by_slices else None
        return dump(document or answer(request, Store())).encode()
    except (InputError, SolverError) as error:
        return f"{type(error).__name__} {error}".encode()


@pytest.mark.parametrize(
    ("count", "seed", "kinds"),
    [
        pytest.param(12, 1, CHEAP, id="some"),
        pytest.param(500, 2, tuple(KINDS), id="all", marks=[pytest.mark.long, pytest.mark.timeout(7200)]),
    ],
)
def test_the_order_of_questions_does_not_matter(
    count: int, seed: int, kinds: tuple[str, ...], redis: Redis
) -> None:
    asked = list(questions(count, seed, kinds))
    rng, digests = Random(seed), []
    for _ in range(2):
        rng.shuffle(asked)
        redis.flushdb()
        store = ResultStore(redis, WorkerSettings())
        digests.append({x.content_hash: hashlib.sha256(kept(x, store)).hexdigest() for x in asked})
    first, second = digests
    different = [json.dumps(x.content) for x in asked if first[x.content_hash] != second[x.content_hash]]
    assert different == []


def test_what_is_known_changes_no_answer(redis: Redis) -> None:
    store = ResultStore(redis, WorkerSettings())
    for request in questions(15, 3, CHEAP):
        assert kept(request, store) == alone(request)
