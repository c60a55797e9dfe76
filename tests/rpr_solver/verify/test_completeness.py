"""What a full certificate says about the transitions and what is degenerate."""

from __future__ import annotations

from typing import Any

import pytest

from rpr_solver import ClaimStatus, Manipulator, census, verify_document
from rpr_solver.verify.completeness import Completeness, degenerate_claims

DOCUMENT = census(Manipulator(9, 4, 11, 14, 15, 13), digits=15, start=24, certificate="full").to_json()
FULL = "/certificate/full"


def test_a_sample_outside_its_interval_and_what_is_not_degenerate() -> None:
    document = DOCUMENT
    samples = document["certificate"]["full"]["samples"]
    samples[0], samples[1] = samples[1], samples[0]
    document["degenerate"] = [{"kind": "node", "from": "24", "to": None, "count": 2}]
    refused = {claim.at for claim in verify_document(document).refused}
    assert refused == {f"{FULL}/samples/0", f"{FULL}/samples/1", "/degenerate"}


NODES = {"kind": "node", "from": "3", "to": "5", "count": 2}
CURVE = {"kind": "curve", "from": "4", "to": "4", "equation": None}


@pytest.mark.parametrize(
    ("listed", "generic", "status"),
    [
        ([], [True, True], ClaimStatus.CHECKED),
        ([NODES], [True, False], ClaimStatus.CHECKED),
        ([NODES], [False, True], ClaimStatus.REFUSED),
        ([], [True, False], ClaimStatus.NOT_CHECKED),
        ([], [True, None], ClaimStatus.NOT_CHECKED),
        ([CURVE], [True, True], ClaimStatus.CHECKED),
    ],
)
def test_nothing_degenerate_where_all_roots_are_simple(
    listed: list[dict[str, Any]], generic: list[bool | None], status: ClaimStatus
) -> None:
    document = {"degenerate": listed, "intervals": [{"from": "0", "to": "3"}, {"from": "3", "to": None}]}
    [claim] = degenerate_claims(document, generic, None)
    assert claim.status is status


def test_a_complete_certificate_leaves_nothing_degenerate() -> None:
    for listed, status in (([], ClaimStatus.CHECKED), ([NODES], ClaimStatus.REFUSED)):
        [claim] = degenerate_claims({"degenerate": listed}, [], Completeness((), ()))
        assert claim.status is status
    assert Completeness((), None).transitions().status is ClaimStatus.NOT_CHECKED
    assert "left open: this" in Completeness((), ("this",)).transitions().reason
