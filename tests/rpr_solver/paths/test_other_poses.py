"""What becomes of the other poses: each one is accounted for, and folds come in pairs.

The numbers of poses in the table of their joint vector.
"""

from __future__ import annotations

from collections import Counter

import pytest

from rpr_solver import EXAMPLES, Path, cusp_loop, poses
from tests.support.motions import Mover, angles_of


def check(loop: Path) -> Counter[str]:
    """Each pose but the first is accounted for; returns how many end how."""
    path = loop.with_others()
    assert path.others is not None
    documents = path.to_json()["others"]
    assert [other["to"] is None for other in documents] == [other.stop is None for other in path.others]
    count = poses(path.manipulator, *path.lengths, digits=15).count
    assert [other.start.number for other in path.others] == [
        k for k in range(1, count + 1) if k != path.start.number
    ]
    arrived = [path.stop.number, *(other.stop.number for other in path.others if other.stop)]
    assert len(set(arrived)) == len(arrived), "two poses cannot arrive at one"
    mover = Mover.of(path.manipulator, path.fixed_leg)
    for other in path.others:
        if other.fold is not None:
            assert other.stop is None
            length = float(other.fold.lengths[path.fixed_leg - 1])
            legs = mover.legs(*angles_of(other.fold), length)
            assert legs == pytest.approx([float(x) for x in other.fold.lengths])
            assert abs(mover.determinant(*angles_of(other.fold), length)) < 1e-4
    folds = Counter(other.fold for other in path.others if other.fold)
    return Counter(
        "fold" if other.fold else "lives" if other.stop else "undecided" for other in path.others
    ) | Counter({"pairs": sum(n == 2 for n in folds.values())})


def test_near_a_cusp_two_poses_meet_and_others_live() -> None:
    ends = check(cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2))
    assert ends == {"fold": 2, "lives": 1, "pairs": 1}


@pytest.mark.long
@pytest.mark.parametrize(("name", "length", "count"), [("innocenti", 27, 8), ("fourteen-cusps", "5.96", 14)])
def test_nearly_all_are_decided(name: str, length: int | str, count: int) -> None:
    ends: Counter[str] = Counter()
    for cusp in range(1, count + 1):
        ends += check(cusp_loop(EXAMPLES[name], length, cusp, samples=2))
    assert ends["fold"] > count
    assert ends["undecided"] < count
