"""A search for a geometry, when processes die: the same answer, proved."""

from __future__ import annotations

import contextlib
import os
import signal
from pathlib import Path
from typing import Any

import httpx
import pytest

from rpr_solver import design
from tests.support.jobs import SMALL, WISH
from tests.support.processes import PATIENCE, until
from tests.support.stack import Stack, running

PARTS = ("worker.__main__", "api_process", "valkey-server")


def state(stack: Stack, path: str) -> dict[str, Any]:
    """What is at a path, empty while there is nothing."""
    with contextlib.suppress(httpx.HTTPError):
        reply = httpx.get(f"{stack.base}{path}", timeout=PATIENCE)
        if reply.status_code == 200:
            found: dict[str, Any] = reply.json()
            return found
    return {}


def asked(stack: Stack, budget: int) -> str:
    """Asks for a design; returns the path of the job."""
    body = {
        "geometry": SMALL.to_json(),
        "objective": "longest-range",
        "requirement": {"range": {"from": 1, "to": 5}, "max_cusps": 0},
        "vary": "5%",
        "decimals": 2,
        "budget": {"censuses": budget},
    }
    reply = httpx.post(
        f"{stack.base}/v1/designs", json=body, headers={"Prefer": "respond-async"}, timeout=PATIENCE
    )
    assert reply.status_code == 202
    return str(reply.json()["links"]["self"])


def agrees(found: dict[str, Any], budget: int) -> None:
    """Compares a result with that of the library, which proves it anew."""
    own = design(SMALL, "longest-range", WISH, vary="5%", decimals=2, budget=budget)
    assert found == own.to_json()


def test_worker_api_and_valkey_are_killed_during_a_search(tmp_path: Path) -> None:
    """Worker, API and Valkey are each killed once while candidates are examined. The search goes on, with the
    answer of the library.

    A service, and each of seven censuses twice.
    """
    budget = 7
    with running(tmp_path) as stack:
        job = asked(stack, budget)
        for number, part in enumerate(PARTS, 1):
            until(lambda number=number: state(stack, job).get("progress", {}).get("done", 0) >= 2 * number)  # type: ignore[misc]
            os.kill(stack.part(part), signal.SIGKILL)
        found = until(lambda: state(stack, f"{job}/result"))
    agrees(found, budget)


@pytest.mark.long
@pytest.mark.parametrize("workers", [1, 3])
def test_any_number_of_workers_has_the_same_answer(tmp_path: Path, workers: int) -> None:
    """A search is shared by one, two or three workers; if it is one, it is killed. The answer is the same."""
    budget = 40
    with running(tmp_path, workers=workers) as stack:
        job = asked(stack, budget)
        until(lambda: state(stack, job).get("progress", {}).get("done", 0) >= 15)
        if workers == 1:
            os.kill(stack.part(PARTS[0]), signal.SIGKILL)
        found = until(lambda: state(stack, f"{job}/result"))
    agrees(found, budget)
