"""Parts of a census are cut from the whole one, which is computed once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from typing import Any

import pytest
from redis import Redis

import rpr_solver
from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.contract import silent
from worker.answers.censuses import CENSUS
from worker.answers.kind import JobRequest, answer, known_document
from worker.answers.store import ResultStore
from worker.settings import WorkerSettings

MANIPULATOR = EXAMPLES["zein-flat"]


class Computed:
    """Wraps the solver's census: counts its calls, and computes once per number of digits."""

    def __init__(self) -> None:
        self.solve, self.calls = rpr_solver.census, 0
        self.kept: dict[tuple[object, ...], rpr_solver.Census] = {}

    def __call__(self, manipulator: rpr_solver.Manipulator, **options: Any) -> rpr_solver.Census:
        self.calls += 1
        options.pop("progress")
        key = (manipulator.geometry_hash, *options.values())
        if key not in self.kept:
            self.kept[key] = self.solve(manipulator, **options)
        return self.kept[key]


_computed = Computed()


@pytest.fixture
def solver(monkeypatch: pytest.MonkeyPatch) -> Computed:
    _computed.calls = 0
    monkeypatch.setattr(rpr_solver, "census", _computed)
    return _computed


@pytest.fixture
def store(redis: Redis, settings: WorkerSettings) -> ResultStore:
    return ResultStore(redis, settings)


def request(
    start: str = "0",
    stop: str | None = None,
    digits: int = 20,
    manipulator: Manipulator = MANIPULATOR,
    fixed_leg: int = 1,
) -> JobRequest:
    content = {"geometry": manipulator.to_json(), "fixed_leg": fixed_leg, "digits": digits}
    return JobRequest(CENSUS, {**content, "range": {"from": start, "to": stop}})


def get(request_: JobRequest, store: ResultStore) -> dict[str, Any]:
    return known_document(request_, store) or CENSUS.compute(request_, store, silent)


def test_any_part_with_fewer_digits_follows_from_the_whole(solver: Computed, store: ResultStore) -> None:
    part = get(request("34", "38"), store)
    assert part["range"] == {"from": "34", "to": "38"}
    assert [interval["count"] for interval in part["intervals"]] == [6, 8, 6, 4]
    whole = get(request(), store)
    assert len(whole["transitions"]) == 12
    shorter = get(request("34", digits=15), store)
    assert [t["l1"] for t in shorter["transitions"]] == [
        "34.0716802345821",
        "35.2127837717642",
        "37.3170902975635",
    ]
    assert solver.calls == 1


def test_more_digits_are_computed(solver: Computed, store: ResultStore) -> None:
    get(request(), store)
    assert known_document(request(digits=21), store) is None
    assert len(get(request(digits=21), store)["transitions"][0]["l1"]) > 20
    assert solver.calls == 2


def test_simultaneous_requests_compute_it_once(solver: Computed, store: ResultStore) -> None:
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda start: CENSUS.compute(request(str(start)), store, silent), range(4)))
    assert solver.calls == 1


def test_an_end_that_digits_do_not_separate_from_a_transition(solver: Computed, store: ResultStore) -> None:
    lengths = [t["l1"] for t in get(request(digits=40), store)["transitions"]]
    near = lengths[-1][:23]  # as many digits as the shorter census has
    store.redis.flushall()
    part = get(request(near), store)
    assert len(part["transitions"]) == 1  # the length was truncated, so the transition is above
    assert [(i["from"], i["count"]) for i in part["intervals"]] == [
        (near, 6),
        (part["transitions"][0]["l1"], 4),
    ]
    assert solver.calls == 3  # with 40 digits, the whole, and the part alone


def test_an_end_at_a_transition(store: ResultStore) -> None:
    """With leg 2 fixed, this manipulator has a node at exactly L2 = 16."""
    turned = Manipulator(*(Fraction(x) for x in (10, 0, 8, 6, 10, 8)))
    held: dict[str, Any] = {"manipulator": turned, "fixed_leg": 2}
    whole = get(request(**held), store)
    [k] = [k for k, t in enumerate(whole["transitions"]) if Fraction(t["l2"]) == 16]
    above = get(request("16", **held), store)
    below = get(request(stop="16", **held), store)
    assert above["transitions"] == whole["transitions"][k + 1 :]
    assert below["transitions"] == whole["transitions"][:k]
    assert above["intervals"][0]["from"] == below["intervals"][-1]["to"] == "16"


def with_(request_: JobRequest, **more: object) -> JobRequest:
    return JobRequest(request_.kind, {**request_.content, **more})


def test_a_stored_census_serves_the_question_for_sensitivities_too(
    solver: Computed, store: ResultStore
) -> None:
    plain = get(request("34", "38"), store)
    moving = known_document(with_(request("34", "36", digits=15), sensitivities=True), store)
    assert solver.calls == 1
    assert moving == rpr_solver.with_sensitivities(get(request("34", "36", digits=15), store))
    assert moving["transitions"][0]["events"][0]["sensitivity"]["a2x"] is not None
    assert get(request("34", "38"), store) == plain


def test_a_question_for_sensitivities_keeps_the_census(solver: Computed, store: ResultStore) -> None:
    asked = with_(request("34", "38"), sensitivities=True)
    assert known_document(asked, store) is None
    moving = get(asked, store)
    assert moving == rpr_solver.with_sensitivities(get(request("34", "38"), store))
    assert solver.calls == 1


def test_a_census_of_a_tolerance_keeps_the_census(solver: Computed, store: ResultStore) -> None:
    within = with_(request("35", "36"), tolerance={"a2x": "0.0001"})
    assert known_document(within, store) is None
    document = answer(within, store)
    assert solver.calls == 1
    assert document["complete"] is True
    [transition] = document["transitions"]
    assert Fraction(transition["from"]) < Fraction(transition["l1"]) < Fraction(transition["to"])
    plain = known_document(request("35", "36"), store)
    assert plain is not None
    assert {name: document[name] for name in ("range", "intervals")} == {
        name: plain[name] for name in ("range", "intervals")
    }
    moving = known_document(with_(within, sensitivities=True), store)
    assert moving == rpr_solver.with_sensitivities(document)
