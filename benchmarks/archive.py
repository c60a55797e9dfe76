"""Slices that outgrow Redis: asked for, computed, moved to an archive, and read back.

    python -m benchmarks.archive [--count 20000] [--minutes 20] [--maxmemory-mb 20] [--folder DIR]

A service with two workers, and a Redis with a bound (1 kB a slice if nothing is said), has an archive in a
folder. So many slices of 90 digits are asked for, in scans with a manipulator each, and each table is read
when its job has ended. After `--minutes`, further scans are written as a worker writes them, not computed:
true answers under other lengths. Once nothing moves any more, all are asked for again and compared, slice by
slice; so is one computed slice of a thousand with the library's. At last 500 of the slices that are in the
archive, drawn at random, are asked for one after the other.

That nothing was computed twice is shown by the service: no chunk was lost and repeated, nothing was found
lost in the archive, and no job was made beside those of the scans.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import statistics
import tempfile
import time
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import httpx
from redis import Redis
from redis.exceptions import OutOfMemoryError

from benchmarks.stack import GEOMETRY, serving
from rpr_solver import Manipulator, table_document
from service.stack.embedded_valkey import EmbeddedValkey
from worker.answers import JobRequest, SliceJson
from worker.answers.layout import AWAY, dump
from worker.answers.store import ResultStore
from worker.answers.tables import CUSP_TABLE
from worker.connection import connect
from worker.jobs.installation import read_load
from worker.settings import WorkerSettings

DIGITS = 90
ASKED = 500
CHECKED = 1000  # of so many slices, one is compared with the library's
AT_ONCE = 2  # jobs that wait or run
GROUP = 500  # slices that are written at once
WAIT = {"Prefer": "wait=30"}
PAUSE = 25.0  # seconds for several rounds of the process that moves
LIMITS = {"MAX_SLICES": "100000", "MAX_COST_SECONDS": "100000"}

say = partial(print, flush=True)


class Scan:
    """Slices of one manipulator, the article's first, a little changed; asked for together."""

    def __init__(self, number: int, count: int) -> None:
        self.geometry = {**GEOMETRY, "a3y": f"10.{number:04}1"}
        self.lengths = [f"{10 + i / 5000:.4f}9" for i in range(count)]
        self.is_computed = False
        self.digests: list[bytes] = []
        self._link = ""

    @property
    def request(self) -> JobRequest:
        """The question as workers know it."""
        geometry = Manipulator.from_json(self.geometry).to_json()
        content = {"geometry": geometry, "fixed_leg": 1, "digits": DIGITS, "l1": self.lengths}
        return JobRequest(CUSP_TABLE, content)

    def body(self, l1: object = None) -> dict[str, Any]:
        """Returns the question for all slices, or for some."""
        every = {"from": self.lengths[0], "to": self.lengths[-1], "step": "0.0002"}
        return {"geometry": self.geometry, "digits": DIGITS, "l1": l1 or every}

    def submit(self, client: httpx.Client) -> None:
        """Have it computed."""
        reply = client.post("/v1/cusp-tables", json=self.body()).raise_for_status()
        assert reply.status_code == 202, reply.text[:200]
        self._link = reply.json()["links"]["self"]

    def has_ended(self, client: httpx.Client) -> bool:
        """Whether the job has succeeded."""
        status = client.get(self._link).raise_for_status().json()["status"]
        assert status in ("queued", "running", "succeeded"), status
        self.is_computed = status == "succeeded"
        return self.is_computed

    def write(self, store: ResultStore, sample: Sequence[SliceJson]) -> int:
        """Write all slices as a worker does; returns how often Redis was full."""
        request, waits = self.request, 0
        for first in range(0, len(self.lengths), GROUP):
            group = self.lengths[first : first + GROUP]
            slices = {x: {**sample[(first + i) % len(sample)], "l1": x} for i, x in enumerate(group)}
            self.digests += [_digest(dump(value).encode()) for value in slices.values()]
            while True:
                try:
                    store.put_slices(request, slices)
                    break
                except OutOfMemoryError:
                    waits += 1
                    time.sleep(0.2)
        return waits

    def read(self, client: httpx.Client) -> list[bytes]:
        """Asks for it; returns the digests of the slices in their order, none if it is not known."""
        form = {"Accept": "application/x-ndjson"}
        with client.stream("POST", "/v1/cusp-tables", json=self.body(), headers=form) as reply:
            reply.raise_for_status()
            is_known = reply.status_code == 200
            return [_digest(line.encode()) for line in reply.iter_lines()] if is_known else []

    def differs(self, client: httpx.Client) -> int:
        """Compares some slices with the library's; returns how many are others."""
        chosen = random.Random(1).sample(self.lengths, max(1, len(self.lengths) // CHECKED))
        expected = table_document(Manipulator.from_json(self.geometry), chosen, digits=DIGITS)["slices"]
        reply = client.post("/v1/cusp-tables", json=self.body(chosen), headers=WAIT).raise_for_status()
        return sum(one != other for one, other in zip(reply.json()["slices"], expected, strict=True))


def _digest(text: bytes) -> bytes:
    """Returns that of a slice, in a line or alone."""
    return hashlib.blake2b(text[text.index(b'"l1":') :], digest_size=16).digest()


class Progress:
    """Says now and then how far it is."""

    def __init__(self, redis: Redis, settings: WorkerSettings) -> None:
        self._redis, self._settings = redis, settings
        self._begin = time.perf_counter()
        self._next = 0.0

    def __call__(self, what: str, *, now: bool = False) -> None:
        """Print what was reached, once a minute or at once."""
        seconds = time.perf_counter() - self._begin
        if now or seconds >= self._next:
            self._next = seconds + 60
            load = read_load(self._redis, self._settings)
            say(
                f"  {seconds:5.0f} s: {what}; moved {load.archive.get('moved', 0)}, "
                f"Redis {load.memory >> 20} MiB, lost chunks {sum(load.ends.lost.values())}"
            )


def compute(client: httpx.Client, scans: list[Scan], seconds: float, progress: Progress) -> int:
    """Have scans computed for so long, and read each table then; returns how many slices they have."""
    end, done = time.perf_counter() + seconds, 0
    waiting = iter(scans)
    active: list[Scan] = []
    while True:
        while len(active) < AT_ONCE and time.perf_counter() < end and (scan := next(waiting, None)):
            scan.submit(client)
            active.append(scan)
        if not active:
            return done
        if active[0].has_ended(client):
            scan = active.pop(0)
            scan.digests = scan.read(client)
            assert len(scan.digests) == len(scan.lengths), f"{len(scan.digests)} slices came"
            done += len(scan.digests)
        else:
            time.sleep(0.5)
        progress(f"{done} slices computed and read")


def write(store: ResultStore, scans: list[Scan], sample: Sequence[SliceJson], progress: Progress) -> None:
    """Write those that were not computed."""
    waits, done = 0, 0
    for scan in scans:
        if not scan.is_computed:
            waits += scan.write(store, sample)
            done += len(scan.lengths)
            progress(f"{done} slices written; Redis took no more {waits} times")


def read_back(client: httpx.Client, scans: list[Scan], progress: Progress) -> int:
    """Returns how many slices came back as they were."""
    right, asked = 0, 0
    for scan in scans:
        right += sum(one == other for one, other in zip(scan.digests, scan.read(client), strict=False))
        asked += len(scan.lengths)
        progress(f"{right} of {asked} slices came back as they were")
    return right


def archived(store: ResultStore, scans: list[Scan]) -> tuple[int, list[dict[str, Any]]]:
    """Returns how many slices are in the archive, and questions for some of them, drawn at random."""
    away: list[tuple[Scan, str]] = []
    for scan in scans:
        keys = store.slice_keys(scan.request, scan.lengths)
        for first in range(0, len(keys), GROUP):
            values = store.redis.mget(keys[first : first + GROUP])
            pairs = zip(scan.lengths[first : first + GROUP], values, strict=True)
            away += [(scan, x) for x, value in pairs if value is not None and value[:1] == AWAY]
    chosen = random.Random(1).sample(away, min(ASKED, len(away)))
    return len(away), [scan.body(x) for scan, x in chosen]


def milliseconds(client: httpx.Client, bodies: Iterator[dict[str, Any]]) -> Iterator[float]:
    """Yields the time of questions for one slice each."""
    for body in bodies:
        begin = time.perf_counter()
        reply = client.post("/v1/cusp-tables", json=body, headers=WAIT).raise_for_status()
        yield 1000 * (time.perf_counter() - begin)
        assert len(reply.json()["slices"]) == 1


def fill(
    client: httpx.Client, store: ResultStore, args: argparse.Namespace, progress: Progress
) -> list[Scan]:
    """Have slices computed, write the others, and wait until nothing moves; returns all."""
    count, each = args.count, args.of_a_job
    scans = [Scan(i, min(each, count - first)) for i, first in enumerate(range(0, count, each))]
    begin = time.perf_counter()
    computed = compute(client, scans, 60 * args.minutes, progress)
    say(f"{computed} slices of {DIGITS} digits computed and read in {time.perf_counter() - begin:.0f} s")
    begin = time.perf_counter()
    sample = store.get_slices(scans[0].request, scans[0].lengths[::10])
    write(store, scans, list(sample.values()), progress)
    say(f"{count - computed} written in {time.perf_counter() - begin:.0f} s")
    before = -1
    while (moved := read_load(store.redis, store.settings).archive.get("moved", 0)) > before:
        before = moved
        progress("waiting until nothing moves", now=True)
        time.sleep(PAUSE)
    return scans


def measure(redis: Redis, args: argparse.Namespace, client: httpx.Client) -> None:
    """Print the figures."""
    store = ResultStore(redis, WorkerSettings())
    progress = Progress(redis, store.settings)
    scans = fill(client, store, args, progress)
    begin = time.perf_counter()
    right = read_back(client, scans, progress)
    seconds = time.perf_counter() - begin
    away, questions = archived(store, scans)
    say(f"{right} of {args.count} came back as they were in {seconds:.0f} s; {away} are in the archive")
    computed = [scan for scan in scans if scan.is_computed]
    others = sum(scan.differs(client) for scan in computed)
    say(f"some slices of {len(computed)} scans compared with the library's: {others} are others")
    objects = list((args.folder / "archive" / "objects").iterdir())
    size, load = sum(path.stat().st_size for path in objects), read_load(redis, store.settings)
    say(
        f"Redis uses {load.memory >> 20} of {args.maxmemory_mb} MiB; {len(objects)} objects, {size >> 20} MiB"
    )
    taken = sorted(milliseconds(client, iter(questions)))
    say(
        f"{len(taken)} archived answers, one after the other: p50 {statistics.median(taken):.1f} ms, "
        f"p95 {taken[int(0.95 * len(taken)) - 1]:.1f} ms"
    )
    load = read_load(redis, store.settings)
    say(
        f"jobs: {sum(load.ends.by_status.values())} for {len(computed)} scans; lost chunks: "
        f"{dict(load.ends.lost)}; in the archive: {load.archive}"
    )


def main() -> None:
    """Start the service and measure."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--count", type=int, default=20_000, help="slices; default: 20000")
    parser.add_argument("--of-a-job", type=int, default=10_000, help="slices of one scan; default: 10000")
    parser.add_argument("--minutes", type=float, default=60, help="of computing, about; default: 60")
    parser.add_argument("--maxmemory-mb", type=int, help="bound of Redis; default: 1000 bytes a slice")
    parser.add_argument("--folder", type=Path, help="where the archive and Redis keep their files")
    args = parser.parse_args()
    args.maxmemory_mb = args.maxmemory_mb or max(16, args.count * 1000 >> 20)
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        args.folder = Path(folder)
        os.environ["RPR_CUSPS_ARCHIVE_URL"] = f"file://{folder}/archive"
        with EmbeddedValkey(args.folder / "redis") as server, connect(server.url) as redis:
            redis.config_set("maxmemory", args.maxmemory_mb << 20)
            serve = serving("--workers", "2", "--redis-url", server.url, **LIMITS)
            with serve as stack, httpx.Client(base_url=stack.url, timeout=300) as client:
                measure(redis, args, client)


if __name__ == "__main__":
    main()
