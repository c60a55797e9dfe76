"""Margins: alterations of right documents are refused, or the claim that is left open is named."""

import pytest

from rpr_solver import verify_document
from tests.rpr_solver.verify.forgeries import base
from tests.rpr_solver.verify.margin_forgeries import MARGINS
from tests.support.mutations import OF_MARGINS, mutated
from tests.support.verified import is_named

pytestmark = pytest.mark.usefixtures("events_are_found_once")


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        pytest.param(name, seed, marks=[] if (name, seed) == ("refuted margin", 0) else pytest.mark.long)
        for name in MARGINS
        for seed in range(7)
    ],
)
def test_no_alteration_is_established(name: str, seed: int) -> None:
    for done, wrong in mutated(base(name), OF_MARGINS, len(OF_MARGINS), seed):
        assert is_named(wrong), done


def test_a_short_margin_leaves_only_its_proof_open() -> None:
    verification = verify_document(base("short margin"))
    assert [claim.at for claim in verification.open] == ["/proved"]
    assert "ask for --certificate full" in verification.open[0].reason


def test_a_turn_with_thousands_of_digits_on_both_sides_of_the_point_has_an_answer() -> None:
    document = base("margin of an open range")
    document["certificate"]["full"]["turn"] = f"1{'0' * 19_900}.{'0' * 19_900}1"
    assert "/proved" in [claim.at for claim in verify_document(document).refused]
