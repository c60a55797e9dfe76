"""Elimination and slices compared with the naive route, and slices in a chunk with slices alone.

    python benchmarks/solver.py

In a chunk means 501 slices by `solve_slices`; alone means each by the polynomials of its slice, the way of
the reference in `slices/reference.py`, in turns with the chunk. A row holds the slices with so many cusps.

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

from rpr_solver import EXAMPLES, Eliminant, cusp_table, eliminate, solve_slice
from rpr_solver.exact.biform import OMEGA, L, U
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.cusp_table import SliceSolver
from rpr_solver.slices.fast.scan import BLOCK
from rpr_solver.slices.reference import ReferenceSlice

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
    j, e = (form.sliced(length).joined for form in (slice_map.singular, slice_map.coalescence))
    resultant = j.resultant(e, "t") % (OMEGA**2 - slice_map.radicand)
    closed = slice_map.f.closed(length).a
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


def in_chunks(eliminant: Eliminant, digits: int) -> None:
    """Print what a slice costs in a chunk and alone, by the number of its cusps."""
    lengths = [Fraction(k, 10) for k in range(1, 502)]
    solver = SliceSolver(eliminant, lengths, digits)
    groups: dict[int, list[tuple[float, float]]] = {}
    shared = 0.0
    for place, length in enumerate(lengths):
        start = time.process_time()
        count = solver.table(place).count
        mine = 1000 * (time.process_time() - start)
        if place % BLOCK == 0:  # this slice also paid for the whole block, and a second time it does not
            start = time.process_time()
            solver.table(place)
            again = 1000 * (time.process_time() - start)
            shared, mine = (mine - again) / BLOCK, again
        mine += shared
        if place % 5 == 0:
            start = time.process_time()
            ReferenceSlice(eliminant, length, digits).solve()
            groups.setdefault(count, []).append((mine, 1000 * (time.process_time() - start)))
    for count, times in [*sorted(groups.items()), (-1, [pair for x in groups.values() for pair in x])]:
        ours, peer = (statistics.mean(x) for x in zip(*times, strict=True))
        label = f"{digits} digits, {'all' if count < 0 else count} cusps, {len(times)} slices [ms]"
        print(f"{label:<42}{ours:10.3f}{peer:10.3f}{peer / ours:9.1f}")


def in_a_loop(digits: int, count: int = 300) -> None:
    """Print what a loop of ``cusp_table`` with one length each costs, beside one call with the list."""
    lengths = [Fraction(n, 10) for n in range(30, 30 + count)]
    cusp_table(MANIPULATOR, lengths[:4], digits=15)
    begin = time.process_time()
    cusp_table(MANIPULATOR, lengths, digits=digits)
    middle = time.process_time()
    for length in lengths:
        cusp_table(MANIPULATOR, length, digits=digits)
    listed, looped = (1000 * x / count for x in (middle - begin, time.process_time() - middle))
    print(f"{f'{digits} digits, {count} slices [ms]':<42}{looped:10.3f}{listed:10.3f}{looped / listed:9.1f}")


def main() -> None:
    """Print the table."""
    form = argparse.RawDescriptionHelpFormatter
    argparse.ArgumentParser(description=__doc__, formatter_class=form).parse_args()
    slice_map = SliceMap.of(MANIPULATOR)
    eliminant = eliminate(MANIPULATOR)
    ours, peer = timed(lambda: eliminate(MANIPULATOR).a), timed(lambda: naive_elimination(slice_map), 3)
    print(f"{'first manipulator':<34}{'ours':>10}{'naive':>10}{'ratio':>9}")
    print(f"{'elimination, symbolic in L1 [ms]':<34}{ours:10.1f}{peer:10.1f}{peer / ours:9.1f}")
    for length in LENGTHS:
        ours = timed(partial(solve_slice, eliminant, length), 25)
        peer = timed(partial(naive_slice, slice_map, length * slice_map.scale))
        count = solve_slice(eliminant, length).count
        label = f"slice L1 = {float(length)}, {count} cusps [ms]"
        print(f"{label:<34}{ours:10.2f}{peer:10.2f}{peer / ours:9.1f}")
    print(f"\n{'slices in a chunk, alone':<42}{'chunk':>10}{'alone':>10}{'ratio':>9}")
    for digits in (15, 90, 1000):
        in_chunks(eliminant, digits)
    print(f"\n{'a loop of single lengths, a list':<42}{'loop':>10}{'list':>10}{'ratio':>9}")
    for digits in (15, 90):
        in_a_loop(digits)


if __name__ == "__main__":
    main()
