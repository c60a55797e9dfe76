"""The command line as a user runs it: a process, its output and its exit status."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
from contextlib import suppress
from decimal import Context, Decimal
from pathlib import Path

import httpx
import pytest

from rpr_solver import EXAMPLES, table_document
from rpr_solver.exports.latex import latex_table
from tests.support.cli_process import ENVIRONMENT, Run, command, run
from tests.support.processes import PATIENCE, completed, started, until
from tests.support.service_server import GEOMETRY


def test_a_table_in_a_pipe_is_aligned_and_whole() -> None:
    done = completed(
        command("solve", "innocenti", "--l1", "14.98", "--digits", "15"), ENVIRONMENT, in_full=True
    )
    lines = done.stdout.splitlines()
    assert "L1 = 14.98: 6 cusps" in lines
    first, *cusps = lines[lines.index("L1 = 14.98: 6 cusps") + 1 :]
    assert first.split() == ["α", "[deg]", "θ1", "[deg]", "L2", "L3"]
    assert len(cusps) == 6
    assert {len(re.sub(r"[-.]|^0\.", "", cell).lstrip("0")) for row in cusps for cell in row.split()} == {15}
    assert len({row.index(row.split()[2]) for row in cusps}) == 1


@pytest.mark.parametrize("digits", [1, 40])
def test_the_digits_that_are_printed(run_here: Run, digits: int) -> None:
    args = ("solve", "zein-flat", "--l1", "10", "--digits", str(digits))
    document = json.loads(run_here(*args, "--json").stdout)
    assert document == table_document(EXAMPLES["zein-flat"], 10, digits=max(digits, 15))
    rows = [line.split() for line in run_here(*args).stdout.splitlines()[4:]]
    exact = table_document(EXAMPLES["zein-flat"], 10, digits=60)["slices"][0]["cusps"]
    for row, cusp in zip(rows, exact, strict=True):
        for text, number in zip(row, cusp.values(), strict=True):
            assert Decimal(text) == Context(prec=digits).create_decimal(number)


def test_the_geometry_may_come_from_a_file_or_standard_input(run_here: Run, tmp_path: Path) -> None:
    file = tmp_path / "robot.json"
    file.write_text(json.dumps(GEOMETRY))
    named = run_here("solve", "innocenti", "--l1", "3", "--digits", "20", "--format", "json")
    read = run_here("solve", str(file), "--l1", "3", "--digits", "20", "--format", "json")
    piped = run_here(
        "solve", "-", "--l1", "3.0", "--digits", "20", "--format", "json", stdin=json.dumps(GEOMETRY)
    )
    assert named.stdout == read.stdout == piped.stdout
    assert json.loads(named.stdout)["slices"]
    noted = json.dumps({"name": "Gripper", "unit": "mm", **GEOMETRY})
    for text in (named.stdout, noted, f'{{"geometry": {noted}}}'):
        again = run_here("solve", "-", "--l1", "3", "--digits", "20", "--format", "json", stdin=text)
        assert again.stdout == named.stdout


@pytest.mark.parametrize(
    ("args", "stdin", "said"),
    [
        (("bogus",), "", "invalid choice"),
        (("solve", "innocenti", "--l1", "14,98"), "", 'write a decimal point, "14.98"'),
        (("solve", "innocenti", "--l1-range", "0:1:1e-300"), "", "max_slices"),
        (("solve", "-", "--l1", "1"), '{"a2x": 0}', "geometry.d1: is missing"),
        (("serve", "--redis-url", "localhost"), "", "redis://"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    run_here: Run, args: tuple[str, ...], stdin: str, said: str
) -> None:
    done = run_here(*args, stdin=stdin)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"rpr-cusps {args[0]}: " if args and args[0] != "bogus" else "rpr-cusps: ")


def test_a_slice_without_an_answer_is_reported_with_the_others(run_here: Run) -> None:
    done = run_here("solve", "innocenti", "--l1", "0", "--l1", "14.98", "--digits", "15")
    assert done.returncode == 2
    assert "L1 = 14.98: 6 cusps" in done.stdout
    assert done.stderr.startswith("rpr-cusps solve: L1 = 0: no answer (input-error)")


def test_no_service_is_status_3(run_here: Run) -> None:
    done = run_here("solve", "innocenti", "--l1", "1", "--url", "http://127.0.0.1:1")
    assert (done.returncode, done.stderr.count("\n")) == (3, 1)
    assert "no service answers at http://127.0.0.1:1" in done.stderr
    assert "`rpr-cusps serve --port 1` starts one" in done.stderr


def test_a_refusal_of_the_service_is_status_2(run_here: Run, idle_url: str) -> None:
    done = run_here("solve", "innocenti", "--l1-range", "1:100:1", "--url", idle_url)
    assert done.returncode == 2
    assert "max_slices is 5" in done.stderr


def test_a_broken_pipe_is_quiet() -> None:
    with started(
        command("solve", "innocenti", "--l1-range", "1:20:0.1"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=ENVIRONMENT,
    ) as process:
        process.stdout.read(1)
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(PATIENCE) == 141


def test_ctrl_c_is_quiet_and_status_130() -> None:
    main, side = pty.openpty()
    with started(
        command("solve", "innocenti", "--l1-range", "1:20:0.001", "--digits", "1000"),
        stdout=subprocess.PIPE,
        stderr=side,
        env={**ENVIRONMENT, "TERM": "xterm"},
    ) as process:
        os.close(side)
        seen = bytearray()
        os.set_blocking(main, False)
        until(lambda: b"slices" in read_some(main, seen))
        os.set_blocking(main, True)
        process.send_signal(signal.SIGINT)
        seen += read_to_the_end(main)
        out = process.stdout.read()
        assert (process.wait(PATIENCE), out) == (130, b"")
    assert b"Traceback" not in seen


def read_some(terminal: int, seen: bytearray) -> bytearray:
    with suppress(BlockingIOError):
        seen += os.read(terminal, 4096)
    return seen


def read_to_the_end(terminal: int) -> bytes:
    seen = b""
    try:
        while part := os.read(terminal, 65536):
            seen += part
    except OSError:  # on Linux: the other end is closed
        pass
    os.close(terminal)
    return seen


def test_on_a_terminal_there_is_a_table_that_fits_and_a_progress_bar() -> None:
    main, side = pty.openpty()
    with started(
        command("solve", "innocenti", "--l1", "14.98"),
        stdout=side,
        stderr=side,
        env={**ENVIRONMENT, "TERM": "xterm"},
    ) as process:
        os.close(side)
        seen = read_to_the_end(main)
        assert process.wait(PATIENCE) == 0
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", seen.decode())
    assert "slices" in text
    rows = [line for line in text.splitlines() if line.startswith("│")]
    assert len(rows) == 7
    assert all(len(row) <= 100 for row in rows)
    assert "-69.1293760614883" in text
    assert "All 90 digits are in --format json" in text


@pytest.mark.long
def test_the_demonstration_shows_the_table_and_leaves_nothing_behind(tmp_path: Path) -> None:
    done = run("demo", TMPDIR=str(tmp_path), XDG_RUNTIME_DIR=str(tmp_path))
    assert done.returncode == 0
    assert "L1 = 14.98: 6 cusps" in done.stdout
    address = re.search(r"http://\S+?(?=;)", done.stderr)
    assert address is not None
    with pytest.raises(httpx.ConnectError):
        httpx.get(address[0])
    assert [path for path in tmp_path.rglob("*") if not path.name.startswith("rpr-cusps-")] == []


@pytest.mark.long
def test_the_demonstration_stops_everything_on_ctrl_c(tmp_path: Path) -> None:
    with started(
        command("demo", "--keep"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**ENVIRONMENT, "TMPDIR": str(tmp_path), "XDG_RUNTIME_DIR": str(tmp_path)},
    ) as process:
        seen = process.stderr.readline() + process.stderr.readline()
        assert "Still serving" in seen
        address = seen.split(" runs at ")[1].split(";")[0]
        assert httpx.get(f"{address}/readyz").status_code == 200
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert "Traceback" not in err
    with pytest.raises(httpx.ConnectError):
        httpx.get(address)
    assert "6 cusps" in out


def test_a_table_for_a_paper(run_here: Run) -> None:
    done = run_here("solve", "zein-flat", "--l1", "10", "--digits", "6", "--format", "latex")
    assert done.returncode == 0
    assert done.stdout == latex_table(table_document(EXAMPLES["zein-flat"], 10, digits=15), 6)
    cited = run_here("cite", "-", stdin=json.dumps(table_document(EXAMPLES["zein-flat"], 10, digits=20)))
    assert cited.stdout.startswith("@software{rpr-cusps-3af2cfa0,\n")


def test_what_has_no_geometry_cannot_be_cited(run_here: Run) -> None:
    done = run_here("cite", "-", stdin="{}")
    assert done.returncode == 2
    assert done.stderr == "rpr-cusps cite: FILE: has no geometry; give an answer of rpr-cusps as JSON\n"
    done = run_here("cite", "-", stdin="[]")
    assert done.stderr.startswith("rpr-cusps cite: FILE: ")
