"""The pose at which both free legs close: its numbers, and that no other event is near it."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb, ctx

from rpr_solver.boxes import Boxes, contains
from rpr_solver.verify.equations import LENGTH, Lengths, Mechanism
from rpr_solver.verify.geometry import Geometry
from rpr_solver.verify.meetings import Form, Meeting, have_no_zero
from rpr_solver.verify.work import Work
from tests.support.families import family

ALL = Boxes(np.zeros((3, 1)), np.ones((3, 1)))


def forms(*rows: dict[tuple[int, ...], float]) -> list[Form]:
    return [{n: arb(x, 2.0**-20) for n, x in row.items()} for row in rows]


ANGLES = {(2, 0, 0): 1.0, (0, 2, 0): 1.0}
"""x² + y²."""
CONE = {(2, 0, 0): 1.0, (0, 2, 0): -1.0}
"""x² − y²."""
PRODUCTS = {(1, 0, 1): 1.0, (0, 1, 1): -1.0}
"""(x − y) z."""
LENGTHS = {(0, 0, 2): 1.0, (0, 1, 1): -0.5}
"""z² − y z/2."""


@pytest.mark.parametrize(
    ("rows", "none"),
    [
        ((ANGLES, LENGTHS), True),
        ((ANGLES,), False),
        ((CONE, PRODUCTS), False),
        ((CONE, PRODUCTS, LENGTHS), False),
        ((ANGLES, PRODUCTS, LENGTHS), True),
        ((CONE, {(1, 0, 0): 1.0}, {(0, 0, 1): 1.0}), True),
        ((CONE, {(1, 0, 0): 1.0, (0, 1, 0): 1.0}, {(0, 0, 1): 1.0}), False),
    ],
)
def test_common_zeros_of_forms(rows: tuple[dict[tuple[int, ...], float], ...], none: bool) -> None:
    assert have_no_zero(forms(*rows), Work(0)) is none


@pytest.mark.parametrize("beyond", [False, True])
def test_both_free_legs_have_the_length_0(beyond: bool) -> None:
    mechanism = Mechanism(Geometry.read(family("d1 = a2x").to_json(), ""), 3)
    space = Lengths(mechanism, beyond=beyond)
    meeting = Meeting.of(space, ALL, Work(0))
    if beyond:
        assert meeting is None
        return
    assert meeting is not None
    box = meeting.within(200)
    assert contains(meeting.room, box)
    assert max(float(x.rad()) for x in box) <= 2.0**-200
    assert box[0].is_zero()
    with ctx.workprec(256):
        for leg in mechanism.free:
            assert abs(space.on(box, 0).square(leg).value) < 2.0**-190
    assert box[LENGTH] > 0


@pytest.mark.parametrize(("name", "leg"), [("d1 = a2x", 1), ("isosceles", 3), ("congruent, mirrored", 3)])
def test_there_is_none_where_sides_differ_or_more_poses_coalesce(name: str, leg: int) -> None:
    mechanism = Mechanism(Geometry.read(family(name).to_json(), ""), leg)
    assert not any(Meeting.of(Lengths(mechanism, beyond=x), ALL, Work(0)) for x in (False, True))
