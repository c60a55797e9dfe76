"""The long run of thresholds: checks, designs and changes of assembly mode against grids of their own.

    python -m tests.rpr_solver.modes.long_run [--checks 80] [--modes 100] [--designs 20] [--seed 1]

Checks: the number of cusps is counted in slices a third of the ignored width apart. A check that passes has
no violating slices in a row as long as that; one that fails has some. Designs are checked likewise. Modes:
the clearance of a path is measured at its samples by a grid of the singular curve; where no path is to keep
the clearance, a grid of poses must have no two poses of one joint vector in one component that keeps a little
more. Within a tolerance, J must keep its sign along the path for random neighbours. Answers are asked again
with looser thresholds, which must not lose a yes. Prints every failure, then the numbers, and exits with
status 1 if there was one.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations, groupby
from random import Random

import numpy as np

from rpr_solver import Change, Manipulator, Requirement, SolverError, assembly_modes, check, design
from rpr_solver.contract import LENGTHS
from rpr_solver.modes.wide_pairs import components
from rpr_solver.slices.cusp_table import cusp_table
from tests.support.mode_grid import poses_of
from tests.support.motions import angles_of
from tests.support.oracle import free_legs_of, singularity
from tests.support.pictures import random_robot
from tests.support.width_grid import WidthGrid

SAMPLES = 90
"""Slices in a range."""
TRIALS = 400
NODES = 120
NEAREST = 5
"""Samples of a path whose distances are measured finely, by those of the grid."""


def violating_runs(manipulator: Manipulator, wish: Requirement) -> list[Fraction]:
    """How long the rows of violating slices are, a third of the ignored width apart, from first to last."""
    assert wish.stop is not None
    step = wish.ignore_windows / 3
    count = int((wish.stop - wish.start) / step)
    lengths = [wish.start + step * k + step / 7 for k in range(count)]
    tables = cusp_table(manipulator, lengths, digits=15)
    admitted = [wish.admits(table.count) for table in tables]
    rows = [len(list(same)) for is_admitted, same in groupby(admitted) if not is_admitted]
    return [step * (row - 1) for row in rows]


def of_check(rng: Random) -> Iterator[str]:
    """What is wrong with a check."""
    manipulator = random_robot(rng)
    size = manipulator.bounds()[0][1]
    start = size * Fraction(rng.randint(1, 20), 10)
    width = size * Fraction(rng.randint(2, 12), 10)
    least = 3 * width / SAMPLES
    wish = Requirement(start=start, stop=start + width, max_cusps=rng.choice((2, 4, 6)), ignore_windows=least)
    report = check(manipulator, wish, digits=15)
    runs = violating_runs(manipulator, wish)
    yield "passed" if report else "failed"
    if report and any(run >= least for run in runs):
        yield f"FAULT: passes with a window of {float(max(runs))}: {manipulator}, {wish}"
    if not report and not any(run >= least / 3 for run in runs):
        yield f"FAULT: fails without a window: {manipulator}, {wish}"
    if report and not check(manipulator, wish.ignoring(least * 2), digits=15):
        yield f"FAULT: a wider threshold fails: {manipulator}, {wish}"


def of_design(rng: Random) -> Iterator[str]:
    """What is wrong with a design."""
    manipulator = random_robot(rng)
    size = manipulator.bounds()[0][1]
    wish = Requirement(start=size, stop=size * 2, max_cusps=rng.choice((4, 6)), ignore_windows=size / 30)
    found = design(manipulator, "least-change", wish, vary="15%", budget=8, seed=rng.randint(1, 99))
    runs = violating_runs(found.best, wish)
    yield "met" if found.met else "not met"
    is_seen = any(run >= (wish.ignore_windows if found.met else wish.ignore_windows / 3) for run in runs)
    if found.met == is_seen:
        yield f"FAULT: met is {found.met}, with {list(map(float, runs))}: {found.best}"


def of_mode(rng: Random) -> Iterator[str]:
    """What is wrong with a change of assembly mode."""
    manipulator = random_robot(rng)
    length = manipulator.bounds()[0][1] * Fraction(rng.randint(1, 30), 10)
    clearance = Fraction(rng.choice((1, 3, 8, 20, 40, 60)))
    tolerance = None if rng.random() < 0.5 else length * Fraction(rng.choice((1, 10)), 10_000)
    asked = {"clearance": clearance, "tolerance": tolerance, "with_regions": False}
    answer = assembly_modes(manipulator, length, **asked)  # type: ignore[arg-type]
    yield str(answer.change)
    grid = WidthGrid(manipulator, 1, float(length), NODES)
    if answer.change is Change.POSSIBLE and answer.witness is not None:
        places = [angles_of(sample) for sample in answer.witness.samples]
        about = grid.zeros.query(np.degrees(places) % 360)[0]
        nearest = np.degrees(places)[about.argsort()[:NEAREST]]
        seen = min(grid.distance((float(a), float(t))) for a, t in nearest)
        assert answer.witness.clearance is not None
        if seen < float(clearance) or seen < float(answer.witness.clearance.proved) * (1 - 1e-6):
            yield f"FAULT: the witness keeps {seen}: {manipulator}, L1 = {length}, {asked}"
        own = dict(zip(LENGTHS, manipulator.lengths, strict=True))
        for _ in range(8 if tolerance is not None else 0):
            moved = {g: x + rng.choice((-1, 1)) * (tolerance or 0) for g, x in own.items()}
            legs = free_legs_of(Manipulator(**{**manipulator.to_dict(), **moved}), 1)
            if any(singularity(legs, float(length), *x) * answer.witness.sign <= 0 for x in places):
                yield f"FAULT: a neighbour meets a singularity: {manipulator}, L1 = {length}, {asked}"
        looser = {**asked, "clearance": clearance / 2}
        if assembly_modes(manipulator, length, **looser).change is not Change.POSSIBLE:  # type: ignore[arg-type]
            yield f"FAULT: a smaller clearance is not possible: {manipulator}, L1 = {length}, {asked}"
    if answer.change is Change.IMPOSSIBLE and pair_found(grid, float(clearance), rng):
        yield f"FAULT: a grid has a change: {manipulator}, L1 = {length}, {asked}"


def pair_found(grid: WidthGrid, clearance: float, rng: Random) -> bool:
    """Whether random joint vectors have two poses in one component of nodes that keep a little more."""
    step, legs = grid.step, free_legs_of(grid.manipulator, 1)
    nodes = np.stack(np.meshgrid(*[np.arange(NODES) * step] * 2, indexing="ij"), -1)
    far = grid.zeros.query(nodes.reshape(-1, 2))[0].reshape(NODES, NODES)
    kept = [components((far > clearance + step) & (grid.values * sign > 0)) for sign in (1, -1)]
    for _ in range(TRIALS):
        alpha, theta = (rng.uniform(0, 2 * np.pi) for _ in range(2))
        ends = [abs(grid.length * np.exp(1j * theta) + x * np.exp(1j * alpha) - a) for x, a in legs]
        spots = [
            tuple(round(np.degrees(x) / step) % NODES for x in place)
            for place in poses_of(legs, grid.length, ends)
        ]
        for one, other in combinations(spots, 2):
            if one != other and any(labels[one] == labels[other] >= 0 for labels in kept):
                return True
    return False


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    kinds = {"checks": of_check, "modes": of_mode, "designs": of_design}
    for name, default in (("checks", 80), ("modes", 100), ("designs", 20), ("seed", 1)):
        parser.add_argument(f"--{name}", type=int, default=default)
    args = parser.parse_args()
    faults = 0
    for name, judged in kinds.items():
        found, start = Counter[str](), time.process_time()
        for number in range(getattr(args, name)):
            try:
                for word in judged(Random(f"{args.seed} {name} {number}")):
                    faults += word.startswith("FAULT")
                    print(f"{name} {number}: {word}", flush=True) if word.startswith("FAULT") else None
                    found[word.partition(":")[0]] += 1
            except SolverError as error:
                found[f"no answer ({type(error).__name__})"] += 1
        print(f"{name}: {dict(found)}, {time.process_time() - start:.0f} s", flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
