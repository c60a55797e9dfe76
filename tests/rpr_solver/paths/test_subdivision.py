"""The search among boxes: a way stays in allowed boxes, and its corners are near each other."""

from fractions import Fraction
from itertools import pairwise
from math import pi

import pytest

from rpr_solver import EXAMPLES, Unproved, poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths import subdivision
from rpr_solver.paths.between_poses import isolated
from rpr_solver.paths.boxes import Boxes, Place
from rpr_solver.paths.path_limits import PathLimits
from rpr_solver.paths.subdivision import search
from tests.support.motions import Mover

FIRST = EXAMPLES["innocenti"]
SLICE = SliceMap.of(FIRST)
TABLE = poses(FIRST, 27, 20, 20, digits=20)


def place(number: int) -> Place:
    return *isolated(SLICE, TABLE, number).angles, 27 * SLICE.scale


def boxes_of(maximum: int, low: int = 27, high: int = 27) -> Boxes:
    limits = PathLimits.of(SLICE, {2: (None, Fraction(maximum))})
    return Boxes(SLICE, -1, limits, low * SLICE.scale, high * SLICE.scale)


@pytest.mark.parametrize(("low", "high"), [(27, 27), (24, 29)])
def test_a_way_keeps_what_is_asked_between_its_corners_too(low: int, high: int) -> None:
    outcome = search(boxes_of(30, low, high), place(1), place(2))
    assert outcome.way is not None
    mover, scale = Mover.of(FIRST), float(SLICE.scale)
    for first, last in pairwise(outcome.way):
        for share in (0.0, 0.3, 0.7, 1.0):
            alpha, theta, length = (float(x) + share * float(y - x) for x, y in zip(first, last, strict=True))
            assert abs(float(last[0] - first[0])) < pi / 4 + 1e-9
            assert low <= length / scale <= high
            assert mover.legs(alpha, theta, length / scale)[1] < 30
            assert mover.determinant(alpha, theta, length / scale) < 0


def test_no_way_is_left_where_limits_cut_the_aspect() -> None:
    outcome = search(boxes_of(21), place(1), place(2))
    assert (outcome.way, outcome.is_separated) == (None, True)


def test_a_way_that_is_too_narrow_is_left_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subdivision, "_LEVELS", {2: (6, 7)})
    limits = PathLimits.of(SLICE, {2: (None, Fraction("26.3438"))})
    outcome = search(Boxes(SLICE, -1, limits, 27 * SLICE.scale, 27 * SLICE.scale), place(1), place(2))
    assert (outcome.way, outcome.is_separated, outcome.level) == (None, False, 7)


def test_a_pose_that_is_not_allowed_is_refused() -> None:
    with pytest.raises(Unproved, match="too near to a singularity or to a limit"):
        search(boxes_of(19), place(1), place(2))
