"""What a verification says."""

from rpr_solver import Claim, ClaimStatus, Verification


def test_a_verification_counts_its_claims() -> None:
    claims = [Claim(f"/slices/{n}", "a claim", status, "so") for n, status in enumerate(ClaimStatus)]
    whole = Verification("cusp-table", "sha256:0", "4", tuple(claims))
    assert (whole.accepted, whole.verdict) == (False, "refused")
    assert whole.refused == (claims[-1],)
    answer = whole.to_json()
    assert answer["counts"] == {"proved": 1, "checked": 1, "not_checked": 1, "refused": 1}
    assert answer["claims"][0] == {"at": "/slices/0", "claim": "a claim", "status": "proved", "reason": "so"}
    assert (
        repr(whole) == "<Verification of cusp-table: refused; 1 proved, 1 checked, 1 not checked, 1 refused>"
    )
