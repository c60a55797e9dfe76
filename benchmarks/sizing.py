"""What a worker does in a second, and what Redis keeps of it: the figures of docs/operating.md.

    python -m benchmarks.sizing

Starts an embedded Valkey and one worker in an empty data directory, and stops both at the end.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from rpr_solver import EXAMPLES
from service.stack.embedded_valkey import EmbeddedValkey
from worker.answers import JobRequest
from worker.answers.censuses import CENSUS
from worker.answers.kind import ALL_LENGTHS
from worker.answers.tables import CUSP_TABLE
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.jobs.upkeep import Inventory
from worker.process.pool import WorkerPool
from worker.settings import WorkerSettings

DIGITS = 90
JOBS = 20
SLICES = 200


def manipulator(number: int) -> dict[str, str]:
    """Returns one of many manipulators that are near the example."""
    return {**EXAMPLES["innocenti"].to_json(), "a3y": f"10.{number:04}"}


def table(number: int, *l1: str) -> JobRequest:
    """Returns a request for slices of such a manipulator."""
    content = {"geometry": manipulator(number), "fixed_leg": 1, "digits": DIGITS, "l1": list(l1)}
    return JobRequest(CUSP_TABLE, content)


def census(number: int) -> JobRequest:
    """Returns a request for the census of such a manipulator."""
    content = {"geometry": manipulator(number), "fixed_leg": 1, "digits": DIGITS, "range": ALL_LENGTHS}
    return JobRequest(CENSUS, content)


def seconds(queue: JobQueue, *requests: JobRequest) -> float:
    """Returns the time from the first request to the last answer."""
    begin = time.perf_counter()
    waiting = [queue.submit(request).id for request in requests]
    while waiting:
        view = queue.get(waiting[-1])
        assert view is not None
        assert view.status != "failed", view.error
        if view.is_terminal:
            waiting.pop()
        else:
            time.sleep(0.01)
    return time.perf_counter() - begin


def measure(queue: JobQueue) -> None:
    """Print the figures."""
    seconds(queue, table(0, "27"))  # the first job of a worker is slower
    taken = seconds(queue, *(table(i, "27") for i in range(1, JOBS + 1)))
    print(f"{JOBS} jobs of one slice, each of another manipulator: {JOBS / taken:.1f} jobs/s per worker")
    taken = seconds(queue, table(1, *(f"{10 + i / 10}" for i in range(SLICES))))
    print(f"one job of {SLICES} slices of one manipulator: {SLICES / taken:.0f} slices/s per worker")
    taken = seconds(queue, *(census(i) for i in range(1, 4)))
    print(f"3 censuses: {3 / taken:.2f} jobs/s per worker")
    for kind, stock in Inventory(queue.redis, queue.settings).stock().items():
        print(f"{stock.keys:5} keys of the kind {kind}: {stock.size / stock.keys:.0f} bytes each")


def main() -> None:
    """Start the two processes and measure."""
    with tempfile.TemporaryDirectory() as data, EmbeddedValkey(Path(data)) as server:
        pool = WorkerPool(1, server.url, "WARNING")
        pool.start()
        try:
            with connect(server.url) as redis:
                measure(JobQueue(redis, WorkerSettings()))
        finally:
            pool.stop()


if __name__ == "__main__":
    main()
