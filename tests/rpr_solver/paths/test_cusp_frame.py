"""The local algebra: the outer poses over nearly one joint vector, and J of the signs that it tells."""

from collections.abc import Callable

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, solve_slice
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.paths.cusp_frame import CuspFrame
from rpr_solver.paths.isolated import Angles, local_map
from tests.support.shared import eliminant_of


def gap(image: Callable[[Angles], Angles], frame: CuspFrame, s: float) -> float:
    """How far apart the images of the outer poses are, over their distance from the cusp's."""
    one, other, cusp = map(image, (frame.outer(arb(s)), frame.outer(arb(-s)), frame.cusp))
    apart, away = (((one[0] - x[0]) ** 2 + (one[1] - x[1]) ** 2).sqrt() for x in (other, cusp))
    return float(apart / away)


@pytest.mark.parametrize(("name", "length"), [("innocenti", "27"), ("fourteen-cusps", "5.96")])
def test_the_outer_poses_meet_and_the_inner_one_lies_across_the_curve(name: str, length: str) -> None:
    eliminant = eliminant_of(EXAMPLES[name])
    slice_map, table = eliminant.slice_map, solve_slice(eliminant, length, 40)
    s = 1e-6
    with ctx.workprec(160):
        scaled = ball_of(table.length * slice_map.scale)

        def image(angles: Angles) -> Angles:
            f, g = local_map(slice_map, scaled, angles, 0).squared_lengths()
            return f, g

        for cusp in table.cusps:
            alpha, theta = (arb(text) * arb.pi() / 180 for text in cusp.coordinates[:2])
            frame = CuspFrame.at(slice_map, scaled, (alpha, theta))
            # without β they would stay as far apart as they are from the cusp's
            assert gap(image, frame, s / 10) < gap(image, frame, s) / 5 < 1e-3
            back = frame.kappa * arb(s) ** 2
            inner = alpha - back * frame.normal[0], theta - back * frame.normal[1]
            for angles, sign in ((frame.outer(arb(s)), 1), (frame.outer(arb(-s)), 1), (inner, -1)):
                assert local_map(slice_map, scaled, angles, 2).singularity().value * frame.sign * sign > 0
