"""Cusps counted at a degenerate pose, beside the table of its slice where that can be had."""

from __future__ import annotations

from fractions import Fraction

import pytest

from rpr_solver import Manipulator, solve_slice
from rpr_solver.contract import silent
from rpr_solver.curves.exact_slice import most_cusps
from rpr_solver.model.exact_pose import ExactPose
from rpr_solver.transitions.survey import Survey, survey

MIRRORED = Manipulator(6, 3, 4, 6, 5, 5, "cw")
IRRATIONAL = Manipulator("6.77", 0, "6.77", "6.77", "13.54", "6.77")


def poses_of(whole: Survey) -> list[ExactPose]:
    return [e.pose for group in whole.groups for e in group if isinstance(e.pose, ExactPose)]


def test_it_is_the_number_of_the_slice() -> None:
    """At rational lengths, where roots of Q are multiple or leg f may be closed and stretched."""
    whole = survey(MIRRORED, 2, silent, start=Fraction("5.9"), stop=Fraction("9.7"))
    poses = poses_of(whole)
    lengths = [pose.length.rational for pose in poses]
    assert None not in lengths
    scale = whole.eliminant.slice_map.scale
    counts = [solve_slice(whole.eliminant, x / scale, 15).count for x in lengths if x is not None]
    found = [most_cusps(whole.eliminant, pose) for pose in poses]
    assert len(found) == 3
    assert any(count is not None for count in found)
    assert all(most in (None, count) for most, count in zip(found, counts, strict=True))


def test_a_cusp_is_missing_at_an_irrational_quadruple_point(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = survey(IRRATIONAL, 3, silent, start=Fraction("9.5"), stop=Fraction("9.6"))
    [pose] = poses_of(whole)
    assert [table.count for table in whole.slices] == [6, 6]
    assert most_cusps(whole.eliminant, pose) == 5
    monkeypatch.setattr("rpr_solver.curves.exact_slice._GREATEST_DEGREE", 1)
    assert most_cusps(whole.eliminant, pose) is None
