"""The whole service under load: mixed questions, a long run of cached ones, and connections that hold it up.

    python -m benchmarks.load mixed --clients 100 --seconds 60
    python -m benchmarks.load cached --clients 32 --requests 100000
    python -m benchmarks.load held --idle 10000 --slow 600

Each starts the real stack on a free port of 127.0.0.1 with an empty data directory, and stops it at the end.
The clients share the cores with it. `--at URL` loads a service of your own on this computer instead.
"""

from __future__ import annotations

import argparse
import asyncio
import itertools
import json
import os
import random
import re
import resource
import time
from collections import Counter, defaultdict
from collections.abc import Awaitable, Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import urlsplit

from benchmarks.stack import GEOMETRY, serving
from service.stack.embedded_valkey import EmbeddedValkey

CACHED = {"geometry": GEOMETRY, "l1": "14.98"}

_fresh = itertools.count(random.randrange(10**9))


class Connection:
    """One HTTP/1.1 connection, opened again when the service closes it; far cheaper than a full client."""

    def __init__(self, port: int) -> None:
        self.port = port
        self.streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    async def call(
        self, method: str, path: str, body: object = None, headers: Mapping[str, str] | None = None
    ) -> tuple[int, bytes]:
        """Returns the status and the body of the answer."""
        if self.streams is None:
            self.streams = await asyncio.open_connection("127.0.0.1", self.port)
        reader, writer = self.streams
        content = b"" if body is None else json.dumps(body).encode()
        lines = [
            f"{method} {path} HTTP/1.1",
            "Host: 127.0.0.1",
            "Content-Type: application/json",
            f"Content-Length: {len(content)}",
        ]
        lines += [f"{name}: {value}" for name, value in (headers or {}).items()]
        writer.write("\r\n".join(lines).encode() + b"\r\n\r\n" + content)
        head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").lower()
        if (length := re.search(r"\ncontent-length: (\d+)", head)) is not None:
            answer = await reader.readexactly(int(length[1]))
        else:
            answer = b"".join([chunk async for chunk in chunks(reader)])
        if "\nconnection: close" in head:
            writer.close()
            self.streams = None
        return int(head.split()[1]), answer


async def chunks(reader: asyncio.StreamReader) -> Any:
    """Yields the parts of a chunked body."""
    while size := int(await reader.readline(), 16):
        yield (await reader.readexactly(size + 2))[:-2]
    await reader.readline()


def new_geometry() -> dict[str, str]:
    """Returns a manipulator that nobody has asked for."""
    return {**GEOMETRY, "a3y": f"10.{next(_fresh):012d}"}


async def cached(connection: Connection) -> int:
    """A table that is known."""
    return (await connection.call("POST", "/v1/cusp-tables", CACHED))[0]


async def ready(connection: Connection) -> int:
    """The state of the service."""
    return (await connection.call("GET", "/readyz"))[0]


async def cold_job(connection: Connection) -> int:
    """A table of a new manipulator, as a job."""
    question = {"geometry": new_geometry(), "l1": "14.98", "digits": 30}
    return (await connection.call("POST", "/v1/cusp-tables", question))[0]


async def cold_wait(connection: Connection) -> int:
    """The same, and the client waits."""
    question = {"geometry": new_geometry(), "l1": "14.98", "digits": 30}
    return (await connection.call("POST", "/v1/cusp-tables", question, {"Prefer": "wait=30"}))[0]


async def poses(connection: Connection) -> int:
    """The poses of a new joint vector."""
    lengths = {"l1": "14.98", "l2": f"16.{next(_fresh):012d}", "l3": "20"}
    return (await connection.call("POST", "/v1/poses", {"geometry": GEOMETRY, **lengths}))[0]


KINDS: Mapping[str, tuple[Callable[[Connection], Awaitable[int]], int]] = {
    "POST cached": (cached, 8),
    "GET /readyz": (ready, 4),
    "POST cold, 202": (cold_job, 1),
    "POST cold, wait=30": (cold_wait, 2),
    "POST poses": (poses, 1),
}
"""What the clients of the mixed load do, and how often."""


class Times:
    """The durations and statuses of calls."""

    def __init__(self) -> None:
        self.seconds: dict[str, list[float]] = defaultdict(list)
        self.statuses: dict[str, Counter[str]] = defaultdict(Counter)

    async def take(self, kind: str, call: Callable[[], Awaitable[int]]) -> None:
        """Call once."""
        start = time.perf_counter()
        try:
            status = str(await call())
        except (OSError, asyncio.IncompleteReadError, ValueError) as error:
            status = type(error).__name__
        self.seconds[kind].append(time.perf_counter() - start)
        self.statuses[kind][status] += 1

    def show(self) -> None:
        """Print the table."""
        print("| call | count | p50 ms | p95 | p99 | max | statuses |\n|---|---|---|---|---|---|---|")
        for kind, seconds in self.seconds.items():
            ranked = sorted(1000 * x for x in seconds)
            figures = " | ".join(
                f"{ranked[int(part * (len(ranked) - 1))]:.1f}" for part in (0.5, 0.95, 0.99, 1)
            )
            statuses = ", ".join(f"{count} × {status}" for status, count in self.statuses[kind].items())
            print(f"| {kind} | {len(ranked)} | {figures} | {statuses} |")


