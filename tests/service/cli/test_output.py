"""What the command line prints, wherever stdout leads, and its help."""

from __future__ import annotations

import json
import os
import pty
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, table_csv, table_document
from service.cli import pages
from service.cli.main import COMMANDS, main
from service.cli.output import Stages
from tests.support.cli_process import ENVIRONMENT, Run, command, run
from tests.support.processes import PATIENCE, started

SLICE = ("solve", "innocenti", "--l1", "14.98", "--digits", "15")
SCAN = ("solve", "zein-flat", "--l1-range", "1:50:0.001", "--digits", "60")


def into(args: tuple[str, ...], redirection: str) -> subprocess.CompletedProcess[str]:
    """Runs a command as a shell does."""
    shell = ["sh", "-c", f'exec "$@" {redirection}', "sh", *command(*args)]
    return subprocess.run(
        shell, env=ENVIRONMENT, capture_output=True, text=True, timeout=PATIENCE, check=False
    )


def test_an_encoding_without_greek_letters_gets_words() -> None:
    done = run(*SLICE, PYTHONIOENCODING="latin-1")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[3].split() == ["alpha", "[deg]", "theta1", "[deg]", "L2", "L3"]


def test_json_without_unicode_is_the_same_json() -> None:
    done = run(*SLICE, "--format", "json", PYTHONIOENCODING="ascii")
    assert done.stdout.isascii()
    expected = table_document(EXAMPLES["innocenti"], "14.98", digits=15)
    assert json.loads(done.stdout) == expected


@pytest.mark.parametrize("form", ["table", "csv"])
def test_a_full_disk_is_one_line(form: str) -> None:
    done = into((*SLICE, "--format", form), ">/dev/full")
    assert done.returncode == 1
    assert done.stderr == "rpr-cusps solve: cannot write to stdout: No space left on device\n"


def test_a_closed_stdout_is_noticed_before_the_work() -> None:
    done = into(SCAN, ">&-")
    assert (done.returncode, done.stderr) == (
        1,
        "rpr-cusps solve: stdout is closed; nothing can be printed\n",
    )


def test_a_closed_stderr_leaves_stdout_alone() -> None:
    args = ("solve", "innocenti", "--l1", "0.1", "--l1", "0", "--digits", "15", "--format", "csv")
    done = into(args, "2>&-")
    assert done.returncode == 2
    assert [line.split(",")[0] for line in done.stdout.splitlines()] == ["l1", "0.1", "0"]


def test_ctrl_c_keeps_the_slices_of_a_scan_that_are_done() -> None:
    with started(
        command(*SCAN, "--format", "csv"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT
    ) as process:
        seen = b"".join(process.stdout.readline() for _ in range(6))
        process.send_signal(signal.SIGINT)
        rest, err = process.stdout.read(), process.stderr.read()
        assert (process.wait(PATIENCE), err) == (130, b"")
    printed = (seen + rest).decode()
    lengths = list(dict.fromkeys(line.partition(",")[0] for line in printed.splitlines()[1:]))
    assert printed == table_csv(table_document(EXAMPLES["zein-flat"], lengths, digits=60))
    assert 1 <= len(lengths) < 49_000


def test_ndjson_is_a_slice_a_line(run_here: Run) -> None:
    done = run_here("solve", "zein-flat", "--l1", "1", "--l1", "0", "--digits", "15", "--format", "ndjson")
    first, second = map(json.loads, done.stdout.splitlines())
    document = table_document(EXAMPLES["zein-flat"], ["1", "0"], digits=15)
    head = {key: document[key] for key in ("geometry_hash", "fixed_leg", "digits", "solver_version")}
    assert [first, second] == [{**head, **part} for part in document["slices"]]
    assert done.returncode == 2


def on_terminal(patch: pytest.MonkeyPatch, width: int, *args: str) -> list[str]:
    """Returns what a command prints on a terminal of this width, without colours and the progress bar."""
    patch.setenv("TERM", "xterm")
    patch.setenv("COLUMNS", str(width))
    terminal, side = pty.openpty()
    with ThreadPoolExecutor() as pool, os.fdopen(side, "w", encoding="utf-8") as stdout:
        patch.setattr(sys, "stdout", stdout)
        shown = pool.submit(lambda: b"".join(chunks(terminal)).decode())
        assert main(args) == 0
        stdout.close()
        text = shown.result(PATIENCE)
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text).splitlines()


def test_a_bar_on_the_terminal_leaves_stdout_alone() -> None:
    terminal, side = pty.openpty()
    line, pipe = command(*SLICE, "--format", "csv"), subprocess.PIPE
    with started(line, stdout=pipe, stderr=side, env={**ENVIRONMENT, "TERM": "xterm"}) as process:
        os.close(side)
        shown = b"".join(chunks(terminal)).decode()
        text = process.stdout.read().decode()
        assert process.wait(PATIENCE) == 0
    assert text == table_csv(table_document(EXAMPLES["innocenti"], "14.98", digits=15))
    assert "slices" in shown
    assert "l1,count" not in shown


def chunks(terminal: int) -> Iterator[bytes]:
    try:
        while part := os.read(terminal, 65536):
            yield part
    except OSError:  # on Linux: the other end is closed
        os.close(terminal)


