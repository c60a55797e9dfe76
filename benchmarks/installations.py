"""Whole installations behind a proxy that routes by geometry: a simulation with measured costs.

    python -m benchmarks.installations [--number 4] [--rate 200] [--minutes 60] [--costs FILE]

Questions come at random, about manipulators of which few are asked for often (Zipf). A proxy sends each to
one installation: the one with the highest hash of its name and the geometry (rendezvous hashing), so that the
loss of one moves only its own manipulators. Each second an installation has so much time of workers, of its
Redis and of its API; what is not done waits. After half of the time one installation is lost with all that it
knew, and for the last quarter it is back, empty. `--costs` takes the file of `benchmarks.parts --json`.
"""

from __future__ import annotations

import argparse
import bisect
import hashlib
import itertools
import json
import random
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

NEW, KNOWN = "one slice of a new manipulator", "known answer"
COSTS = {NEW: {"worker": 11.0, "valkey": 1.2, "api": 4.0}, KNOWN: {"worker": 0.0, "valkey": 0.0, "api": 0.6}}
"""Milliseconds of an idle machine, where no file is given."""
PARTS = ("worker", "valkey", "api")
EXPONENT = 0.9
SLICES = 20  # of each manipulator that are asked for


@dataclass
class Installation:
    """What one knows, and the work that waits in it, in milliseconds of each part."""

    name: str
    cores: dict[str, int]
    known: set[tuple[int, int]] = field(default_factory=set)
    waiting: dict[str, float] = field(default_factory=lambda: dict.fromkeys(PARTS, 0.0))
    used: dict[str, float] = field(default_factory=lambda: dict.fromkeys(PARTS, 0.0))
    asked: int = 0
    hits: int = 0
    is_lost: bool = False

    def ask(self, question: tuple[int, int], costs: dict[str, dict[str, float]]) -> None:
        """Take a question; its answer is known from then on."""
        is_known = question in self.known
        self.asked, self.hits = self.asked + 1, self.hits + is_known
        self.known.add(question)
        for part in PARTS:
            self.waiting[part] += costs[KNOWN if is_known else NEW][part]

    def work(self) -> None:
        """Let a second pass."""
        for part in PARTS:
            done = min(self.waiting[part], 1000.0 * self.cores[part])
            self.waiting[part] -= done
            self.used[part] += done

    @property
    def delay(self) -> float:
        """The seconds until what waits is done."""
        return max(self.waiting[part] / 1000 / self.cores[part] for part in PARTS)

    def lose(self) -> None:
        """Forget everything."""
        self.is_lost = True
        self.known.clear()
        self.waiting = dict.fromkeys(PARTS, 0.0)


@cache
def order(manipulator: int, names: tuple[str, ...]) -> tuple[str, ...]:
    """Returns the installations of a manipulator, the first choice first."""
    return tuple(
        sorted(
            names, key=lambda name: hashlib.sha256(f"{name} {manipulator}".encode()).digest(), reverse=True
        )
    )


def draw(manipulators: int, seed: int) -> tuple[random.Random, list[float]]:
    """Returns what draws questions: the cumulated shares of the manipulators, by Zipf's law."""
    shares = [rank**-EXPONENT for rank in range(1, manipulators + 1)]
    return random.Random(seed), list(itertools.accumulate(shares))


def simulate(args: argparse.Namespace, costs: dict[str, dict[str, float]]) -> None:
    """Print a line for each tenth of the time."""
    cores = {"worker": args.workers, "valkey": 1, "api": args.api}
    farm = [Installation(f"i{i}", cores) for i in range(args.number)]
    names, by_name = tuple(one.name for one in farm), {one.name: one for one in farm}
    choice, shares = draw(args.manipulators, args.seed)
    seconds = 60 * args.minutes
    print("| minute | known | longest wait | busiest part | most to fewest questions | not reached |")
    print("|---" * 6 + "|")
    delays, refused, before = [0.0], 0, Counter({one.name: 0 for one in farm})
    for second in range(seconds):
        if second == seconds // 2:
            farm[0].lose()
        if second == 3 * seconds // 4:
            farm[0].is_lost = False
        for _ in range(round(choice.gauss(args.rate, args.rate**0.5))):
            manipulator = bisect.bisect(shares, choice.random() * shares[-1])
            question = manipulator, choice.randrange(SLICES)
            reached = [n for n in order(manipulator, names) if not by_name[n].is_lost]
            if by_name[order(manipulator, names)[0]].is_lost and args.no_failover:
                refused += 1
                continue
            by_name[reached[0]].ask(question, costs)
        for one in farm:
            one.work()
        delays.append(max(one.delay for one in farm))
        if (second + 1) % (seconds // 10) == 0:
            show(second + 1, farm, before, delays, refused, seconds // 10)
            delays, refused = [0.0], 0


def show(
    second: int,
    farm: Sequence[Installation],
    before: Counter[str],
    delays: Sequence[float],
    refused: int,
    step: int,
) -> None:
    """Print what happened since the last line."""
    live = [one for one in farm if not one.is_lost]
    asked = [one.asked - before[one.name] for one in live]
    known = sum(one.hits for one in farm) / max(1, sum(one.asked for one in farm))
    shares = {
        f"{one.name} {part}": one.used[part] / (1000 * one.cores[part] * step)
        for one in live
        for part in PARTS
    }
    busiest = max(shares, key=lambda name: shares[name])
    part = f"{busiest} {100 * shares[busiest]:.0f} %"
    balance = max(asked) / max(1, min(asked))
    times = f"{second / 60:.0f} | {100 * known:.0f} % | {max(delays):.1f} s"
    print(f"| {times} | {part} | {balance:.2f} | {refused} |")
    for one in farm:
        before[one.name] = one.asked
        one.used = dict.fromkeys(PARTS, 0.0)
        one.asked, one.hits, before[one.name] = 0, 0, 0


def main() -> None:
    """Simulate."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--number", type=int, default=4, help="installations; default: 4")
    parser.add_argument("--workers", type=int, default=4, help="cores for workers, in each; default: 4")
    parser.add_argument("--api", type=int, default=2, help="processes of the API, in each; default: 2")
    parser.add_argument("--rate", type=float, default=600, help="questions a second in all; default: 600")
    parser.add_argument("--manipulators", type=int, default=100_000, help="default: 100000")
    parser.add_argument("--minutes", type=int, default=60, help="default: 60")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    parser.add_argument(
        "--no-failover", action="store_true", help="no other takes over from one that is lost"
    )
    parser.add_argument(
        "--costs", type=Path, help="written by benchmarks.parts; default: those of an idle machine"
    )
    args = parser.parse_args()
    simulate(args, json.loads(args.costs.read_text(encoding="utf-8")) if args.costs else COSTS)


if __name__ == "__main__":
    main()
