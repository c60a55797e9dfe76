"""What a slice costs as its question grows, and what a long job takes in time, memory and store.

    python -m benchmarks.scale [--plot FILE.svg] [--job 20000 [--workers 1 2] [--only-job]]
    python -m benchmarks.scale --slices 1 10 100 1000 10000

Costs are processor time of a slice in a chunk of the first manipulator, by digits of the answer, and by
digits of the input numbers at 30 digits of the answer. `--slices` prints instead what a slice costs from
nothing by the number of slices at 15 digits: processor time of one process, and of the slower of two that
share the slices, which is what two idle cores take. `--job` adds one job with so many slices at 15 digits,
sent to a service in an empty data directory, once for each number of workers: time, processor time, bytes of
the store, and the greatest memory of a process.
"""

from __future__ import annotations

import argparse
import random
import re
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from multiprocessing import Pool, Value
from pathlib import Path

import httpx

from benchmarks.overhead import processor_seconds
from benchmarks.stack import GEOMETRY, serving
from rpr_solver import EXAMPLES, Manipulator, SliceTable, eliminate, solve_slices

DIGITS = {15: 300, 30: 300, 90: 300, 300: 150, 1000: 100, 3000: 64, 10_000: 64}
"""Digits of the answer → slices."""
INPUTS = {3: 300, 10: 200, 30: 100, 100: 64, 200: 64}
"""Digits of each input number → slices."""
COUNT = Value("i", 0)
"""Slices of a scan that processes share."""
NAMES = ("a2x", "a3x", "a3y", "d1", "d2", "d3")


def milliseconds(
    manipulator: Manipulator, lengths: Sequence[Fraction], digits: int
) -> tuple[float, float, int]:
    """Processor time of the elimination and of a slice, and the cusps of all."""
    begin = time.process_time()
    eliminant = eliminate(manipulator)
    assert eliminant.a, "its coefficients are computed at their first use"
    middle = time.process_time()
    count = sum(table.count for table in solve_slices(eliminant, lengths, digits))  # type: ignore[union-attr]
    return 1000 * (middle - begin), 1000 * (time.process_time() - middle) / len(lengths), count