@pytest.mark.parametrize("width", [40])
def test_words_are_whole_on_a_terminal_and_lines_fit(monkeypatch: pytest.MonkeyPatch, width: int) -> None:
    census = on_terminal(monkeypatch, width, "census", "zein-flat", "--l1-range", "22:32", "--digits", "60")
    assert sum("swallowtail" in line for line in census) == 4
    legs = ("--l1", "14.98", "--l2", "16", "--l3", "20")
    poses = on_terminal(monkeypatch, width, "poses", "innocenti", *legs)
    assert "mult." in " ".join(poses)
    assert any("All 90 digits are in --format json" in " ".join(poses[i : i + 3]) for i in range(len(poses)))
    assert max(map(len, census + poses)) <= width
    assert any("d3 = 20.84" in line for line in poses)


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_help_fits_80_columns(run_here: Run, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    done = run_here(*([name] if name else []), "--help")
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_a_file_of_another_system_is_read(run_here: Run, tmp_path: Path) -> None:
    text = json.dumps(EXAMPLES["innocenti"].to_json())
    plain = run_here("solve", "-", "--l1", "3", "--digits", "15", stdin=text).stdout
    for encoding in ("utf-8-sig", "utf-16"):
        file = tmp_path / "robot.json"
        file.write_bytes(text.encode(encoding))
        assert run_here("solve", str(file), "--l1", "3", "--digits", "15").stdout == plain


NUMBERS = st.from_regex(r"-?[0-9]{1,4}\.[0-9]{1,90}(e-[0-9]{1,3})?", fullmatch=True)
WORDS = st.sampled_from(
    ["swallowtail", "beak-to-beak", "", "8 → 10", "426/25", "C14", "k1 = k3 = 0: the first column vanishes"]
)


@given(NUMBERS, st.integers(0, 120))
def test_a_shortened_number_begins_as_the_number_and_keeps_its_exponent(text: str, width: int) -> None:
    short = pages.shortened(text, width)
    if short != text:
        assert len(short) < len(text)
        begin, end = short.split("…")
        assert text.startswith(begin)
        assert text.endswith(end)
        assert re.search(r"\.\d\d", begin)
        assert end.startswith("e") or not end


@given(st.lists(st.tuples(WORDS, NUMBERS, NUMBERS, WORDS), min_size=1, max_size=5), st.integers(20, 200))
def test_columns_fit_or_become_records(rows: list[tuple[str, ...]], width: int) -> None:
    table = [("kind", "L2", "L3", "joins"), *rows]
    widths = pages.column_widths(table, width)
    if widths is None:
        shown = "\n".join(pages.records(table, width))
        words = {word for row in rows for cell in (row[0], row[3]) for word in cell.split()}
        assert words <= set(shown.split())
        return
    assert sum(widths) + pages.COLUMN_PADDING * len(widths) + 1 <= width
    for row in table:
        for cell, room in zip(row, widths, strict=True):
            lines = pages.fitted(cell, room).splitlines()
            assert max(map(len, lines), default=0) <= room
            assert "…" in "".join(lines) or " ".join(lines).split() == cell.split()


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(1, 500)), max_size=20))
def test_progress_never_runs_backwards(steps: list[tuple[int, int]]) -> None:
    stages = Stages()
    shown = [(stage, done / total) for stage, done, total in (stages.at(*step) for step in steps)]
    assert shown == sorted(shown)


BIN = Path(sys.executable).parent


def test_without_a_command_the_help_is_printed_and_it_is_no_success(run_here: Run) -> None:
    bare, asked, option = run_here(), run_here("help"), run_here("--help")
    assert bare.stdout == asked.stdout == option.stdout
    assert (bare.returncode, asked.returncode, bare.stderr) == (2, 0, "")
    assert all(f"\n  {name}" in bare.stdout for name in COMMANDS)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("sovle", "innocenti"), "'sovle'; did you mean solve?"),
        (("keys", "creat"), "'creat'; did you mean create?"),
        (("xyzzy",), "'xyzzy'; choose from solve, census, "),
    ],
)
def test_what_is_mistyped_is_told_in_one_line(run_here: Run, words: tuple[str, ...], said: str) -> None:
    done = run_here(*words)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert said in done.stderr


def in_bash(line: str, folder: Path) -> set[str]:
    """What bash offers for a line, by the script that the command prints."""
    script = f"""
        source <(rpr-cusps completion bash)
        read -ra COMP_WORDS <<< "{line}x"; COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
        COMP_LINE="{line}"; COMP_POINT={len(line)}; COMP_TYPE=9
        _python_argcomplete rpr-cusps
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    path = os.pathsep.join([str(BIN), ENVIRONMENT["PATH"]])
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=folder,
        env={**ENVIRONMENT, "PATH": path},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=True,
    )
    assert done.stderr == ""
    return {word.strip() for word in done.stdout.splitlines() if word.strip()}


def test_bash_completes_commands_and_geometries(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robot.json").write_text("{}")
    assert in_bash("rpr-cusps c", tmp_path) == {name for name in COMMANDS if name.startswith("c")}
    assert in_bash("rpr-cusps solve ", tmp_path) >= {*EXAMPLES, "robot.json", "robots/"}


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_has_its_script(run_here: Run, shell: str) -> None:
    done = run_here("completion", shell)
    assert (done.returncode, done.stderr) == (0, "")
    assert "rpr-cusps" in done.stdout
    if program := shutil.which(shell):
        subprocess.run([program, "-n"], input=done.stdout, text=True, timeout=PATIENCE, check=True)
