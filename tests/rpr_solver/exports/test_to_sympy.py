"""Scripts for SymPy."""

from pathlib import Path

import pytest

from rpr_solver import census
from tests.support.scripts import RATIONAL, said, table


@pytest.mark.parametrize("wrong", [False, pytest.param(True, marks=pytest.mark.long)])
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
