"""Random machines by points, sides and roots: answers of the solver against witnesses that know no field.

    python -m tests.rpr_solver.triangles.long_run [--machines 500] [--first 0] [--seed 1]

Machine n is the same in every run with the same seed, so that a run may be done in parts (``--first``). Of
each one slice, one joint vector, one census and the singular curves of the slice are compared: cusps by
Newton's iteration from many starts, poses by a sextic in doubles, counts between transitions, and J = 0 and
the legs at samples. A path between two random poses is followed by its legs and J; that there is none is
compared with a grid of poses. Whether the mode can change is shown by a path, or compared with the grid.

Each line is a machine that differs, and in what; the last line has the numbers. A machine in which J and E
share curves is counted as special, of similar triangles the mode must not change; one that needs two roots at
once is counted as refused. Exits with status 1 if a machine differs.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from math import radians
from random import Random
from typing import Any

import mpmath as mp

from rpr_solver import (
    Change,
    InputError,
    Manipulator,
    Obstacle,
    Path,
    SolverError,
    assembly_modes,
    census,
    pose_path,
    poses,
    singular_curves,
    solve_slice,
)
from rpr_solver.slices import eliminate
from tests.rpr_solver.modes.test_modes import replayed
from tests.rpr_solver.paths.test_random_pairs import is_kept
from tests.support.mode_grid import ModeGrid
from tests.support.oracle import free_legs_of, singularity
from tests.support.pair_grid import PairGrid
from tests.support.triangle_oracle import Waves, corners_of, cusps, wrapped
from tests.support.triangle_oracle import poses as known_poses
from tests.support.triangle_spellings import drawn

_CLOSE = Fraction(1, 50)
"""Of a length: near a transition the witness may lose cusps."""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--machines", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    counts = Counter[str]()
    for number in range(args.first, args.first + args.machines):
        draw = Random(f"{args.seed} {number}")
        manipulator, length = machine(draw), Fraction(draw.randint(200, 2500), 100)
        verdict = compared(manipulator, length, draw)
        counts[verdict] += 1
        if verdict not in ("agree", "special", "refused"):
            print(number, verdict, manipulator, length, flush=True)
    print(dict(counts))
    return int(bool(counts.keys() - {"agree", "special", "refused", "unproved"}))


def machine(draw: Random) -> Manipulator:
    while True:
        try:
            return Manipulator.from_json(drawn(draw))
        except InputError:
            continue


def compared(manipulator: Manipulator, length: Fraction, draw: Random) -> str:
    """What differs, if anything does."""
    try:
        _ = manipulator.frame
    except InputError:
        return "refused"
    if manipulator.geometry.is_similar:
        answer = assembly_modes(manipulator, length, with_regions=False)
        return "special" if answer.change is Change.IMPOSSIBLE else "modes"
    table = solve_slice(eliminate(manipulator), length, 20)
    if table.degenerate_points:
        return "special"
    with mp.workdps(40):
        differences = (
            ("cusps", cusps_differ(manipulator, length, [mp.mpf(x.theta1_deg) for x in table.cusps])),
            ("poses", poses_differ(manipulator, length, draw)),
            ("census", census_differs(manipulator, draw)),
            ("curves", curves_differ(manipulator, length)),
            ("paths", path_differs(manipulator, length, draw)),
        )
        if found := next((name for name, differs in differences if differs), None):
            return found
    return mode_verdict(manipulator, length, draw)


def cusps_differ(manipulator: Manipulator, length: Fraction, degrees: list[Any]) -> bool:
    base, platform = corners_of(manipulator.geometry)
    angles = sorted(map(mp.radians, degrees))
    for starts in (30, 160):
        others = sorted(theta for _, theta in cusps(base, platform, number(length), starts))
        if len(others) == len(angles):
            break
    near = all(abs(wrapped(x - y)) < 1e-8 for x, y in zip(angles, others, strict=False))
    return len(others) != len(angles) or not near


def poses_differ(manipulator: Manipulator, length: Fraction, draw: Random) -> bool:
    """At the legs of a random pose, rounded."""
    base, platform = corners_of(manipulator.geometry)
    tip, turn = (mp.expj(draw.uniform(0, 6.28)) for _ in range(2))
    legs = [abs(number(length) * tip + turn * platform[k] - base[k]) for k in (1, 2)]
    rounded = [Fraction(str(mp.nstr(leg, 8))) for leg in legs]
    found = poses(manipulator, length, *rounded, digits=20)
    known = known_poses(base, platform, [number(x) for x in (length, *rounded)])
    angles = sorted(mp.radians(mp.mpf(pose.alpha_deg)) for pose in found.poses)
    near = all(abs(wrapped(x - y)) < 1e-9 for x, (y, _) in zip(angles, known, strict=False))
    return len(angles) != len(known) or not near


def census_differs(manipulator: Manipulator, draw: Random) -> bool:
    base, platform = corners_of(manipulator.geometry)
    wide = [
        (Fraction(part["from"]) + Fraction(part["to"]), part["count"])
        for part in census(manipulator, digits=20).to_json()["intervals"][1:-1]
        if Fraction(part["to"]) - Fraction(part["from"]) > _CLOSE * Fraction(part["to"])
    ]
    if not wide:
        return False
    twice, count = draw.choice(wide)
    return not any(len(cusps(base, platform, number(twice) / 2, starts)) == count for starts in (30, 160))


def curves_differ(manipulator: Manipulator, length: Fraction) -> bool:
    base, platform = corners_of(manipulator.geometry)
    waves, size = (
        Waves.of(base, platform, number(length)),
        max(abs(z) for z in (*base, *platform, number(length))),
    )
    return any(
        abs(waves.system(alpha, theta, mp.exp)[0]) > size**4 * 1e-6
        or any(
            abs(abs(number(length) * mp.expj(theta) + mp.expj(alpha) * platform[k] - base[k]) - leg)
            > size * 1e-6
            for k, leg in enumerate(legs, 1)
        )
        for alpha, theta, legs in samples(manipulator, length)
    )


def path_differs(manipulator: Manipulator, length: Fraction, draw: Random) -> bool:
    """Between two random poses with J > 0."""
    legs, size, ends = free_legs_of(manipulator, 1), float(length), []
    while len(ends) < 2:
        alpha, theta = (Fraction(draw.randint(-1799, 1800), 10) for _ in range(2))
        if singularity(legs, size, radians(alpha), radians(theta)) > 0:
            ends.append({"alpha_deg": alpha, "theta1_deg": theta, "l1": length})
    try:
        answer = pose_path(manipulator, ends[0], ends[1], samples=2)
    except SolverError:
        return True
    if isinstance(answer, Path):
        return not is_kept(answer, 1, {}, (size, size))
    if answer.obstacle is not Obstacle.OTHER_ASPECT:
        return True
    first, last = ((radians(end["alpha_deg"]), radians(end["theta1_deg"]), size) for end in ends)
    return PairGrid(manipulator, 1, (size, size), {}, size=360).joins(first, last)


def mode_verdict(manipulator: Manipulator, length: Fraction, draw: Random) -> str:
    answer = assembly_modes(manipulator, length, with_regions=False)
    if answer.change is Change.UNDECIDED:
        return "unproved"
    if answer.change is Change.POSSIBLE:
        replayed(answer)
        return "agree"
    grid = ModeGrid(manipulator, 1, (float(length), float(length)), {})
    return "agree" if grid.change(300, draw.randint(1, 1000)) is None else "modes"


def samples(manipulator: Manipulator, length: Fraction) -> Iterator[tuple[Any, Any, tuple[float, float]]]:
    for strand in singular_curves(manipulator, length).strands:
        columns = strand.alpha_deg, strand.theta_deg, strand.first, strand.second
        for alpha, theta, *legs in list(zip(*columns, strict=True))[::20]:
            yield mp.radians(mp.mpf(alpha)), mp.radians(mp.mpf(theta)), (legs[0], legs[1])


def number(x: Fraction) -> Any:
    return mp.mpf(x.numerator) / x.denominator


if __name__ == "__main__":
    sys.exit(main())
