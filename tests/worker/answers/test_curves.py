"""Parts and samples of cusp curves set out from the whole ones, which are followed once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from typing import Any

import pytest
from redis import Redis

import rpr_solver
from rpr_solver import EXAMPLES, CuspCurves
from worker import DocumentRequest, ResultStore, WorkerSettings
from worker.answers.curves import curves_request
from worker.answers.documents import compute, known_document

MANIPULATOR = EXAMPLES["zein-flat"]
DIGITS = 20


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Has an entry for each time that curves are followed."""
    follow, made = rpr_solver.cusp_curves, []

    def counted(manipulator: rpr_solver.Manipulator, **options: Any) -> CuspCurves:
        made.append(options["digits"])
        return follow(manipulator, **options)

    monkeypatch.setattr(rpr_solver, "cusp_curves", counted)
    return made


@pytest.fixture
def store(redis: Redis, settings: WorkerSettings) -> ResultStore:
    return ResultStore(redis, settings)


def request(**wanted: Any) -> DocumentRequest:
    return curves_request(MANIPULATOR, digits=DIGITS, **wanted)


def get(wanted: DocumentRequest, store: ResultStore) -> dict[str, Any]:
    return known_document(wanted, store) or compute(wanted, store, lambda *_: None)


def test_everything_sets_out_from_the_whole(calls: list[int], store: ResultStore) -> None:
    sampled = get(request(lengths=[Fraction(10), Fraction(20), Fraction(10)], stop=Fraction(20)), store)
    assert {p["l1"] for c in sampled["curves"] for p in c["points"]} == {"10", "20"}
    spread = get(request(samples=2, start=Fraction(10), stop=Fraction(12)), store)
    assert all(10 < Fraction(p["l1"]) < 12 for c in spread["curves"] for p in c["points"])
    assert known_document(request(samples=2), store) is None
    part = known_document(request(start=Fraction(30)), store)
    assert part is not None
    assert part["range"] == {"from": "30", "to": None}
    assert known_document(request(), store) == CuspCurves.from_json(get(request(), store)).to_json()
    assert calls == [DIGITS]


def test_at_once_they_are_followed_once(calls: list[int], store: ResultStore) -> None:
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda x: compute(request(lengths=[Fraction(x)]), store, lambda *_: None), range(5, 9)))
    assert calls == [DIGITS]


def test_progress_goes_on_over_both_parts(store: ResultStore) -> None:
    seen: list[tuple[int, int]] = []
    compute(request(lengths=[Fraction(7), Fraction(8)]), store, lambda *step: seen.append(step))
    assert seen == sorted(seen)
    assert seen[-1][0] == seen[-1][1]
    assert seen[-1][1] == seen[-3][1] + 2


def test_equal_questions_are_one() -> None:
    a = request(lengths=[Fraction(2), Fraction(1)])
    assert a.job_id == request(lengths=[Fraction(1), Fraction(2), Fraction(2)]).job_id
    assert a.job_id != request(lengths=[Fraction(1)]).job_id
