"""Boxes of singular poses: none is lost, and where folds meet nothing is proved."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from random import Random

import numpy as np
import pytest

from rpr_solver import EXAMPLES, Manipulator, solve_slice
from rpr_solver import poses as rpr_poses
from rpr_solver.exact.turns import TURN
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.fold_boxes import Boxes, FoldBoxes, Slab
from rpr_solver.modes.folds import folds_apart
from rpr_solver.slices.eliminant import kept_eliminant
from tests.support.motions import Mover
from tests.support.oracle import free_legs_of, singularity

SOME = [("innocenti", 1, "27"), ("zein-flat", 2, "10"), ("fourteen-cusps", 3, "5.96")]


def singular_poses(
    manipulator: Manipulator, leg: int, length: float, lines: int
) -> list[tuple[float, float]]:
    """Zeros of J by bisection on lines of random θ."""
    legs, random = free_legs_of(manipulator, leg), Random(7)
    angles = np.linspace(0, 2 * np.pi, 400)
    found = []
    for theta in (random.uniform(0, 2 * np.pi) for _ in range(lines)):
        values = singularity(legs, length, angles, theta)
        for k in np.flatnonzero(np.diff(np.sign(values))):
            low, high = angles[k], angles[k + 1]
            for _ in range(60):
                middle = (low + high) / 2
                same = singularity(legs, length, middle, theta) * values[k] > 0
                low, high = (middle, high) if same else (low, middle)
            found.append((float(low), theta))
    return found


@pytest.mark.parametrize(("name", "leg", "text"), SOME)
def test_narrowed_and_halved_boxes_keep_all_singular_poses(name: str, leg: int, text: str) -> None:
    manipulator, length = EXAMPLES[name], Fraction(text)
    slice_map = SliceMap.of(manipulator, leg)
    scaled = length * slice_map.scale
    model = FoldBoxes.of(slice_map, {}, scaled)
    slab = model.slab(scaled * Fraction(99, 100), scaled * Fraction(101, 100))
    poses = [
        pose
        for share in (0.99, 1, 1.01)
        for pose in singular_poses(manipulator, leg, float(length) * share, 12)
    ]
    assert len(poses) > 40
    _boxes_that_keep(poses, model, slab)


def _boxes_that_keep(poses: Sequence[Sequence[float]], model: FoldBoxes, slab: Slab) -> Boxes:
    """Boxes that are contracted and cut four times; each of these poses stays in one of them."""
    boxes = Boxes.all(32)
    for _ in range(4):
        boxes, keep = model.contracted(boxes, slab)
        boxes = boxes[keep]
        for pose in poses:
            away = [
                abs((x * TURN / (2 * np.pi) - middle + TURN / 2) % TURN - TURN / 2) - wide
                for x, middle, wide in zip(pose, *boxes.sides, strict=True)
            ]
            assert (np.maximum(*away) < 4).any()
        boxes = boxes.cut()
    return boxes


def _holding(slab: Slab, number: float) -> Slab:
    """A small part of a slab round a number."""
    while slab.half > 1e-3:
        slab = min(slab.halves(), key=lambda half: abs(half.middle - number))
    return slab


@pytest.mark.parametrize(("name", "leg", "_text"), SOME)
@pytest.mark.parametrize("times", [1.5, 40])
def test_boxes_of_inverse_lengths_keep_all_singular_poses(
    name: str, leg: int, _text: str, times: float
) -> None:
    manipulator = EXAMPLES[name]
    slice_map = SliceMap.of(manipulator, leg)
    model = FoldBoxes.of(slice_map, {}, Fraction(1))
    slab = _holding(model.beyond(), 1 / times)
    poses = singular_poses(manipulator, leg, float(model.unit / slice_map.scale) * times, 12)
    assert len(poses) > 15
    boxes = _boxes_that_keep(poses, model, slab)
    assert len(boxes) < 4 * 32 * 32


@pytest.mark.parametrize(("name", "leg", "_text"), SOME)
def test_poses_of_one_joint_vector_of_long_legs_are_not_apart(name: str, leg: int, _text: str) -> None:
    manipulator, random = EXAMPLES[name], Random(3)
    slice_map = SliceMap.of(manipulator, leg)
    model, scale = FoldBoxes.of(slice_map, {}, Fraction(1)), slice_map.scale
    mover, found = Mover.of(manipulator, leg), 0
    while found < 6:
        angles = [random.uniform(-np.pi, np.pi) for _ in range(2)]
        size = random.uniform(1.1, 9) * float(model.unit / scale)
        lengths = [Fraction(round(x, 3)).limit_denominator(1000) for x in mover.legs(*angles, size)]
        length = lengths[leg - 1]
        rows = rpr_poses(manipulator, *lengths).poses
        if len(rows) < 2:
            continue
        found += 1
        slab = _holding(model.beyond(), float(model.unit / scale / length))
        places = np.array([[float(row.alpha_deg), float(getattr(row, f"theta{leg}_deg"))] for row in rows])
        alpha, theta = np.rint(places.T / 360 * TURN).astype(np.int64)
        wide = np.full(len(rows), TURN >> 12)
        first, second = np.triu_indices(len(rows), 1)
        assert not model.apart(Boxes(alpha, theta, wide, wide), slab, first, second).any()
        moved = np.concatenate([alpha + TURN // 7, alpha])
        both = Boxes(moved, *(np.tile(x, 2) for x in (theta, wide, wide)))
        assert model.apart(both, slab, np.arange(len(rows)), np.arange(len(rows)) + len(rows)).any()


@pytest.mark.parametrize("seed", [1, 2, *(pytest.param(n, marks=pytest.mark.long) for n in range(3, 40))])
def test_nothing_is_proved_where_there_is_a_cusp(seed: int) -> None:
    random, found = Random(f"cusps {seed}"), 0
    while not found:
        values = [random.randint(-20, 20) for _ in range(3)] + [random.randint(5, 20) for _ in range(3)]
        try:
            manipulator = Manipulator(*values)
        except ValueError:
            continue
        length = Fraction(random.randint(1, 60), random.choice([1, 10]))
        found = solve_slice(kept_eliminant(manipulator, 1), length, 15).count
        slice_map = SliceMap.of(manipulator, 1)
        ends = length * slice_map.scale, length * slice_map.scale * random.choice([1, Fraction(11, 10)])
        proof = folds_apart(slice_map, ends, {})
        assert proof.left or not found
        assert not found or proof.left[0].size_deg < 15
