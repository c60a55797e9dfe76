"""A batch of many small questions over HTTP: accepted, run and fetched, and the memory that it takes.

    python -m benchmarks.batches [--items 10000] [--workers 2] [--of slices]

Half of the items are slices of one manipulator, half are poses; or each is about another manipulator: one
slice of it, or its census. Then as many processes as there are workers answer the same questions by the
library, before the service, and all answers are compared. Starts the real stack (embedded Valkey, workers,
uvicorn) on a free port of 127.0.0.1 with an empty data directory, and stops it at the end.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import random
import subprocess
import threading
import time
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import httpx

from benchmarks.overhead import processor_seconds
from benchmarks.stack import GEOMETRY, Stack, serving
from rpr_solver import Manipulator, census, table_document

WAIT = 60
NDJSON = {"Content-Type": "application/x-ndjson"}
ROLES = {"api_process": "API", "worker": "a worker with its horse", "valkey-server": "Valkey"}


Question = dict[str, Any]


def different(of: str, count: int) -> list[Question]:
    """Questions about as many random manipulators, with sides of four digits."""
    rng = random.Random(24)
    questions: list[Question] = []
    while len(questions) < count:
        sides = [f"{rng.randint(1000, 4000) / 100:.2f}" for _ in range(6)]
        sides[1] = rng.choice(("", "-")) + sides[1]
        d = sorted(map(float, sides[3:]))
        if d[2] < d[0] + d[1]:
            geometry = dict(zip(GEOMETRY, sides, strict=True))
            legs = {"l1": f"{rng.randint(500, 4000) / 100:.2f}"} if of == "slices" else {}
            kind = "cusp-table" if of == "slices" else "census"
            questions.append({"kind": kind, "request": {"geometry": geometry, "digits": 20, **legs}})
    return questions


def by_library(question: Question) -> tuple[float, dict[str, Any]]:
    """The processor time and the answer without the service."""
    begin = time.process_time()
    answer = answered(question)
    return time.process_time() - begin, answer


def answered(question: Question) -> dict[str, Any]:
    """The answer without the service."""
    request = question["request"]
    manipulator = Manipulator.from_json(request["geometry"])
    if question["kind"] == "census":
        return census(manipulator, digits=request["digits"]).to_json()
    return table_document(manipulator, request["l1"], digits=request["digits"])


def alone(questions: list[Question], workers: int) -> tuple[float, list[tuple[float, dict[str, Any]]]]:
    """The seconds that as many processes take for all answers, once they have started; and the answers."""
    with multiprocessing.Pool(workers) as pool:
        pool.map(by_library, questions[: 4 * workers], 1)
        begin = time.perf_counter()
        answers = pool.map(by_library, questions, 4)
        return time.perf_counter() - begin, answers


def submitted(client: httpx.Client, questions: list[Question]) -> dict[str, Any]:
    """Sends a batch."""
    lines = b"".join(json.dumps(question).encode() + b"\n" for question in questions)
    batch: dict[str, Any] = client.post("/v1/batches", content=lines, headers=NDJSON).json()
    return batch


def compare(stack: Stack, client: httpx.Client, questions: list[Question], workers: int) -> None:
    """Print the rates and the processor time of the library and of a batch, and how many answers differ.

    Both have answered a few questions before, so that no start is counted.
    """
    warm, questions = questions[: 4 * workers], questions[4 * workers :]
    seconds, answers = alone(questions, workers)
    count = len(questions)
    as_they_come(client, submitted(client, warm))
    each = 1000 * sum(used for used, _ in answers) / count
    print(f"library, {workers} processes: {count / seconds:.1f} a second, {each:.2f} ms of a processor each")
    before, begin = processor_seconds(stack), time.perf_counter()
    batch = submitted(client, questions)
    print(f"accepted in {time.perf_counter() - begin:.1f} s")
    as_they_come(client, batch)
    took, used = time.perf_counter() - begin, processor_seconds(stack)
    print(f"batch: {count / took:.1f} a second, {100 * seconds / took:.0f} % of the library's rate")
    print("ms of a processor for each:", {k: round(1000 * (used[k] - before[k]) / count, 2) for k in used})
    text = client.get(batch["links"]["results"]).text
    found = [json.loads(line)["result"] for line in text.splitlines()]
    print(
        f"other answers than the library's: {sum(a != b for a, (_, b) in zip(found, answers, strict=True))}"
    )


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
    """Reads all results as they come, and returns their number (a look at them would take time)."""
    count = 0
    while count < batch["progress"]["total"]:
        path = f"{batch['links']['results']}?after={count - 1}"
        with client.stream("GET", path, headers={"Prefer": f"wait={WAIT}"}) as answer:
            count += sum(piece.count(b"\n") for piece in answer.iter_raw())
    return count


def measure(client: httpx.Client, count: int) -> None:
    """Print the times."""
    begin = time.perf_counter()
    batch = client.post("/v1/batches", content=items(count), headers=NDJSON).json()
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
    batch = client.post("/v1/batches", content=items(count), headers=NDJSON).json()
    as_they_come(client, batch)
    print(f"the same batch again, all known: {time.perf_counter() - again:.1f} s")


def main() -> None:
    """Print the times and the memory."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--items", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--of", choices=("mixed", "slices", "censuses"), default="mixed")
    options = parser.parse_args()
    with (
        serving("--workers", str(options.workers)) as stack,
        httpx.Client(base_url=stack.url, timeout=2 * WAIT) as client,
    ):
        memory = Memory(stack.pid)
        memory.start()
        if options.of == "mixed":
            measure(client, options.items)
        else:
            questions = different(options.of, options.items + 4 * options.workers)
            compare(stack, client, questions, options.workers)
        memory.is_over.set()
        memory.join()
        for role, size in sorted(memory.peak.items()):
            print(f"largest memory of {role}: {size:.0f} MiB")


if __name__ == "__main__":
    main()
