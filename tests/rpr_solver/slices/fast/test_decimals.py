"""From proved boxes to decimals, against the table of the slice alone."""

from __future__ import annotations

from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, JointPoint
from rpr_solver.slices.fast.proofs import NearPose, guesses, proved_boxes
from rpr_solver.slices.fast.scan import Scan
from rpr_solver.slices.reference import ReferenceSlice
from tests.support.shared import eliminant_of

LENGTH = Fraction(349, 10)


def boxes(name: str) -> list[NearPose]:
    eliminant = eliminant_of(EXAMPLES[name])
    scaled = LENGTH * eliminant.slice_map.scale
    [found] = proved_boxes(eliminant, [scaled], [guesses(eliminant, [scaled])[0].real])
    assert found is not None
    return found


def cusps_in(name: str, digits: int, found: list[NearPose]) -> list[JointPoint] | None:
    scan = Scan(eliminant_of(EXAMPLES[name]), [LENGTH], digits)
    return scan.cusps(LENGTH * scan.eliminant.slice_map.scale, found)


@pytest.mark.parametrize("digits", [15, 90, 1000])
@pytest.mark.parametrize("name", ["zein-flat", "sixteen-cusps"])
def test_the_cusps_of_the_slice(name: str, digits: int) -> None:
    cusps = cusps_in(name, digits, boxes(name))
    alone = ReferenceSlice(eliminant_of(EXAMPLES[name]), LENGTH, digits).solve()
    assert cusps == [*alone.cusps]


def test_far_roots_are_found_as_their_inverse() -> None:
    """Any root is far if the bound of the near ones is small enough."""
    found = boxes("zein-flat")
    assert any(x.u_inverse for x in found)
    expected = cusps_in("zein-flat", 60, found)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rpr_solver.slices.sharpener._NEAR", 0)
        assert cusps_in("zein-flat", 60, found) == expected


def test_boxes_that_are_too_wide_decide_nothing() -> None:
    [first, *_] = boxes("zein-flat")
    for wide in (first._replace(u_reach=0.5), first._replace(t_reach=0.5)):
        assert cusps_in("zein-flat", 15, [wide]) is None


def test_no_boxes_are_no_cusps() -> None:
    assert cusps_in("zein-flat", 15, []) == []
