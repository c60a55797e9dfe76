"""What HTTP, queue, store and work horse add to an answer: time, and processor time by process; and starts.

    python -m benchmarks.overhead [--jobs 200]

First the processor time of commands is measured, and how long `serve` takes until it is ready, with two
workers; of several starts the quickest counts. Then it starts the real stack with one worker, asks for the
poses of so many joint vectors one after the other, each of which is a job of its own, and then for a cached
table. The computation itself is measured in this process. On a busy machine, `chrt --rr 10` before it (as
root) gives about the times of an idle one.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import httpx

from benchmarks.stack import GEOMETRY, Stack, serving
from rpr_solver import Manipulator, poses

TICK = os.sysconf("SC_CLK_TCK")
WAIT = {"Prefer": "wait=30"}
STARTS = 5
CACHED = {"geometry": GEOMETRY, "l1": "14.98"}


def processor_seconds(stack: Stack) -> dict[str, float]:
    """Returns the seconds that the children of the service have used, with their own children."""
    seen: dict[int, tuple[int, bytes, float]] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
            words = path.with_name("cmdline").read_bytes()
        except OSError:
            continue
        seen[int(path.parent.name)] = int(fields[1]), words, sum(map(int, fields[11:15])) / TICK
    found: dict[str, float] = {}
    for parent, words, seconds in seen.values():
        if stack.pid in (parent, seen.get(parent, (0,))[0]):
            name = next(name for name in ("valkey", "worker", "template", "api") if name.encode() in words)
            found[name] = found.get(name, 0.0) + seconds
    return found


def milliseconds(calls: list[Callable[[], object]]) -> float:
    """Returns the median time of calls."""
    samples = []
    for call in calls:
        start = time.perf_counter()
        call()
        samples.append(time.perf_counter() - start)
    return 1000 * statistics.median(samples)


def starts() -> None:
    """Print what starts take."""
    program = [sys.executable, "-m", "service"]
    for words in (["--help"], ["solve", "innocenti", "--l1", "14.98"]):
        used = []
        for _ in range(STARTS):
            before = os.times()
            subprocess.run([*program, *words], stdout=subprocess.DEVNULL, check=True)
            after = os.times()
            used.append(
                after.children_user + after.children_system - before.children_user - before.children_system
            )
        print(f"rpr-cusps {' '.join(words)}: {min(used):.2f} s of a processor", flush=True)
    ready = []
    for _ in range(STARTS):
        begin = time.perf_counter()
        with serving("--workers", "2"):
            ready.append(time.perf_counter() - begin)
    print(f"rpr-cusps serve --workers 2: ready after {min(ready):.2f} s", flush=True)


def main() -> None:
    """Print the figures."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--jobs", type=int, default=200, help="default: 200")
    jobs = parser.parse_args().jobs
    starts()
    manipulator = Manipulator.from_json(GEOMETRY)
    lengths = [f"15.{k:06}" for k in range(jobs)]
    alone = milliseconds([lambda x=x: poses(manipulator, 15, x, 30) for x in lengths])  # type: ignore[misc]
    with serving("--workers", "1") as stack, httpx.Client(base_url=stack.url, timeout=60) as client:

        def ask(path: str, body: object) -> None:
            answer = client.post(path, json=body, headers=WAIT)
            assert answer.status_code == 200, answer.text

        ask("/v1/cusp-tables", CACHED)
        ask("/v1/poses", {"geometry": GEOMETRY, "l1": "15", "l2": "16", "l3": "30"})
        legs = [{"geometry": GEOMETRY, "l1": "15", "l2": x, "l3": "30"} for x in lengths]
        for what, computed, calls in (
            ("a cold job", alone, [lambda body=body: ask("/v1/poses", body) for body in legs]),  # type: ignore[misc]
            ("a cached table", 0.0, [lambda: ask("/v1/cusp-tables", CACHED)] * jobs),
            ("GET /healthz", 0.0, [lambda: client.get("/healthz")] * jobs),
        ):
            before = processor_seconds(stack)
            median = milliseconds(calls)
            used = processor_seconds(stack)
            each = ", ".join(f"{x} {1000 * (used[x] - before[x]) / jobs:.2f}" for x in sorted(used))
            of = f", of which {computed:.2f} ms are the computation" if computed else ""
            print(f"{what}: {median:.2f} ms{of}; processor: {each} ms", flush=True)


if __name__ == "__main__":
    main()
