"""The parts of the allowed region: against aspects, against a grid of poses, and against paths."""

from __future__ import annotations

from fractions import Fraction
from math import radians
from random import Random
from typing import Any

import numpy as np
import pytest
from flint import arb

from rpr_solver import EXAMPLES, Manipulator, NoPath, Obstacle, pose_connections, pose_path
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.joined_regions import AllowedParts
from rpr_solver.paths import search
from rpr_solver.paths.boxes import Boxes, Spot
from rpr_solver.paths.components import AllowedRegion
from rpr_solver.paths.proofs import PathLimits
from rpr_solver.singular.aspects import number_of_aspects
from service.schemas.modes import PoseConnections as Document
from tests.rpr_solver.paths.test_random_pairs import a_manipulator
from tests.support.oracle import free_legs_of, singularity
from tests.support.pair_grid import PairGrid
from tests.support.pictures import words

FIRST = EXAMPLES["innocenti"]
SIMILAR = Manipulator(a2x=30, a3x=0, a3y=40, d1=15, d2=25, d3=20)
Limits = dict[int, Bounds]


def parts_of(
    m: Manipulator, leg: int, length: Fraction, limits: Limits, high: Fraction | None = None
) -> AllowedParts:
    return AllowedParts.of(SliceMap.of(m, leg), limits, (length, high or length), {})


def random_slice(random: Random) -> tuple[Manipulator, int, Fraction]:
    m, leg = a_manipulator(random), random.choice([1, 2, 3])
    return m, leg, Fraction(f"{random.uniform(0.1, 1.5) * (float(m.d1) + float(m.d2)):.2f}")


def counts_aspects(m: Manipulator, leg: int, length: Fraction) -> bool:
    """Whether the number of parts without limits is that of the aspects; it may also stay undecided."""
    slice_map = SliceMap.of(m, leg)
    found = parts_of(m, leg, length, {}).count
    assert found in (None, number_of_aspects(slice_map, length * slice_map.scale))
    return found is not None


def test_without_limits_parts_are_aspects() -> None:
    assert counts_aspects(EXAMPLES["zein-flat"], 1, Fraction(10))


@pytest.mark.long
def test_without_limits_parts_of_random_slices_are_aspects() -> None:
    random = Random(5)
    assert sum(counts_aspects(*random_slice(random)) for _ in range(60)) >= 54


