"""The verdict: its first line names each claim that is not proved."""

from __future__ import annotations

from rpr_solver.boxes import Undecided
from rpr_solver.verify.claims import (
    Claim,
    ClaimStatus,
    Open,
    Refused,
    Verdict,
    Verification,
    claim_by,
    demand,
    open_claim,
)


def _verification(*claims: Claim) -> Verification:
    return Verification("cusp-table", "sha256:…", "5", claims, ("/solver_version",))


def _raises(error: Exception) -> Claim:
    def proof() -> str:
        raise error

    return claim_by("/at", "a claim", proof)


def test_a_claim_stands_as_its_proof_decides() -> None:
    assert claim_by("/at", "a claim", lambda: "so") == Claim("/at", "a claim", ClaimStatus.PROVED, "so")
    assert _raises(Open("why")) == open_claim("/at", "a claim", "why")
    assert _raises(Refused("why")).status is ClaimStatus.REFUSED
    assert _raises(Undecided()).status is _raises(OverflowError()).status is ClaimStatus.OPEN
    assert claim_by("/at", "a claim", lambda: demand(False, "why")).reason == "why"


def test_the_worst_claim_decides_the_verdict() -> None:
    proved, left, wrong = (
        claim_by("/a", "x", lambda: ""),
        open_claim("/b/0", "y", ""),
        _raises(Refused("")),
    )
    assert _verification(proved, proved).summary == "VERIFIED: 2 claims"
    assert _verification(proved, proved)
    assert _verification(proved, left).summary == "NOT VERIFIED: y (/b/0)"
    assert not _verification(proved, left)
    assert _verification(proved, left, wrong).summary == "REFUSED: a claim (/at)"
    assert _verification(left, wrong).verdict is Verdict.REFUSED


def test_the_answer_has_all_claims_and_where_those_are_that_are_not_proved() -> None:
    answer = _verification(claim_by("/a", "x", lambda: "so"), open_claim("/b", "y", "why")).to_json()
    assert (answer["verdict"], answer["open"], answer["refused"]) == ("not verified", ["/b"], [])
    assert answer["claims"][0] == {"at": "/a", "claim": "x", "status": "proved", "reason": "so"}
