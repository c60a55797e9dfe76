"""What is not read is named, once for a whole document."""

from __future__ import annotations

from typing import Any

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, article_table, poses, table_document, verify_document
from rpr_solver.verify.unread import unread_claims

TABLE = table_document(EXAMPLES["zein-flat"], [10, 11], digits=15)


def names(kind: str, document: dict[str, Any]) -> list[str]:
    reasons = [claim.reason for claim in unread_claims(kind, document)]
    return [
        name for reason in reasons for name in reason.removeprefix("this verifier does not read ").split(", ")
    ]


def test_members_of_a_table_and_of_poses() -> None:
    diagnostics = ["slices/*/certificate/proofs", "slices/*/certificate/working_bits"]
    assert names("cusp-table", TABLE) == diagnostics
    noted = {**TABLE, "by": {"me": 1}, "slices": [*TABLE["slices"], {"l1": "1", "error": {}, "why": ""}]}
    assert names("cusp-table", noted) == ["by", *diagnostics, "slices/*/why"]
    document = poses(EXAMPLES["zein-flat"], 10, 20, 30, digits=15).to_json()
    assert names("poses", document) == ["certificate/method", "certificate/working_bits"]
    assert not names("poses", {**document, "certificate": {}})


def test_a_full_certificate_is_read_and_the_range_of_curves_only_with_one() -> None:
    document: dict[str, Any] = {"range": {}, "curves": [{"name": "C1", "colour": "red"}], "certificate": {}}
    assert names("cusp-curves", document) == ["curves/*/colour", "range"]
    full = {**document, "certificate": {"full": {"chains": []}}}
    assert names("cusp-curves", full) == ["curves/*/colour"]


def test_a_table_by_the_method_of_the_article_is_accepted() -> None:
    slice_ = article_table(EXAMPLES["zein-flat"], 10, digits=15).to_json()
    verification = verify_document({**TABLE, "method": "article", "slices": [slice_]})
    assert verification.accepted
    assert verification.claims[-1].claim == "these 4 cusps are all"
    open_claims = [claim.at for claim in verification.claims if claim.status is ClaimStatus.NOT_CHECKED]
    assert open_claims == ["", "/slices/0/certificate"]


@pytest.mark.parametrize(
    ("member", "name"),
    [("samples", "a path"), ("checks", "a list of reports of checks"), ("verdict", "a verification")],
)
def test_other_documents_are_named(member: str, name: str) -> None:
    with pytest.raises(
        ValueError, match=f"is, {name}, of no kind that can be verified; known are cusp-table"
    ):
        verify_document({member: []})
