"""The list of forgeries: each is refused, or its false claim is named in the first line."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from tests.rpr_solver.verify.forgeries import BASES, FORGERIES, Forgery, first_line, is_named

CHEAP = ("table", "similar table", "poses", "loop", "range", "given", "motion", "signs", "aspect", "outside")
"""Documents whose forgeries take a tenth of a second each."""


def cases() -> list[Any]:
    """All of cheap documents, of others one of each; curves take five seconds, but for what is read."""
    seen: Counter[str] = Counter()
    found = []
    for forgery in FORGERIES:
        runs = forgery.base in CHEAP or (forgery.base != "curves" and not seen[forgery.base])
        runs = runs or forgery.name == "a cusp of number 0"
        name = f"{forgery.name} of {forgery.base}"
        found.append(pytest.param(forgery, id=name, marks=[] if runs else [pytest.mark.long]))
        seen[forgery.base] += 1
    return found


def test_there_are_enough_of_all_kinds() -> None:
    assert len(FORGERIES) >= 150
    assert len({(forgery.name, forgery.base) for forgery in FORGERIES}) == len(FORGERIES)
    assert {forgery.base for forgery in FORGERIES} == set(BASES)


@pytest.mark.parametrize("forgery", cases())
def test_a_forgery_is_refused_or_its_claim_named(forgery: Forgery) -> None:
    line = first_line(forgery.text())
    assert is_named(line, forgery.at), line
