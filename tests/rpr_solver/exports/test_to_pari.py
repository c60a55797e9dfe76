"""Scripts for PARI/GP, run where it is installed."""

import shutil
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, census
from tests.support.scripts import RATIONAL, said, table

pytestmark = pytest.mark.skipif(shutil.which("gp") is None, reason="needs PARI/GP: apt-get install pari-gp")


@pytest.mark.parametrize(
    ("name", "l1", "count"), [("innocenti", "28.1", 10), ("sixteen-cusps", "14.46845", 16)]
)
def test_pari_finds_the_same_cusps(name: str, l1: str, count: int, tmp_path: Path) -> None:
    status, lines = said(table(EXAMPLES[name], l1), "pari", tmp_path)
    assert (status, lines) == (0, [f"L1 = {l1}: {count} cusps, {count} expected: agrees", "agrees"])


@pytest.mark.parametrize("leg", [2, 3])
def test_pari_with_another_leg_fixed_and_the_other_orientation(leg: int, tmp_path: Path) -> None:
    for m in (RATIONAL, EXAMPLES["twelve-cusps"]):
        status, lines = said(table(m, "2", "7.5", leg=leg), "pari", tmp_path)
        assert (status, lines[-1], len(lines)) == (0, "agrees", 3)


@pytest.mark.parametrize("change", ["digit", "missing", "more"])
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


@pytest.mark.long
def test_pari_agrees_with_a_census(tmp_path: Path) -> None:
    document = census(EXAMPLES["zein-flat"], digits=20).to_json()
    status, lines = said(document, "pari", tmp_path)
    assert (status, lines[-1], len(lines)) == (0, "agrees", 13 + 12 + 1)
