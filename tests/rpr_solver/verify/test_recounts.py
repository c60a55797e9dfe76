"""Numbers of cusps of intervals and beside cuts, by whatever counts slices."""

from fractions import Fraction

import pytest

from rpr_solver import ClaimStatus
from rpr_solver.verify.recounts import Recount

ONE, TWO = Fraction(1), Fraction(2)


def recount(*found: tuple[int, bool] | None) -> Recount:
    answers = iter(found)
    return Recount(lambda _: next(answers), "by hand", ("open", "open beside"))


@pytest.mark.parametrize(
    ("found", "status", "simple"),
    [
        (((4, True), (4, True)), ClaimStatus.PROVED, True),
        (((4, True), (4, False)), ClaimStatus.CHECKED, False),
        (((4, True), (6, True)), ClaimStatus.REFUSED, None),
        ((None,), ClaimStatus.NOT_CHECKED, False),
    ],
)
def test_an_interval(
    found: tuple[tuple[int, bool] | None, ...], status: ClaimStatus, simple: bool | None
) -> None:
    claim, are_simple = recount(*found).throughout("/x", "four", 4, [ONE, TWO])
    assert (claim.status, are_simple) == (status, simple)


def test_a_cut() -> None:
    sides = [((ONE, TWO), Fraction("1.99"), 4), ((TWO, TWO + 1), Fraction("2.01"), 6)]
    assert recount((4, True), (6, True)).beside("/x", sides).status is ClaimStatus.PROVED
    assert recount((4, True), (6, False)).beside("/x", sides).status is ClaimStatus.CHECKED
    assert recount((4, True), (4, True)).beside("/x", sides).status is ClaimStatus.REFUSED
    assert recount(None).beside("/x", sides).reason == "open beside"
    assert "no room" in recount((4, True)).beside("/x", [sides[0], (None, TWO, 6)]).reason
