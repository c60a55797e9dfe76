"""The long run of singular curves: slices of all degenerate families, without a refusal.

    python -m tests.rpr_solver.singular.long_run [--slices 1000] [--first 0] [--seed 1]

Slice n is the same in every run with the same seed, so that a run may be done in parts (``--first``) and a
failure be repeated alone. A slice is of a random manipulator of a degenerate family, of any leg, at a random
length, or one that is a side, a height, or the printed length of a transition. Its curves, regions and
aspects must come. By floats alone, which share nothing with the solver, are counted the poses at the point of
each region and at random joint vectors, and the aspects on a grid; where floats do not decide, that is said.
Prints every failure as it is found, then the numbers, and exits with status 1 if there was a failure.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice, pairwise
from math import hypot
from random import Random

from rpr_solver import Manipulator, SingularCurves, SolverError, census, eliminate, trace_slice
from tests.support.degenerate import draws, special_lengths
from tests.support.oracle import FloatManipulator

_GRIDS = (150, 400, 1200, 3000)
_VECTORS = 12


@dataclass(frozen=True)
class Case:
    """A slice to be drawn."""

    number: int
    family: str
    manipulator: Manipulator
    leg: int
    length: Fraction
    kind: str

    def __str__(self) -> str:
        geometry = self.manipulator.to_json()
        sides = " ".join(str(geometry[name]) for name in geometry)
        return f"{self.number} ({self.family}): {sides}, L{self.leg} = {self.length} ({self.kind})"


def case(number: int, seed: int) -> Case:
    """Case n of a seed."""
    rng = Random(f"{seed} {number}")
    family, manipulator = next(islice(draws(rng), number % 13, None))
    leg = rng.choice((1, 2, 3))
    length, kind = _length(rng, manipulator, leg)
    return Case(number, family, manipulator, leg, length, kind)


def _length(rng: Random, m: Manipulator, leg: int) -> tuple[Fraction, str]:
    kind = rng.choice(("random", "special", "special", "beside special", "transition", "extreme"))
    special = special_lengths(m)
    if kind == "transition":
        digits = rng.randint(15, 100)
        transitions = census(m, fixed_leg=leg, digits=digits).transitions
        if transitions:
            return Fraction(rng.choice(transitions).length), f"transition to {digits} digits"
    if kind == "special":
        return rng.choice(special), kind
    if kind == "beside special":
        part = 1 + rng.choice((1, -1)) * Fraction(1, 10 ** rng.randint(3, 30))
        return rng.choice(special) * part, kind
    if kind == "extreme":
        return special[-1] * Fraction(10) ** rng.choice((-6, -4, 2, 5)), kind
    return special[-1] * Fraction(rng.randint(1, 20000), 10000), "random"


def failures(case: Case, seen: Counter[str]) -> Iterator[str]:
    """What is wrong with a slice; counts in ``seen`` what was compared."""
    try:
        curves = trace_slice(eliminate(case.manipulator, case.leg), case.length)
        regions, aspects = curves.regions, curves.aspects
    except SolverError as error:
        yield f"{type(error).__name__}: {error}"
        return
    floats = FloatManipulator(case.manipulator, case.leg, float(case.length))
    for region in regions:
        found = floats.number_of_poses(*map(float, region.point))
        seen["regions" if found is not None else "regions left open"] += 1
        if found is not None and found != region.poses:
            yield f"{found} poses at {region.point}, not {region.poses}"
    yield from _vectors(case, curves, floats, seen)
    if not case.kind.startswith(("transition", "beside", "extreme")):  # too narrow for a grid
        if any(floats.aspects(size) == len(aspects) for size in _GRIDS):
            seen["aspects"] += 1
        elif len(aspects) < floats.aspects(_GRIDS[-1]) and floats.is_narrow(_GRIDS[-1]):
            seen["aspects left open"] += 1
        else:
            yield f"{len(aspects)} aspects, on grids {[floats.aspects(size) for size in _GRIDS]}"


def _vectors(
    case: Case, curves: SingularCurves, floats: FloatManipulator, seen: Counter[str]
) -> Iterator[str]:
    """Random joint vectors, in the region that holds them."""
    rng = Random(case.number)
    rings = [(region, ring) for region in curves.regions for ring in region.rings]
    points = [point for _, ring in rings for point in ring]
    if not points:
        return
    spans = [(min(p[k] for p in points), max(p[k] for p in points)) for k in (0, 1)]
    extent = max(high - low for low, high in spans)
    for _ in range(_VECTORS):
        x, y = (rng.uniform(low, high) for low, high in spans)
        if min(_distance(x, y, *edge) for _, ring in rings for edge in pairwise(ring)) < 0.01 * extent:
            continue
        holding = [
            region
            for region in curves.regions
            if region.bounded and sum(_inside(ring, x, y) for ring in region.rings) % 2
        ]
        found = floats.number_of_poses(x, y)
        if found is None or len(holding) > 1:
            seen["joint vectors left open"] += 1
            if len(holding) > 1:
                yield f"{x}, {y} lies in {len(holding)} regions"
            continue
        seen["joint vectors"] += 1
        expected = holding[0].poses if holding else 0
        if found != expected:
            yield f"{found} poses at {x}, {y}, in a region of {expected}"


def _distance(x: float, y: float, a: tuple[float, float], b: tuple[float, float]) -> float:
    """From a segment."""
    along = b[0] - a[0], b[1] - a[1]
    square = along[0] ** 2 + along[1] ** 2
    part = ((x - a[0]) * along[0] + (y - a[1]) * along[1]) / square if square else 0.0
    part = min(max(part, 0.0), 1.0)
    return hypot(a[0] + part * along[0] - x, a[1] + part * along[1] - y)


def _inside(ring: tuple[tuple[float, float], ...], x: float, y: float) -> bool:
    odd = False
    for (ax, ay), (bx, by) in pairwise(ring):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            odd = not odd
    return odd


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--slices", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="the number of the first slice")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    seen: Counter[str] = Counter()
    wrong, start = 0, time.process_time()
    for number in range(given.first, given.first + given.slices):
        now = case(number, given.seed)
        for failure in failures(now, seen):
            print(f"{now}: {failure}", flush=True)
            wrong += 1
    compared = ", ".join(f"{count} {what}" for what, count in sorted(seen.items()))
    seconds = time.process_time() - start
    print(f"{given.slices} slices, {wrong} failures; compared: {compared}; {seconds:.0f} s of processor time")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
