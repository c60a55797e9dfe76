"""Numbers are shortened, words are not, and everything fits."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.cli import pages
from service.cli.output import Stages

NUMBERS = st.from_regex(r"-?[0-9]{1,4}\.[0-9]{1,90}(e-[0-9]{1,3})?", fullmatch=True)
WORDS = st.sampled_from(
    ["swallowtail", "beak-to-beak", "", "8 → 10", "426/25", "C14", "k1 = k3 = 0: the first column vanishes"]
)


@given(NUMBERS, st.integers(0, 120))
def test_a_shortened_number_begins_as_the_number_and_keeps_its_exponent(text: str, width: int) -> None:
    short = pages.shortened(text, width)
    if short != text:
        assert len(short) < len(text)
        begin, end = short.split("…")
        assert text.startswith(begin)
        assert text.endswith(end)
        assert re.search(r"\.\d\d", begin)
        assert end.startswith("e") or not end


@given(st.lists(st.tuples(WORDS, NUMBERS, NUMBERS, WORDS), min_size=1, max_size=5), st.integers(20, 200))
def test_columns_fit_or_become_records(rows: list[tuple[str, ...]], width: int) -> None:
    table = [("kind", "L2", "L3", "joins"), *rows]
    widths = pages.column_widths(table, width)
    if widths is None:
        shown = "\n".join(pages.records(table, width))
        words = {word for row in rows for cell in (row[0], row[3]) for word in cell.split()}
        assert words <= set(shown.split())
        return
    assert sum(widths) + pages.COLUMN_PADDING * len(widths) + 1 <= width
    for row in table:
        for cell, room in zip(row, widths, strict=True):
            lines = pages.fitted(cell, room).splitlines()
            assert max(map(len, lines), default=0) <= room
            assert "…" in "".join(lines) or " ".join(lines).split() == cell.split()


@pytest.mark.parametrize("width", [20, 40, 80])
def test_lines_break_between_words_and_never_within_an_equation(width: int) -> None:
    text = "3-RPR manipulator  a2x = 15.91  a3x = 0  a3y = 10  d1 = 17.04  (ccw)"
    lines = pages.wrapped(text, width)
    assert max(map(len, lines)) <= width
    assert " ".join(" ".join(lines).split()) == " ".join(text.split())
    assert not any(re.search(r"(^=|=$)", line.strip()) for line in lines)


def test_numbers_in_a_sentence_are_shortened_to_fit() -> None:
    text = "swallowtail: α [deg] 12.3456789012345678901234567890, θ1 [deg] -1.23456789012345678901e-5"
    short = pages.with_short_numbers(text, 60)
    assert short == "swallowtail: α [deg] 12.3456789012…, θ1 [deg] -1.2345678…e-5"
    assert pages.with_short_numbers(text, 200) == text


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(1, 500)), max_size=20))
def test_progress_never_runs_backwards(steps: list[tuple[int, int]]) -> None:
    stages = Stages()
    shown = [(stage, done / total) for stage, done, total in (stages.at(*step) for step in steps)]
    assert shown == sorted(shown)
