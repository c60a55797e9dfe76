"""Margins: how near to the truth they are proved, what they cost, and whether they are sound.

python benchmarks/margins.py                     the examples
python benchmarks/margins.py --random 200        random manipulators: the share of the possible that is proved
python benchmarks/margins.py --samples 5000      exact counts in proved boxes; exit status 1 if one differs
python benchmarks/margins.py --censuses 100      censuses of a tolerance against exact ones; likewise

Times are those of the process, so that other processes do not count. The share is the proved radius over
the least of the first-order radius, the counter-example's and the validity radius.
"""

from __future__ import annotations

import argparse
import random
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from itertools import islice, pairwise
from typing import Any, TypeVar

from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    Margin,
    Requirement,
    SolverError,
    census,
    cusp_table,
    margin,
    tolerance_census,
)
from rpr_solver.contract import LENGTHS

INNOCENTI = EXAMPLES["innocenti"]
CASES: dict[str, tuple[Manipulator, dict[str, Any], str]] = {
    "first manipulator, L1 = 28.1": (INNOCENTI, {"length": "28.1"}, "6.0e-4"),
    "first manipulator, L1 = 27": (INNOCENTI, {"length": 27}, "0.070"),
    "first manipulator, L1 = 17": (INNOCENTI, {"length": 17}, "0.22"),
    "first manipulator, 6 cusps on [21, 26]": (
        INNOCENTI,
        {"requirement": Requirement(start=21, stop=26, max_cusps=6, min_cusps=6)},
        "0.07",
    ),
    "first manipulator, at most 8 cusps on [29, 35]": (
        INNOCENTI,
        {"requirement": Requirement(start=29, stop=35, max_cusps=8)},
        "0.004",
    ),
    "sixteen-cusps, L1 = 14.46845": (EXAMPLES["sixteen-cusps"], {"length": "14.46845"}, "8.1e-7"),
    "eighteen-cusps, L1 = 15.6431": (EXAMPLES["eighteen-cusps"], {"length": "15.6431"}, "4.55e-7"),
}
TOLERANCES = [
    ("first manipulator", INNOCENTI, "0.001"),
    ("twelve-cusps", EXAMPLES["twelve-cusps"], "0.0001"),
    ("fourteen-cusps", EXAMPLES["fourteen-cusps"], "0.0001"),
    ("sixteen-cusps", EXAMPLES["sixteen-cusps"], "0.00001"),
]
T = TypeVar("T")


def timed(ask: Callable[[], T]) -> tuple[T, float]:
    """An answer and the processor time in seconds."""
    start = time.process_time()
    return ask(), time.process_time() - start


def possible(answer: Margin) -> Fraction | None:
    """The radius that no proof can exceed, as far as is known."""
    bounds = [] if answer.first_order is None else [Fraction(answer.first_order.radius)]
    bounds += [] if answer.counterexample is None else [answer.counterexample.radius]
    bounds += [] if answer.validity is None else [answer.validity]
    return min(bounds, default=None)


def examples() -> None:
    """Print the answers to the examples, and the time for the proof of the radius that should be proved."""
    for name, (manipulator, question, least) in CASES.items():
        answer, whole = timed(partial(margin, manipulator, **question))
        single, proof = timed(partial(margin, manipulator, **question, tolerance=least))
        top = possible(answer)
        assert top is not None
        against = answer.counterexample and float(answer.counterexample.radius)
        print(
            f"{name}: {answer.count} cusps; first order "
            f"{answer.first_order and answer.first_order.radius:.4g}, refuted {against}, proved "
            f"{float(answer.proved or 0):.4g} ({float((answer.proved or 0) / top):.0%}) in {whole:.1f} s, "
            f"{answer.boxes} boxes; {least}: {single.verdict} in {proof:.1f} s, {single.boxes} boxes"
        )
    for name, manipulator, tolerance in TOLERANCES:
        table, seconds = timed(partial(tolerance_census, manipulator, tolerance, digits=30))
        known = sum(span is not None for span in table.spans)
        print(
            f"{name}, census within {tolerance}: {known} of {len(table.spans)} transitions bounded, "
            f"{len(table.open)} ranges open, {table.boxes} boxes, {seconds:.1f} s"
        )


def questions(seed: int) -> Iterator[tuple[Manipulator, Fraction, int]]:
    """Random manipulators with a slice of each leg in turn."""
    rng, number = random.Random(seed), 0
    while True:
        values = [Fraction(rng.randrange(-200, 200), 10) for _ in range(3)]
        values += [Fraction(rng.randrange(20, 300), 10) for _ in range(3)]
        try:
            manipulator = Manipulator(*values, orientation=rng.choice(("ccw", "cw")))
        except InputError:
            continue
        number += 1
        yield manipulator, Fraction(rng.randrange(10, 400), 10), 1 + number % 3


