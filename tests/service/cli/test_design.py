"""`design` on this machine: Ctrl-C and a deadline end the search, not the command."""

from __future__ import annotations

import json
import signal
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import pytest

from rpr_solver import Manipulator
from rpr_solver.designs import design as module
from rpr_solver.designs.plan import Goal
from service.cli import design as command
from service.cli.main import main

ASKED = ["design", "innocenti", "--objective", "longest-range", "--l1-range", "1:2", "--max-cusps", "0"]


def begins(monkeypatch: pytest.MonkeyPatch, act: object, number: int) -> None:
    """Has something happen when so many geometries have been examined."""
    examine, numbers = module.examined, iter(range(1, 100))

    def examined(manipulator: Manipulator, goal: Goal) -> Mapping[str, Any] | None:
        if next(numbers) == number:
            act()  # type: ignore[operator]
        return examine(manipulator, goal)

    monkeypatch.setattr(module, "examined", examined)


def test_ctrl_c_ends_with_the_best_found_so_far(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    begins(monkeypatch, lambda: signal.raise_signal(signal.SIGINT), 2)
    before = signal.getsignal(signal.SIGINT)
    assert main([*ASKED, "--format", "json"]) == 1
    assert signal.getsignal(signal.SIGINT) is before
    shown = capsys.readouterr()
    document = json.loads(shown.out)
    assert (document["stopped"], document["censuses"]) == ("canceled", 1)
    assert "Ctrl-C again" in shown.err


def test_a_deadline_does_so_too(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    late = SimpleNamespace(monotonic=lambda: 1e9)  # for the command alone: services run in this process too
    begins(monkeypatch, lambda: monkeypatch.setattr(command, "time", late), 2)
    assert main([*ASKED, "--deadline", "600", "--format", "json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert (document["stopped"], document["censuses"]) == ("deadline", 1)
    assert main([*ASKED, "--deadline", "soon"]) == 2
    assert "--deadline" in capsys.readouterr().err
