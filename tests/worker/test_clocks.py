"""No duration of the worker layer is a difference of wall clocks, which may be set at any moment."""

from __future__ import annotations

import ast
from pathlib import Path

WORKER = Path(__file__).parents[2] / "worker"
WALL = {"time.time", "time.time_ns", "datetime.now", "datetime.utcnow", "datetime.today"}
ALLOWED = {"jobs/records.py": {"time.time_ns"}, "tracing.py": {"time.time_ns"}}  # the moments of a trace


def test_only_traces_read_the_wall_clock() -> None:
    found = {
        path.relative_to(WORKER).as_posix(): {
            name
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Call) and (name := ast.unparse(node.func)) in WALL
        }
        for path in sorted(WORKER.rglob("*.py"))
    }
    assert {path: names for path, names in found.items() if names} == ALLOWED
