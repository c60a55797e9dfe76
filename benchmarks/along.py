"""Poses along a leg: CPU time of questions, and what the service estimates for them.

python -m benchmarks.along            20 questions of each machine, 15, 90 and 1000 digits
"""

from __future__ import annotations

import argparse
import statistics
import time
from random import Random

from rpr_solver import EXAMPLES, Manipulator, leg_poses
from service.client import leg_poses as asked

MACHINES = {
    **{name: EXAMPLES[name] for name in ("innocenti", "zein-flat", "eighteen-cusps")},
    "equilateral in equilateral": Manipulator(base={"equilateral": 10}, platform={"circumradius": 1}),
    "roots": Manipulator(base={"equilateral": 10}, platform={"sides": [6, 7, 5]}),
    "A1 = A2": Manipulator(base={"sides": [0, 10, 10]}, platform={"sides": [6, 7, 5]}),
}


def main() -> None:
    """Print the table."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--questions", type=int, default=20, help="of each machine (default: 20)")
    args = parser.parse_args()
    print(f"{'machine':28}{'digits':>7}{'ends':>6}{'median':>8}{'most':>8}{'estimate':>10}   [ms of CPU]")
    for name, manipulator in MACHINES.items():
        for digits in (15, 90, 1000):
            rng = Random(1)
            times, estimates, ends = [], [], []
            for _ in range(args.questions):
                held = {"l1": f"{rng.uniform(3, 25):.2f}", "l3": f"{rng.uniform(3, 25):.2f}"}
                start = time.process_time()
                ends.append(len(leg_poses(manipulator, held, digits=digits).ends))
                times.append(1e3 * (time.process_time() - start))
                question = asked(manipulator, held, digits=digits).question
                estimates.append(1e3 * question.job_request().cost.whole)
            middle = f"{statistics.mean(ends):>6.1f}{statistics.median(times):>8.0f}{max(times):>8.0f}"
            print(f"{name:28}{digits:>7}{middle}{statistics.median(estimates):>10.0f}", flush=True)


if __name__ == "__main__":
    main()
