"""The singular curves of slices: CPU time of the curves alone, and with their regions and aspects.

python benchmarks/singular.py            tolerance 0.001 of the picture
python benchmarks/singular.py --slices 40 --tolerance 0.0001
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from fractions import Fraction
from functools import partial

from rpr_solver import EXAMPLES, SingularCurves, eliminate, solve_slice, trace_slice

SLICES = {"innocenti": ("14.98", "27", "28.1"), "zein-flat": ("10", "34"), "fourteen-cusps": ("5.96",)}


def cpu(function: Callable[[], object]) -> float:
    """Returns the CPU time in milliseconds, the least of three calls after a first one."""
    function()
    times = []
    for _ in range(3):
        start = time.process_time()
        function()
        times.append(1e3 * (time.process_time() - start))
    return min(times)


def everything(curves: SingularCurves) -> None:
    """Computes what is computed only when it is asked for."""
    assert curves.regions
    assert curves.aspects


def main() -> None:
    """Print the table."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--tolerance", default="0.001", help="relative to the picture (default: 0.001)")
    parser.add_argument(
        "--slices", type=int, default=20, help="slices of the first manipulator (default: 20)"
    )
    args = parser.parse_args()
    print(f"{'slice':24}{'cusps':>8}{'samples':>9}{'table':>9}{'curves':>9}{'all':>9}   [ms of CPU]")
    for name, lengths in SLICES.items():
        eliminant = eliminate(EXAMPLES[name])
        for length in lengths:
            curves = trace_slice(eliminant, length, tolerance=args.tolerance)
            samples = sum(len(strand.first) for strand in curves.strands)
            table = cpu(partial(solve_slice, eliminant, length, 15))
            trace = partial(trace_slice, eliminant, length, tolerance=args.tolerance)
            alone, whole = cpu(trace), cpu(lambda trace=trace: everything(trace()))  # type: ignore[misc]
            row = f"{name + ' ' + length:24}{curves.table.count:>8}{samples:>9}"
            print(f"{row}{table:>9.1f}{alone:>9.1f}{whole:>9.1f}")
    eliminant = eliminate(EXAMPLES["innocenti"])
    scan = [Fraction(40 * (k + 1), args.slices + 1) for k in range(args.slices)]
    times = [cpu(partial(trace_slice, eliminant, x, tolerance=args.tolerance)) for x in scan]
    median, greatest = statistics.median(times), max(times)
    print(f"{args.slices} slices of innocenti, curves: median {median:.1f}, greatest {greatest:.1f}")


if __name__ == "__main__":
    main()
