"""Elimination and slices compared with the naive route.

    python benchmarks/solver.py

The naive route uses FLINT directly: one multivariate resultant in t, u, h and L1, reduced and divided; for a
slice, the same resultant at its L1, its factors, and `roots(tol)` of the factor of degree 24.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from fractions import Fraction
from functools import partial

from flint import acb_poly, arb, ctx, fmpz_mpoly

from rpr_solver import EXAMPLES, eliminate, solve_slice
from rpr_solver.exact.biform import OMEGA, BiForm, L, U
from rpr_solver.model.slice_map import SliceMap

REPEATS = 7
MANIPULATOR = EXAMPLES["innocenti"]
LENGTHS = [Fraction(n, 100) for n in (1498, 2700, 3400, 2810)]


def timed(function: Callable[[], object], repeats: int = REPEATS) -> float:
    """Returns the median wall time in milliseconds."""
    function()
    samples = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        samples.append(1000 * (time.perf_counter() - start))
    return statistics.median(samples)


def naive_elimination(slice_map: SliceMap) -> fmpz_mpoly:
    """Returns Res_t(J, E) over ℤ[ω], symbolic in L, divided by its known factors."""
    resultant = slice_map.singular.joined.resultant(slice_map.coalescence.joined, "t")
    f = slice_map.f
    closed = (L**2 + f.ax**2 - f.m**2) * (1 + U**2) - 2 * L * f.ax * (1 - U**2)
    return resultant % (OMEGA**2 - slice_map.radicand) / (U**2 * (U**2 + 1) ** 9 * closed)


def naive_slice(slice_map: SliceMap, length: Fraction) -> list[arb]:
    """Returns the real roots u of a slice: resultant at this L1, division, FLINT's roots to 90 digits."""
    j, e = (
        BiForm.of_rows(form.at(length), form.degree_u).joined
        for form in (slice_map.singular, slice_map.coalescence)
    )
    resultant = j.resultant(e, "t") % (OMEGA**2 - slice_map.radicand)
    closed = slice_map.f.closed(length)
    known = U**2 * (U**2 + 1) ** 9 * (closed[0] + closed[1] * U + closed[2] * U**2)
    q = resultant / known
    parts = [[0] * 25, [0] * 25]
    for (_, k, _, power), c in q.to_dict().items():
        parts[power][k] = c
    with ctx.workprec(400):
        omega = arb(slice_map.radicand).sqrt()
        balls = [arb(a) + omega * arb(b) for a, b in zip(*parts, strict=True)]
        roots = acb_poly(balls).roots(tol=arb(10) ** -90)
    return [r.real for r in roots if r.imag.contains(0)]


def main() -> None:
    """Print the table."""
    form = argparse.RawDescriptionHelpFormatter
    argparse.ArgumentParser(description=__doc__, formatter_class=form).parse_args()
    slice_map = SliceMap.of(MANIPULATOR)
    eliminant = eliminate(MANIPULATOR)
    ours, peer = timed(lambda: eliminate(MANIPULATOR)), timed(lambda: naive_elimination(slice_map), 3)
    print(f"{'first manipulator':<34}{'ours':>10}{'naive':>10}{'ratio':>9}")
    print(f"{'elimination, symbolic in L1 [ms]':<34}{ours:10.1f}{peer:10.1f}{peer / ours:9.1f}")
    for length in LENGTHS:
        ours = timed(partial(solve_slice, eliminant, length), 25)
        peer = timed(partial(naive_slice, slice_map, length * slice_map.scale))
        count = solve_slice(eliminant, length).count
        label = f"slice L1 = {float(length)}, {count} cusps [ms]"
        print(f"{label:<34}{ours:10.2f}{peer:10.2f}{peer / ours:9.1f}")


if __name__ == "__main__":
    main()
