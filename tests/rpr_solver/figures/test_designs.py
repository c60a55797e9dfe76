"""Designs as pictures: each improvement, both censuses, and what is wanted of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rpr_solver.figures.views import figure_of
from service.cli.main import main
from tests.support.pictures import GEOMETRY, check, words
from tests.support.sampling import long, sample


def table(*ends: tuple[str, str | None, int]) -> dict[str, Any]:
    return {"intervals": [{"from": a, "to": b, "count": n} for a, b, n in ends]}


def document(objective: str = "longest-range", stop: str | None = "30", **wish: int | None) -> dict[str, Any]:
    values = [(1, "0", False), (12, "2.5", False), (40, "4.125", True)]
    counts = {"min_cusps": None, "max_cusps": None, **wish}
    return {
        "geometry": GEOMETRY,
        "fixed_leg": 2,
        "asked": {"objective": objective, "requirement": {**counts, "range": {"from": "5", "to": stop}}},
        "start": {"value": "0", "met": False, "census": table(("5", "9", 6), ("9", stop, 8))},
        "best": {
            "geometry": GEOMETRY,
            "value": "4.125",
            "met": True,
            "census": table(("5", "25.875", 6), ("25.875", stop, 4)),
        },
        "trace": [{"census": n, "value": value, "met": met} for n, value, met in values],
        "censuses": 50,
        "stopped": "budget",
    }


@pytest.mark.parametrize(
    "wish", [{"max_cusps": 4}, long({"min_cusps": 6}), long({"min_cusps": 2, "max_cusps": 40}), {}]
)
@pytest.mark.parametrize("stop", sample(["30", None], 0))
def test_all_that_was_found_is_shown(wish: dict[str, int], stop: str | None) -> None:
    figure = figure_of(document("least-change", stop, **wish))
    check(figure)
    assert figure.title == "Best found: least-change, 4.125 (met)"
    assert {"given", "best found", "L2", "change"} <= set(words(figure))
    assert "0 at census 1; 2.5 at census 12; 4.125 at census 40." in figure.description
    end = "∞" if stop is None else "30"
    assert f"6 from 5 to 9; 8 from 9 to {end}" in figure.description
    assert f"6 from 5 to 25.875; 4 from 25.875 to {end}" in figure.description
    assert "50 censuses, stopped: budget" in figure.description


def test_the_command_draws_the_document_in_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, target = tmp_path / "design.json", tmp_path / "design.svg"
    path.write_text(json.dumps(document(max_cusps=4)))
    assert main(["plot", str(path), "--kind", "design", "--theme", "dark", "-o", str(target)]) == 0
    assert target.read_text() == figure_of(document(max_cusps=4)).styled(theme="dark").svg()
    path.write_text(json.dumps(GEOMETRY))
    assert main(["plot", str(path), "--kind", "design"]) == 2
    assert "has no design; give what design --format json writes" in capsys.readouterr().err
