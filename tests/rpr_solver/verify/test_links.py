"""The coordinates of poses about tubes, and chains that are broken."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.links import Pose, chain_of, moved, with_bits
from rpr_solver.verify.tubes import Forms
from tests.support.chains import PAST, poses, surface, tubes

BITS = 200


def test_from_one_tube_to_the_next_a_pose_has_the_coordinates_of_that() -> None:
    first, *_, last = tubes(PAST)
    pose = Pose(*(Interval.of(x, BITS) for x in (Fraction(1, 7), Fraction(-2), surface().unit)))
    box = moved(pose.about(first), first, last)
    for mine, other in zip(box, pose.about(last), strict=True):
        assert abs(mine.middle - other.middle) < Fraction(1, 10**20)
        assert mine.meets(with_bits(other, BITS + 30))


def test_precision_is_rounded_outwards() -> None:
    x = Interval(-5, 5, 3)
    assert with_bits(x, 2) == Interval(-3, 3, 2)
    assert with_bits(x, 4) == Interval(-10, 10, 4)


def test_a_chain_has_no_gap_and_holds_its_points() -> None:
    forms, chain = Forms(surface()), tubes(PAST)
    start, stop = poses()["C1", Fraction(1)], poses()["C2", Fraction(1)]
    found = chain_of(surface(), forms, chain, start, stop)
    assert not found.fault
    assert found.turning is not None
    assert len(found.turning) == 1
    back = chain_of(surface(), forms, chain[:2] + chain[1:], start, stop)  # it may go back and forth
    assert (back.fault, len(back.turning or ())) == ("", 1)
    narrow = replace(chain[3], reach=chain[3].reach / 100)
    for wrong, ends in (
        ([], (start, stop)),
        (chain[:3] + chain[4:], (start, stop)),
        ([*chain[:3], narrow, *chain[4:]], (start, stop)),
        (chain, (stop, start)),
        (chain, (start, start)),
        (chain[:-1], (start, stop)),
    ):
        assert chain_of(surface(), forms, wrong, *ends).fault
