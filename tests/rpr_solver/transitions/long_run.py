"""Censuses beside special shapes: how long each takes, at every distance and for every leg.

    python -m tests.rpr_solver.transitions.long_run --machines 600 --seed 1

A line for each census that takes more than 3 seconds of processor time, or is refused; then the number of
them, and the longest time at each distance.
"""

import argparse
import time
from collections import defaultdict
from random import Random

from rpr_solver import SolverError, census
from tests.support.degenerate import MAKERS, beside

_EXPONENTS = (1, 3, 6, 9, 16, 25, 40)
_LONG = 3.0


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--machines", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    draw, names, times = Random(args.seed), list(MAKERS), defaultdict[int, list[float]](list)
    for number in range(args.machines):
        name, exponent, leg = names[number % len(names)], draw.choice(_EXPONENTS), draw.choice((1, 2, 3))
        manipulator = beside(draw, name, exponent)
        start, refusal = time.process_time(), ""
        try:
            census(manipulator, fixed_leg=leg)
        except SolverError as error:
            refusal = str(error)
        took = time.process_time() - start
        times[exponent].append(took)
        if refusal or took > _LONG:
            print(f"{took:.2f} s", name, exponent, leg, manipulator.to_json(), refusal, flush=True)
    for exponent, found in sorted(times.items()):
        long = sum(took > _LONG for took in found)
        print(f"1e-{exponent}: {len(found)} censuses, the longest {max(found):.2f} s, {long} long")


if __name__ == "__main__":
    main()
