"""The page for beginners and its notebook: links open what they say, cells run and show what is told."""

from __future__ import annotations

import ast
import json
import re
import shutil
import subprocess
from contextlib import redirect_stdout
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs

import pytest

from rpr_solver import EXAMPLES, cusp_table, poses
from rpr_solver.contract import number_of

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/cusps-in-ten-minutes.md").read_text(encoding="utf-8")
NOTEBOOK = ROOT / "docs/cusps-in-ten-minutes.ipynb"
EXPLORER = ROOT / "service/api/web/explorer"
LINKS = re.findall(r"\]\(http://127\.0\.0\.1:8000/(#[^)]+)\)", PAGE)
READER = """
import { faultOf, hashOf, stateOf } from "./state.js";
const read = (hash) => ({ state: stateOf(hash), again: stateOf(hashOf(stateOf(hash))) });
console.log(JSON.stringify(JSON.parse(process.argv[2]).map(read)));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="needs Node.js: apt-get install nodejs")
def test_the_explorer_understands_every_link(tmp_path: Path) -> None:
    """The page's own module reads it, and writes the same state into the address."""
    for name in ("state.js", "geometry.js", "decimals.js", "surds.js"):
        shutil.copy(EXPLORER / name, tmp_path)
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "read.js").write_text(READER, encoding="utf-8")
    command = ["node", "read.js", json.dumps(LINKS)]
    out = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    for link, found in zip(LINKS, json.loads(out), strict=True):
        state, given = found["state"], {name: value for name, [value] in parse_qs(link[1:]).items()}
        assert state == found["again"]
        geometry = {name: state["geometry"][name] for name in ("a2x", "a3x", "a3y", "d1", "d2", "d3")}
        assert ",".join([*geometry.values(), state["geometry"]["orientation"]]) == given.pop("g")
        assert (state["l1"], state["view"]) == (given.pop("l1"), given.pop("v"))
        assert state["cusp"] == number_of(given.pop("c", "A"), 26) - 1
        if at := given.pop("p", ""):
            assert at == f"{state['at']['l2']},{state['at']['l3']},{state['at']['pose'] + 1}"
        if limits := given.pop("b", ""):
            ends = [state["limits"][leg][end] for leg in ("l2", "l3") for end in ("min", "max")]
            assert ",".join(ends) == limits
        assert not given, "nothing that the page would overlook"


@pytest.mark.parametrize("link", LINKS)
def test_there_is_what_a_link_opens(link: str) -> None:
    given = {name: value for name, [value] in parse_qs(link[1:]).items()}
    robot = EXAMPLES["innocenti"]
    written = robot.to_json()
    assert given["g"] == ",".join(
        written[name] for name in ("a2x", "a3x", "a3y", "d1", "d2", "d3", "orientation")
    )
    if "c" in given:
        [table] = cusp_table(robot, given["l1"], digits=15)
        count = len(table.cusps)
        assert 1 <= number_of(given["c"], count) <= count
    if "p" in given:
        l2, l3, pose = given["p"].split(",")
        assert int(pose) <= len(poses(robot, given["l1"], l2, l3, digits=15).poses)


@cache
def shown() -> dict[str, Any]:
    """What each cell of the notebook shows: the value of its last line, or what it prints, in one session."""
    session: dict[str, Any] = {}
    found = {}
    for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            *before, last = ast.parse("".join(cell["source"])).body
            is_value, printed = isinstance(last, ast.Expr), StringIO()
            with redirect_stdout(printed):
                exec(
                    compile(ast.Module(before if is_value else [*before, last], []), cell["id"], "exec"),
                    session,
                )
                if isinstance(last, ast.Expr):
                    found[cell["id"]] = eval(compile(ast.Expression(last.value), cell["id"], "eval"), session)
                else:
                    found[cell["id"]] = printed.getvalue()
    return found


def test_the_notebook_runs_and_shows_what_it_tells() -> None:
    found = shown()
    for name in ("begin", "mechanism", "slice", "loop", "torus", "census"):
        assert found[name]._repr_svg_().startswith("<svg ")
    for name in ("six-poses", "cusps"):
        assert found[name]._repr_html_().count("<tr") > 6
    assert len(found["six-poses"].poses) == 6
    assert len(found["cusps"].cusps) == 8
    assert float(found["orientation"]) == pytest.approx(52.2, abs=0.05)
    assert found["ends"] == (2, 3)
    assert found["control"] == ("possible", "impossible")
    most, lengths = found["most"]
    assert most == 10
    assert lengths == sorted(lengths)
    assert [round(x, 4) for x in lengths if 28 < x < 28.2] == [28.0949, 28.1074]
    assert found["exercise-1"] == 2
    assert sorted(found["exercise-2"]) == ["beak-to-beak", "swallowtail"]
    assert set(found["exercise-3"]) == {0}
    assert found["exercise-4"] == (True, 47.6, 56.2)


def test_three_poses_of_four_merge_on_the_way_to_the_cusp() -> None:
    cusp, spreads = float(shown()["orientation"]), []
    for line in shown()["merging"].splitlines():
        alphas = [float(text) for text in re.findall(r"'(.*?)'", line)]
        assert len(alphas) == 4
        near = sorted(alphas, key=lambda alpha: abs(alpha - cusp))[:3]
        spreads.append(max(near) - min(near))
    assert spreads == sorted(spreads, reverse=True)
    assert spreads[-1] < 1 < 15 < spreads[0]
