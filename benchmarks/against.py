"""This tree beside an older commit, in turns: is anything slower?

    python benchmarks/against.py REVISION [--rounds 5]

The commit is checked out into a temporary folder and runs under the same interpreter. Only public names are
used. In each round both trees do the same work, one after the other, each in a process of its own; a row
gives the medians and the median of the rounds' ratios, this tree over the other. Times are those of the
processor, but for the service.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]

PREPARE = """
import random, time
from fractions import Fraction
from rpr_solver import EXAMPLES, Manipulator, Requirement, census, cusp_curves
from rpr_solver import design, eliminate, margin, solve_slice
innocenti = EXAMPLES["innocenti"]
def timed(work, clock=time.process_time):
    start = clock()
    work()
    print(clock() - start)
rng = random.Random(24)
randoms = [
    Manipulator(*(Fraction(rng.randint(2000, 3000), 100) for _ in range(6)), sign)
    for sign in ("ccw", "cw") * 5
]
slices = [(innocenti, "28.1", 1), (randoms[0], 20, 1), (randoms[1], 15, 2), (randoms[2], 25, 3)]
four_cusps = Requirement(start=5, stop=30, max_cusps=4)
"""
SCAN = """
import re, subprocess, sys, tempfile, httpx
body = {"geometry": innocenti.to_json(), "l1": {"from": "0.1", "to": "50.1", "step": "0.1"}}
with tempfile.TemporaryDirectory() as folder:
    command = [sys.executable, "-m", "service", "serve", "--port", "0", "--data-dir", folder]
    serve = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        url = next(found[0] for line in serve.stdout if (found := re.search(r"http://[\\d.]+:\\d+", line)))
        with httpx.Client(base_url=url, timeout=60) as client:
            def scan():
                job = client.post("/v1/cusp-tables", json=body, headers={"Prefer": "wait=30"})
                assert job.status_code == 200, job.text
            while client.get("/readyz").status_code != 200:
                time.sleep(0.05)
            timed(scan, time.perf_counter)
    finally:
        serve.terminate()
        serve.wait()
"""
WORK = {
    "elimination": "timed(lambda: eliminate(innocenti).a)",
    "200 slices at 90 digits": "e = eliminate(innocenti)\n"
    "timed(lambda: [solve_slice(e, Fraction(k, 4), 90) for k in range(1, 201)])",
    "census, 30 digits": "timed(lambda: census(innocenti, digits=30))",
    "10 random censuses": "census(innocenti)\ntimed(lambda: [census(m, digits=15) for m in randoms])",
    "4 margins": "margin(innocenti, '28.1', tolerance='0.0005')\n"
    "timed(lambda: [margin(m, length, fixed_leg=leg) for m, length, leg in slices])",
    "design of 30 censuses": "census(innocenti)\n"
    "timed(lambda: design(innocenti, 'longest-range', four_cusps, vary='15%', budget=30))",
    "cusp curves, 30 digits": "timed(lambda: cusp_curves(innocenti, digits=30))",
    "501 slices over HTTP": SCAN,
}


def seconds(tree: Path, work: str) -> float:
    """How long a piece of work takes in a tree."""
    run = subprocess.run(
        [sys.executable, "-c", PREPARE + work],
        cwd=tree,
        env={**os.environ, "PYTHONPATH": str(tree)},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(run.stdout)


def main() -> None:
    """Print one row for each piece of work."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("revision", help="a commit of this repository")
    parser.add_argument("--rounds", type=int, default=5, help="default: 5")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        archive = subprocess.run(
            ["git", "archive", args.revision], cwd=ROOT, stdout=subprocess.PIPE, check=True
        ).stdout
        subprocess.run(["tar", "-x", "-C", folder], input=archive, check=True)
        for name, work in WORK.items():
            rounds = [(seconds(ROOT, work), seconds(Path(folder), work)) for _ in range(args.rounds)]
            here, there = (statistics.median(times) for times in zip(*rounds, strict=True))
            ratio = statistics.median(a / b for a, b in rounds)
            print(f"{name:26} {here:8.3f} s, {args.revision} {there:8.3f} s: {ratio:.2f} ×", flush=True)


if __name__ == "__main__":
    main()
