"""CSV that a spreadsheet may open: no cell is a formula, and every cell can be read back."""

from __future__ import annotations

import csv
import io
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.notebook.tables import csv_text, read_cell

STARTS = "=+-@\t\r\n'"
NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+)?(e[0-9]+)?(/[0-9]+)?")
TEXTS = st.text(st.sampled_from(STARTS + '1a.,;e/ "é'), max_size=8)


def written(name: str, *cells: object) -> list[str]:
    head, *rows = csv.reader(io.StringIO(csv_text([name, "more"], ({name: x, "more": 0} for x in cells))))
    assert head == [name, "more"]
    return [row[0] for row in rows]


@given(st.lists(TEXTS, min_size=1))
@pytest.mark.parametrize("column", ["id", "error"])
def test_a_text_is_no_formula_and_comes_back(column: str, texts: list[str]) -> None:
    cells = written(column, *texts)
    assert [read_cell(cell) for cell in cells] == texts
    numbers = [] if column == "id" else [cell for cell in cells if NUMBER.fullmatch(cell)]
    assert not any(cell.startswith(tuple("=+-@\t\r\n")) for cell in cells if cell not in numbers)


@pytest.mark.parametrize("text", ['=HYPERLINK("x";"k")', "@SUM(1)", "-2+3", "+1", "-5", "\t=1", "\r=1", "'a"])
def test_an_apostrophe_comes_first(text: str) -> None:
    assert written("id", text) == [f"'{text}"]


@given(st.from_regex(r"-?(0|[1-9][0-9]{0,20})(\.[0-9]{1,20})?(e[+-][0-9]{1,3})?", fullmatch=True))
def test_numbers_stay(text: str) -> None:
    assert written("l2", text, text) == [text, text]
