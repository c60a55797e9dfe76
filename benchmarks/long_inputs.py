"""Cost against the digits of the inputs: does it grow as the coefficients do?

    python -m benchmarks.long_inputs [--digits 6 30 100] [--check]
    python -m benchmarks.long_inputs --unequal

A row gives processor seconds of one core; in brackets, the time for each bit of the eliminant's longest
coefficient, against the first row: 1 is what the growth of the coefficients alone demands. "products" is the
elimination in units of a reference computed in the same run, one product in FLINT of two polynomials of
degree 24 with such coefficients. With --unequal the other rows are censuses of manipulators some of whose
sides are a thousand million times as long as others. With --check the exit status is 1 if a wide margin is
passed: MOST_GROWTH or MOST_PRODUCTS.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import fmpz_poly

from rpr_solver import Eliminant, Manipulator, article_table, census, eliminate, solve_slice

Work = Callable[[Manipulator, Eliminant, Fraction], object]

SIDES = (15, 3, 10, 17, 16, 20)
"""A manipulator with sides near these, with as many further digits as are asked for."""
LONG = "1000000000"
UNEQUAL = {
    "a2x long": (LONG, "3.1", "10.7", "0.26", "0.31", "0.41"),
    "a3x long": ("0.17", LONG, "0.7", "0.26", "0.31", "0.41"),
    "a3y long": ("0.17", "0.7", LONG, "0.26", "0.31", "0.41"),
    "base long": (LONG, "1234567890", "987654321", "0.26", "0.31", "0.41"),
    "platform long": ("0.26", "0.31", "0.4", LONG, "1234567890", "987654321"),
    "d2, d3 long": ("0.17", "0.31", "0.4", "0.26", LONG, "1000000000.1"),
    "a2x, d1, d3 long": (LONG, "0.26", "0.31", "1000000000.1", "0.29", LONG),
    "a3x, d1, d2 long": ("0.17", LONG, "3.7", LONG, "1000000000.1", "0.26"),
}
"""Sides of a thousand million beside some below 1."""
MOST_GROWTH = 5.0
MOST_PRODUCTS = 3000
"""Three times what was measured."""
ARTICLE_DIGITS = 60


def manipulator(digits: int) -> Manipulator:
    """Sides of so many random digits."""
    draw = random.Random(digits)
    return Manipulator(*(f"{side}." + "".join(draw.choices("0123456789", k=digits - 2)) for side in SIDES))


def seconds(work: Callable[[], object], rounds: int = 1) -> float:
    """The least processor time of some rounds."""
    times = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def bits(eliminant: Eliminant) -> int:
    """The length of the longest coefficient."""
    return max(int(abs(c)).bit_length() for part in (eliminant.a, eliminant.b) for c in part.entries())


def product(length: int) -> float:
    """Seconds of the reference: two polynomials of degree 24 with coefficients of so many bits."""
    draw = random.Random(0)
    first, second = (fmpz_poly([draw.getrandbits(length) for _ in range(25)]) for _ in range(2))
    repeats = max(3, 2_000_000 // length)
    return seconds(lambda: [first * second for _ in range(repeats)], 3) / repeats


@dataclass(frozen=True)
class Row:
    """Bits of the longest coefficient, the elimination in products, and the seconds of each work."""

    bits: int
    products: float
    seconds: dict[str, float]


def measured(digits: int, works: Mapping[str, Work]) -> Row:
    """One row of the table."""
    m, length = manipulator(digits), Fraction("25." + "7" * (digits - 2))
    eliminant, rounds = eliminate(m), 3 if digits < 50 else 1
    size = bits(eliminant)
    taken = {
        name: seconds(partial(work, m, eliminant, length), rounds)
        for name, work in works.items()
        if name != "article" or digits <= ARTICLE_DIGITS
    }
    return Row(size, taken["elimination"] / product(size), taken)


def unequal() -> None:
    """Print a row for each manipulator with sides of very unequal length."""
    rows = {"6 digits": manipulator(6), **{name: Manipulator(*sides) for name, sides in UNEQUAL.items()}}
    first = 0.0
    for name, m in rows.items():
        size = bits(eliminate(m))
        taken = seconds(partial(census, m, digits=15), 2)
        first = first or taken / size
        print(f"{name:18} {size:6} bits  census {taken:7.3f} s ({taken / size / first:4.2f})", flush=True)


def main() -> None:
    """Print a row for each number of digits."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--digits", type=int, nargs="+", default=[6, 15, 30, 60, 100])
    parser.add_argument("--check", action="store_true", help="fail where the cost grows too fast")
    parser.add_argument("--unequal", action="store_true", help="sides of very unequal length")
    args = parser.parse_args()
    if args.unequal:
        unequal()
        return
    works: dict[str, Work] = {
        "elimination": lambda m, _e, _x: eliminate(m).a,
        "slice": lambda _m, e, x: solve_slice(e, x, 15),
        "census": lambda m, _e, _x: census(m, digits=15),
        "article": lambda m, _e, x: article_table(m, x, digits=15),
    }
    print(f"{'digits':>6} {'bits':>7} {'products':>9}", *(f"{name:>18}" for name in works))
    first: dict[str, float] = {}
    ok = True
    for digits in args.digits:
        row = measured(digits, works)
        ok &= row.products < MOST_PRODUCTS
        cells = []
        for name, taken in row.seconds.items():
            growth = taken / row.bits / first.setdefault(name, taken / row.bits)
            ok &= growth < MOST_GROWTH
            cells.append(f"{taken:9.3f} s ({growth:4.2f})")
        print(f"{digits:6} {row.bits:7} {row.products:9.0f}", *cells, flush=True)
    if args.check and not ok:
        sys.exit("the cost grows faster than the margins allow")


if __name__ == "__main__":
    main()
