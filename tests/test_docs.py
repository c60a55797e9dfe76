"""Examples in documents and docstrings give what is printed below them; what is named and linked is there."""

import doctest
import importlib
import re
import tomllib
from datetime import date
from pathlib import Path

import pytest

import rpr_solver
from docs import reference, reliability
from service.api.problems import ProblemType
from service.cli.serve import names
from tests.support.links import broken
from tests.support.pages import BLOCKS, NEEDS, PAGES, READ, RUN, SHOWN
from tests.support.sampling import long

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)

TEXTS = {path.name: path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("*.md"))}
TUTORIALS = {name: text for name, text in TEXTS.items() if "```python" in text}
MODULES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for package in ("rpr_solver", "worker", "service")
    for path in sorted((ROOT / package).rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]


def session(name: str) -> doctest.DocTest:
    """All code blocks of a tutorial, one session, as in a notebook."""
    text = TUTORIALS[name]
    blocks = BLOCK.findall(text)
    assert len(blocks) == text.count("```python")
    assert all(block.startswith(">>> ") for block in blocks)
    return doctest.DocTestParser().get_doctest("\n".join(blocks), {}, name, name, 0)


@pytest.mark.slow
@pytest.mark.parametrize("name", TUTORIALS)
def test_code_blocks(name: str) -> None:
    assert doctest.DocTestRunner().run(session(name)).failed == 0


@pytest.mark.slow
def test_code_blocks_are_strictly_typed(tmp_path: Path, pytestconfig: pytest.Config) -> None:
    """What mypy knows of the libraries is kept from run to run."""
    api = pytest.importorskip("mypy.api")
    scripts = [tmp_path / Path(name).with_suffix(".py").name.replace("-", "_") for name in TUTORIALS]
    for script, name in zip(scripts, TUTORIALS, strict=True):
        script.write_text("".join(example.source for example in session(name).examples), encoding="utf-8")
    known = pytestconfig.cache.mkdir("mypy") if pytestconfig.cache else tmp_path / "cache"
    options = ["--strict", "--config-file=", f"--cache-dir={known}", "--follow-imports=silent"]
    report, errors, status = api.run([*options, *map(str, scripts)])
    assert (status, errors) == (0, ""), report


EXPENSIVE = {
    "rpr_solver.curves.curve_set": "cusp_curves",
    "rpr_solver.designs.design": "design_csv",
    "rpr_solver.margins.margin": "Margin",
    "rpr_solver.margins.tolerance_census": "ToleranceCensus",
    "rpr_solver.modes.joined_regions": "AllowedPart",
    "rpr_solver.paths.other_poses": "FoldPoint",
}
"""Modules that run one docstring each time, and all of them with `--long`."""


@pytest.mark.parametrize(
    ("module", "name"), [*EXPENSIVE.items(), *(long(m, "") if m in EXPENSIVE else (m, "") for m in MODULES)]
)
def test_docstrings(module: str, name: str) -> None:
    loaded = importlib.import_module(module)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for test in doctest.DocTestFinder(exclude_empty=True).find(loaded):
        if name in ("", test.name.rpartition(".")[2]):
            runner.run(test)
    assert runner.tries
    assert runner.failures == 0


def test_the_reference_is_what_the_code_says(capsys: pytest.CaptureFixture[str]) -> None:
    assert reference.main(["--check"]) == 0, f"run `python docs/reference.py`:\n{capsys.readouterr().out}"


def test_the_fault_matrix_is_what_the_tests_say(capsys: pytest.CaptureFixture[str]) -> None:
    assert reliability.main(["--check"]) == 0, capsys.readouterr().err


def test_every_setting_problem_option_and_public_name_is_in_the_reference() -> None:
    rows = [line for line in TEXTS["reference.md"].splitlines() if line.startswith("|")]
    assert not [row for row in rows if "|  |" in row], "something is named without its meaning"
    documented = {code.split()[0] for row in rows for code in re.findall(r"`([^`]+)`", row)}
    problems = {kind.slug for kind in ProblemType}
    options = {
        name
        for _, parser in reference.commands()
        for action in reference.visible(parser)
        for name in action.option_strings
    }
    assert names() | problems | options | set(rpr_solver.__all__) <= documented


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_every_block_is_in_a_language_that_is_run_or_says_why_it_is_not(path: Path) -> None:
    found = [block for block in BLOCKS if block.page == path.relative_to(ROOT).as_posix()]
    fences = re.findall(r"^ *(```+)(\S*)", path.read_text(encoding="utf-8"), re.MULTILINE)
    directives = [language for _, language in fences if language.startswith("{")]
    shown = [block for block in found if block.printed]
    assert len(fences) == 2 * (len(found) + len(shown) + len(directives)), "a block is indented or unclosed"
    known = RUN | READ | SHOWN | NEEDS.keys()
    strange = [block.name for block in found if block.language not in known and not block.reason]
    assert not strange, "see docs/testing.md: name the language, or why the block is not run"


@pytest.mark.parametrize(
    "path",
    [
        *("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "examples/README.md"),
        *(f"docs/{name}" for name in TEXTS),
    ],
)
def test_every_link_leads_somewhere(path: str) -> None:
    assert not list(broken(ROOT / path))


def test_every_page_is_in_the_navigation_once() -> None:
    tree = re.compile(r"^```\{toctree\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    trees = [found for text in TEXTS.values() for found in tree.findall(text)]
    listed = [line for tree in trees for line in tree.splitlines() if not line.startswith(":")]
    assert sorted(f"{name}.md" for name in [*listed, "index"]) == sorted(TEXTS)


def test_the_changelog_has_this_version_dated_below_what_is_unreleased() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    unreleased, *released = re.findall(r"^## (.+)$", changelog, re.MULTILINE)
    assert unreleased == "[Unreleased]"
    found = [re.fullmatch(r"\[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)", heading) for heading in released]
    versions = [(tuple(map(int, each[1].split("."))), date.fromisoformat(each[2])) for each in found if each]
    assert len(versions) == len(released)
    assert versions == sorted(versions, reverse=True)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["version"] == ".".join(map(str, versions[0][0]))
