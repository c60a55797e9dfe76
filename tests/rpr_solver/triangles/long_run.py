"""Random machines by points, sides and roots: answers of the solver against a witness that knows no field.

    python -m tests.rpr_solver.triangles.long_run --machines 500 --seed 1

Of each machine one slice, one joint vector, one census and the singular curves of the slice are compared:
cusps by Newton's iteration from many starts, poses by a sextic in doubles, counts between transitions, and
J = 0 and the legs at samples. Each line is a machine that differs, and in what; the last line has the
numbers. A machine in which J and E share curves, as similar triangles do, is counted as special, and one that
needs two roots at once as refused.
"""

import argparse
import random
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import mpmath as mp

from rpr_solver import InputError, Manipulator, census, poses, singular_curves, solve_slice
from rpr_solver.slices import eliminate
from tests.support.triangle_oracle import Waves, corners_of, cusps, wrapped
from tests.support.triangle_oracle import poses as known_poses

_CLOSE = Fraction(1, 50)
"""Of a length: near a transition the witness may lose cusps."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--machines", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    draw, counts = random.Random(args.seed), Counter[str]()
    while counts.total() < args.machines:
        spelling = spelled(draw)
        length = Fraction(draw.randint(200, 2500), 100)
        try:
            manipulator = Manipulator.from_json(spelling)
        except InputError:
            continue
        verdict = compared(manipulator, length, draw)
        counts[verdict] += 1
        if verdict not in ("agree", "special", "refused"):
            print(verdict, spelling, length, flush=True)
    print(dict(counts))


def spelled(draw: random.Random) -> dict[str, Any]:
    """A geometry as people write it; not all are manipulators."""
    spelling = {name: triangle(draw) for name in ("base", "platform")}
    return (
        spelling
        if "points" in spelling["platform"]
        else spelling | {"orientation": draw.choice(["ccw", "cw"])}
    )


def triangle(draw: random.Random) -> Any:
    def decimal(low: int, high: int) -> str:
        return f"{draw.uniform(low, high):.2f}"

    def whole() -> str:
        return str(draw.randint(3, 12))

    def root() -> str:
        return f"{draw.randint(1, 6)}*sqrt({draw.randint(2, 7)})"

    corners = [
        ["0", "0"],
        [decimal(3, 15), "0"],
        [decimal(0, 15), f"{decimal(1, 4)}*sqrt({draw.randint(2, 1000)})"],
    ]
    spellings = (
        {"equilateral": decimal(3, 15)},
        {"equilateral": root()},
        {"circumradius": decimal(3, 6)},
        {"sides": [decimal(3, 14) for _ in range(3)]},
        {"sides": [whole(), root(), whole()]},
        {"points": [[decimal(-5, 15), decimal(-5, 15)] for _ in range(3)]},
        {"points": draw.sample(corners, 3)},
    )
    return draw.choice(spellings)


def compared(manipulator: Manipulator, length: Fraction, draw: random.Random) -> str:
    """What differs, if anything does."""
    try:
        _ = manipulator.frame
    except InputError:
        return "refused"
    table = solve_slice(eliminate(manipulator), length, 20)
    if manipulator.geometry.is_similar or table.degenerate_points:
        return "special"
    with mp.workdps(40):
        differences = (
            ("cusps", cusps_differ(manipulator, length, [mp.mpf(x.theta1_deg) for x in table.cusps])),
            ("poses", poses_differ(manipulator, length, draw)),
            ("census", census_differs(manipulator, draw)),
            ("curves", curves_differ(manipulator, length)),
        )
        return next((name for name, differs in differences if differs), "agree")


def cusps_differ(manipulator: Manipulator, length: Fraction, degrees: list[Any]) -> bool:
    base, platform = corners_of(manipulator.geometry)
    angles = sorted(map(mp.radians, degrees))
    for starts in (30, 160):
        others = sorted(theta for _, theta in cusps(base, platform, number(length), starts))
        if len(others) == len(angles):
            break
    near = all(abs(wrapped(x - y)) < 1e-8 for x, y in zip(angles, others, strict=False))
    return len(others) != len(angles) or not near


def poses_differ(manipulator: Manipulator, length: Fraction, draw: random.Random) -> bool:
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


def census_differs(manipulator: Manipulator, draw: random.Random) -> bool:
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


def samples(manipulator: Manipulator, length: Fraction) -> Iterator[tuple[Any, Any, tuple[float, float]]]:
    for strand in singular_curves(manipulator, length).strands:
        columns = strand.alpha_deg, strand.theta_deg, strand.first, strand.second
        for alpha, theta, *legs in list(zip(*columns, strict=True))[::20]:
            yield mp.radians(mp.mpf(alpha)), mp.radians(mp.mpf(theta)), (legs[0], legs[1])


def number(x: Fraction) -> Any:
    return mp.mpf(x.numerator) / x.denominator


if __name__ == "__main__":
    main()
