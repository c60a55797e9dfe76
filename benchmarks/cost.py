"""The estimated cost of questions (worker/answers/cost.py), and what they take.

    python benchmarks/cost.py             about three minutes
    python benchmarks/cost.py --cap 120   also what takes up to two minutes each

A quotient of 2 is an estimate of twice what was measured. A question that does not end within the cap is a
lower bound. For each kind follows the factor by which its constants would have to change: the geometric mean.
"""

from __future__ import annotations

import argparse
import math
import os
import resource
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from typing import Any

import rpr_solver
from rpr_solver import EXAMPLES, Manipulator, Requirement
from rpr_solver.article.audit import article_document
from worker.answers import article, censuses, checks, curves, poses, tables
from worker.answers.cost import seconds, sizes
from worker.answers.requests import ALL_LENGTHS, JobRequest, Kind
from worker.process.preload import load_numpy, load_solver

Case = tuple[str, Manipulator, Kind, dict[str, Any]]

USUAL = (15.91, 0.73, 10.07, 17.04, 16.54, 20.84)


def long_sides(digits: int) -> Manipulator:
    """A manipulator of usual shape, its sides with so many digits."""
    unit = 10 ** (digits - 2)
    noise = int("7318526940" * (digits // 10 + 1))
    return Manipulator(
        *(Fraction(int(Fraction(str(x)) * unit) + (noise * (k + 3)) % (unit // 100 + 1), unit)
          for k, x in enumerate(USUAL))
    )  # fmt: skip


def uneven_sides(power: int) -> Manipulator:
    """A manipulator with sides of very different sizes."""
    return Manipulator(f"1e{power}", 0, 1, 1, f"1e-{power // 2}", 1)


def cases() -> Iterator[Case]:
    """Yields the questions."""
    innocenti = EXAMPLES["innocenti"]
    for digits in (15, 90, 1000, 10_000):
        yield f"slice, {digits} digits", innocenti, tables.KIND, {"l1": ["14.98"], "digits": digits}
    scan = [str(Fraction(n, 10)) for n in range(1, 2001)]
    yield "2000 slices", innocenti, tables.KIND, {"l1": scan, "digits": 15}
    for size in (4, 16, 30, 60, 100, 200, 400):
        m = long_sides(size)
        yield f"slice, sides of {size} digits", m, tables.KIND, {"l1": ["14.98"], "digits": 90}
        length = f"14.{'9' * (size - 2)}"
        yield "its length too", m, tables.KIND, {"l1": [length], "digits": 90}
    for power in (10, 40, 100, 160, 200):
        m = uneven_sides(power)
        for length in ("1", str(10**power), str(Fraction(1, 10**power))):
            name = f"slice, sides 1e{power}, 1e-{power // 2}, {length[:1]}{'…' if len(length) > 1 else ''}"
            yield name, m, tables.KIND, {"l1": [length], "digits": 15}
    for size in (4, 8, 16, 30, 100, 400):
        m = long_sides(size)
        yield f"census, sides of {size} digits", m, censuses.KIND, {"range": ALL_LENGTHS, "digits": 90}
        requirement = Requirement(1, 20, 25, 8).to_json()
        yield f"check, sides of {size} digits", m, checks.KIND, {"requirement": requirement, "digits": 30}
        whole = {"range": ALL_LENGTHS, "lengths": [], "samples": None, "digits": 30}
        yield f"curves, sides of {size} digits", m, curves.KIND, whole
        yield f"article, sides of {size} digits", m, article.KIND, {"l1": ["14.98"], "digits": 90}
        legs = {"l1": "14.98", "l2": "15", "l3": "30", "digits": 90}
        yield f"poses, sides of {size} digits", m, poses.KIND, legs
    yield "census, 1000 digits", innocenti, censuses.KIND, {"range": ALL_LENGTHS, "digits": 1000}


def answer(m: Manipulator, kind: Kind, content: dict[str, Any]) -> object:
    """Compute the answer, as a worker does."""
    digits = content["digits"]
    if kind is tables.KIND:
        return rpr_solver.cusp_table(m, content["l1"], digits=digits)
    if kind is article.KIND:
        return article_document(m, [Fraction(x) for x in content["l1"]], digits)
    if kind is poses.KIND:
        return rpr_solver.poses(m, content["l1"], content["l2"], content["l3"], digits=digits)
    if kind is censuses.KIND:
        return rpr_solver.census(m, digits=digits)
    if kind is checks.KIND:
        return rpr_solver.check(m, Requirement.from_json(content["requirement"]), digits=digits)
    return rpr_solver.cusp_curves(m, digits=digits)


def measured(compute: Callable[[], object], cap: int) -> float | None:
    """Returns the processor time in seconds, or None if it exceeds the cap."""
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (cap, cap + 1))
        start = time.process_time()
        compute()
        os.write(writer, f"{time.process_time() - start}".encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        text = pipe.read()
    os.waitpid(pid, 0)
    return float(text) if text else None


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cap", type=int, default=10, help="seconds for one question (default: 10)")
    cap = parser.parse_args().cap
    load_solver()
    load_numpy()
    quotients: dict[str, list[float]] = defaultdict(list)
    print(f"{'question':<40}{'bits':>6}{'estimate [s]':>14}{'measured [s]':>14}{'quotient':>10}")
    for name, m, kind, content in cases():
        request = JobRequest(kind, {"geometry": m.to_json(), "fixed_leg": 1, **content})
        size = sizes(request)
        estimate = seconds(kind, size)
        row = f"{name:<40}{size.geometry:>6}{estimate:>14.3f}"
        taken = measured(partial(answer, m, kind, content), cap)
        if taken is None:
            verdict = "" if estimate > cap / 3 else f"< {estimate / cap:.2f}"
            print(f"{row}{f'> {cap}':>14}{verdict:>10}", flush=True)
            continue
        quotients[kind.name].append(estimate / taken)
        print(f"{row}{taken:>14.3f}{estimate / taken:>10.2f}", flush=True)
    for kind_name, values in quotients.items():
        mean = math.exp(sum(map(math.log, values)) / len(values))
        print(
            f"{kind_name}: constants × {1 / mean:.2f}; quotients from {min(values):.2f} to {max(values):.2f}"
        )


if __name__ == "__main__":
    main()
