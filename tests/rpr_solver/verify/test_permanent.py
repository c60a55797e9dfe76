"""Poses that are singular for every length."""

from __future__ import annotations

import pytest

from rpr_solver import EXAMPLES
from rpr_solver.verify import permanent
from rpr_solver.verify.surface import Surface
from tests.support.families import family
from tests.support.verified import geometry_of


@pytest.mark.parametrize(("fixed", "count"), [(1, 8), (3, 8)])
def test_j_is_zero_there_for_every_length(fixed: int, count: int) -> None:
    surface = Surface.of(geometry_of(EXAMPLES["twelve-cusps"]), fixed)
    poses = list(permanent._poses(surface))
    assert len(poses) == count
    for pose in poses:
        values = [pose.value(row) for row in surface.singular]
        assert all(x.contains(0) and x.radius < 1e-60 for x in values)
    assert permanent.never_degenerate(surface)


@pytest.mark.parametrize("name", ["similar", "right angles", "flat base"])
def test_nothing_is_claimed_of_special_manipulators(name: str) -> None:
    assert not permanent.never_degenerate(Surface.of(geometry_of(family(name)), 1))
