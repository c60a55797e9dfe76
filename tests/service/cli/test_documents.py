"""`rpr-cusps verify` and `rpr-cusps export`."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from rpr_solver import EXAMPLES, cusp_loop, cusp_table, export, poses, table_document, table_json
from tests.support.cli_process import Run


def test_a_document_is_verified_or_refused(run_here: Run, tmp_path: Path) -> None:
    [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=15)
    document = table_json(EXAMPLES["zein-flat"], 1, 15, [table.to_json()])
    file = tmp_path / "table.json"
    file.write_text(json.dumps(document))
    done = run_here("verify", str(file))
    assert done.returncode == 0
    first, *_, last = done.stdout.splitlines()
    assert (first, last) == ("VERIFIED: 7 claims", f"cusp-table of {document['geometry_hash']}")
    done = run_here("verify", str(file), "--verbose")
    assert "no claims: " in done.stdout
    assert "/slices/*/certificate/method" in done.stdout
    assert "/slices/0/count: proved: these 4 cusps are all" in done.stdout
    document["slices"][0]["cusps"].pop()
    done = run_here("verify", "-", "--json", stdin=json.dumps(document))
    answer = json.loads(done.stdout)
    assert (done.returncode, answer["verdict"], answer["refused"]) == (1, "refused", ["/slices/0/count"])
    assert "/slices/0/count" in answer["summary"]


@pytest.mark.parametrize(
    ("stdin", "said"),
    [
        ("", "is not valid JSON"),
        ('{"slices": [], "slices": [1]}', "'slices' is given twice"),
        ("{}", "of no kind"),
        (f'{{"slices": [{{"l1": {"9" * 5000}}}]}}', "slices[0].l1: a number with 5000 digits"),
        (f'{{"slices": [{{"l1": "14.{"9" * 3000}"}}]}}', "slices[0].l1: has a number of 3003 characters"),
        ("[" * 5000 + "]" * 5000, "nested more than 32 levels deep"),
    ],
    ids=lambda text: text[:30],
)
def test_what_is_no_document_is_bad_input(run_here: Run, stdin: str, said: str) -> None:
    done = run_here("verify", "-", stdin=stdin)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert said in done.stderr


@cache
def the_document() -> dict[str, Any]:
    return table_document(EXAMPLES["zein-flat"], [3], digits=15)


@cache
def the_two() -> dict[str, Any]:
    return table_document(EXAMPLES["zein-flat"], [3, 4], digits=15)


@pytest.mark.parametrize("system", ["maple", "pari"])
def test_the_script_is_that_of_the_library(run_here: Run, tmp_path: Path, system: str) -> None:
    printed = run_here("export", "-", "--to", system, stdin=json.dumps(the_document()))
    assert (printed.returncode, printed.stderr, printed.stdout) == (0, "", export(the_document(), system))
    source, target = tmp_path / "table.json", tmp_path / "script"
    source.write_text(json.dumps(the_document()))
    assert run_here("export", str(source), "--to", system, "-o", str(target)).returncode == 0
    assert target.read_text(encoding="utf-8") == printed.stdout


@pytest.mark.parametrize(
    ("args", "stdin", "said"),
    [
        (("-", "--to", "pari"), "{}", "FILE: is no cusp table and no census; give one as JSON"),
        (
            ("-", "--to", "msolve"),
            json.dumps(the_two()),
            "FILE: has 2 slices, but msolve solves one system of",
        ),
    ],
    ids=["another document", "two slices"],
)
def test_what_is_wrong_is_named(run_here: Run, args: tuple[str, ...], stdin: str, said: str) -> None:
    done = run_here("export", *args, stdin=stdin)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert said in done.stderr


def test_a_path_and_a_pose_are_exported_for_robots(run_here: Run, tmp_path: Path) -> None:
    first = EXAMPLES["innocenti"]
    path = cusp_loop(first, 27, "B", samples=3, duration=2).to_json()
    done = run_here("export", "-", "--to", "ros2-yaml", "--unit", "mm", stdin=json.dumps(path))
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == export(path, "ros2-yaml", unit="mm")
    table = poses(first, 27, 20, 20, digits=15).to_json()
    target = tmp_path / "robot.sdf"
    args = ("export", "-", "--to", "sdf", "--unit", "in", "--pose", "2", "--name", "<me>", "-o", str(target))
    assert run_here(*args, stdin=json.dumps(table)).returncode == 0
    assert target.read_text() == export(table, "sdf", unit="in", pose=2, name="<me>")


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--to", "sdf"), "--unit: is missing"),
        (("--to", "sdf", "--unit", "mm", "--pose", "9"), "--pose: is 9; give 1 to 4"),
    ],
    ids=lambda part: part if isinstance(part, str) else part[1],
)
def test_what_cannot_be_exported_for_robots_names_the_option(
    run_here: Run, args: tuple[str, ...], said: str
) -> None:
    table = poses(EXAMPLES["innocenti"], 27, 20, 20, digits=15).to_json()
    done = run_here("export", "-", *args, stdin=json.dumps(table))
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert said in done.stderr
