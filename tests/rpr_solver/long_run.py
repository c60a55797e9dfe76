"""The long run: random slices against independent witnesses, and slices beside transitions.

    python -m tests.rpr_solver.long_run [--cases 2000] [--transitions 200] [--censuses 20] [--lengths 1000]

Every case is a random manipulator, fixed leg and length. Its table must be the same, whether the eliminant
is computed at this length alone or for all lengths, and agree with that of its mirror image at another scale.
Every cusp that floating-point Newton finds must be in it (Newton may lose cusps, so the converse is not
required). Beside a transition, at a relative distance of 1e-30, the count must be that of the census on that
side. Censuses of 20 manipulators, every degenerate family among them, must agree with slices at 1,000 random
lengths and in the middle of every interval, and cusp curves must name every cusp of some of these slices.
Prints all failures and then exits with status 1.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

from rpr_solver import (
    InputError,
    Manipulator,
    SliceTable,
    SolverError,
    census,
    cusp_curves,
    eliminate,
    solve_slice,
)
from rpr_solver.contract import FEW_SLICES
from tests.support.families import FAMILIES, family
from tests.support.newton import count_cusps, distance

NAMES = ("a2x", "a3x", "a3y", "d1", "d2", "d3")


def manipulator(rng: random.Random) -> Manipulator:
    """A random geometry whose legs share no joint; small integers bring coincidences."""
    while True:
        size, places = rng.choice([(4, 1), (12, 1), (30, 10), (30, 1000)])
        low = [-size, -size, -size, 0, 0, 0]
        values = [Fraction(rng.randint(x * places, size * places), places) for x in low]
        try:
            drawn = Manipulator(*values, orientation=rng.choice(["ccw", "cw"]))
        except InputError:
            continue
        if not drawn.geometry.shared_joints:
            return drawn


def transformed(m: Manipulator, rng: random.Random) -> tuple[Manipulator, Fraction]:
    """The mirror image at another scale, and the scale."""
    factor = Fraction(rng.randint(1, 99), rng.randint(1, 99))
    scaled = replace(m, **{name: getattr(m, name) * factor for name in NAMES})
    side = "cw" if m.orientation == "ccw" else "ccw"
    return replace(scaled, a3y=-scaled.a3y, orientation=side), factor


def kinds(table: SliceTable) -> Counter[str]:
    return Counter(point["kind"] for point in table.degenerate_points)


def random_case(rng: random.Random) -> str | None:
    """The failure of one random slice, or None."""
    m, leg = manipulator(rng), rng.choice([1, 2, 3])
    length = Fraction(rng.randint(1, 6000), 100)
    table = solve_slice(eliminate(m, leg), length, 20)
    if solve_slice(eliminate(m, leg).expect(FEW_SLICES + 1), length, 20).to_json() != table.to_json():
        return f"{m} leg {leg} at {length}: another table if the eliminant is known for all lengths"
    other, factor = transformed(m, rng)
    image = solve_slice(eliminate(other, leg), length * factor, 20)
    if (table.count, kinds(table)) != (image.count, kinds(image)):
        return f"{m} leg {leg} at {length}: {table.count} cusps, its image has {image.count}"
    if leg == 1 and rng.random() < 0.3:
        ours = [(math.radians(float(c.alpha_deg)), math.radians(float(c.theta1_deg))) for c in table.cusps]
        for point in count_cusps(m, float(length), starts=8):
            if not any(distance(point, x) < 1e-4 for x in ours):
                return f"{m} at {length}: Newton finds a cusp at {point}, which is not in the table"
    return None


def beside_transitions(rng: random.Random, wanted: int) -> list[str]:
    """Failures beside transitions of random manipulators."""
    wrong, done = [], 0
    while done < wanted:
        m, leg = manipulator(rng), rng.choice([1, 2, 3])
        try:
            document = census(m, fixed_leg=leg, digits=50)
        except SolverError as error:
            print(f"no census: {error}")
            continue
        eliminant = eliminate(m, leg)
        for transition in document.transitions:
            at = Fraction(transition.length)
            for offset, count in (
                (-Fraction(1, 10**30), transition.count_before),
                (Fraction(1, 10**30), transition.count_after),
            ):
                found = solve_slice(eliminant, at * (1 + offset), 15).count
                done += 1
                if found != count:
                    wrong.append(f"{m} leg {leg} beside {transition.length}: {found} cusps, not {count}")
        print(f"{done} slices beside transitions, {len(wrong)} wrong", flush=True)
    return wrong


def censuses_against_slices(rng: random.Random, manipulators: int, lengths: int) -> list[str]:
    """Disagreements between a census and slices."""
    wrong = []
    names = list(FAMILIES)[:manipulators]
    chosen = [family(name) for name in names]
    chosen += [manipulator(rng) for _ in range(manipulators - len(chosen))]
    for n, m in enumerate(chosen, 1):
        leg = rng.choice([1, 2, 3])
        try:
            document = census(m, fixed_leg=leg, digits=30)
        except SolverError as error:
            print(f"no census: {error}")
            continue
        eliminant = eliminate(m, leg)
        ends = [Fraction(0), *(Fraction(t.length) for t in document.transitions)]
        top = ends[-1] * 2 + 1
        places = [(a + b) / 2 for a, b in pairwise([*ends, top])]
        places += [top * Fraction(rng.randint(1, 10**9), 10**9) for _ in range(lengths)]
        for length in places:
            expected = document.counts[sum(end < length for end in ends[1:])]
            if (found := solve_slice(eliminant, length, 15).count) != expected:
                wrong.append(f"{m} leg {leg} at {length}: census {expected}, slice {found}")
        wrong += curves_against_slices(m, leg, places[:: max(1, len(places) // 50)])
        print(f"{n} censuses against {len(places)} slices each, {len(wrong)} wrong", flush=True)
    return wrong


def curves_against_slices(m: Manipulator, leg: int, lengths: list[Fraction]) -> list[str]:
    """Slices passed by another number of cusp curves than they have cusps."""
    try:
        curves = cusp_curves(m, fixed_leg=leg, digits=30).sampled(lengths)
    except SolverError as error:
        return [f"{m} leg {leg}: no curves: {error}"]
    eliminant, wrong = eliminate(m, leg), []
    for length in lengths:
        named = [p.cusp for curve in curves.curves for p in curve.points if p.length == length]
        between = sum(
            Fraction(c.start.length or 0) < length
            and (c.stop.length is None or length < Fraction(c.stop.length))
            for c in curves.curves
        )
        count = solve_slice(eliminant, length, 15).count
        if sorted(named) != list(range(1, count + 1)) or between != count:
            wrong.append(f"{m} leg {leg} at {length}: {count} cusps, named {named}, between ends {between}")
    return wrong


def main() -> int:
    """Runs all cases."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--transitions", type=int, default=200)
    parser.add_argument("--censuses", type=int, default=20)
    parser.add_argument("--lengths", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    wrong = []
    for n in range(1, arguments.cases + 1):
        if problem := random_case(rng):
            wrong.append(problem)
        if n % 100 == 0:
            print(f"{n} random slices, {len(wrong)} wrong", flush=True)
    wrong += beside_transitions(rng, arguments.transitions)
    wrong += censuses_against_slices(rng, arguments.censuses, arguments.lengths)
    print("\n".join(wrong) or "nothing wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
