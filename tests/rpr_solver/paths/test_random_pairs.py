"""Random pairs of poses, in slices and ranges, with limits and without: paths against a grid of poses.

A path must keep the sign of J and the limits at many places. Two poses that the grid joins may not be called
apart. Hard pairs are close to the singular curve, half of them in slices beside a transition, where a grid is
too coarse: the verifier may refuse no answer. Many of them, or pairs of all kinds:

    python -m tests.rpr_solver.paths.test_random_pairs [--pairs 500] [--seed 1] [--hard | --roots]
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from math import degrees, pi, radians
from random import Random
from typing import Any

import pytest

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    NoPath,
    Obstacle,
    Path,
    SolverError,
    census,
    pose_path,
    poses,
    verify_document,
)
from tests.support.families import FAMILIES, family
from tests.support.motions import Mover, angles_of, legs_of
from tests.support.pair_grid import PairGrid, Place
from tests.support.triangle_spellings import manipulator_with_roots

Asked = dict[str, Any]
Limits = dict[int, tuple[Fraction, Fraction]]
Draw = Callable[[Random], Manipulator]
_MANIPULATORS = (*EXAMPLES.values(), *(family(name) for name in FAMILIES if "flat" not in name))


def a_manipulator(random: Random) -> Manipulator:
    """One of the examples and of the families, or a generic one."""
    if random.random() < 0.5:
        return random.choice(_MANIPULATORS)
    while True:
        sizes = [f"{random.uniform(2, 20):.1f}" for _ in range(6)]
        try:
            return Manipulator(*sizes, random.choice(["ccw", "cw"]))
        except InputError:
            continue


def an_end(random: Random, m: Manipulator, leg: int, length: Fraction) -> tuple[Asked, Place]:
    """A random pose: by its angles, or by its number among those of its joint vector."""
    alpha, theta = (Fraction(random.randint(-1799, 1800), 10) for _ in range(2))
    place = radians(alpha), radians(theta), float(length)
    if random.random() < 0.5:
        return {"alpha_deg": alpha, f"theta{leg}_deg": theta, f"l{leg}": length}, place
    legs = [f"{x:.3f}" for x in Mover.of(m, leg).legs(*place)]
    legs[leg - 1] = str(length)
    table = poses(m, *legs, digits=15)
    if not table.count:
        return an_end(random, m, leg, length)
    number = random.randint(1, table.count)
    pose = table.poses[number - 1].to_json()
    angles = radians(float(pose["alpha_deg"])), radians(float(pose[f"theta{leg}_deg"]))
    return {"l1": legs[0], "l2": legs[1], "l3": legs[2], "pose": number}, (*angles, float(length))


def a_hard_length(random: Random, m: Manipulator, leg: int) -> Fraction:
    """A length, half of the time 10^-2 to 10^-6 beside a transition."""
    rows = census(m, fixed_leg=leg, digits=15).transitions if random.random() < 0.5 else ()
    if not rows:
        return Fraction(f"{random.uniform(0.05, 1.5) * float(m.d1 + m.d2):.2f}")
    off = Fraction(random.choice([-1, 1]) * random.randint(1, 9), 10 ** random.randint(3, 6))
    return round(Fraction(random.choice(rows).length) * (1 + off), 9)


def a_hard_end(random: Random, m: Manipulator, leg: int, length: Fraction, sign: int) -> tuple[Asked, Place]:
    """A pose with this sign of J, 10^-4 to 10^-0.5 radians beside J = 0."""
    mover, size = Mover.of(m, leg), float(length)
    while True:
        theta = random.uniform(-pi, pi)
        steps = [2 * pi * k / 180 - pi for k in range(181)]
        signs = [mover.determinant(alpha, theta, size) > 0 for alpha in steps]
        ends = [pair for pair, (a, b) in zip(pairwise(steps), pairwise(signs), strict=True) if a != b]
        if not ends:
            continue
        low, high = random.choice(ends)
        for _ in range(40):
            middle = (low + high) / 2
            is_low = mover.determinant(middle, theta, size) > 0
            low, high = (
                (middle, high) if is_low == (mover.determinant(low, theta, size) > 0) else (low, middle)
            )
        alpha = low + random.choice([-1, 1]) * 10 ** random.uniform(-4, -0.5)
        given = Fraction(f"{degrees(alpha):.7f}"), Fraction(f"{degrees(theta):.7f}")
        place = radians(given[0]), radians(given[1]), size
        if mover.determinant(*place) * sign > 0:
            return {"alpha_deg": given[0], f"theta{leg}_deg": given[1], f"l{leg}": length}, place


def compared_hard(count: int, seed: int) -> Counter[str]:
    """What became of so many hard pairs of one sign of J, which the verifier may not refuse."""
    random = Random(f"hard {seed}")
    found: Counter[str] = Counter()
    while found.total() < count:
        m, leg = a_manipulator(random), random.choice([1, 2, 3])
        length, sign = a_hard_length(random, m, leg), random.choice([1, -1])
        ends = [a_hard_end(random, m, leg, length, sign) for _ in range(2)]
        limits = some_limits(random, m, leg, (ends[0][1], ends[1][1])) if random.random() < 0.5 else {}
        high = length * random.choice([1, 1, Fraction(11, 10), Fraction(3, 2)])
        between = None if high == length else (length, high)
        asked = {"between": between, "limits": limits, "fixed_leg": leg, "samples": 2}
        try:
            answer = pose_path(m, ends[0][0], ends[1][0], **asked)
        except InputError:
            found["refused"] += 1
            continue
        except SolverError as error:
            found[f"unproved: {error}"] += 1
            print(f"{m!r}, {ends[0][0]}, {ends[1][0]}, {asked}: {error}")
            continue
        refused = verify_document(json.dumps(answer.to_json())).refused
        assert not refused, (m, ends, asked, refused)
        assert not isinstance(answer, Path) or is_kept(answer, leg, limits, (float(length), float(high)))
        kind = "path" if isinstance(answer, Path) else answer.obstacle.value
        found[f"{kind}, with limits" if limits else kind] += 1
    return found


def some_limits(random: Random, m: Manipulator, leg: int, places: tuple[Place, Place]) -> Limits:
    """Limits of the free legs that both poses keep, often narrowly."""
    limits = {}
    for k in {1, 2, 3} - {leg}:
        own = [Mover.of(m, leg).legs(*place)[k - 1] for place in places]
        room = random.choice([0.01, 0.1, 0.5, 2.0]) * max(own)
        low = max(min(own) - room, min(own) / 2)
        limits[k] = Fraction(f"{low:.4f}"), Fraction(f"{max(own) + room:.4f}")
    return limits


def is_kept(path: Path, leg: int, limits: Limits, span: tuple[float, float]) -> bool:
    """Whether samples of a path are regular poses of one sign within the limits and the range."""
    mover = Mover.of(path.manipulator, leg)
    for sample in path.resampled(301).samples:
        legs = legs_of(sample)
        assert mover.legs(*angles_of(sample), legs[leg - 1]) == pytest.approx(legs, rel=1e-8)
        assert span[0] - 1e-9 <= legs[leg - 1] <= span[1] + 1e-9
        assert float(sample.determinant) * path.sign > 0
        assert all(
            float(low) - 1e-9 <= legs[k - 1] <= float(high) + 1e-9 for k, (low, high) in limits.items()
        )
    return True


def compared(count: int, seed: int, a_machine: Draw = a_manipulator) -> Counter[str]:
    """What became of so many pairs, each compared with the grid."""
    random = Random(seed)
    found: Counter[str] = Counter()
    while found.total() < count:
        m, leg = a_machine(random), random.choice([1, 2, 3])
        size = sum(m.doubles()[3:5])
        low = Fraction(f"{random.uniform(0.1, 1.5) * size:.2f}")
        high = low * random.choice([1, 1, Fraction(11, 10), Fraction(3, 2)])
        lengths = [low, high] if random.random() < 0.5 else [low, low]
        ends = [an_end(random, m, leg, length) for length in lengths]
        places = ends[0][1], ends[1][1]
        limits = some_limits(random, m, leg, places) if random.random() < 0.4 else {}
        between = None if low == high else (low, high)
        try:
            answer = pose_path(
                m, ends[0][0], ends[1][0], between=between, limits=limits, fixed_leg=leg, samples=2
            )
        except InputError:
            found["refused"] += 1
            continue
        except SolverError as error:
            found[f"unproved: {error}"] += 1
            continue
        span = float(low), float(high)
        if isinstance(answer, Path):
            assert is_kept(answer, leg, limits, span)
            found["path"] += 1
            continue
        assert isinstance(answer, NoPath)
        bounds = {k: (float(x), float(y)) for k, (x, y) in limits.items()}
        sizes = {"size": 90, "lengths": 16} if between else {"size": 360}
        is_joined = PairGrid(m, leg, span, bounds, **sizes).joins(*places)
        if answer.obstacle is Obstacle.UNDECIDED:
            found["undecided, but the grid joins" if is_joined else "undecided"] += 1
        else:
            assert not is_joined, (m, leg, ends, between, limits, answer.obstacle)
            found[answer.obstacle.value] += 1
    return found


def test_few_pairs_agree_with_the_grid() -> None:
    found = compared(8, 3)
    assert found["path"]
    assert found["opposite-signs"]


def test_few_pairs_of_manipulators_with_roots_agree_with_the_grid() -> None:
    assert compared(8, 1, manipulator_with_roots)["path"]


@pytest.mark.long
def test_200_pairs_of_manipulators_with_roots_agree_with_the_grid() -> None:
    assert compared(200, 2, manipulator_with_roots)["path"] > 40


@pytest.mark.long
def test_500_pairs_agree_with_the_grid() -> None:
    found = compared(500, 1)
    undecided = sum(n for name, n in found.items() if name.startswith(("undecided", "unproved")))
    assert (undecided <= 15, found["path"] > 100) == (True, True), found


def test_few_hard_pairs_are_decided() -> None:
    assert compared_hard(2, 2).total() == 2


@pytest.mark.long
def test_120_hard_pairs_are_decided() -> None:
    found = compared_hard(120, 1)
    assert sum(n for name, n in found.items() if name.startswith(("undecided", "unproved"))) <= 6, found


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--pairs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--hard", action="store_true", help="pairs close to the singular curve")
    parser.add_argument("--roots", action="store_true", help="of manipulators with roots")
    given = parser.parse_args()
    if given.hard:
        found = compared_hard(given.pairs, given.seed)
    else:
        found = compared(given.pairs, given.seed, manipulator_with_roots if given.roots else a_manipulator)
    print(", ".join(f"{count} {name}" for name, count in found.most_common()))


if __name__ == "__main__":
    main()
