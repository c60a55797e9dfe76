"""Threads share python-flint's working precision: they may disturb each other, but never change a digit."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from typing import Any

import pytest
from flint import ctx

from rpr_solver import EXAMPLES, SolverError, eliminate, poses, solve_slice

MANIPULATOR = EXAMPLES["innocenti"]
LENGTHS = [Fraction(n, 10) for n in range(20, 320, 60)]
DIGITS = (15, 300)


@pytest.fixture
def _close_turns() -> Iterator[None]:
    """Threads switch a hundred times as often; the precision is restored afterwards."""
    interval, precision = sys.getswitchinterval(), ctx.prec
    sys.setswitchinterval(1e-4)
    yield
    sys.setswitchinterval(interval)
    ctx.prec = precision


@pytest.mark.usefixtures("_close_turns")
def test_threads_at_different_precisions_give_true_answers_or_none() -> None:
    eliminant = eliminate(MANIPULATOR)

    def answers(digits: int, length: Fraction) -> Iterator[dict[str, Any]]:
        """A slice and the poses of a joint vector."""
        for compute in (
            lambda: solve_slice(eliminant, length, digits),
            lambda: poses(MANIPULATOR, length, Fraction(16), Fraction(20), digits=digits),
        ):
            try:
                document = compute().to_json()
            except SolverError:
                yield {}
            else:
                yield {key: value for key, value in document.items() if key != "certificate"}

    truth = {(d, x): list(answers(d, x)) for d in DIGITS for x in LENGTHS}
    assert all(all(pair) for pair in truth.values())

    def compare(digits: int) -> int:
        given = 0
        for x in LENGTHS * 4:
            for answer, true in zip(answers(digits, x), truth[digits, x], strict=True):
                assert answer in ({}, true)
                given += bool(answer)
        return given

    with ThreadPoolExecutor(len(DIGITS)) as pool:
        assert sum(pool.map(compare, DIGITS)) > 0
