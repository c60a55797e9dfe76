"""The long run of cusp curves: right beside all their ends, each cusp of a slice is on one curve.

    python -m tests.rpr_solver.curves.long_run [--machines 60] [--first 0] [--seed 1]

Machine n is the same in every run with the same seed, so that a run may be done in parts (``--first``).
Every third one is random, every third one of a degenerate family, and every third one beside such a family by
1e-2 to 1e-7; the curves of these are often cut where it is not proved which cusps continue. The curves get
their points at each printed end, and beside it by 1e-6 to 1e-14 of it. Each cusp of such a slice, which is
solved anew, must be on exactly one curve, and between the ends of that curve. Prints every failure as it is
found, then the numbers, and exits with status 1 if there was a failure.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from itertools import islice
from random import Random

from rpr_solver import CuspCurves, Manipulator, SolverError, cusp_curves, eliminate, solve_slice
from rpr_solver.slices.eliminant import Eliminant
from tests.rpr_solver.long_run import manipulator
from tests.support.degenerate import MAKERS, beside, draws

DIGITS = 15
EXPONENTS = (6, 8, 10, 12, 13, 14)


def machine(number: int, seed: int) -> tuple[str, Manipulator, int]:
    """Machine n of a seed: what it is, and its fixed leg."""
    rng = Random(f"{seed} {number}")
    leg = rng.choice((1, 2, 3))
    if number % 3 == 0:
        return "random", manipulator(rng), leg
    family = list(MAKERS)[number // 3 % len(MAKERS)]
    if number % 3 == 1:
        return family, next(islice(draws(rng), list(MAKERS).index(family), None))[1], leg
    exponent = rng.randint(2, 7)
    return f"1e-{exponent} beside {family}", beside(rng, family, exponent), leg


def ends_of(curves: CuspCurves) -> set[Fraction]:
    """The printed lengths at which curves begin and end, but 0 and infinity."""
    texts = {end.length for curve in curves.curves for end in (curve.start, curve.stop)}
    return {Fraction(text) for text in texts if text is not None} - {Fraction(0)}


def lengths_beside(ends: set[Fraction]) -> list[Fraction]:
    """Each end, and lengths on both sides of it."""
    shares = [Fraction(sign, 10**k) for k in EXPONENTS for sign in (-1, 1)]
    return sorted({end * (1 + share) for end in ends for share in (Fraction(0), *shares)})


def failures(curves: CuspCurves, eliminant: Eliminant, lengths: list[Fraction]) -> Iterator[str]:
    """Slices of which a cusp is on no curve, on two, or beyond the ends of its own."""
    try:
        sampled = curves.sampled(lengths, eliminant=eliminant)
    except SolverError as error:
        if len(lengths) > 1:  # which one it is
            for length in lengths:
                yield from failures(curves, eliminant, [length])
        else:
            yield f"{lengths[0]}: {error}"
        return
    rounding = Fraction(10) ** (1 - DIGITS) / 2
    for length in lengths:
        numbers = []
        for curve in sampled.curves:
            for point in curve.points:
                if point.length == length:
                    numbers.append(point.cusp)
                    start, stop = Fraction(curve.start.length or 0), curve.stop.length
                    if length < start * (1 - rounding) or (
                        stop is not None and length > Fraction(stop) * (1 + rounding)
                    ):
                        yield f"{length}: cusp {point.cusp} is beyond an end of {curve.name}"
        count = solve_slice(eliminant, length, DIGITS).count
        if sorted(numbers) != list(range(1, count + 1)):
            yield f"{length}: of {count} cusps those with the numbers {sorted(numbers)} are on curves"


def main() -> int:
    """Runs all machines."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--machines", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    done = Counter[str]()
    for number in range(arguments.first, arguments.first + arguments.machines):
        kind, m, leg = machine(number, arguments.seed)
        before = time.process_time()
        try:
            curves = cusp_curves(m, fixed_leg=leg, digits=DIGITS)
        except SolverError as error:
            print(f"{number} ({kind}) {m!r} leg {leg}: no curves: {error}", flush=True)
            done["without curves"] += 1
            continue
        lengths = lengths_beside(ends_of(curves))
        cut = sum(end.kind.value == "undecided" for c in curves.curves for end in (c.start, c.stop))
        wrong = list(failures(curves, eliminate(m, leg), lengths))
        done += Counter(machines=1, curves=len(curves.curves), cut=cut, slices=len(lengths), wrong=len(wrong))
        for words in wrong:
            print(f"WRONG {number} ({kind}) {m!r} leg {leg} at {words}", flush=True)
        spent = time.process_time() - before
        print(
            f"{number} ({kind}): {len(curves.curves)} curves, {len(lengths)} slices, {spent:.0f} s",
            flush=True,
        )
    print(", ".join(f"{name}: {count}" for name, count in done.items()))
    return 1 if done["wrong"] else 0


if __name__ == "__main__":
    sys.exit(main())
