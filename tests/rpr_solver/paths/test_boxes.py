"""Verdicts about boxes of poses against poses in them, in floats and from the geometry alone."""

from collections.abc import Iterator
from fractions import Fraction
from math import pi
from random import Random

import pytest
from flint import ctx

from rpr_solver import EXAMPLES
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.boxes import BITS, Box, Boxes, Verdict
from rpr_solver.paths.proofs import PathLimits
from tests.support.motions import Mover

FIRST = EXAMPLES["fourteen-cusps"]
BOUNDS = {1: (Fraction(1), Fraction(25)), 3: (None, Fraction(25))}


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    with ctx.workprec(BITS):
        yield


def boxes_of(low: int, high: int, sign: int) -> Boxes:
    slice_map = SliceMap.of(FIRST, 2)
    limits = PathLimits.of(slice_map, BOUNDS)
    return Boxes(slice_map, sign, limits, low * slice_map.scale, high * slice_map.scale)


def a_box(boxes: Boxes, random: Random) -> Box:
    level = random.choice((3, 5, 7, 8))
    turn = 1 << level
    return level, random.randrange(turn), random.randrange(turn), random.randrange(boxes.lengths(level))


@pytest.mark.parametrize(("low", "high"), [(6, 6), (6, 8), (1, 30)])
@pytest.mark.parametrize("sign", [1, -1])
def test_what_is_proved_about_a_box_holds_at_its_poses(low: int, high: int, sign: int) -> None:
    random, boxes, mover = Random(low + high), boxes_of(low, high, sign), Mover.of(FIRST, 2)
    seen = dict.fromkeys(Verdict, 0)
    some = [a_box(boxes, random) for _ in range(400)]
    for box, judgement in zip(some, boxes.judged(some), strict=True):
        verdict = judgement.verdict
        seen[verdict] += 1
        middle, sizes = boxes.middle(box), boxes.sizes(box)
        for _ in range(3):
            shares = (Fraction(random.randint(-50, 50), 100) for _ in middle)
            at = [float(x + size * part) for x, size, part in zip(middle, sizes, shares, strict=True)]
            alpha, theta, length = 2 * pi * at[0], 2 * pi * at[1], at[2] / float(boxes.slice_map.scale)
            l1, _, l3 = mover.legs(alpha, theta, length)
            allowed = 1 <= l1 <= 25 and l3 <= 25 and mover.determinant(alpha, theta, length) * sign > 0
            assert verdict is Verdict.UNDECIDED or allowed == (verdict is Verdict.IN)
    assert min(seen.values()) > 0
