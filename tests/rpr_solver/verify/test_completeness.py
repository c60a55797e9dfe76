"""What a full certificate says about the transitions and what is degenerate."""

from __future__ import annotations

from rpr_solver import ClaimStatus, Manipulator, census, verify_document
from rpr_solver.verify.completeness import Completeness

DOCUMENT = census(Manipulator(9, 4, 11, 14, 15, 13), digits=15, start=24, certificate="full").to_json()
FULL = "/certificate/full"


def test_a_sample_outside_its_interval_and_what_is_not_degenerate() -> None:
    document = DOCUMENT
    samples = document["certificate"]["full"]["samples"]
    samples[0], samples[1] = samples[1], samples[0]
    document["degenerate"] = [{"kind": "node", "from": "24", "to": None, "count": 2}]
    refused = {claim.at for claim in verify_document(document).refused}
    assert refused == {f"{FULL}/samples/0", f"{FULL}/samples/1", "/degenerate"}


def test_a_complete_certificate_leaves_nothing_degenerate() -> None:
    complete = Completeness((), ())
    nodes = {"kind": "node", "from": "3", "to": "5", "count": 2}
    assert complete.degenerate([]).status is ClaimStatus.CHECKED
    assert complete.degenerate([nodes]).status is ClaimStatus.REFUSED
    assert Completeness((), None).transitions().status is ClaimStatus.NOT_CHECKED
    assert "left open: this" in Completeness((), ("this",)).transitions().reason
