"""Machines with roots beside rational ones of as many bits: what a square root costs.

    python -m benchmarks.irrational [--rounds 5]

Each machine of tests/data/irrational.json stands beside six rational numbers near its own, rounded to so many
decimals that the coordinates of both have about as many bits. Both do the same work in turns, each round with
a manipulator that nothing is kept of. A row gives the medians of the rounds, in milliseconds of processor
time, and the median over the machines of the ratios of roots to rational numbers.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path

from rpr_solver import InputError, Manipulator, census, cusp_table, eliminate, poses, solve_slices
from rpr_solver.contract import LENGTHS
from rpr_solver.model.slice_map import SliceMap

ROWS = json.loads(Path(__file__).parents[1].joinpath("tests", "data", "irrational.json").read_text("utf-8"))[
    "rows"
]
SCAN = 40
"""Slices of a scan, near the given length."""
Work = Callable[[Manipulator, Fraction], object]
WORKS: Mapping[str, Work] = {
    "a slice from nothing": lambda m, length: cusp_table(m, length),
    "a scan of 40 slices": lambda m, length: solve_slices(
        eliminate(m), [length * (1 + Fraction(k, 1000)) for k in range(SCAN)]
    ),
    "a census": lambda m, _: census(m),
    "poses": lambda m, length: poses(m, length, length, length),
}


def bits(manipulator: Manipulator) -> int:
    """The bits of the greatest coordinate of the forms."""
    slice_map = SliceMap.of(manipulator)
    numbers = [x for leg in (slice_map.f, slice_map.g) for point in (leg.platform, leg.base) for x in point]
    return max(abs(part).bit_length() for x in numbers for part in (x.a, x.b))


def rounded(manipulator: Manipulator, places: int) -> Manipulator:
    """The manipulator of six decimals near those of another."""
    unit = 10**places
    lengths = [Fraction(round(x * unit), unit) for x in manipulator.doubles()]
    return Manipulator(**dict(zip(LENGTHS, lengths, strict=True)), orientation=manipulator.orientation)


def neighbour(manipulator: Manipulator) -> Manipulator:
    """The one of those whose coordinates have most nearly as many bits."""
    wanted = bits(manipulator)
    return min((rounded(manipulator, n) for n in range(1, 9)), key=lambda m: abs(bits(m) - wanted))


def seconds(work: Work, manipulator: Manipulator, length: Fraction, seed: int) -> float:
    """Processor time of some work, at a length that was not asked for before."""
    start = time.process_time()
    work(manipulator, length + Fraction(seed, 10**6))
    return time.process_time() - start


def main() -> None:
    """Print a row for each work."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.irrational")
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    pairs = []
    for row in ROWS:
        manipulator = Manipulator.from_json(row["geometry"])
        try:
            pairs.append((manipulator, neighbour(manipulator), Fraction(row["l1"])))
        except InputError:  # rounded sides of a flat platform may be no triangle
            continue
    print(f"{len(pairs)} machines; ms of processor time: with roots, rational, and the median ratio")
    for name, work in WORKS.items():
        times = [
            [
                statistics.median(seconds(work, each, length, seed) for seed in range(rounds))
                for each in (own, other)
            ]
            for own, other, length in pairs
        ]
        own, other = (1000 * statistics.median(column) for column in zip(*times, strict=True))
        ratio = statistics.median(a / b for a, b in times)
        print(f"{name:22} {own:8.2f} {other:8.2f} {ratio:6.2f}")


if __name__ == "__main__":
    main()
