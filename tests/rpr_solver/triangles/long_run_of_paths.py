"""Random machines by points, sides and roots, against witnesses that know no field, no frame and no ρ.

    python -m tests.rpr_solver.triangles.long_run_of_paths [--machines 500] [--first 0] [--seed 1]

Machine n is the same in every run with the same seed, so that a run may be done in parts. In a slice of each:

- cusps, against Newton's iteration from many starts;
- the count of the census at the length of the slice, likewise, unless a transition is near;
- samples of the singular curves, whose joints and J are computed anew;
- a path between two random poses, at whose samples the legs are right and J has one sign, or that there is
  none, against a grid of poses;
- whether the mode can change: the witness is replayed, and a proof that it cannot is compared with the grid.

Each failure is printed with its machine. A machine of which J and E share curves is counted as special, one
that needs two roots at once as refused. Exits with status 1 if anything differs.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from math import radians
from random import Random

import mpmath as mp

from rpr_solver import (
    Change,
    InputError,
    Manipulator,
    NoPath,
    Obstacle,
    Path,
    SolverError,
    assembly_modes,
    census,
    cusp_table,
    pose_path,
    singular_curves,
)
from rpr_solver.triangles import own_shapes, read_geometry
from tests.rpr_solver.modes.test_modes import replayed
from tests.rpr_solver.paths.test_random_pairs import is_kept
from tests.support.mode_grid import ModeGrid
from tests.support.motions import Mover
from tests.support.oracle import free_legs_of, singularity
from tests.support.pair_grid import PairGrid
from tests.support.triangle_oracle import corners_of, cusps, wrapped
from tests.support.triangle_spellings import drawn

AGREES, DIFFERS, UNPROVED = "agrees", "DIFFERS", "unproved"
_NEAR = Fraction(1, 100)
"""Of a length: the witness may lose cusps so near to a transition."""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--machines", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    found: Counter[tuple[str, str]] = Counter()
    for number in range(args.first, args.first + args.machines):
        random = Random(f"{args.seed} {number}")
        manipulator, length = machine(random), Fraction(random.randint(200, 2500), 100)
        for kind, verdict in examined(manipulator, length, random):
            found[kind, verdict] += 1
            if verdict == DIFFERS:
                print(number, kind, manipulator, length, flush=True)
    for (kind, verdict), count in sorted(found.items()):
        print(f"{kind}: {count} {verdict}")
    return int(any(verdict == DIFFERS for _, verdict in found))


def machine(random: Random) -> Manipulator:
    while True:
        try:
            return Manipulator.of(read_geometry(drawn(random)))
        except InputError:
            continue


def examined(m: Manipulator, length: Fraction, random: Random) -> Iterator[tuple[str, str]]:
    """What was asked, and what came of it."""
    try:
        if any(shape == "similar" for shape, _ in own_shapes(m.geometry)):
            yield "similar", stated(assembly_modes(m, length).change is Change.IMPOSSIBLE)
            return
        [table] = cusp_table(m, length, digits=20)
    except InputError:
        yield "machines", "refused: two roots at once"
        return
    except SolverError as error:
        yield "cusps", f"special: {error}"
        return
    known = witnessed(m, length, table.count)
    angles = sorted(float(cusp.theta1_deg) for cusp in table.cusps)
    yield "cusps", stated(len(known) == len(angles) and all(map(near, known, angles)))
    for kind, verdict in (
        ("census", of_census),
        ("singular curves", of_curves),
        ("paths", of_path),
        ("modes", of_modes),
    ):
        try:
            yield kind, verdict(m, length, random)
        except SolverError:
            yield kind, UNPROVED
        except AssertionError as error:
            print(error)
            yield kind, DIFFERS


def stated(is_so: bool) -> str:
    return AGREES if is_so else DIFFERS


def near(x: float, y: float) -> bool:
    return abs((x - y + 180) % 360 - 180) < 1e-7


def witnessed(m: Manipulator, length: Fraction, count: int) -> list[float]:
    """The angles θ1 of cusps by Newton's iteration, from more starts if some seem to be missing."""
    with mp.workdps(40):
        base, platform = corners_of(m.geometry)
        at = mp.mpf(length.numerator) / length.denominator
        for starts in (60, 160):
            found = cusps(base, platform, at, starts)
            if len(found) == count:
                break
        return sorted(float(mp.degrees(wrapped(theta))) for _, theta in found)


def of_census(m: Manipulator, length: Fraction, random: Random) -> str:
    parts = census(m, digits=15).to_json()["intervals"]
    inner = [part for part in parts if part["to"] is not None]
    part = random.choice(inner or parts)
    low = Fraction(part["from"])
    high = 2 * low + length if part["to"] is None else Fraction(part["to"])
    if high - low < _NEAR * high:
        return "of a narrow interval, not compared"
    return stated(len(witnessed(m, (low + high) / 2, part["count"])) == part["count"])


def of_curves(m: Manipulator, length: Fraction, _: Random) -> str:
    mover, legs = Mover.of(m), free_legs_of(m, 1)
    size = max(map(abs, m.doubles())) + float(length)
    for component in singular_curves(m, length, digits=15).to_json()["components"]:
        for strand in component["strands"]:
            samples = zip(*(strand[x] for x in ("alpha_deg", "theta1_deg", "l2", "l3")), strict=True)
            for sample in list(samples)[::9]:
                alpha, theta = (radians(float(x)) for x in sample[:2])
                own = mover.free(alpha, theta, float(length))
                assert all(abs(x - float(y)) < 1e-6 * size for x, y in zip(own, sample[2:], strict=True))
                assert abs(singularity(legs, float(length), alpha, theta)) < 1e-6 * size**3
    return AGREES


def of_path(m: Manipulator, length: Fraction, random: Random) -> str:
    """Between two poses that are likely to have one sign of J."""
    legs, ends = free_legs_of(m, 1), []
    while len(ends) < 2:
        alpha, theta = (Fraction(random.randint(-1799, 1800), 10) for _ in range(2))
        if singularity(legs, float(length), radians(alpha), radians(theta)) > 0:
            ends.append({"alpha_deg": alpha, "theta1_deg": theta, "l1": length})
    answer = pose_path(m, *ends, samples=2)
    if isinstance(answer, Path):
        return stated(is_kept(answer, 1, {}, (float(length), float(length))))
    assert isinstance(answer, NoPath)
    assert answer.obstacle is Obstacle.OTHER_ASPECT
    places = [(radians(end["alpha_deg"]), radians(end["theta1_deg"]), float(length)) for end in ends]
    grid = PairGrid(m, 1, (float(length), float(length)), {}, size=360)
    return stated(not grid.joins(places[0], places[1]))


def of_modes(m: Manipulator, length: Fraction, random: Random) -> str:
    answer = assembly_modes(m, length, with_regions=False)
    if answer.change is Change.POSSIBLE:
        replayed(answer)
        return AGREES
    if answer.change is Change.UNDECIDED:
        return UNPROVED
    grid = ModeGrid(m, 1, (float(length), float(length)), {})
    return stated(grid.change(300, random.randint(1, 1000)) is None)


if __name__ == "__main__":
    sys.exit(main())
