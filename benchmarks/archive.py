"""Slices that outgrow Redis: how many move to an archive, whether each comes back, and how quickly.

    python -m benchmarks.archive [--count 20000] [--computed 500] [--maxmemory-mb 20] [--folder DIR]

A service with two workers, and a Redis with a bound (1 kB a slice if nothing is said), has an archive in a
folder. `--computed` slices of 90 digits are asked for and computed. The others, to make up the number, are
written as a worker writes them: true answers under other lengths. Then each slice is read back from the store
and compared, those in the archive and those in Redis. At last 500 questions, one after the other, are asked
over HTTP, and it is counted how many were computed again.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import statistics
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import httpx
from redis import Redis
from redis.exceptions import OutOfMemoryError

from benchmarks.stack import serving
from rpr_solver import EXAMPLES
from service.stack.embedded_valkey import EmbeddedValkey
from worker.answers.layout import AWAY
from worker.answers.requests import JobRequest
from worker.answers.store import ResultStore
from worker.answers.tables import CUSP_TABLE
from worker.connection import connect
from worker.jobs.installation import read_load
from worker.process.pool import WorkerPool
from worker.settings import WorkerSettings

MANIPULATOR = EXAMPLES["innocenti"].to_json()
DIGITS = 90
GROUP = 500
ASKED = 500
WAIT = {"Prefer": "wait=30"}


def request_for(l1: Sequence[str]) -> JobRequest:
    """Returns the question for slices of the first manipulator."""
    return JobRequest(CUSP_TABLE, {"geometry": MANIPULATOR, "fixed_leg": 1, "digits": DIGITS, "l1": list(l1)})


def lengths(count: int) -> Iterator[list[str]]:
    """Yields so many different lengths, in groups."""
    for first in range(0, count, GROUP):
        yield [f"{10 + i / 100_000:.5f}9" for i in range(first, min(count, first + GROUP))]


def compute(client: httpx.Client, count: int) -> tuple[list[dict[str, object]], float]:
    """Have so many slices computed; returns them, and the seconds."""
    begin, slices = time.perf_counter(), []
    for first in range(0, count, GROUP):
        l1 = [f"{10 + i / 100:.2f}1" for i in range(first, min(count, first + GROUP))]
        body = {"geometry": MANIPULATOR, "digits": DIGITS, "l1": l1}
        slices += client.post("/v1/cusp-tables", json=body, headers=WAIT).raise_for_status().json()["slices"]
    return slices, time.perf_counter() - begin


def slice_at(sample: Sequence[dict[str, object]], l1: str, position: int) -> dict[str, object]:
    """Returns what is written under a length: a true answer under another one."""
    return {**sample[position % len(sample)], "l1": l1}


def fill(store: ResultStore, sample: Sequence[dict[str, object]], count: int) -> tuple[float, int]:
    """Write slices as a worker does, and wait while Redis is full; returns the seconds, and how often."""
    begin, waits, done = time.perf_counter(), 0, 0
    for group in lengths(count):
        slices = {l1: slice_at(sample, l1, done + i) for i, l1 in enumerate(group)}
        while True:
            try:
                store.put_slices(request_for(group), slices)
                break
            except OutOfMemoryError:
                waits += 1
                time.sleep(0.2)
        done += len(group)
        if not done % 100_000:
            print(f"  {done} written after {time.perf_counter() - begin:.0f} s", flush=True)
    return time.perf_counter() - begin, waits


def read_back(store: ResultStore, sample: Sequence[dict[str, object]], count: int) -> tuple[int, int, float]:
    """Returns how many slices came back as they were, how many of these from the archive, and the seconds."""
    begin, right, away, done = time.perf_counter(), 0, 0, 0
    for group in lengths(count):
        request = request_for(group)
        heads = store.redis.mget(store.slice_keys(request, group))
        away += sum(head is not None and head[:1] == AWAY for head in heads)
        texts = store.get_texts(request, group, DIGITS)
        expected = {l1: slice_at(sample, l1, done + i) for i, l1 in enumerate(group)}
        right += sum(l1 in texts and json.loads(texts[l1]) == expected[l1] for l1 in group)
        done += len(group)
    return right, away, time.perf_counter() - begin


def archived(redis: Redis, settings: WorkerSettings, count: int) -> list[str]:
    """Returns lengths whose slices are in the archive, drawn at random."""
    store, every = ResultStore(redis, settings), [x for group in lengths(count) for x in group]
    random.Random(1).shuffle(every)
    found: list[str] = []
    for first in range(0, len(every), GROUP):
        group = every[first : first + GROUP]
        values = redis.mget(store.slice_keys(request_for(group), group))
        found += [
            x for x, value in zip(group, values, strict=True) if value is not None and value[:1] == AWAY
        ]
        if len(found) >= ASKED:
            break
    return found[:ASKED]


def ask(client: httpx.Client, l1: Sequence[str]) -> list[float]:
    """Returns the milliseconds of questions for one slice each."""
    taken = []
    for x in l1:
        begin = time.perf_counter()
        body = {"geometry": MANIPULATOR, "digits": DIGITS, "l1": x}
        client.post("/v1/cusp-tables", json=body, headers=WAIT).raise_for_status()
        taken.append(1000 * (time.perf_counter() - begin))
    return taken


def measure(redis: Redis, args: argparse.Namespace, client: httpx.Client) -> None:
    """Print the figures."""
    settings = WorkerSettings()
    store = ResultStore(redis, settings)
    sample, seconds = compute(client, args.computed)
    print(f"{len(sample)} slices of {DIGITS} digits computed in {seconds:.0f} s", flush=True)
    redis.config_set("maxmemory", args.maxmemory_mb << 20)
    seconds, waits = fill(store, sample, args.count)
    print(f"{args.count} written in {seconds:.0f} s; Redis took no more {waits} times", flush=True)
    before = 0
    while (moved := read_load(redis, settings).archive.get("moved", 0)) > before:
        before = moved
        time.sleep(25)  # several rounds of the process that moves
    right, away, seconds = read_back(store, sample, args.count)
    print(
        f"{right} of {args.count} came back as they were, {away} of them from the archive, in {seconds:.0f} s"
    )
    load, ended = read_load(redis, settings), sum(read_load(redis, settings).ends.by_status.values())
    size = sum(path.stat().st_size for path in (args.folder / "archive" / "objects").iterdir())
    print(
        f"Redis uses {load.memory / 2**20:.0f} of {args.maxmemory_mb} MiB; the archive has "
        f"{load.archive['objects']} objects of {size / 2**20:.0f} MiB; lost: {load.archive.get('lost', 0)}"
    )
    taken = sorted(ask(client, archived(redis, settings, args.count)))
    again = sum(read_load(redis, settings).ends.by_status.values()) - ended
    print(
        f"{len(taken)} archived answers over HTTP: p50 {statistics.median(taken):.1f} ms, "
        f"p95 {taken[int(0.95 * len(taken)) - 1]:.1f} ms; computed again: {again}"
    )


def main() -> None:
    """Start the service and measure."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--count", type=int, default=20_000, help="slices; default: 20000")
    parser.add_argument("--computed", type=int, default=500, help="of them computed; default: 500")
    parser.add_argument("--maxmemory-mb", type=int, help="bound of Redis; default: 1000 bytes a slice")
    parser.add_argument("--folder", type=Path, help="where the archive and Redis keep their files")
    args = parser.parse_args()
    args.maxmemory_mb = args.maxmemory_mb or max(16, args.count * 1000 >> 20)
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        args.folder = Path(folder)
        os.environ["RPR_CUSPS_ARCHIVE_URL"] = f"file://{folder}/archive"
        with EmbeddedValkey(args.folder / "redis") as server, connect(server.url) as redis:
            pool = WorkerPool(2, server.url, "WARNING")
            pool.start()
            try:
                serve = serving("--workers", "0", "--redis-url", server.url)
                with serve as stack, httpx.Client(base_url=stack.url, timeout=60) as client:
                    measure(redis, args, client)
            finally:
                pool.stop()


if __name__ == "__main__":
    main()
