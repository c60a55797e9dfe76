"""The long run of poses along a leg: counts against direct kinematics, and each end by its neighbours.

    python -m tests.rpr_solver.along.long_run [--machines 300] [--first 0] [--seed 1]

Machine n is the same in every run with the same seed. Every third one is random, every third one exact, with
roots, and every third one of a degenerate family; the lengths held are often equal, or a side. The number of
poses is counted at lengths between all neighbours, at even steps, and beside each printed end by one unit of
its last digit, where it must be that of the interval. Where two counts at even steps differ, bisection leads
to a length that must be an end. Prints every failure, then the numbers, and exits with status 1 if there was
one.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from functools import partial
from itertools import islice, pairwise
from random import Random

from rpr_solver import LegPoses, Manipulator, SolverError, leg_poses
from rpr_solver.exact.modular import simple_and_finite
from rpr_solver.exact.real_roots import number_of_real_roots
from rpr_solver.model.fibre import DEGREE, Closure, fibre
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.slice_map import SliceMap
from tests.rpr_solver.long_run import manipulator
from tests.support.degenerate import MAKERS, draws

DIGITS = 90
STEPS = 12
HALVINGS = 60


def exact_machine(rng: Random) -> Manipulator:
    """A machine with roots: equilateral, by sides, or by points."""

    def sides() -> dict[str, object]:
        kind = rng.randrange(3)
        if kind == 0:
            return {"equilateral": str(rng.randint(2, 20))}
        if kind == 1:
            side = rng.randint(2, 9)
            return {"sides": [str(side), f"{side}*sqrt(2)", str(side)]}
        return {"circumradius": str(rng.randint(1, 9))}

    corners = [["0", "0"], [str(rng.randint(2, 9)), str(rng.randint(1, 5))], [str(rng.randint(-3, 3)), "7"]]
    base = {"points": corners} if rng.random() < 0.3 else sides()
    return Manipulator(base=base, platform=sides(), orientation=rng.choice(("ccw", "cw")))


def machine(number: int, seed: int) -> tuple[str, Manipulator, dict[str, Fraction]]:
    """Machine n of a seed: what it is, and the lengths of its held legs."""
    rng = Random(f"{seed} {number}")
    if number % 3 == 0:
        name, found = "random", manipulator(rng)
    elif number % 3 == 1:
        name, found = "exact", exact_machine(rng)
    else:
        name = list(MAKERS)[number // 3 % len(MAKERS)]
        found = next(islice(draws(rng), list(MAKERS).index(name), None))[1]
    model = SliceMap.of(found)
    size = Fraction(round(model.f.size / model.scale / 2) or 1)
    first = Fraction(rng.randint(1, 150), 100) * size
    second = first if rng.random() < 0.3 else Fraction(rng.randint(1, 150), 100) * size
    legs = rng.sample(("l1", "l2", "l3"), 2)
    return name, found, dict(sorted(zip(legs, (first, second), strict=True)))


def closure_of(found: LegPoses, slice_map: SliceMap, length: Fraction) -> Closure:
    """The closure equations at one length of the moving leg."""
    lengths = {**found.lengths, f"l{found.moving_leg}": length}
    legs = (slice_map.fixed_leg, *free_legs(slice_map.fixed_leg))
    return Closure.of(slice_map, [lengths[f"l{leg}"] ** 2 for leg in legs])


def counted(found: LegPoses, slice_map: SliceMap, length: Fraction) -> int:
    """The number of poses at one length, by direct kinematics."""
    closure = closure_of(found, slice_map, length)
    if simple_and_finite(closure.sextic, DEGREE):
        return number_of_real_roots(closure.sextic)
    return len(fibre(closure, 15).poses)


def failures(found: LegPoses) -> Iterator[str]:
    """What is wrong with the ends and the counts."""
    slice_map = SliceMap.of(found.manipulator, int(min(found.lengths)[1]))
    count = partial(counted, found, slice_map)
    # where two poses always have one α, number fields count them, which takes long with long numbers
    sextic = closure_of(found, slice_map, Fraction(found.intervals[0].at)).sextic
    is_simple = simple_and_finite(sextic, DEGREE)
    ends = [Fraction(end.length) for end in found.ends if end.length != "0"]
    counts = [interval.count for interval in found.intervals]
    if len(counts) != len(ends) + 1:
        yield f"{len(ends)} ends and {len(counts)} intervals"
        return
    for end, (before, after) in zip(ends if is_simple else (), pairwise(counts), strict=is_simple):
        step = Fraction(1, 10 ** (DIGITS - len(str(int(end)))))
        beside = count(end - step), count(end + step)
        if beside != (before, after):
            yield f"{beside} poses beside {float(end)}, not {(before, after)}"
    last = max([*ends, Fraction(1)]) * Fraction(6, 5)
    even = [Fraction(round(100 * last * k / STEPS) or 1, 100) for k in range(1, STEPS + 1)]
    seen = [count(x) for x in even]
    for x, number in zip(even, seen, strict=True):
        is_between = all(abs(x - end) > Fraction(1, 10**9) for end in ends)
        if is_between and number != counts[sum(end < x for end in ends)]:
            yield f"{number} poses at {float(x)}"
    for (low, high), (first, second) in zip(pairwise(even), pairwise(seen), strict=True):
        if first == second or not is_simple:
            continue
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if count(middle) == first else (low, middle)
        if not any(low - (high - low) <= end <= high + (high - low) for end in ends):
            yield f"a fold near {float(low)}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--machines", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    started, seen, wrong, slowest = time.process_time(), Counter[str](), 0, 0.0
    for number in range(args.first, args.first + args.machines):
        name, found, held = machine(number, args.seed)
        before = time.process_time()
        try:
            answer = leg_poses(found, held, digits=DIGITS)
        except SolverError as error:
            seen["refused"] += 1
            print(f"{number} {name}: refused: {error}", flush=True)
            continue
        slowest = max(slowest, time.process_time() - before)
        seen["ends"] += len(answer.ends)
        seen["intervals"] += len(answer.intervals)
        seen["undecided signs"] += sum(sign is None for x in answer.intervals for sign in x.signs)
        for failure in failures(answer):
            wrong += 1
            print(f"{number} {name} {held}: {failure}", flush=True)
    print(f"{args.machines} machines, {dict(seen)}, {wrong} failures", end="; ")
    print(f"slowest {slowest:.1f} s, {time.process_time() - started:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
