from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

import rpr_solver
from rpr_solver import EXAMPLES
from worker import TableRequest
from worker.jobs import requests as module
from worker.jobs.requests import request_from_json


def test_equal_questions_are_one_request() -> None:
    manipulator = EXAMPLES["innocenti"]
    one = TableRequest.of(manipulator, [Fraction("14.98"), Fraction(27), Fraction("14.980")])
    two = TableRequest.of(manipulator, [Fraction(749, 50), Fraction(54, 2)])
    assert one == two
    assert one.l1 == ("14.98", "27")
    assert one.job_id == two.job_id
    assert one.job_id.startswith("ct-")
    assert len(one.job_id) == 43


def test_every_field_changes_the_id(monkeypatch: pytest.MonkeyPatch) -> None:
    base = TableRequest.of(EXAMPLES["innocenti"], [Fraction(1), Fraction(2)])
    others = [
        TableRequest.of(EXAMPLES["zein-flat"], [Fraction(1), Fraction(2)]),
        replace(base, fixed_leg=2),
        replace(base, digits=91),
        replace(base, l1=("1",)),
        replace(base, l1=("2", "1")),
    ]
    ids = {request.job_id for request in (base, *others)}
    monkeypatch.setattr(module, "SOLVER_VERSION", rpr_solver.SOLVER_VERSION + "x")
    ids.add(replace(base).job_id)
    assert len(ids) == len(others) + 2


def test_json_and_back() -> None:
    request = TableRequest.of(EXAMPLES["innocenti"], [Fraction(1, 3)], fixed_leg=3, digits=15)
    assert request_from_json(request.to_json()) == request
