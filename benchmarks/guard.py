"""Has anything become slow? Processor time of the main work, in units of a reference of the same run.

    python -m benchmarks.guard

The reference is one product in FLINT of two polynomials of degree 24 with coefficients of 1,000 bits. The
exit status is 1 if some work takes more than MARGIN times as many of these products as when it was measured.
So neither the speed of the machine nor what else it does matters much. `benchmarks/solver.py` and the others
measure more exactly, and beside peers.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from benchmarks.long_inputs import product, seconds
from rpr_solver import (
    EXAMPLES,
    Manipulator,
    census,
    cusp_curves,
    cusp_loop,
    eliminate,
    poses,
    singular_curves,
    solve_slice,
    solve_slices,
)

MARGIN = 4
REFERENCE_BITS = 1000
SCAN = [Fraction(k, 4) for k in range(1, 201)]


@dataclass(frozen=True)
class Work:
    """Some work in equal parts, and the products that one part took when this was written."""

    name: str
    products: int
    run: Callable[[], object]
    parts: int = 1
    rounds: int = 3


def works() -> list[Work]:
    """What is guarded."""
    m = EXAMPLES["innocenti"]
    of_long_sides = Manipulator(*(f"{side}.{'1234567890' * 5}" for side in (15, 3, 10, 17, 16, 20)))
    eliminant = eliminate(m)
    return [
        Work("elimination", 450, lambda: eliminate(m).a, rounds=9),
        Work("elimination, sides of 52 digits", 8400, lambda: eliminate(of_long_sides).a),
        Work("a slice", 60, lambda: solve_slice(eliminant, 27, 90), rounds=9),
        Work("a slice of a scan", 20, lambda: list(solve_slices(eliminant, SCAN, 90)), parts=len(SCAN)),
        Work("poses", 22, lambda: poses(m, 27, 20, 20), rounds=9),
        Work("census", 6600, lambda: census(m, digits=30)),
        Work("census and curves", 35000, lambda: cusp_curves(m, digits=15), rounds=1),
        Work("singular curves", 1470, lambda: singular_curves(m, 27)),
        Work("a loop", 1650, lambda: cusp_loop(m, 27, cusp=1)),
    ]


def main() -> int:
    """Print a row for each work, and tell whether one takes too long."""
    unit = product(REFERENCE_BITS)
    is_slow = False
    print(f"{'':32} {'products':>9} {'of those measured':>18}")
    for work in works():
        taken = seconds(work.run, work.rounds) / work.parts / unit
        is_slow |= taken > MARGIN * work.products
        print(f"{work.name:32} {taken:9.0f} {taken / work.products:18.2f}", flush=True)
    if is_slow:
        print(f"Something takes more than {MARGIN} times as long as it did.", file=sys.stderr)
    return int(is_slow)


if __name__ == "__main__":
    sys.exit(main())
