"""Atlases: rows that depend on the seed and their number alone, made in several goes without loss."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from fractions import Fraction
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import census
from rpr_solver.transitions.atlas import atlas_geometry, atlas_row
from service.cli.design import kept_rows
from service.cli.main import main
from tests.support.processes import descendants, environment, is_running, started, until


def rows_of(path: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


@given(seed=st.integers(0, 9), index=st.integers(0, 10**6))
def test_a_geometry_is_not_flat_and_within_its_bounds(seed: int, index: int) -> None:
    m = atlas_geometry(seed, index)
    assert m == atlas_geometry(seed, index)
    assert m.a2x == 10
    assert abs(m.a3x) <= 20 >= m.a3y > 0
    assert max(m.d1, m.d2, m.d3) <= 40
    longest = max(m.d1, m.d2, m.d3)
    assert m.area16 / 4 / longest**2 >= (longest / 20) ** 2


def test_a_row_says_what_the_census_does() -> None:
    row, table = atlas_row(3, 5), census(atlas_geometry(3, 5), digits=15)
    assert row["most_cusps"] == max(table.counts)
    assert row["transitions"] == len(table.transitions)
    assert row["lengths"].keys() == {str(count) for count in table.counts}
    [last] = [name for name, length in row["lengths"].items() if length is None]
    assert int(last) == table.counts[-1]
    finite = sum(float(length) for length in row["lengths"].values() if length is not None)
    ends = [0.0, *(float(t.length) for t in table.transitions)]
    others = [b - a for a, b, n in zip(ends, ends[1:], table.counts, strict=False) if n != int(last)]
    assert finite == pytest.approx(sum(others))


def test_an_atlas_continues_where_it_was_killed(tmp_path: Path) -> None:
    path, count = tmp_path / "atlas.ndjson", 4
    command = [sys.executable, "-m", "service", "atlas", "--count", str(count), "-o", str(path)]
    with started(command, env=environment()) as process:
        until(lambda: path.exists() and path.read_bytes().count(b"\n") >= 1)
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    with path.open("ab") as file:
        file.write(b'{"seed":1,"ind')  # as if it had been killed while it wrote
    kept = path.read_bytes().rpartition(b"\n")[0]
    assert main(["atlas", "--count", str(count), "-o", str(path)]) == 0
    assert path.read_bytes().startswith(kept)
    rows = rows_of(path)
    assert [row["index"] for row in rows] == list(range(count))
    assert rows[-1] == atlas_row(1, count - 1)


def test_parquet_has_the_same_rows(tmp_path: Path) -> None:
    lines, target = tmp_path / "a.parquet.rows", tmp_path / "a.parquet"
    lines.write_text(json.dumps(atlas_row(2, 0)) + "\n")
    assert main(["atlas", "--count", "2", "--seed", "2", "-o", str(target)]) == 0
    assert not lines.exists()
    table = pq.read_table(target).to_pylist()
    for index, row in enumerate(table):
        own = atlas_row(2, index)
        assert row["geometry_hash"] == own["geometry_hash"]
        assert Fraction(row["d1"]) == atlas_geometry(2, index).d1
        assert row["most_cusps"] == own["most_cusps"]
        assert {str(x["cusps"]) for x in row["lengths"]} == own["lengths"].keys()


def test_what_is_no_atlas_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "other.ndjson"
    path.write_text('{"seed": 7, "index": 0}\n{"seed": 7, "index": 2}\n')
    assert main(["atlas", "--count", "2", "--seed", "7", "-o", str(path)]) == 2
    assert "line 2" in capsys.readouterr().err
    assert main(["atlas", "--count", "2", "-o", str(tmp_path / "atlas.csv")]) == 2
    assert main(["atlas", "--count", "0", "-o", str(path)]) == 2
    assert kept_rows(tmp_path / "none.ndjson", 1) == 0


QUICK = """
import sys, time
from service.cli import design
from service.cli.main import main
from rpr_solver.transitions import atlas as rows
def row(seed, index):
    time.sleep(0.0003)
    return {"seed": seed, "index": index, **rows.atlas_geometry(seed, index).identity_json()}
rows.atlas_row = row
design.usable_cores = lambda: 1
sys.exit(main(sys.argv[1:]))
"""
"""The command with rows that have no census."""


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(["-c", QUICK], id="without a census"),
        pytest.param(["-m", "service"], id="with", marks=pytest.mark.long),
    ],
)
@pytest.mark.long
def test_two_thousand_rows_are_killed_three_times(tmp_path: Path, command: list[str]) -> None:
    """The rows without a census take two seconds of processor time, mostly for four starts."""
    path, count = tmp_path / "atlas.ndjson", 2000
    whole = [sys.executable, *command, "atlas", "--count", str(count), "-o", str(path)]
    for kill in range(3):
        with started(whole, env=environment()) as process:
            least = 100 + 600 * kill
            while not path.exists() or path.read_bytes().count(b"\n") < least:
                assert process.poll() is None
                time.sleep(0.02)
            children = descendants(process.pid)
            os.kill(process.pid, signal.SIGKILL)
            process.wait()
            until(lambda children=children: not any(map(is_running, children)))  # type: ignore[misc]
        assert path.read_bytes().count(b"\n") < count
    with started(whole, env=environment()) as process:
        assert process.wait() == 0
    rows = rows_of(path)
    assert [row["index"] for row in rows] == list(range(count))
    known = [atlas_geometry(1, k).geometry_hash for k in range(count)]
    assert [row["geometry_hash"] for row in rows] == known
