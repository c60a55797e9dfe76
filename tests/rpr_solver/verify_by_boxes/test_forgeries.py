"""The list of forgeries: each is refused, or its false claim is named in the first line."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from rpr_solver.verify_by_boxes.documents import KINDS
from tests.rpr_solver.verify_by_boxes.forgeries import BASES, FORGERIES, Forgery, base, first_line, is_named

CHEAP = ("table", "similar table", "poses", "loop", "range", "given", "motion", "signs", "aspect", "outside")
"""Documents whose forgeries take a tenth of a second each."""


def verified() -> list[Forgery]:
    """The forgeries of the kinds of documents that are read."""
    members = {member for member, _, _ in KINDS.values()}
    return [forgery for forgery in FORGERIES if members & base(forgery.base).keys()]


def cases() -> list[Any]:
    """All of cheap documents, of others one of each."""
    seen: Counter[str] = Counter()
    found = []
    for forgery in FORGERIES:
        runs = forgery.base in CHEAP or not seen[forgery.base]
        found.append(pytest.param(forgery, id=forgery.name, marks=[] if runs else [pytest.mark.long]))
        seen[forgery.base] += 1
    return found


def test_there_are_enough_of_all_kinds() -> None:
    assert len(FORGERIES) >= 150
    assert len({forgery.name for forgery in FORGERIES}) == len(FORGERIES)
    assert {forgery.base for forgery in FORGERIES} == set(BASES)


@pytest.mark.parametrize("forgery", cases())
def test_a_forgery_is_refused_or_its_claim_named(forgery: Forgery) -> None:
    line = first_line(forgery.text())
    assert is_named(line, forgery.at), line
