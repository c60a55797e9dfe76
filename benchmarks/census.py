"""The census of the first manipulator, and its smaller eliminant against FLINT's multivariate resultant.

python benchmarks/census.py
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from fractions import Fraction

from flint import fmpz_mpoly

from rpr_solver import EXAMPLES, Requirement, census, check, cusp_curves, eliminate, solve_slice
from rpr_solver.exact.biform import OMEGA
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_systems import EventSystems

MANIPULATOR = EXAMPLES["innocenti"]


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


def main() -> None:
    """Print the table."""
    form = argparse.RawDescriptionHelpFormatter
    argparse.ArgumentParser(description=__doc__, formatter_class=form).parse_args()
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
