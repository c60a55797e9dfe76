"""Checks within a tolerance: put together from answers that are kept, and from those alone."""

from __future__ import annotations

from typing import Any

import pytest
from redis import Redis

import rpr_solver
from rpr_solver import EXAMPLES, Requirement
from worker.answers.censuses import CHECK, margin_request, within_tolerance
from worker.answers.kind import JobRequest, answer
from worker.answers.store import ResultStore
from worker.settings import WorkerSettings

GEOMETRY = EXAMPLES["innocenti"].to_json()
NARROW = Requirement(start=23, stop=24, max_cusps=6).to_json()
WITHIN = dict.fromkeys(("a2x", "a3x", "a3y", "d1", "d2", "d3"), "0.0001")
REPORT: dict[str, Any] = {"passed": True, "intervals": [{}]}
MARGIN: dict[str, Any] = {
    "verdict": "open",
    "reason": None,
    "validity": None,
    "first_order": None,
    "counterexample": None,
    "certificate": {"boxes": 7},
}


@pytest.fixture
def store(redis: Redis, settings: WorkerSettings) -> ResultStore:
    return ResultStore(redis, settings)


def check(requirement: dict[str, Any] = NARROW, **more: object) -> JobRequest:
    return JobRequest(CHECK, {"geometry": GEOMETRY, "digits": 15, "requirement": requirement, **more})


def test_both_parts_are_kept_as_if_asked_for_alone(
    store: ResultStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[tuple[int, int]] = []
    report = answer(check(tolerance=WITHIN), store, lambda done, total: steps.append((done, total)))
    assert (report["passed"], report["margin"]["verdict"]) == (True, "proved")
    assert steps == sorted(steps)
    plain = store.get_document(check())
    margin = store.get_document(margin_request(GEOMETRY, {"requirement": NARROW, "fixed_leg": 1}, WITHIN))
    assert plain is not None
    assert margin is not None
    assert within_tolerance(plain, margin, WITHIN) == report
    for name in ("check", "margin"):  # nothing is computed again
        monkeypatch.delattr(rpr_solver, name)
    store.redis.delete(store.keys.document(check(tolerance=WITHIN).content_hash))
    assert answer(check(tolerance=WITHIN), store) == report


def test_what_the_geometry_itself_violates_needs_no_search(
    store: ResultStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(rpr_solver, "margin")
    report = answer(check({**NARROW, "max_cusps": 4}, tolerance=WITHIN), store)
    assert (report["passed"], report["margin"]["verdict"]) == (False, "refuted")
    assert report["margin"]["reason"] == "the manipulator itself does not satisfy the requirement"
    assert len(report["violations"]) == 1


def test_what_is_open_says_why() -> None:
    report = within_tolerance(REPORT, MARGIN, WITHIN)
    assert (report["passed"], report["margin"]["verdict"]) == (False, "open")
    assert report["margin"]["reason"] == "no proof and no counter-example was found in 7 boxes"
    changing = within_tolerance({**REPORT, "intervals": [{}, {}]}, MARGIN, WITHIN)
    assert "the number of cusps changes within the range" in changing["margin"]["reason"]
    known = within_tolerance(REPORT, {**MARGIN, "reason": "degenerate throughout: node"}, WITHIN)
    assert known["margin"]["reason"] == "degenerate throughout: node"
