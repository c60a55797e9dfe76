"""What each part of a service spends on each kind of question: the table of docs/performance.md.

    python -m benchmarks.parts [--jobs 40] [--json FILE]

A service with one worker runs beside a Valkey of its own. For each kind, so many questions are asked one
after the other (a scan has ten times as many slices, in one job). Processor time of API, worker and Valkey,
commands of Redis (those inside scripts too, without those of an idle service) and bytes that stay are divided
by their number. `--json` writes
the figures for `benchmarks.installations`. On a busy machine, `chrt --rr 10` before it helps (as root).
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
from redis import Redis

from benchmarks.overhead import processor_seconds
from benchmarks.stack import GEOMETRY, Stack, serving
from service.stack.embedded_valkey import EmbeddedValkey
from worker.connection import connect

WAIT = {"Prefer": "wait=30"}
SLICES = 10  # of a scan for each job
SETTLED = 0.4  # seconds after the last answer, in which its chunk ends
IDLE = 5.0  # seconds in which the commands of an idle service are counted
PARTS = ("api", "worker", "valkey", "commands", "bytes")


def other(number: int) -> dict[str, str]:
    """Returns one of many manipulators that are near the first."""
    return {**GEOMETRY, "a3y": f"10.{number:06}1"}


def scan(count: int, digits: int) -> dict[str, Any]:
    """Returns a question for so many slices."""
    return {
        "geometry": GEOMETRY,
        "digits": digits,
        "l1": [f"{10 + i / 100:.2f}{digits}" for i in range(count)],
    }


def commands(redis: Redis) -> int:
    """Returns the number of commands that Redis has run."""
    return sum(entry["calls"] for entry in redis.info("commandstats").values())


def of_idle_service(redis: Redis) -> float:
    """Returns the commands in a second while nobody asks anything."""
    time.sleep(SETTLED)
    before = commands(redis)
    time.sleep(IDLE)
    return (commands(redis) - before) / IDLE


@contextmanager
def spent(stack: Stack, redis: Redis, count: int, found: dict[str, float], idle: float) -> Iterator[None]:
    """Puts into `found` what a block spends on each of so many questions: milliseconds, commands, bytes.

    `idle`: the commands of an idle service, in a second.
    """

    def now() -> dict[str, float]:
        used, cpu, memory = processor_seconds(stack), redis.info("cpu"), redis.info("memory")
        return {
            "api": 1000 * used.get("api", 0.0),
            "worker": 1000 * used.get("worker", 0.0),
            "valkey": 1000 * (cpu["used_cpu_user"] + cpu["used_cpu_sys"]),
            "commands": commands(redis) - idle * time.perf_counter(),
            "bytes": memory["used_memory"],
        }

    before, begin = now(), time.perf_counter()
    yield
    found["seconds"] = (time.perf_counter() - begin) / count
    time.sleep(SETTLED)
    after = now()
    found |= {part: (after[part] - before[part]) / count for part in PARTS}


def kinds(client: httpx.Client, jobs: int) -> Mapping[str, tuple[int, Callable[[], None]]]:
    """Returns for each kind how many questions it has, and what asks them."""

    def each(path: str, bodies: list[Any]) -> Callable[[], None]:
        def ask() -> None:
            for body in bodies:
                answer = client.post(path, json=body, headers=WAIT).raise_for_status()
                while answer.json().get("status") in ("queued", "running"):
                    time.sleep(0.2)
                    answer = client.get(answer.json()["links"]["self"]).raise_for_status()

        return ask

    few = max(3, jobs // 10)
    slices = [{"geometry": other(i), "l1": "14.98", "digits": 15} for i in range(2 * jobs)]
    poses = [{"geometry": GEOMETRY, "l1": "14.98", "l2": f"16.{i:06}1", "l3": "30"} for i in range(jobs)]
    items = [{"kind": "cusp-table", "request": body} for body in slices[jobs:]]
    return {
        "slice of a scan, 15 digits": (SLICES * jobs, each("/v1/cusp-tables", [scan(SLICES * jobs, 15)])),
        "slice of a scan, 90 digits": (SLICES * jobs, each("/v1/cusp-tables", [scan(SLICES * jobs, 90)])),
        "one slice of a new manipulator": (jobs, each("/v1/cusp-tables", slices[:jobs])),
        "the same, as an item of a batch": (jobs, each("/v1/batches", [{"items": items}])),
        "poses": (jobs, each("/v1/poses", poses)),
        "census of a new manipulator": (
            few,
            each("/v1/censuses", [{"geometry": other(900_000 + i), "digits": 15} for i in range(few)]),
        ),
        "known answer": (10 * jobs, each("/v1/poses", poses * 10)),
    }


def table(figures: Mapping[str, Mapping[str, float]]) -> str:
    """Returns the figures as a table."""
    lines = [
        "| question | worker ms | Valkey ms | API ms | commands | bytes kept |",
        "|---|---|---|---|---|---|",
    ]
    for name, of in figures.items():
        times = " | ".join(f"{of[part]:.2f}" for part in ("worker", "valkey", "api"))
        lines.append(f"| {name} | {times} | {of['commands']:.1f} | {max(0.0, of['bytes']):.0f} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, and print the table."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--jobs", type=int, default=40, help="questions of a kind; default: 40")
    parser.add_argument("--json", type=Path, help="where the figures go")
    args = parser.parse_args()
    figures: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder, EmbeddedValkey(Path(folder)) as server:
        serve = serving("--workers", "1", "--redis-url", server.url, MAX_SLICES="100000")
        with connect(server.url) as redis, serve as stack, httpx.Client(base_url=stack.url) as client:
            client.timeout = httpx.Timeout(120)
            for path, body in (("/v1/poses", {"l2": "15", "l3": "30"}), ("/v1/cusp-tables", {})):
                first = {"geometry": other(999_999), "l1": "20", **body}
                client.post(path, json=first, headers=WAIT).raise_for_status()
            idle = of_idle_service(redis)
            for name, (count, act) in kinds(client, args.jobs).items():
                figures[name] = {}
                with spent(stack, redis, count, figures[name], idle):
                    act()
    print(table(figures))
    if args.json:
        args.json.write_text(json.dumps(figures, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
