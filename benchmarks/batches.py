"""A batch of many small questions over HTTP: accepted, run and fetched, and the memory that it takes.

    python -m benchmarks.batches [--items 10000] [--workers 2]

Half of the items are slices of one manipulator, half are poses. Starts the real stack (embedded Valkey,
workers, uvicorn) on a free port of 127.0.0.1 with an empty data directory, and stops it at the end.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import threading
import time
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import httpx

from benchmarks.stack import GEOMETRY, serving

WAIT = 60
ROLES = {"api_process": "API", "worker": "a worker with its horse", "valkey-server": "Valkey"}


def items(count: int) -> Iterator[bytes]:
    """Yields the batch, line by line."""
    for i in range(count):
        legs = {"l1": f"{20 + i / 1000:.3f}"}
        if i % 2:
            legs |= {"l2": "17", "l3": "21"}
        request = {"geometry": GEOMETRY, "digits": 20, **legs}
        yield json.dumps({"kind": "poses" if i % 2 else "cusp-table", "request": request}).encode() + b"\n"


class Memory(threading.Thread):
    """The largest resident memory of each child of the supervisor, with its own children, in MiB."""

    def __init__(self, pid: int) -> None:
        super().__init__(daemon=True)
        self.pid = pid
        self.peak: defaultdict[str, float] = defaultdict(float)
        self.is_over = threading.Event()

    def run(self) -> None:
        """Look until it is over."""
        while not self.is_over.wait(0.2):
            table = subprocess.run(
                ["ps", "-ww", "-eo", "pid=,ppid=,rss=,args="], capture_output=True, text=True, check=True
            )
            rows = [line.split(None, 3) for line in table.stdout.splitlines()]
            for pid, parent, size, args in rows:
                if int(parent) == self.pid:
                    role = next((text for part, text in ROLES.items() if part in args), "other")
                    whole = int(size) + sum(int(row[2]) for row in rows if row[1] == pid)
                    self.peak[role] = max(self.peak[role], whole / 1024)


def as_they_come(client: httpx.Client, batch: dict[str, Any]) -> int:
    """Reads all results as they come; returns their number."""
    count = 0
    while count < batch["total"]:
        path = f"{batch['links']['results']}?after={count - 1}"
        with client.stream("GET", path, headers={"Prefer": f"wait={WAIT}"}) as answer:
            for line in answer.iter_lines():
                result = json.loads(line)
                assert (result["index"], result["status"]) == (count, "succeeded"), line[:300]
                count += 1
    return count


def measure(client: httpx.Client, count: int) -> None:
    """Print the times."""
    begin = time.perf_counter()
    batch = client.post(
        "/v1/batches", content=items(count), headers={"Content-Type": "application/x-ndjson"}
    ).json()
    accepted = time.perf_counter()
    print(f"{count} items accepted: {accepted - begin:.1f} s")
    as_they_come(client, batch)
    done = time.perf_counter()
    print(
        f"run, and read as they came: {done - accepted:.1f} s, {count / (done - accepted):.0f} items a second"
    )
    text = client.get(batch["links"]["results"]).content
    seconds = time.perf_counter() - done
    print(f"read again: {seconds:.1f} s, {len(text) / 2**20:.0f} MiB, {text.count(b'succeeded')} results")
    again = time.perf_counter()
    batch = client.post(
        "/v1/batches", content=items(count), headers={"Content-Type": "application/x-ndjson"}
    ).json()
    as_they_come(client, batch)
    print(f"the same batch again, all known: {time.perf_counter() - again:.1f} s")


def main() -> None:
    """Print the times and the memory."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--items", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    with (
        serving("--workers", str(options.workers)) as stack,
        httpx.Client(base_url=stack.url, timeout=2 * WAIT) as client,
    ):
        memory = Memory(stack.pid)
        memory.start()
        measure(client, options.items)
        memory.is_over.set()
        memory.join()
        for role, size in sorted(memory.peak.items()):
            print(f"largest memory of {role}: {size:.0f} MiB")


if __name__ == "__main__":
    main()
