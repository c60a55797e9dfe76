"""docs/article.md: every figure is what its script computes, and prose has no figures of its own."""

import re

import pytest

from docs import article

DEAR = ("counts", "scan", "maxima", "eighteen", "few", "factors", "conjecture")
TEXT = article.FILE.read_text(encoding="utf-8")
PART = re.compile(r"<!-- (\w+) -->\n.*?<!-- end -->\n", re.DOTALL)
AS_PRINTED = {"0.1", "12.52"}
"""Decimals of the article that its tables do not have: its step, and one that is wrong."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long) if name in DEAR else name for name in article.PARTS]
)
def test_a_part_is_what_is_computed(name: str) -> None:
    assert article.written(TEXT, [name]) == TEXT, "run `python docs/article.py`"


def test_the_page_has_every_part() -> None:
    assert PART.findall(TEXT) == list(article.PARTS)
    with pytest.raises(ValueError, match="no place for tables"):
        article.written("", ["tables"])


def test_decimals_in_prose_are_in_a_part() -> None:
    prose = re.sub(r"```.*?```|`[^`]*`|\]\([^)]*\)", "", PART.sub("", TEXT), flags=re.DOTALL)
    decimals = set(re.findall(r"\d+\.\d+", prose))
    known = set(re.findall(r"\d+\.\d+", "".join(found[0] for found in PART.finditer(TEXT))))
    assert decimals
    assert {x for x in decimals - AS_PRINTED if not any(y.startswith(x) for y in known)} == set()


def test_the_tables_of_the_article_are_right_but_for_one_number() -> None:
    """Digit by digit, cut after the second place; and no cusp is missing or left over."""
    wrong = []
    for key, rows in article.PRINTED.items():
        pairs = list(article.compared(*key))
        assert len({proved for _, proved in pairs}) == len(rows) == article.slice_of(*key).count
        wrong += [(a, b) for pair in pairs for a, b in zip(*pair, strict=True) if a != article.cut(b)]
    [(printed, proved)] = wrong
    assert (printed, article.cut(proved)) == ("12.52", "12.65")


@pytest.mark.parametrize(
    ("name", "l1", "count"),
    [
        ("innocenti", "28.1", 10),
        ("zein-flat", "34.5", 8),
        ("twelve-cusps", "8.28", 12),
        ("fourteen-cusps", "5.96", 14),
        ("sixteen-cusps", "14.46845", 16),
        ("eighteen-cusps", "15.6431", 18),
    ],
)
def test_slices_with_more_cusps_than_the_article_found(name: str, l1: str, count: int) -> None:
    assert article.slice_of(name, l1).count == count > article.CLAIMED.get(name, 8)
