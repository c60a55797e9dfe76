"""The two proofs, each with a path that passes it and one that must not.

Limits of the free legs as walls in half their squared lengths.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.proofs import PathLimits, prove
from rpr_solver.paths.routes import Arc, Image, Point, expanded
from tests.support.motions import Mover

FIRST = EXAMPLES["innocenti"]
SLICE = SliceMap.of(FIRST)
LENGTH = 15.0
RING = [(0.5, 0.6), (0.8, 0.6), (0.8, 0.9), (0.5, 0.9), (0.5, 0.6)]
"""The corners of a small square where J does not vanish."""


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    with ctx.workprec(128):
        yield


def point(alpha: float, theta: float) -> Point:
    return arb(alpha), arb(theta), LENGTH * SLICE.scale_ball()


def through(corners: list[tuple[float, float]]) -> list[Arc]:
    points = [point(*corner) for corner in corners]
    return [Arc.over(pair) for pair in pairwise(points)]


def image(alpha: float, theta: float) -> Image:
    at = expanded(SLICE, Arc.over([point(alpha, theta)] * 2), arb(0), 0)
    return at.first[0], at.second[0]


def sign_at(alpha: float, theta: float) -> int:
    return 1 if Mover.of(FIRST).determinant(alpha, theta, LENGTH) > 0 else -1


def test_a_path_in_one_aspect_is_proved() -> None:
    sign = sign_at(0.65, 0.75)
    proof = prove(SLICE, through(RING), sign)
    assert proof is not None
    assert (proof.sign, proof.windings) == (sign, ())
    values = [Mover.of(FIRST).determinant(*corner, LENGTH) * sign for corner in RING]
    assert 0 < float(proof.least) / float(SLICE.scale) <= min(values)


def test_the_wrong_sign_is_refused() -> None:
    assert prove(SLICE, through(RING), -sign_at(0.65, 0.75)) is None


def test_a_path_across_the_singular_curve_is_refused() -> None:
    across = [(0.65, 0.75), (0.65 + 3.0, 0.75)]
    signs = {sign_at(0.65 + 0.1 * k, 0.75) for k in range(31)}
    assert signs == {1, -1}
    assert prove(SLICE, through(across), sign_at(0.65, 0.75)) is None


def test_windings_count_turns_with_their_direction() -> None:
    sign = sign_at(0.65, 0.75)
    inside, outside = image(0.65, 0.75), image(1.2, 0.75)
    for corners, turns in ((RING, sign), (RING[::-1], -sign), (RING + RING[1:], 2 * sign)):
        proof = prove(SLICE, through(corners), sign, [inside, outside])
        assert proof is not None
        assert proof.windings == (turns, 0)


def test_a_path_through_the_centre_is_refused() -> None:
    assert prove(SLICE, through(RING), sign_at(0.65, 0.75), [image(0.65, 0.6)]) is None


def half_squares(*lengths: int) -> list[arb]:
    return [(length * SLICE.scale_ball()) ** 2 / 2 for length in lengths]


def test_from_a_limit_the_way_leads_inwards() -> None:
    legs = tuple(length * SLICE.scale for length in (Fraction(27), Fraction(20), Fraction(9)))
    limits = PathLimits.of(SLICE, {2: (None, Fraction(20))}, ((legs[0], legs[1], legs[2]),) * 2)
    near = [x.union(y) for x, y in zip(half_squares(20, 9), half_squares(19, 9), strict=True)]
    near[0] = near[0] + arb(0, 1)
    falling, rising = (arb(-1), arb(0)), (arb(1), arb(0))
    assert limits.hold(near, falling, at_start=True)
    assert limits.hold(near, rising, at_stop=True)
    assert not limits.hold(near, rising, at_start=True)
    assert not limits.hold(near, falling, at_stop=True)
    assert not limits.hold(near, falling)
    untouched = PathLimits.of(SLICE, {2: (None, Fraction(20))})
    assert not untouched.hold(near, falling, at_start=True)
