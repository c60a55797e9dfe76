"""What a process loads at its start: little, so that it starts quickly."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.test_rooms import FILES, ROOT, imported

HEAVY = {
    "rpr_solver.slices",
    "rpr_solver.slices.fast",
    "rpr_solver.notebook.sheet",
    "matplotlib",
    "worker.answers.store",
    "worker.lua",
    "flint",
    "numpy",
    "sympy",
    "pydantic",
    "pydantic_settings",
    "asyncio",
    "redis",
    "rq",
    "fastapi",
    "httpx",
    "rich",
    "prometheus_client",
}

COMMAND = """
import contextlib
from service.cli.main import main
with contextlib.suppress(SystemExit):
    main"""


def loaded(program: str) -> set[str]:
    """The modules that a process holds after a program."""
    program = f"import sys\n{program}\nprint(*sys.modules, file=sys.stderr)"
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    return set(done.stderr.split())


def test_work_horses_find_the_whole_solver_loaded() -> None:
    modules = loaded("import worker.process.horse; worker.process.horse.load_solver()")
    answers = [path for name, path in FILES.items() if name.startswith("worker.answers.")]
    named = {name for path in answers for name in imported(path) if name.startswith("rpr_solver")}
    assert named
    named |= {name for name in FILES if name.startswith("rpr_solver.slices")}
    assert not named - modules
    assert "numpy" in modules


@pytest.mark.parametrize(
    ("program", "needed"),
    [
        ("import rpr_solver.errors", set()),
        (f"{COMMAND}(['--version'])", set()),
        (f"{COMMAND}(['check', '--help'])", {"pydantic"}),
        (f"{COMMAND}(['solve', 'innocenti', '--l1', '27'])", {"pydantic", "flint", "rpr_solver.slices"}),
        (
            "import service.api.app; service.api.app.create_app()",
            {
                *("pydantic", "pydantic_settings", "asyncio", "fastapi", "redis", "rq", "prometheus_client"),
                *("worker.answers.store", "worker.lua"),
            },
        ),
    ],
)
def test_what_is_not_needed_is_not_loaded(program: str, needed: set[str]) -> None:
    assert HEAVY & loaded(program) == needed


def test_a_search_loads_nothing_for_plots() -> None:
    modules = loaded("from rpr_solver.designs.search import cma_alone; cma_alone()")
    assert "cma" in modules
    assert modules.isdisjoint({"matplotlib", "scipy.stats"})
