"""Memory of the API by readers: of a large result, of one that is never read, and of one job's events.

    python -m benchmarks.readers [--slices 2000] [--digits 1000]

Starts an embedded Valkey and an API without workers on 127.0.0.1, puts a table of copies of one slice into
the store, and stops both at the end.
"""

from __future__ import annotations

import argparse
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from fractions import Fraction
from pathlib import Path

import rpr_solver
from benchmarks.stack import serving
from service.stack.embedded_valkey import EmbeddedValkey
from worker.answers import JobRequest
from worker.answers.store import packed
from worker.answers.tables import CUSP_TABLE
from worker.connection import connect
from worker.jobs.attempts import Attempts
from worker.jobs.queue import JobQueue

MANIPULATOR = rpr_solver.EXAMPLES["innocenti"]
SECONDS = 60


def memory(pid: int) -> float:
    """Resident MiB of a process and its children."""
    command = ["ps", "-eo", "pid=,ppid=,rss="]
    table = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    rows = [tuple(map(int, line.split())) for line in table.splitlines()]
    family = {pid} | {child for child, parent, _ in rows if parent == pid}
    return sum(size for child, _, size in rows if child in family) / 1024


def known_table(queue: JobQueue, slices: int, digits: int) -> str:
    """Put a table into the store; returns the id of its job."""
    l1 = [str(10 + i) for i in range(slices)]
    content = {"geometry": MANIPULATOR.to_json(), "fixed_leg": 1, "digits": digits, "l1": l1}
    request = JobRequest(CUSP_TABLE, content)
    one = rpr_solver.slice_json(rpr_solver.eliminate(MANIPULATOR), Fraction("14.98"), digits)
    for x, key in zip(l1, queue.store.slice_keys(request, l1), strict=True):
        queue.redis.set(key, packed({**one, "l1": x}))
    return queue.submit(request).id


def running_job(queue: JobQueue, slices: int, digits: int) -> tuple[str, Callable[[], None]]:
    """Begin a job; returns its id, and what does it."""
    l1 = [str(10_000 + i) for i in range(slices)]
    content = {"geometry": MANIPULATOR.to_json(), "fixed_leg": 1, "digits": digits, "l1": l1}
    request = JobRequest(CUSP_TABLE, content)
    job_id = queue.submit(request).id
    one = rpr_solver.slice_json(rpr_solver.eliminate(MANIPULATOR), Fraction("14.98"), digits)

    def run() -> None:
        attempts = Attempts(queue.redis, queue.settings, queue.store)
        for ref, entry in queue.records.open_chunks([job_id])[job_id].items():
            chunk = attempts.start(ref, entry.first, entry.last)
            assert chunk is not None
            for position, x in zip(chunk.positions, chunk.parts, strict=True):
                attempts.put_slices(ref, chunk, [position], [{**one, "l1": x}])
                time.sleep(0.005)

    return job_id, run


class Readers:
    """Clients that ask for the same, and read everything or nothing."""

    def __init__(self, port: int, path: str, count: int) -> None:
        self.done: list[int] = []
        self._stack = ExitStack()
        ask = f"GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode()
        self.sockets = []
        for _ in range(count):
            client = self._stack.enter_context(closing(socket.create_connection(("127.0.0.1", port))))
            client.settimeout(SECONDS)
            client.sendall(ask)
            self.sockets.append(client)

    def read(self) -> list[threading.Thread]:
        """Read everything, each in a thread."""
        threads = [threading.Thread(target=self._drain, args=(client,)) for client in self.sockets]
        for thread in threads:
            thread.start()
        return threads

    def _drain(self, client: socket.socket) -> None:
        size = 0
        while part := client.recv(1 << 16):
            size += len(part)
        self.done.append(size)

    def close(self) -> None:
        self._stack.close()


def peak(pid: int, is_over: Callable[[], bool]) -> float:
    """The largest memory until something is over."""
    highest, end = 0.0, time.monotonic() + SECONDS
    while not is_over() and time.monotonic() < end:
        highest = max(highest, memory(pid))
        time.sleep(0.1)
    return highest


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--slices", type=int, default=2000)
    parser.add_argument("--digits", type=int, default=1000)
    options = parser.parse_args()
    with ExitStack() as stack:
        valkey = stack.enter_context(EmbeddedValkey(Path(stack.enter_context(tempfile.TemporaryDirectory()))))
        api = stack.enter_context(serving("--workers", "0", "--redis-url", valkey.url))
        port, pid = api.port, api.pid
        with connect(valkey.url) as redis:
            queue = JobQueue(redis)
            path = f"/v1/jobs/{known_table(queue, options.slices, options.digits)}/result"
            print(f"{'API at rest':<45}{memory(pid):8.0f} MiB")
            for count in (1, 20):
                readers = Readers(port, path, count)
                begin = time.monotonic()
                threads = readers.read()
                high = peak(pid, lambda threads=threads: not any(t.is_alive() for t in threads))  # type: ignore[misc]
                seconds, size = time.monotonic() - begin, max(readers.done) / 2**20
                print(f"{f'{count} readers of {size:.0f} MiB, {seconds:.1f} s':<45}{high:8.0f} MiB")
                readers.close()
            readers = Readers(port, path, 20)
            end = time.monotonic() + 5
            high = peak(pid, lambda: time.monotonic() > end)
            print(f"{'20 readers that never read':<45}{high:8.0f} MiB")
            readers.close()
            for count in (200, 300):
                job_id, run = running_job(queue, 200, 500 + count)
                readers = Readers(port, f"/v1/jobs/{job_id}/events", count)
                threads = readers.read()
                work = threading.Thread(target=run)
                work.start()
                high = peak(pid, lambda threads=threads: not any(t.is_alive() for t in threads))  # type: ignore[misc]
                size = sum(readers.done) / len(readers.done) / 2**20
                print(f"{f'{count} followers of a job, {size:.1f} MiB each':<45}{high:8.0f} MiB")
                readers.close()
            time.sleep(1)
            print(f"{'API afterwards':<45}{memory(pid):8.0f} MiB")


if __name__ == "__main__":
    main()