def agrees_with_a_grid(
    m: Manipulator, leg: int, length: Fraction, limits: Limits, size: int, high: Fraction | None = None
) -> bool:
    """Whether the number of parts is proved, having compared the parts with components of a grid.

    What the grid joins is in one part; of each part that is proved to be one, no two components are apart.
    """
    slice_map, span = SliceMap.of(m, leg), (length, high or length)
    bounds = {k: (float(low or 0), 1e9 if most is None else float(most)) for k, (low, most) in limits.items()}
    grid = PairGrid(m, leg, (float(span[0]), float(span[1])), bounds, size=size, lengths=12)
    labels, is_proved = grid._components, True
    levels = [min(max(Fraction(level), span[0]), span[1]) for level in grid.levels.tolist()]
    for sign in (1, -1):
        ends = [end * slice_map.scale for end in span]
        region = AllowedRegion(Boxes(slice_map, sign, PathLimits.of(slice_map, limits), *ends))
        is_proved &= all(group.is_one for group in region.groups)
        heads: dict[int, Spot] = {}
        for label in (x for x in np.unique(labels) if x >= 0 and (labels == x).sum() >= 12):
            cells = np.argwhere(labels == label)
            chosen = [
                (grid.angles[i], grid.angles[k], levels[n]) for n, k, i in cells[:: max(len(cells) // 5, 1)]
            ]
            if grid_sign(m, leg, chosen[0]) != sign:
                continue
            points = [(arb(a), arb(t), level * slice_map.scale) for a, t, level in chosen]
            found = {region.group_of(point) for point in points} - {None}
            [group] = found
            assert group is not None
            head = chosen[len(chosen) // 2]
            if region.groups[group].is_one and group in heads:
                assert not are_apart(m, leg, span, limits, (heads[group], head))
            heads.setdefault(group, head)
    return is_proved


def grid_sign(m: Manipulator, leg: int, spot: Spot) -> int:
    alpha, theta, length = spot
    return int(np.sign(singularity(free_legs_of(m, leg), float(length), alpha, theta)))


def are_apart(
    m: Manipulator, leg: int, span: tuple[Fraction, Fraction], limits: Limits, ends: tuple[Spot, ...]
) -> bool:
    """Whether a search for a path proves that there is none."""
    first, last = (
        {
            "alpha_deg": f"{np.degrees(alpha):.9f}",
            f"theta{leg}_deg": f"{np.degrees(theta):.9f}",
            f"l{leg}": length,
        }
        for alpha, theta, length in ends
    )
    between = None if span[0] == span[1] else span
    path = pose_path(m, first, last, between=between, limits=limits, fixed_leg=leg, samples=2)
    return isinstance(path, NoPath) and path.obstacle is not Obstacle.UNDECIDED


def random_limits(random: Random, m: Manipulator, leg: int, length: Fraction) -> Limits:
    limits: Limits = {}
    for k in {1, 2, 3} - {leg}:
        size = float(m.d1) + float(m.d2) + float(length)
        low, wide = random.uniform(0.1, 0.6) * size, random.uniform(0.1, 0.6) * size
        ends = Fraction(f"{low:.2f}"), Fraction(f"{low + wide:.2f}")
        limits[k] = random.choice([ends, (None, ends[1]), (ends[0], None)])
    return limits


def test_parts_agree_with_a_grid() -> None:
    limits: Limits = {2: (Fraction("15.5"), Fraction(18)), 3: (None, Fraction("20.5"))}
    assert agrees_with_a_grid(FIRST, 1, Fraction("14.98"), limits, 240)


@pytest.mark.long
def test_parts_of_random_regions_agree_with_a_grid() -> None:
    random, proved = Random(7), 0
    for _ in range(60):
        m, leg, length = random_slice(random)
        proved += agrees_with_a_grid(m, leg, length, random_limits(random, m, leg, length), 720)
    assert proved >= 50


RANGED = Manipulator("18.2", "6.5", "7.5", "8.3", "5.1", "3.7", "cw")
RANGE = Fraction("1.52"), Fraction("1.672")
OF_RANGE: Limits = {1: (None, Fraction("11.2")), 3: (Fraction("7.05"), Fraction("12.07"))}


def test_parts_in_a_range_are_proved_at_its_ends_too() -> None:
    assert parts_of(RANGED, 2, RANGE[0], OF_RANGE, RANGE[1]).count == 2
    assert agrees_with_a_grid(RANGED, 2, RANGE[0], OF_RANGE, 90, RANGE[1])


@pytest.mark.long
def test_parts_in_random_ranges_agree_with_a_grid() -> None:
    random, proved = Random(17), 0
    for _ in range(20):
        m, leg, length = random_slice(random)
        limits = random_limits(random, m, leg, length)
        proved += agrees_with_a_grid(m, leg, length, limits, 180, length * Fraction(11, 10))
    assert proved >= 10


def test_a_part_along_a_straight_singular_curve_is_counted() -> None:
    m = Manipulator(a2x=10, a3x=5, a3y=8, d1=6, d2=7, d3=7)
    limits: Limits = {2: (Fraction("7.64"), Fraction("12.92")), 3: (Fraction("3.33"), Fraction("15.24"))}
    assert parts_of(m, 1, Fraction("8.3"), limits).count == 4


def test_poses_are_in_the_parts_that_the_matrix_tells_apart() -> None:
    found = pose_connections(FIRST, 27, 20, 20, limits={"l2": (None, 22)}, parts=True)
    assert found.allowed is not None
    groups = [part.places for part in found.allowed.parts if part.places]
    assert sorted(groups) == sorted(found.groups)
    document = found.to_json()
    assert Document.model_validate(document).model_dump(exclude_unset=True, by_alias=True) == document
    for part in document["allowed"]["parts"]:
        assert part["is_one"]
        alpha, theta = (radians(float(part["pose"][name])) for name in ("alpha_deg", "theta1_deg"))
        assert grid_sign(FIRST, 1, (alpha, theta, Fraction(27))) == part["sign"]
    [lonely] = [part for part in document["allowed"]["parts"] if not part["poses"]]
    away = pose_path(
        FIRST, lonely["pose"], {"l1": 27, "l2": 20, "l3": 20, "pose": 3}, limits={"l2": (None, 22)}
    )
    assert isinstance(away, NoPath)


def test_parts_decide_what_the_search_for_ways_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "_LEVELS", {2: (6, 7)})
    asked: dict[str, Any] = {"limits": {"l2": (None, "26.3438")}}
    alone = pose_connections(FIRST, 27, 20, 20, **asked)
    found = pose_connections(FIRST, 27, 20, 20, **asked, parts=True)
    assert alone.matrix[0][1] is Obstacle.UNDECIDED
    assert found.matrix[0][1] in (None, Obstacle.SEPARATED_BY_LIMITS)
    assert "undecided" not in found.to_json()


def test_a_node_leaves_the_number_undecided_and_says_where() -> None:
    found = parts_of(SIMILAR, 1, Fraction(14), {})
    assert found.count is None
    near = [part.to_json(1)["near"] for part in found.parts if not part.is_one]
    assert near
    assert all(set(pose) == {"alpha_deg", "theta1_deg", "l1"} for pose in near)


def test_limits_that_exclude_the_slice_leave_no_part() -> None:
    answer = pose_connections(FIRST, 27, 20, 20, limits={"l1": (28, 30)}, parts=True)
    found = answer.to_json()
    assert (found["allowed"]["count"], found["allowed"]["parts"]) == (0, [])
    assert "parts of the allowed region: 0" in words(answer.figure())
