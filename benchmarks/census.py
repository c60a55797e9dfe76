"""The census of the first manipulator, and its smaller eliminant against FLINT's multivariate resultant.

    python -m benchmarks.census [--random 200]

With `--random`, the processor time of the censuses of so many random manipulators, whose sides have four
digits, each from nothing, at 15 digits; and the time that PARI takes for one resultant, if it is installed:
their quotient is about the same on every machine.
"""

from __future__ import annotations

import argparse
import random
import shutil
import statistics
import time
from collections.abc import Callable
from fractions import Fraction

from flint import fmpz_mpoly

from benchmarks.peers import symbolic_resultant
from rpr_solver import (
    EXAMPLES,
    InputError,
    Manipulator,
    Requirement,
    census,
    check,
    cusp_curves,
    eliminate,
    solve_slice,
)
from rpr_solver.exact.biform import OMEGA
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_systems import EventSystems

MANIPULATOR = EXAMPLES["innocenti"]
PARI_ROUNDS = 5


def timed(function: Callable[[], object], repeats: int = 3) -> float:
    """Returns the median wall time in seconds, after a warm-up call."""
    function()
    samples = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        samples.append(time.perf_counter() - start)
    return statistics.median(samples)


def naive_critical(systems: EventSystems) -> fmpz_mpoly:
    """Returns the resultant for lips and beaks in a single elimination."""
    first, second = systems.critical.first.joined, systems.critical.second.joined
    return first.resultant(second, "t") % (OMEGA**2 - systems.slice_map.radicand)


def random_manipulators(count: int) -> list[Manipulator]:
    """As many as are asked for, the same in each run."""
    rng, found = random.Random(24), list[Manipulator]()
    while len(found) < count:
        a2x, a3x, a3y, d1, d2, d3 = (f"{rng.randint(1000, 4000) / 100:.2f}" for _ in range(6))
        sign = rng.choice(("", "-"))
        try:
            found.append(Manipulator(a2x, sign + a3x, a3y, d1, d2, d3, rng.choice(("ccw", "cw"))))
        except InputError:  # these sides are those of no triangle
            continue
    return found


def of_random_ones(count: int) -> None:
    """Print the processor time of random censuses."""
    samples = []
    for manipulator in random_manipulators(count):
        start = time.process_time()
        census(manipulator, digits=15)
        samples.append(time.process_time() - start)
    low, high = min(samples), max(samples)
    median = statistics.median(samples)
    print(f"{count} random censuses: median {median:.3f} s, {low:.3f} to {high:.3f} s")
    if (program := shutil.which("gp")) is not None:
        of_pari = min(symbolic_resultant(program) for _ in range(PARI_ROUNDS))
        print(f"PARI/GP, the resultant of J and E in benchmarks.peers: {of_pari:.3f} s", end="")
        print(f"; a census takes {median / of_pari:.1f} times as long")


def main() -> None:
    """Print the table."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--random", type=int, help="measure the censuses of so many random manipulators")
    if (count := parser.parse_args().random) is not None:
        of_random_ones(count)
        return
    slice_map = SliceMap.of(MANIPULATOR)
    systems = EventSystems.of(slice_map)
    both = timed(lambda: EventSystems.of(slice_map))
    naive = timed(lambda: naive_critical(systems), 1)
    print(f"both eliminants, for swallowtails and for lips and beaks: {both:.2f} s")
    print(f"FLINT's resultant, for lips and beaks alone: {naive:.2f} s, {naive / both:.1f} × that")
    whole = timed(lambda: census(MANIPULATOR, digits=30))
    print(f"census of the first manipulator at 30 digits, all L1: {whole:.2f} s")
    curves = cusp_curves(MANIPULATOR, digits=30)
    followed = timed(lambda: cusp_curves(MANIPULATOR, digits=30))
    print(f"all cusp curves, including the census: {followed:.2f} s")
    lengths = [Fraction(12) + Fraction(i, 10) for i in range(200)]
    eliminant = eliminate(MANIPULATOR)
    alone = timed(lambda: [solve_slice(eliminant, x, 30) for x in lengths], 1)
    named = timed(lambda: curves.sampled(lengths, eliminant=eliminant), 1)
    print(f"200 slices of all curves: {named:.2f} s, {named / alone:.1f} × the slices alone, without names")
    limits = {2: (None, Fraction(40)), 3: (Fraction(5), None)}
    requirement = Requirement(start=Fraction(26), stop=Fraction(29), max_cusps=4, limits=limits)
    limited = timed(lambda: check(MANIPULATOR, requirement), 1)
    print(f"check with joint limits on both other legs: {limited:.2f} s")


if __name__ == "__main__":
    main()
