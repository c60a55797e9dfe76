"""`rpr-cusps export`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, export, table_document
from tests.support.cli_process import Run

DOCUMENT = table_document(EXAMPLES["zein-flat"], [3], digits=15)
TWO = table_document(EXAMPLES["zein-flat"], [3, 4], digits=15)


@pytest.mark.parametrize("system", ["maple", "msolve", "pari", "sage", "sympy"])
def test_the_script_is_that_of_the_library(run_here: Run, tmp_path: Path, system: str) -> None:
    printed = run_here("export", "-", "--to", system, stdin=json.dumps(DOCUMENT))
    assert (printed.returncode, printed.stderr, printed.stdout) == (0, "", export(DOCUMENT, system))
    source, target = tmp_path / "table.json", tmp_path / "script"
    source.write_text(json.dumps(DOCUMENT))
    assert run_here("export", str(source), "--to", system, "-o", str(target)).returncode == 0
    assert target.read_text(encoding="utf-8") == printed.stdout


@pytest.mark.parametrize(
    ("args", "stdin", "said"),
    [
        (("-", "--to", "pari"), "{}", "FILE: is no cusp table and no census; give one as JSON"),
        (("-", "--to", "pari"), "[]", "FILE: standard input holds no object; give a document of rpr-cusps"),
        (("-", "--to", "msolve"), json.dumps(TWO), "FILE: has 2 slices, but msolve solves one system of"),
        (("-", "--to", "pari", "-o", "/nowhere/x"), json.dumps(DOCUMENT), "--output: '/nowhere/x' cannot be"),
    ],
    ids=["another document", "no object", "two slices", "no folder"],
)
def test_what_is_wrong_is_named(run_here: Run, args: tuple[str, ...], stdin: str, said: str) -> None:
    done = run_here("export", *args, stdin=stdin)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert said in done.stderr