def shares(number: int, seed: int, most_boxes: int) -> None:
    """Print the shares and times of random questions."""
    found, times, without = [], [], 0
    for (manipulator, length, leg), _ in zip(questions(seed), range(number), strict=False):
        try:
            answer, seconds = timed(
                partial(margin, manipulator, length, fixed_leg=leg, most_boxes=most_boxes)
            )
        except SolverError as error:
            print(f"no answer: {manipulator} leg {leg} {length}: {error}")
            continue
        top = possible(answer)
        if top is None or answer.reason is not None:
            without += 1
            continue
        found.append(float((answer.proved or 0) / top))
        times.append(seconds)
        words = f"{answer} share {found[-1]:.2f} {seconds:.1f} s"
        print(f"{manipulator} L{leg}={length}: {words}", flush=True)
    low = sum(share < 0.4 for share in found) / len(found)
    median, seconds = statistics.median(found), statistics.median(times)
    print(f"{len(found)} margins, {without} slices with degenerate poses: median share {median:.2f},")
    print(f"below 0.4: {low:.0%}; median time {seconds:.1f} s")


def soundness(samples: int, seed: int, most_boxes: int) -> int:
    """Count exactly at corners and random points of proved boxes; return how many counts are others."""
    rng, done, wrong, confirmed = random.Random(seed), 0, 0, 0
    for manipulator, length, leg in questions(seed):
        answer = margin(manipulator, length, fixed_leg=leg, most_boxes=most_boxes)
        if example := answer.counterexample:
            [table] = cusp_table(example.manipulator, length, fixed_leg=leg, digits=15)
            confirmed += 1
            if table.count == answer.count or table.count != example.found.cusps:
                wrong += 1
                print(f"no counter-example: {answer.to_json()}")
        for sample in range(20 if answer.proved else 0):
            corner, inside = (-1000, 1000), range(-999, 1000)
            parts = [Fraction(rng.choice(corner if sample % 2 else inside), 1000) for _ in LENGTHS]
            lengths = {
                g: getattr(manipulator, g) + (answer.proved or 0) * part
                for g, part in zip(LENGTHS, parts, strict=True)
            }
            other = Manipulator(**{**manipulator.to_dict(), **lengths})
            [table] = cusp_table(other, length, fixed_leg=leg, digits=15)
            done += 1
            if table.count != answer.count:
                wrong += 1
                print(f"WRONG: {answer.to_json()} at {other}: {table.count}")
        if done >= samples:
            break
    print(f"{done} counts in proved boxes, {confirmed} counter-examples: {wrong} wrong")
    return wrong


def censuses(number: int, seed: int) -> int:
    """Compare censuses of a tolerance with exact ones at corners; return how many differ."""
    rng, wrong, known, every = random.Random(seed), 0, 0, 0
    for manipulator, length, leg in islice(questions(seed), number):
        tolerance = Fraction(rng.choice(("0.0001", "0.001", "0.003")))
        span: dict[str, Any] = {"fixed_leg": leg, "start": length, "stop": length + 10, "digits": 15}
        table = tolerance_census(manipulator, tolerance, **span)
        known, every = known + sum(x is not None for x in table.spans), every + len(table.spans)
        for _ in range(3):
            moved = {g: getattr(manipulator, g) + tolerance * rng.choice((-1, 1)) for g in LENGTHS}
            found = census(Manipulator(**{**manipulator.to_dict(), **moved}), **span)
            ends = [length, *(Fraction(one.length) for one in found.transitions), length + 10]
            for piece in table.pieces:
                low, high = piece.span.start, piece.span.stop or length + 10
                counts = {
                    count
                    for count, (a, b) in zip(found.counts, pairwise(ends), strict=True)
                    if a < high and b > low
                }
                if piece.least is not None and not piece.least <= min(counts) <= max(counts) <= piece.most:
                    wrong += 1
                    print(f"WRONG: {table.to_json()} at {moved}: {counts} in {piece}")
    print(f"{number} censuses of a tolerance: {known} of {every} transitions bounded, {wrong} wrong")
    return wrong


def main() -> int:
    """Print what is asked for."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--random", type=int, default=0, metavar="N", help="so many random questions")
    parser.add_argument("--samples", type=int, default=0, metavar="N", help="so many exact counts")
    parser.add_argument("--censuses", type=int, default=0, metavar="N", help="so many of a tolerance")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--boxes", type=int, default=20_000, help="boxes of a margin (default: %(default)s)")
    options = parser.parse_args()
    if options.random:
        shares(options.random, options.seed, options.boxes)
    if options.samples:
        return min(soundness(options.samples, options.seed, options.boxes), 1)
    if options.censuses:
        return min(censuses(options.censuses, options.seed), 1)
    if not options.random:
        examples()
    return 0


if __name__ == "__main__":
    sys.exit(main())
