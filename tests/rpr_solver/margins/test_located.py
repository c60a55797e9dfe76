"""Degenerate poses located for all geometries of a box, against exact censuses of some of them."""

import random
from collections.abc import Mapping
from fractions import Fraction

import pytest

from rpr_solver import EXAMPLES, Manipulator, census
from rpr_solver.contract import LENGTHS
from rpr_solver.exact.turns import TURN
from rpr_solver.margins.bands import Transition, transitions_of
from rpr_solver.margins.located import SWALLOWTAILS, Located
from rpr_solver.margins.problems import GeometryBox

ONES = (Fraction(1),) * len(LENGTHS)


def located(manipulator: Manipulator, radius: str) -> list[Transition]:
    """The transitions of a manipulator."""
    whole = census(manipulator, digits=15).to_json()["transitions"]
    return transitions_of(whole, GeometryBox(manipulator, 1, Fraction(radius), ONES))


@pytest.mark.parametrize(("name", "radius"), [("innocenti", "0.0005"), ("twelve-cusps", "0.0001")])
def test_each_geometry_has_one_pose_in_a_zone_and_at_the_length_that_is_located(
    name: str, radius: str
) -> None:
    manipulator, rng, r = EXAMPLES[name], random.Random(4), Fraction(radius)
    found = located(manipulator, radius)
    assert all(one.is_whole for one in found)
    for _ in range(3):
        steps = [rng.choice((-1, 1)) for _ in LENGTHS]
        moved = {g: getattr(manipulator, g) + r * step for g, step in zip(LENGTHS, steps, strict=True)}
        table = census(Manipulator(**{**manipulator.to_dict(), **moved}), digits=15)
        events = [
            (Fraction(one.length), event.to_json()) for one in table.transitions for event in one.events
        ]
        for pose in (pose for one in found for pose in one.poses):
            [length] = [length for length, event in events if is_within(pose, length, event)]
            middle = pose.at + sum(rate * step for rate, step in zip(pose.rates, steps, strict=True))
            assert abs(length - middle) <= pose.rest + Fraction(1, 10**12)
            assert pose.span[0] <= length <= pose.span[1]


def is_within(pose: Located, length: Fraction, event: Mapping[str, str]) -> bool:
    """Whether a degenerate pose is a zero of the functions of a zone, and in it."""
    if (event["kind"] == "swallowtail") != (pose.system == SWALLOWTAILS):
        return False
    angles = (Fraction(event[name]) / 360 * TURN for name in ("alpha_deg", "theta1_deg"))
    places = [(x - low) % TURN + low for x, low in zip(angles, pose.low, strict=False)]
    return all(x <= high for x, high in zip(places, pose.high, strict=False)) and (
        pose.low[2] <= length <= pose.high[2]
    )


def test_fewer_poses_are_located_in_a_wider_box() -> None:
    few, many = (sum(len(one.poses) for one in located(EXAMPLES["innocenti"], r)) for r in ("0.01", "0.0001"))
    assert few < many == 22