async def mixed(port: int, args: argparse.Namespace) -> None:
    """Closed-loop clients, each doing one thing after another."""
    times, end = Times(), time.monotonic() + args.seconds
    names = [name for name, (_, weight) in KINDS.items() for _ in range(weight)]

    async def client(seed: int) -> None:
        connection, choice = Connection(port), random.Random(seed)
        await asyncio.sleep(choice.uniform(0, args.ramp))
        while time.monotonic() < end:
            name = choice.choice(names)
            if args.pause:
                await asyncio.sleep(choice.uniform(0, 2 * args.pause))
            await times.take(name, lambda name=name: KINDS[name][0](connection))  # type: ignore[misc]

    await asyncio.gather(*(client(i) for i in range(args.clients)))
    times.show()


async def many_cached(port: int, args: argparse.Namespace) -> None:
    """Cached answers, one after another."""
    times, left = Times(), iter(range(args.requests))

    async def client(port: int) -> None:
        connection = Connection(port)
        for _ in left:
            await times.take("POST cached", lambda: cached(connection))

    ports = itertools.islice(itertools.cycle([port, *args.others]), args.clients)
    start = time.perf_counter()
    await asyncio.gather(*map(client, ports))
    times.show()
    print(f"{args.requests / (time.perf_counter() - start):.0f} requests a second")


async def held(port: int, args: argparse.Namespace) -> None:
    """Idle and slow connections, and what is left to others beside them."""
    opened: list[asyncio.StreamWriter] = []
    for i in range(args.idle + args.slow):
        _, writer = await asyncio.open_connection("127.0.0.1", port)
        if i >= args.idle:
            half = b"POST /v1/cusp-tables HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            writer.write(half if i % 2 else half + b"Content-Length: 1000\r\n\r\n{")
        opened.append(writer)
    times = Times()
    for _ in range(50):
        connection = Connection(port)
        await times.take("POST cached, new connection", lambda c=connection: cached(c))  # type: ignore[misc]
    times.show()
    for writer in opened:
        writer.close()


def use(root: int) -> str:
    """Returns the memory and processor time of a process and its descendants, where /proc tells them."""
    parents: dict[int, int] = {}
    sizes: dict[int, tuple[str, float, float]] = {}
    ticks = os.sysconf("SC_CLK_TCK")
    for path in Path("/proc").glob("[0-9]*"):
        try:
            status = dict(
                line.split(":", 1) for line in (path / "status").read_text().splitlines() if ":" in line
            )
            times = (path / "stat").read_text().rpartition(")")[2].split()[11:13]
            command = (path / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:
            continue
        parents[int(path.name)] = int(status["PPid"])
        what = re.search(r"template|api_process|valkey|worker|serve", command)
        sizes[int(path.name)] = (
            what[0] if what else status["Name"].strip(),
            int(status.get("VmRSS", "0").split()[0]) / 1024,
            sum(map(int, times)) / ticks,
        )
    family = {root}
    while more := {pid for pid, parent in parents.items() if parent in family} - family:
        family |= more
    return ", ".join(
        f"{name} {size:.1f} MiB {seconds:.1f} s"
        for name, size, seconds in sorted(sizes[p] for p in family if p in sizes)
    )


def main() -> None:
    """Run one of the loads."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("load", choices=["mixed", "cached", "held"])
    parser.add_argument("--clients", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=60, help="of the mixed load")
    parser.add_argument("--ramp", type=float, default=5, help="seconds in which the clients of it come")
    parser.add_argument("--pause", type=float, default=0.0, help="mean seconds between two calls of a client")
    parser.add_argument("--apis", type=int, default=1, help="API processes for the cached ones")
    parser.add_argument("--requests", type=int, default=100_000, help="cached ones in all")
    parser.add_argument("--idle", type=int, default=10_000, help="connections that send nothing")
    parser.add_argument("--slow", type=int, default=600, help="connections that send half a request")
    parser.add_argument("--at", help="address of a running service on this computer")
    args = parser.parse_args()
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    load = {"mixed": mixed, "cached": many_cached, "held": held}[args.load]
    args.others = []
    if args.at:
        asyncio.run(load(urlsplit(args.at).port or 80, args))
        return
    with ExitStack() as services:
        folder = services.enter_context(TemporaryDirectory())
        server = services.enter_context(EmbeddedValkey(Path(folder)))
        stacks = [
            services.enter_context(serving("--redis-url", server.url, "--workers", workers))
            for workers in ("2", *["0"] * (args.apis - 1))
        ]
        for stack in stacks:
            asyncio.run(known(stack.port))
            print("before:", use(stack.pid))
        args.others = [stack.port for stack in stacks[1:]]
        asyncio.run(load(stacks[0].port, args))
        for stack in stacks:
            print("after:", use(stack.pid))


async def known(port: int) -> None:
    """Have the cached table computed."""
    assert await Connection(port).call("POST", "/v1/cusp-tables", CACHED, {"Prefer": "wait=30"})


if __name__ == "__main__":
    main()