def spread(count: int, places: int = 3) -> list[Fraction]:
    """Lengths over the whole range, with so many decimals."""
    rng = random.Random(7)
    return [Fraction(rng.randint(10**places // 10, 50 * 10**places), 10**places) for _ in range(count)]


def longer(places: int) -> Manipulator:
    """The first manipulator, its lengths changed at a distant decimal."""
    rng = random.Random(places)
    first = EXAMPLES["innocenti"]
    sides = {name: getattr(first, name) + Fraction(rng.randint(1, 9), 10**places) for name in NAMES}
    return replace(first, **sides)


def costs() -> Iterator[tuple[str, int, float]]:
    """Print the tables; yields what each point of the plot shows."""
    first = EXAMPLES["innocenti"]
    print(f"{'digits of the answer':<24}{'ms a slice':>12}{'ms a cusp':>12}")
    for digits, count in DIGITS.items():
        _, each, cusps = milliseconds(first, spread(count), digits)
        print(f"{digits:<24}{each:12.2f}{each * count / cusps:12.2f}", flush=True)
        yield "answer", digits, each
    print(f"\n{'digits of each input':<24}{'elimination':>12}{'ms a slice':>12}")
    for digits, count in INPUTS.items():
        once, each, _ = milliseconds(longer(digits), spread(count, digits), 30)
        print(f"{digits:<24}{once:12.1f}{each:12.2f}", flush=True)
        yield "input", digits, each


def scan(share: tuple[int, int]) -> float:
    """The processor time of a process for every n-th slice of a scan from nothing, from the k-th on."""
    start, step = share
    list(solve_slices(eliminate(EXAMPLES["twelve-cusps"]), [8, 9, 10, 11, 12], 15))
    begin = time.process_time()
    lengths = spread(COUNT.value, 6)[start::step]
    assert all(isinstance(x, SliceTable) for x in solve_slices(eliminate(EXAMPLES["innocenti"]), lengths, 15))
    return time.process_time() - begin


def numbers_of_slices(counts: Sequence[int]) -> None:
    """Print the table by the number of slices."""
    print(f"{'slices':>8}{'ms a slice, one process':>26}{'two processes':>16}")
    for count in counts:
        COUNT.value = count
        with Pool(2) as pool:
            one = pool.apply(scan, ((0, 1),))
            two = max(pool.map(scan, ((0, 2), (1, 2)), 1)) if count > 1 else one
        print(f"{count:8}{1000 * one / count:26.2f}{1000 * two / count:16.2f}", flush=True)


def plot(points: Sequence[tuple[str, int, float]], path: Path) -> None:
    """Draw the costs over the digits, both logarithmic."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 3.6), layout="constrained")
    axes = figure.subplots()
    labels = {"answer": "digits of the answer", "input": "digits of each input number (30 of the answer)"}
    for kind, marker in (("answer", "o"), ("input", "s")):
        x, y = zip(*((digits, each) for name, digits, each in points if name == kind), strict=True)
        axes.loglog(x, y, marker=marker, label=labels[kind])
    axes.set(xlabel="decimal digits", ylabel="ms of one core for a slice")
    axes.grid(visible=True, which="major", alpha=0.3)
    axes.legend()
    figure.savefig(path, metadata={"Date": None})


def job(slices: int, workers: int) -> float:
    """Print what one job of so many slices takes; returns its seconds."""
    limits = {"MAX_SLICES": str(slices), "MAX_COST_SECONDS": str(slices)}
    step = Fraction(50, slices)
    body = {
        "geometry": GEOMETRY,
        "digits": 15,
        "l1": {"from": str(step), "to": "50", "step": str(step)},
    }
    serve = serving("--workers", str(workers), **limits)
    with serve as stack, httpx.Client(base_url=stack.url, timeout=60) as client:
        kept, used, begin = memory_of_store(client), processor_seconds(stack), time.perf_counter()
        sent = client.post("/v1/cusp-tables", json=body)
        sent.raise_for_status()
        accepted = time.perf_counter() - begin
        link, peaks = sent.headers["location"], {stack.pid: 0}
        while (state := client.get(link).json())["status"] not in ("succeeded", "completed", "failed"):
            peaks = greatest(peaks, stack.pid)
            time.sleep(0.2)
        taken = time.perf_counter() - begin
        print(f"\n{slices} slices, workers: {workers}: accepted after {accepted:.1f} s, {state['status']}")
        now = processor_seconds(stack)
        each = ", ".join(f"{name} {1000 * (now[name] - used[name]) / slices:.2f}" for name in sorted(now))
        print(f"{taken:.0f} s, {1000 * taken / slices:.2f} ms a slice; processor time of each: {each} ms")
        print(f"{(memory_of_store(client) - kept) / slices:.0f} bytes of the store for a slice")
        begin, size = time.perf_counter(), 0
        form = {"Accept": "application/x-ndjson"}
        with client.stream("GET", state["links"]["result"], headers=form) as r:
            for part in r.iter_bytes():
                size += len(part)
        seconds = time.perf_counter() - begin
        print(f"read again as NDJSON in {seconds:.1f} s: {size / slices:.0f} bytes a slice")
        peaks = greatest(peaks, stack.pid)
        print(f"{len(peaks)} processes, work horses among them; the largest: {max(peaks.values())} MiB")
        return taken


def memory_of_store(client: httpx.Client) -> float:
    """Bytes that Redis uses."""
    metrics = client.get("/metrics").raise_for_status().text
    found = re.search(r"^rpr_cusps_redis_memory_bytes (\S+)$", metrics, re.MULTILINE)
    assert found is not None
    return float(found[1])


def greatest(peaks: dict[int, int], root: int) -> dict[int, int]:
    """The greatest memory of a process and its descendants so far, in MiB."""
    children: dict[int, list[int]] = {}
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            fields = dict(
                x.split(":", 1) for x in status.read_text(encoding="utf-8").splitlines() if ":" in x
            )
        except OSError:
            continue
        children.setdefault(int(fields["PPid"]), []).append(int(fields["Pid"]))
    todo, found = [root], dict(peaks)
    while todo:
        pid = todo.pop()
        todo += children.get(pid, [])
        try:
            text = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
        except OSError:
            continue
        if peak := re.search(r"VmHWM:\s+(\d+) kB", text):
            found[pid] = max(found.get(pid, 0), int(peak[1]) // 1024)
    return found


def main() -> None:
    """Print the tables."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--plot", type=Path, help="where the plot goes")
    parser.add_argument("--job", type=int, help="slices of one long job")
    parser.add_argument("--workers", type=int, nargs="+", default=[1], help="of the job; default: 1")
    parser.add_argument("--only-job", action="store_true", help="nothing but the job")
    parser.add_argument("--slices", type=int, nargs="+", help="numbers of slices; nothing else is measured")
    args = parser.parse_args()
    if args.slices:
        numbers_of_slices(args.slices)
        return
    points = [] if args.only_job else list(costs())
    if args.plot:
        plot(points, args.plot)
    if args.job:
        first, *others = [job(args.job, count) for count in args.workers]
        for count, taken in zip(args.workers[1:], others, strict=True):
            print(f"workers: {count} are {first / taken:.2f} times as fast as {args.workers[0]}")


if __name__ == "__main__":
    main()
