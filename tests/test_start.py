"""What a process loads at its start: little, so that it starts quickly."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.test_rooms import FILES, ROOT, imported

HEAVY = {
    "rpr_solver.slices",
    "flint",
    "pydantic",
    "redis",
    "rq",
    "fastapi",
    "httpx",
    "rich",
    "prometheus_client",
}


def loaded(program: str) -> set[str]:
    """The modules that a process holds after a program."""
    program = f"import sys\n{program}\nprint(*sys.modules, file=sys.stderr)"
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    return set(done.stderr.split())


def test_work_horses_find_the_whole_solver_loaded() -> None:
    modules = loaded("import worker.process.preload; worker.process.preload.load_solver()")
    answers = [path for name, path in FILES.items() if name.startswith("worker.answers.")]
    named = {name for path in answers for name in imported(path) if name.startswith("rpr_solver")}
    assert named
    assert not named - modules


@pytest.mark.parametrize("program", ["import rpr_solver", "import rpr_solver.errors"])
def test_the_solver_is_loaded_when_it_is_used(program: str) -> None:
    assert not HEAVY & loaded(program)
