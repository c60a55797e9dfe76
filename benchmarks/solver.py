"""Elimination and slices against the naive route, in one run.

    python benchmarks/solver.py

The peer is the straightforward use of FLINT: one multivariate resultant in t, u, h and L1, reduced and
divided; for a slice, the same resultant at its L1, its factors, and `roots(tol)` of the degree-24 factor.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from fractions import Fraction
from functools import partial

from flint import acb_poly, arb, ctx, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from rpr_solver import EXAMPLES, eliminate, solve_slice
from rpr_solver.model.slice_map import BiForm, SliceMap

REPEATS = 7
MANIPULATOR = EXAMPLES["innocenti"]
LENGTHS = [Fraction(n, 100) for n in (1498, 2700, 3400, 2810)]
RING = fmpz_mpoly_ctx.get(("t", "u", "w", "L"), "lex")


def timed(function: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median wall time in milliseconds."""
    function()
    samples = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        samples.append(1000 * (time.perf_counter() - start))
    return statistics.median(samples)


def polynomial(form: BiForm) -> fmpz_mpoly:
    """A form in t, u, w = omega and L."""
    return RING.from_dict(
        {
            (i, k, w, power): c
            for i, row in enumerate(form.coefficients)
            for power, pair in enumerate(row)
            for w, part in enumerate(pair)
            for k, c in enumerate(part.coeffs())
            if c
        }
    )


def naive_elimination(slice_map: SliceMap) -> fmpz_mpoly:
    """Res_t(J, E) over Z[omega], symbolic in L, divided by its known factors."""
    _, u, w, length = RING.gens()
    resultant = polynomial(slice_map.singular).resultant(polynomial(slice_map.coalescence), "t")
    reduced = divmod(resultant, w**2 - slice_map.radicand)[1]
    f = slice_map.f
    closed = (length**2 + f.ax**2 - f.m**2) * (1 + u**2) - 2 * length * f.ax * (1 - u**2)
    return reduced / (u**2 * (u**2 + 1) ** 9 * closed)


def naive_slice(slice_map: SliceMap, length: Fraction) -> list[arb]:
    """The real roots u of one slice: resultant at this L1, division, FLINT's roots to 90 digits."""
    j, e = ([(a, b) for a, b in form.at(length)] for form in (slice_map.singular, slice_map.coalescence))

    def joined(rows: list[tuple[fmpz_poly, fmpz_poly]]) -> fmpz_mpoly:
        return RING.from_dict(
            {
                (i, k, w, 0): c
                for i, row in enumerate(rows)
                for w, part in enumerate(row)
                for k, c in enumerate(part.coeffs())
                if c
            }
        )

    _, u, w, _ = RING.gens()
    resultant = divmod(joined(j).resultant(joined(e), "t"), w**2 - slice_map.radicand)[1]
    closed = slice_map.closed_leg(length)
    known = u**2 * (u**2 + 1) ** 9 * (int(closed[0]) + int(closed[1]) * u + int(closed[2]) * u**2)
    q = resultant / known
    parts = [[0] * 25, [0] * 25]
    for (_, k, power, _), c in q.to_dict().items():
        parts[power][k] = c
    with ctx.workprec(400):
        omega = arb(slice_map.radicand).sqrt()
        balls = [arb(a) + omega * arb(b) for a, b in zip(*parts, strict=True)]
        roots = acb_poly(balls).roots(tol=arb(10) ** -90)
    return [r.real for r in roots if r.imag.contains(0)]


def main() -> None:
    """Print the table."""
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
