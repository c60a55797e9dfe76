from __future__ import annotations

import signal

import pytest

from worker.process.horse_exit import UNRECORDED, Failed, GivenUp, RunAgain, judge_exit
from worker.settings import WorkerSettings

SETTINGS = WorkerSettings(deadline=5, memory_limit_mb=100)


def test_a_normal_exit() -> None:
    assert judge_exit(0, None, SETTINGS) is None
    assert judge_exit(0, "deadline", SETTINGS) is None


@pytest.mark.parametrize(
    ("status", "ended_for", "kind"),
    [
        (signal.SIGKILL, "deadline", "timeout"),
        (signal.SIGKILL, "canceled", ""),
    ],
)
def test_failures(status: int, ended_for: str | None, kind: str) -> None:
    outcome = judge_exit(int(status), ended_for, SETTINGS)
    assert isinstance(outcome, Failed)
    assert outcome.kind == kind


def test_what_is_given_up() -> None:
    outcome = judge_exit(int(signal.SIGABRT), None, SETTINGS)
    assert isinstance(outcome, GivenUp)
    assert outcome.kind == "resource-exhausted"
    assert "100 MiB" in outcome.detail


def test_what_is_run_again() -> None:
    for reason in ("shutdown", "silence"):
        assert judge_exit(int(signal.SIGKILL), reason, SETTINGS) == RunAgain()
    for number in (signal.SIGKILL, signal.SIGSEGV):
        killed = judge_exit(int(number), None, SETTINGS)
        assert isinstance(killed, RunAgain)
        assert (killed.lost, killed.kind) == ("horses", "worker-crashed")
        assert number.name in killed.detail
    unrecorded = judge_exit(UNRECORDED << 8, None, SETTINGS)
    assert isinstance(unrecorded, RunAgain)
    assert unrecorded.lost == "workers"
    exited = judge_exit(1 << 8, None, SETTINGS)
    assert isinstance(exited, RunAgain)
    assert exited.lost == "horses"


def test_the_time_that_other_items_took_is_not_held_against_the_one_at_hand() -> None:
    killed = int(signal.SIGKILL)
    assert judge_exit(killed, "deadline", SETTINGS, has_advanced=True) == RunAgain()
    assert isinstance(judge_exit(killed, "deadline", SETTINGS), Failed)
