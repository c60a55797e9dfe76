"""What is degenerate throughout: right entries, and wrong ones."""

from __future__ import annotations

from typing import Any

import pytest

from rpr_solver import ClaimStatus, census
from rpr_solver.verify.degenerate import degenerate_claims
from rpr_solver.verify.manipulator import Geometry
from tests.support.families import family

NODES = {"kind": "node", "from": "3", "to": "5", "count": 2}
CURVE = {"kind": "curve", "from": "4", "to": "4", "equation": None}
PARTS = [{"from": "0", "to": "3"}, {"from": "3", "to": None}]


def status(
    name: str, entries: list[dict[str, Any]], parts: object, generic: list[bool | None]
) -> ClaimStatus:
    geometry = Geometry.of(family(name).identity_json())
    [claim] = degenerate_claims(geometry, 1, entries, parts, generic)  # type: ignore[arg-type]
    return claim.status


@pytest.mark.parametrize(
    ("entries", "generic", "expected"),
    [
        ([], [True, True], ClaimStatus.CHECKED),
        ([CURVE], [True, True], ClaimStatus.CHECKED),
        ([NODES], [False, True], ClaimStatus.REFUSED),
    ],
)
def test_nothing_is_where_all_roots_are_simple(
    entries: list[dict[str, Any]], generic: list[bool | None], expected: ClaimStatus
) -> None:
    assert status("similar", entries, PARTS, generic) is expected


@pytest.mark.parametrize(
    ("name", "change"),
    [
        pytest.param("similar", {"count": 3}, marks=pytest.mark.long),
        pytest.param("similar", {"kind": "isolated-point"}, marks=pytest.mark.long),
        pytest.param("both flat", {"kind": "node"}, marks=pytest.mark.long),
        ("congruent", {"equation": "alpha = 180 deg"}),
    ],
)
def test_kinds_numbers_and_curves(name: str, change: dict[str, object]) -> None:
    document = census(family(name), digits=15).to_json()
    entries, parts = document["degenerate"], document["intervals"]
    right = ClaimStatus.NOT_CHECKED if name == "congruent" else ClaimStatus.CHECKED
    assert status(name, entries, parts, [False]) is right
    changed = [{**entries[0], **change}, *entries[1:]]
    assert status(name, changed, parts, [False]) is ClaimStatus.REFUSED
    assert status(name, entries[1:], parts, [False]) is ClaimStatus.REFUSED
