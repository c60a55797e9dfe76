"""The work of a verification follows from the length of the document, and is counted."""

from __future__ import annotations

import json
import random
from typing import Any

import pytest

from rpr_solver import ClaimStatus, InputError, Manipulator, table_document, verify_document
from rpr_solver.verify import documents
from rpr_solver.verify.claims import Outcome
from rpr_solver.verify.core.work import ExhaustedError, bounded, spend
from tests.rpr_solver.verify.forgeries import base


def test_products_of_long_numbers_count_more() -> None:
    with bounded(10**9) as left:
        spend(10)
        short = 10**9 - left[0]
        spend(10, 10_000)
        assert 10**9 - left[0] > 50 * short
    spend(10**12)  # nothing is counted outside
    with pytest.raises(ExhaustedError), bounded(5):
        spend(6)


def test_what_is_left_is_open_and_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(documents, "UNITS_OF_A_CHARACTER", 1)
    verification = verify_document(base("table"))
    assert verification.outcome is Outcome.NOT_ESTABLISHED
    assert verification.claims[-1].status is ClaimStatus.NOT_CHECKED
    assert "what is not named here (the document)" in verification.summary
    assert verify_document(base("table"), effort=100).established
    with pytest.raises(InputError, match="effort"):
        verify_document(base("table"), effort=0)


def _long_sides(digits: int) -> list[str]:
    draw = random.Random(digits)
    return [f"{x}.{draw.randrange(10**digits):0{digits}}1" for x in (15, 1, 10, 17, 16, 20)]


def _of_many_parts(count: int) -> dict[str, Any]:
    """A table of many slices without cusps, which takes as long as one of as many with cusps."""
    document = base("table")
    part = {"count": 0, "cusps": [], "degenerate_points": []}
    document["slices"] = [{"l1": f"{n}.5", **part} for n in range(1, count)]
    return document


@pytest.mark.parametrize(
    "make",
    [
        lambda: _of_many_parts(500),
        lambda: table_document(Manipulator(*_long_sides(60)), "14.98", digits=15),
        lambda: {
            **base("report"),
            "intervals": [{"from": "36", "to": "38", "count": 4}],
            "violations": [],
            "passed": True,
            "max_cusps_found": 4,
            "min_cusps_found": 4,
        },
    ],
)
def test_no_document_takes_more_than_its_length_allows(make: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(documents, "UNITS_OF_A_CHARACTER", 4)  # a twentieth, to save time
    spent: list[int] = []

    def counted(units: int) -> Any:
        manager = bounded(units)

        class Counted:
            def __enter__(self) -> list[int]:
                self.left = manager.__enter__()
                return self.left

            def __exit__(self, *error: Any) -> None:
                manager.__exit__(*error)
                spent.append(units - self.left[0])

        return Counted()

    monkeypatch.setattr(documents, "bounded", counted)
    document = make()
    verify_document(document)
    allowed = 4 * max(100_000, 2 * len(json.dumps(document)))
    # a single step may overrun what is left, by no more than its own size
    assert spent[0] < 2 * allowed
