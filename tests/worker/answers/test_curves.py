"""Parts and samples of cusp curves start from the whole ones, which are followed once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from typing import Any

import pytest
from redis import Redis

import rpr_solver
from rpr_solver import EXAMPLES, CuspCurves
from rpr_solver.contract import silent
from worker.answers.documents import CUSP_CURVES
from worker.answers.kind import JobRequest, known_document
from worker.answers.store import ResultStore
from worker.settings import WorkerSettings

MANIPULATOR = EXAMPLES["zein-flat"]
DIGITS = 20


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """A list with an entry for each time that curves are followed."""
    follow, made = rpr_solver.cusp_curves, []

    def counted(manipulator: rpr_solver.Manipulator, **options: Any) -> CuspCurves:
        made.append(options["digits"])
        return follow(manipulator, **options)

    monkeypatch.setattr(rpr_solver, "cusp_curves", counted)
    return made


@pytest.fixture
def store(redis: Redis, settings: WorkerSettings) -> ResultStore:
    return ResultStore(redis, settings)


def request(
    *lengths: str, samples: int | None = None, start: str = "0", stop: str | None = None
) -> JobRequest:
    content = {"geometry": MANIPULATOR.to_json(), "fixed_leg": 1, "digits": DIGITS, "samples": samples}
    ends = {"from": start, "to": stop}
    return JobRequest(CUSP_CURVES, {**content, "range": ends, "lengths": list(lengths)})


def get(request_: JobRequest, store: ResultStore) -> dict[str, Any]:
    return known_document(request_, store) or CUSP_CURVES.compute(request_, store, silent)


def test_everything_starts_from_the_whole(calls: list[int], store: ResultStore) -> None:
    sampled = get(request("10", "20", stop="20"), store)
    assert {p["l1"] for c in sampled["curves"] for p in c["points"]} == {"10", "20"}
    spread = get(request(samples=2, start="10", stop="12"), store)
    assert all(10 < Fraction(p["l1"]) < 12 for c in spread["curves"] for p in c["points"])
    assert known_document(request(samples=2), store) is None
    part = known_document(request(start="30"), store)
    assert part is not None
    assert part["range"] == {"from": "30", "to": None}
    assert known_document(request(), store) == CuspCurves.from_json(get(request(), store)).to_json()
    assert calls == [DIGITS]


def test_simultaneous_requests_follow_them_once(calls: list[int], store: ResultStore) -> None:
    """For ranges, since threads that sample curves would share one working precision."""
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda x: CUSP_CURVES.compute(request(start=str(x)), store, silent), range(5, 9)))
    assert calls == [DIGITS]


def test_progress_covers_both_parts(store: ResultStore) -> None:
    seen: list[tuple[int, int]] = []
    CUSP_CURVES.compute(request("7", "8"), store, lambda *step: seen.append(step))
    assert seen == sorted(seen)
    assert seen[-1][0] == seen[-1][1]
    assert seen[-1][1] == seen[-3][1] + 2
