"""Designs: what a search reaches from the same questions with several seeds, and in how many censuses.

python -m benchmarks.design                          all questions, an hour or more
python -m benchmarks.design range --seeds 3 4        some of them
python -m benchmarks.design range --vary 5% 10%      a front of range against change
python -m benchmarks.design cusps --enough 12        each search ends when it has reached that
python -m benchmarks.design --keep build/censuses    candidates are kept there, for the next run
python -m benchmarks.design --workers 1 2            a job of 300 censuses, shared by so many workers

The values are those that the search sees, and times those of the process without kept candidates. Jobs are
computed by a service of their own.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from math import inf
from pathlib import Path
from typing import Any

from benchmarks.stack import serving
from rpr_solver import EXAMPLES, Manipulator, Requirement
from rpr_solver.contract import LENGTHS
from rpr_solver.designs import Plan, SearchStopped
from rpr_solver.designs.design import examined
from rpr_solver.designs.plan import CANCELED
from rpr_solver.designs.search import Candidate, Documents, searched
from service.client import Asked, ServiceClient
from service.schemas.designs import DesignRequest

INNOCENTI = EXAMPLES["innocenti"]
_SHARE = Fraction(15, 100)
_REACH = {
    name: _SHARE * (INNOCENTI.a2x if name in ("a3x", "a3y") else getattr(INNOCENTI, name)) for name in LENGTHS
}
WIDE = {name: (getattr(INNOCENTI, name) - x, getattr(INNOCENTI, name) + x) for name, x in _REACH.items()}
ANY = Manipulator(10, 5, 8, 12, 20, 15)
"""Where searches begin that look everywhere; they use it as one candidate among others."""
EVERYWHERE = {"a3x": (-20, 20), "a3y": ("0.5", 20), "d1": (1, 40), "d2": (1, 40), "d3": (1, 40)}
ISOSCELES = {"t1": ("0.05", 3), "d1": (1, 40), "d2": (1, 70)}
QUESTIONS: dict[str, tuple[str, Manipulator, str, Requirement, dict[str, Any]]] = {
    "range": (
        "first manipulator ±15 %: longest part of [5, 30] with at most 4 cusps",
        INNOCENTI,
        "longest-range",
        Requirement(start=5, stop=30, max_cusps=4),
        {"vary": "15%", "budget": 150},
    ),
    "wide": (
        "the same, A3 anywhere within 15 % of |A1A2| in each direction",
        INNOCENTI,
        "longest-range",
        Requirement(start=5, stop=30, max_cusps=4),
        {"vary": WIDE, "budget": 150},
    ),
    "change": (
        "first manipulator ±15 %: least change for at most 6 cusps on [5, 30], windows of 1e-3 ignored",
        INNOCENTI,
        "least-change",
        Requirement(start=5, stop=30, max_cusps=6, ignore_windows="0.001"),
        {"vary": "15%", "budget": 300},
    ),
    "cusps": (
        "most cusps, from random starts",
        ANY,
        "most-cusps",
        Requirement(min_cusps=0),
        {"vary": EVERYWHERE, "budget": 400},
    ),
    "isosceles": (
        "most cusps, isosceles at leg 1, from random starts",
        ANY,
        "most-cusps",
        Requirement(min_cusps=0),
        {"vary": ISOSCELES, "budget": 400, "family": "isosceles-1"},
    ),
}


@dataclass
class Kept:
    """Documents of candidates, and what they cost."""

    plan: Plan
    folder: Path | None
    enough: float
    seconds: float = 0.0
    new: int = field(default=0)
    reached: float = 0.0

    def tell(self, candidate: Candidate) -> None:
        """Takes note of an improvement."""
        self.reached = candidate.value

    def examine(self, asked: Sequence[Manipulator]) -> Documents:
        """The documents of a generation.

        Raises:
            SearchStopped: enough is reached.
        """
        if self.reached >= self.enough:
            raise SearchStopped(CANCELED)
        return [self._one(manipulator) for manipulator in asked]

    def _one(self, manipulator: Manipulator) -> Mapping[str, Any] | None:
        path = None if self.folder is None else self.folder / manipulator.geometry_hash[7:]
        if path is not None and path.exists():
            found: Mapping[str, Any] | None = json.loads(path.read_text())
            return found
        start = time.process_time()
        document = examined(manipulator, self.plan.goal)
        self.seconds, self.new = self.seconds + time.process_time() - start, self.new + 1
        if path is not None:
            path.write_text(json.dumps(document))
        return document


def measure(name: str, seed: int, vary: str | None, folder: Path | None, enough: float) -> None:
    """Ask a question with a seed, and print what was found."""
    _, manipulator, objective, requirement, options = QUESTIONS[name]
    if vary is not None:
        options = {**options, "vary": vary}
    plan = Plan.of(manipulator, objective, requirement, **options, seed=seed)
    kept = Kept(plan, folder, enough)
    start = time.process_time()
    outcome = searched(plan, kept.examine, kept.tell)
    own = time.process_time() - start - kept.seconds
    best = outcome.candidates[-1]
    first = {float(one.value): one.number for one in reversed(outcome.candidates)}
    reached = ", ".join(f"{value:.6g} at {first[value]}" for value in sorted(first)[-3:])
    each = kept.seconds / kept.new if kept.new else 0.0
    print(
        f"{name:10} {vary or '':4} seed {seed}: {best.value:.6g} ({'met' if best.met else 'not met'}) in "
        f"{outcome.censuses} censuses; {reached}; {each:.2f} s a census, {own:.0f} s beside",
        flush=True,
    )
    print(f"  {json.dumps(best.manipulator.to_json())}", flush=True)


def job(workers: int) -> float:
    """Ask a service for 300 censuses and the proof of the best; returns the seconds."""
    body = {
        "geometry": INNOCENTI.to_json(),
        "objective": "least-change",
        "requirement": {"range": {"from": 5, "to": 30}, "max_cusps": 6, "ignore_windows": "0.001"},
        "vary": "15%",
    }
    with serving("--workers", str(workers)) as stack, ServiceClient(stack.url) as client:
        start = time.monotonic()
        found = client.ask(Asked.of(DesignRequest.model_validate(body))).document
        seconds = time.monotonic() - start
    print(f"{workers} workers: {found['censuses']} censuses in {seconds:.1f} s", flush=True)
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="QUESTION", help=", ".join(QUESTIONS))
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument(
        "--vary", nargs="+", default=[None], help="a front: the same for each share, as 5%% 10%%"
    )
    parser.add_argument("--enough", type=float, default=inf, help="end a search that has reached this value")
    parser.add_argument("--keep", type=Path, help="a folder for candidates")
    parser.add_argument("--workers", type=int, nargs="*", help="measure jobs instead")
    args = parser.parse_args()
    if args.workers:
        seconds = [job(workers) for workers in args.workers]
        print(", ".join(f"{seconds[0] / each:.2f}" for each in seconds), "times as fast as the first")
        return
    if args.keep is not None:
        args.keep.mkdir(parents=True, exist_ok=True)
    for name in args.names or QUESTIONS:
        print(QUESTIONS[name][0])
        for vary, seed in product(args.vary, args.seeds):
            measure(name, seed, vary, args.keep, args.enough)


if __name__ == "__main__":
    main()
