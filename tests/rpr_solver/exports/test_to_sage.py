"""Scripts for SageMath, run where it is installed; anywhere they are Python."""

import shutil
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, Manipulator, export
from tests.support.scripts import RATIONAL, said, table


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
