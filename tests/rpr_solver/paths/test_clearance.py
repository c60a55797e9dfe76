"""The clearance is a lower bound: no singular pose of the slice is nearer."""

from math import cos, degrees, pi, sin

import pytest

from rpr_solver import EXAMPLES, Manipulator, cusp_loop
from tests.support.motions import Mover, angles_of


@pytest.mark.parametrize(("name", "length", "cusp"), [("fourteen-cusps", "5.96", 3)])
def test_no_singular_pose_is_nearer(name: str, length: str, cusp: int) -> None:
    manipulator: Manipulator = EXAMPLES[name]
    mover, path = Mover.of(manipulator), cusp_loop(manipulator, length, cusp, samples=5)
    for sample in path.samples:
        alpha, theta = angles_of(sample)
        clearance = float(sample.clearance_deg)
        found = min(
            first_zero(mover, alpha, theta, float(length), 2 * pi * k / 8, path.sign) for k in range(8)
        )
        assert 0 < clearance <= found
        # and not a bad one: near the curve both are |J| / |∇J|
        assert found < 30 * clearance


def first_zero(mover: Mover, alpha: float, theta: float, length: float, direction: float, sign: int) -> float:
    """The distance to the first change of sign in a direction, in degrees, to 1 %."""
    x, y, step = cos(direction), sin(direction), 1e-5
    distance = 0.0
    while distance < pi:
        if mover.determinant(alpha + distance * x, theta + distance * y, length) * sign < 0:
            break
        distance, step = distance + step, step * 1.05
    return degrees(distance)
