"""The search for questions that take far longer than estimated."""

from __future__ import annotations

import json
from collections import Counter
from random import Random

import pytest
from redis import Redis

from benchmarks.cost import Finding, Search, line, measured, read
from benchmarks.questions import changed, geometry, seeds
from rpr_solver import EXAMPLES
from service.stack.embedded_valkey import EmbeddedValkey
from worker.answers.kinds import KINDS

INNOCENTI = EXAMPLES["innocenti"].to_json()


def test_every_kind_has_questions_that_the_service_reads() -> None:
    assert set(seeds()) == {kind.name for kind in KINDS}
    for kind, bodies in seeds().items():
        assert any(read(kind, body) is not None for body in bodies), kind


def test_enough_of_the_changed_questions_are_read() -> None:
    rng, read_ = Random(5), Counter[str]()
    for kind, bodies in seeds().items():
        asked = [changed(kind, rng.choice(bodies), rng) for _ in range(30)]
        read_[kind] = sum(read(kind, body) is not None for body in asked)
    assert min(read_.values()) >= 5, read_
    assert sum(read("census", {"geometry": geometry(rng)}) is not None for _ in range(100)) > 30


@pytest.mark.parametrize(
    ("kind", "more", "ended"),
    [
        ("poses", {"l1": "14.98", "l2": "15", "l3": "30"}, "answered"),
        ("cusp-table", {"l1": "14.98"}, "answered"),
        ("path", {"l1": "0.001", "cusp": 24}, "InputError"),
        ("cusp-table", {"l1": {"from": "0.1", "to": "100", "step": "0.1"}, "digits": 1000}, "cut"),
    ],
)
def test_a_question_is_computed_as_by_a_worker_and_cut_at_its_limit(
    valkey: EmbeddedValkey,
    redis: Redis,  # noqa: ARG001
    kind: str,
    more: dict[str, object],
    ended: str,
) -> None:
    request = read(kind, {"geometry": INNOCENTI, **more})
    assert request is not None
    taken, how, document = measured(request, valkey.url, 1)
    assert (how.partition(":")[0], 0 < taken < 10) == (ended, True)
    assert (document is None) == (ended != "answered")
    if document is not None:
        assert document["geometry"] == INNOCENTI


def test_a_finding_holds_its_question(valkey: EmbeddedValkey, redis: Redis) -> None:  # noqa: ARG001
    search = Search(valkey.url, 3, ["poses"], cap=5)
    findings = [x for _ in range(12) if (x := search.step()) is not None]
    assert findings
    assert all(isinstance(x, Finding) and x.kind == "poses" and x.ratio > 0 for x in findings)
    worst = max(findings)
    assert read("poses", worst.body) is not None
    assert json.dumps(worst.body)[:50] in line(worst)
    assert [x.text for x in findings if x in search.worst["poses"]]
