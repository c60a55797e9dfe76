"""What a verification says."""

from rpr_solver import Claim, ClaimStatus, Verification
from rpr_solver.verify.claims import Outcome


def test_a_verification_counts_its_claims() -> None:
    claims = [Claim(f"/slices/{n}", "a claim", status, "so") for n, status in enumerate(ClaimStatus)]
    whole = Verification("cusp-table", "sha256:0", "4", tuple(claims), ("/slices/*/audit",))
    assert (whole.accepted, whole.verdict) == (False, "refused")
    assert whole.refused == (claims[-1],)
    answer = whole.to_json()
    assert answer["counts"] == {"proved": 1, "checked": 1, "not_checked": 1, "refused": 1}
    first = {"at": "/slices/0", "claim": "a claim", "status": "proved", "reason": "so", "established": True}
    assert answer["claims"][0] == first
    assert (answer["outcome"], answer["unread"]) == ("refused", ["/slices/*/audit"])
    assert answer["summary"] == "REFUSED: a claim (/slices/3)"
    assert (
        repr(whole) == "<Verification of cusp-table: refused; 1 proved, 1 checked, 1 not checked, 1 refused>"
    )


def test_the_first_line_names_what_is_open() -> None:
    proved = Claim("/poses", "these are all", ClaimStatus.PROVED, "so")
    drawn = Claim("/transitions", "these are all", ClaimStatus.CHECKED, "so", "2^-200")
    some = [Claim(f"/intervals/{n}/count", f"{n} cusps", ClaimStatus.CHECKED, "so") for n in (0, 1)]

    def whole(*claims: Claim) -> Verification:
        return Verification("census", "sha256:0", "4", claims, ("/solver_version",))

    assert whole(proved, drawn).outcome is Outcome.ESTABLISHED
    assert whole(proved, drawn).summary == (
        "ESTABLISHED: all 2 claims of this census, but for an error probability below 2^-200; "
        "not read, so not established: /solver_version"
    )
    assert whole(proved, *some).accepted
    assert not whole(proved, *some).established
    assert whole(proved, *some).summary.startswith(
        "NOT ESTABLISHED, though nothing is refuted: 0 cusps, … (/intervals/*/count, 2 times); not read"
    )
