"""The programs in other systems, run where those are installed; what is opened in them is closed."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, Manipulator, census, export
from tests.support.families import family
from tests.support.sampling import long
from tests.support.scripts import RATIONAL, said, table, verdict
from tests.support.shared import census_of

needs_pari = pytest.mark.skipif(shutil.which("gp") is None, reason="needs PARI/GP: apt-get install pari-gp")


@pytest.mark.parametrize(
    ("name", "l1", "count"), [("innocenti", "28.1", 10), ("sixteen-cusps", "14.46845", 16)]
)
@needs_pari
def test_pari_finds_the_same_cusps(name: str, l1: str, count: int, tmp_path: Path) -> None:
    status, lines = said(table(EXAMPLES[name], l1), "pari", tmp_path)
    assert (status, lines) == (0, [f"L1 = {l1}: {count} cusps, {count} expected: agrees", "agrees"])


@pytest.mark.parametrize("leg", [2, 3])
@needs_pari
def test_pari_with_another_leg_fixed_and_the_other_orientation(leg: int, tmp_path: Path) -> None:
    for m in (RATIONAL, EXAMPLES["twelve-cusps"]):
        status, lines = said(table(m, "2", "7.5", leg=leg), "pari", tmp_path)
        assert (status, lines[-1], len(lines)) == (0, "agrees", 3)


@pytest.mark.parametrize("change", ["digit", "missing", "more"])
@needs_pari
def test_pari_notices_what_is_wrong(change: str, tmp_path: Path) -> None:
    document = table(EXAMPLES["innocenti"], "14.98")
    part = document["slices"][0]
    if change == "digit":
        text = part["cusps"][2]["l3"]
        part["cusps"][2]["l3"] = text[:12] + str((int(text[12]) + 1) % 10) + text[13:]
    elif change == "missing":
        del part["cusps"][0]
        part["count"] = 5
    else:
        part["cusps"].append(part["cusps"][0])
        part["count"] = 7
    status, lines = said(document, "pari", tmp_path)
    assert (status, lines[-1]) == (1, "differs")


@pytest.mark.parametrize(
    ("m", "length", "leg"),
    [
        (Manipulator(30, 0, "40.0001", 15, 25, 20), "15.000000000049", 1),
        (Manipulator(30, 0, "40.000000001", 15, 25, 20), "44.9999999999835", 1),
        (Manipulator(8, "1/10000", -6, 3, 5, 4), "5.00000000045329695552709381445", 2),
    ],
    ids=["near similar", "nearer", "near a flat base"],
)
@needs_pari
def test_pari_agrees_beside_closed_legs(m: Manipulator, length: str, leg: int, tmp_path: Path) -> None:
    document = table(m, length, leg=leg)
    assert verdict(document, "pari", tmp_path) == "agrees"
    cusp = document["slices"][0]["cusps"][0]
    cusp["alpha_deg"] = cusp["alpha_deg"][:-1] + str((int(cusp["alpha_deg"][-1]) + 5) % 10)
    assert verdict(document, "pari", tmp_path) == "differs"


@needs_pari
def test_pari_tells_nodes_from_cusps_but_cannot_exclude_that_they_are_some(tmp_path: Path) -> None:
    document = table(family("congruent, mirrored"), "5")
    assert verdict(document, "pari", tmp_path) == "agrees"
    part = document["slices"][0]
    node = {name: text for name, text in part["degenerate_points"][0].items() if name != "kind"}
    part["cusps"], part["count"] = [node], 1
    assert verdict(document, "pari", tmp_path) == "cannot decide"
    node["l2"] = node["l2"][:-1] + str((int(node["l2"][-1]) + 5) % 10)
    assert verdict(document, "pari", tmp_path) == "differs"


@pytest.mark.parametrize("kind", ["swallowtail", "lips", "beak-to-beak"])
@pytest.mark.parametrize("name", ["alpha_deg", "l2"])
@needs_pari
def test_pari_notices_a_wrong_transition(kind: str, name: str, tmp_path: Path) -> None:
    document = json.loads(json.dumps(census_of(EXAMPLES["innocenti"]).to_json()))
    has_it = [t for t in document["transitions"] if any(event["kind"] == kind for event in t["events"])]
    document["intervals"], document["transitions"] = [], has_it[:1]
    assert verdict(document, "pari", tmp_path) == "agrees"
    (event,) = has_it[0]["events"]
    event[name] = event[name][:-1] + str((int(event[name][-1]) + 5) % 10)
    assert verdict(document, "pari", tmp_path) == "differs"


@pytest.mark.long
@needs_pari
def test_pari_agrees_with_a_census(tmp_path: Path) -> None:
    document = census(EXAMPLES["zein-flat"], digits=20).to_json()
    status, lines = said(document, "pari", tmp_path)
    assert (status, lines[-1], len(lines)) == (0, "agrees", 13 + 12 + 1)


@pytest.mark.parametrize("wrong", [pytest.param(False, marks=pytest.mark.slow), long(True)])
def test_sympy_finds_the_same_cusps(wrong: bool, tmp_path: Path) -> None:
    document = table(RATIONAL, "2", leg=2)
    if wrong:
        document["slices"][0]["count"] = 5
        del document["slices"][0]["cusps"][2]
    status, lines = said(document, "sympy", tmp_path)
    word = "differs" if wrong else "agrees"
    assert (status, lines) == (int(wrong), [f"L2 = 2: 6 cusps, {5 if wrong else 6} expected: {word}", word])


@pytest.mark.long
def test_sympy_agrees_with_a_census(tmp_path: Path) -> None:
    status, lines = said(census(RATIONAL, digits=20, start=2, stop=4).to_json(), "sympy", tmp_path)
    assert (status, lines[-1]) == (0, "agrees")


def test_the_script_is_python() -> None:
    compile(export(table(EXAMPLES["innocenti"], "14.98"), "sage"), "sage", "exec")


@pytest.mark.skipif(shutil.which("sage") is None, reason="needs SageMath: the program `sage` in the PATH")
@pytest.mark.parametrize(
    ("m", "length", "leg", "wrong"),
    [(RATIONAL, "2", 2, False), (RATIONAL, "2", 2, True), (EXAMPLES["innocenti"], "14.98", 1, False)],
    ids=["rational", "wrong", "irrational"],
)
def test_sage_finds_the_same_cusps(
    m: Manipulator, length: str, leg: int, wrong: bool, tmp_path: Path
) -> None:
    document = table(m, length, leg=leg)
    if wrong:
        document["slices"][0]["count"] = 5
        del document["slices"][0]["cusps"][2]
    word = "differs" if wrong else "agrees"
    status, lines = said(document, "sage", tmp_path)
    assert (status, lines) == (
        int(wrong),
        [f"L{leg} = {length}: 6 cusps, {5 if wrong else 6} expected: {word}", word],
    )


def test_brackets_procedures_loops_and_conditions_of_maple_are_closed() -> None:
    script = re.sub("#.*", "", export(table(EXAMPLES["innocenti"], "14.98"), "maple"))
    for word in ("proc", "do", "if"):
        opened = len(re.findall(rf"(?<!`)\b{word}\b(?!`)", script))
        assert opened == 2 * script.count(f"end {word}") > 0
    assert all(script.count(a) == script.count(b) > 0 for a, b in ("()", "[]"))
