"""Tables for a reader never print two different lengths alike."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.cli import pages
from service.cli.digits import are_alike, printed, rounded
from tests.support.cli_process import Run

NEAR_SIMILAR = {"a2x": 30, "a3x": 0, "a3y": "40.00001", "d1": 15, "d2": 25, "d3": 20}
RANGE = ("--l1-range", "14:16", "--digits", "15")


def ends_of(table: str) -> list[tuple[str, str]]:
    """The ends of the windows in a printed table."""
    lines = table.split("\nfrom ")[1].split("\n\n")[0].splitlines()[1:]
    return [(words[0], words[1]) for line in lines if (words := line.split())[2:]]


@pytest.fixture
def robot(tmp_path: Path) -> str:
    path = tmp_path / "robot.json"
    path.write_text(json.dumps(NEAR_SIMILAR))
    return str(path)


def test_a_census(run_here: Run, robot: str) -> None:
    document = json.loads(run_here("census", robot, *RANGE, "--format", "json").stdout)
    assert are_alike(document)
    table = run_here("census", robot, *RANGE).stdout
    ends = ends_of(table)
    assert all(low != high for low, high in ends)
    assert [high for _, high in ends[:-1]] == [low for low, _ in ends[1:]]
    assert len(ends) == len(document["intervals"])


def test_a_check(run_here: Run, robot: str) -> None:
    args = ("check", robot, *RANGE, "--max-cusps", "0", "--jobs", "1")
    report = json.loads(run_here(*args, "--format", "json").stdout)["checks"][0]["report"]
    assert are_alike({"violations": report["violations"]})
    done = run_here(*args, "--junit", f"{robot}.xml")
    assert done.returncode == 1
    ends = ends_of(done.stdout)
    assert len(ends) == len(report["violations"])
    assert all(low != high for low, high in ends)
    xml = Path(f"{robot}.xml").read_text()
    assert all(low in xml and high in xml for low, high in ends[1:-1])


def document(digits: int, *lengths: str) -> dict[str, Any]:
    cut = [length[: digits + 1] for length in lengths]
    intervals = [{"from": low, "to": high, "count": 0} for low, high in pairwise(["0", *cut])]
    transitions = [{"l1": length, "kind": "lips", "events": [{"l2": "1.5"}]} for length in cut]
    return {"fixed_leg": 1, "digits": digits, "intervals": intervals, "transitions": transitions}


@given(st.lists(st.integers(0, 10**29), min_size=1, max_size=5, unique=True))
def test_different_lengths_are_shown_differently(parts: list[int]) -> None:
    lengths = [f"1.00000000000000{part:030}" for part in sorted(parts)]
    asked: list[int] = []

    def ask(digits: int) -> dict[str, Any]:
        asked.append(digits)
        return document(digits, *lengths)

    before = document(15, *lengths)
    shown = printed(before, 15, ask)
    found = [transition["l1"] for transition in shown["transitions"]]
    assert len(set(found)) == len(parts)
    assert [part["to"] for part in shown["intervals"]] == found
    assert [part["from"] for part in shown["intervals"]][1:] == found[:-1]
    assert all(text.startswith("1.0000") and abs(float(text) - 1) < 1e-14 for text in found)
    assert before == document(15, *lengths)
    assert asked == [30, 60][: (len(parts) > 1) + bool(asked and asked[-1] == 60)]


NUMBERS = st.from_regex(r"1\.[0-2]{1,12}", fullmatch=True)


@given(st.lists(NUMBERS, min_size=1, max_size=6), st.integers(3, 20))
def test_cells_that_differ_still_do_when_they_are_cut(cells: list[str], width: int) -> None:
    short = pages.fitted_column(cells, width)
    assert len(set(short)) == len(set(cells))
    for cell, text in zip(cells, short, strict=True):
        assert cell.startswith(text.rstrip("…"))


def test_sensitivities_which_have_fewer_digits_are_rounded_too() -> None:
    event = {"sensitivity": {"a2x": "-0.86453449186758903132", "d1": None}, "alpha_deg": "1.25"}
    shown = rounded({"digits": 22, "transitions": [{"events": [event]}]}, 6)
    assert shown["transitions"][0]["events"] == [
        {"sensitivity": {"a2x": "-0.864534", "d1": None}, "alpha_deg": "1.25"}
    ]
