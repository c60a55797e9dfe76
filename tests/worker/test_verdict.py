from __future__ import annotations

import signal

import pytest

from worker import WorkerSettings
from worker.verdict import Fail, Retry, verdict

SETTINGS = WorkerSettings(deadline=5, memory_limit_mb=100)


def test_a_horse_that_ended_by_itself() -> None:
    assert verdict(0, None, SETTINGS) is None
    assert verdict(0, "deadline", SETTINGS) is None


@pytest.mark.parametrize(
    ("status", "ended_for", "kind"),
    [
        (signal.SIGKILL, "deadline", "timeout"),
        (signal.SIGABRT, None, "resource-exhausted"),
        (signal.SIGSEGV, None, "worker-crashed"),
        (signal.SIGKILL, "canceled", ""),
    ],
)
def test_failures(status: int, ended_for: str | None, kind: str) -> None:
    outcome = verdict(int(status), ended_for, SETTINGS)
    assert isinstance(outcome, Fail)
    assert outcome.kind == kind


def test_what_is_tried_again() -> None:
    assert verdict(int(signal.SIGKILL), "shutdown", SETTINGS) == Retry(lost=False)
    killed = verdict(int(signal.SIGKILL), None, SETTINGS)
    assert isinstance(killed, Retry)
    assert killed.lost
    assert "SIGKILL" in killed.detail
    exited = verdict(1 << 8, None, SETTINGS)
    assert isinstance(exited, Retry)
    assert exited.lost
