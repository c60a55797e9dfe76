"""The whole service over HTTP: a long scan, and cached answers compared with the cheapest call.

Small calls are sent by `http.client`, which takes a quarter of a millisecond itself, a third of httpx.

    python -m benchmarks.service

Starts the real stack (embedded Valkey, a worker per core, uvicorn) on a free port of 127.0.0.1 with an empty
data directory, and stops it at the end.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import time
from contextlib import closing
from http.client import HTTPConnection

import httpx

from benchmarks.stack import GEOMETRY, serving

SCAN = {"geometry": GEOMETRY, "l1": {"from": "0.1", "to": "50.1", "step": "0.1"}}
ONE = {"geometry": GEOMETRY, "l1": "14.98"}
CALLS = 200


def milliseconds(connection: HTTPConnection, method: str, path: str, body: object = None) -> float:
    """Returns the median wall time of a call."""
    sent = None if body is None else json.dumps(body)
    samples = []
    for _ in range(CALLS):
        start = time.perf_counter()
        connection.request(
            method, path, sent, {"Content-Type": "application/json", "Accept-Encoding": "gzip"}
        )
        answer = connection.getresponse()
        answer.read()
        samples.append(1000 * (time.perf_counter() - start))
        assert answer.status == 200, answer.status
    return statistics.median(samples)


def scan(client: httpx.Client) -> tuple[float, int, int]:
    """Returns the seconds for 501 slices, the number of answers, and the number of progress values seen."""
    start = time.perf_counter()
    asked = client.post("/v1/cusp-tables", json=SCAN, headers={"Prefer": "respond-async"})
    job = asked.raise_for_status().json()
    seen = set()
    while job["status"] in ("queued", "running"):
        time.sleep(0.05)
        job = client.get(job["links"]["self"]).raise_for_status().json()
        if 0 < job["progress"]["done"] < job["progress"]["total"]:
            seen.add(job["progress"]["done"])
    table = client.get(job["links"]["result"]).raise_for_status().json()
    return time.perf_counter() - start, len(table["slices"]), len(seen)


def main() -> None:
    """Print the table."""
    form = argparse.RawDescriptionHelpFormatter
    argparse.ArgumentParser(description=__doc__, formatter_class=form).parse_args()
    begin = time.perf_counter()
    with serving() as stack, httpx.Client(base_url=stack.url, timeout=60) as client:
        print(f"ready after {time.perf_counter() - begin:.2f} s, {os.cpu_count()} cores")
        seconds, slices, seen = scan(client)
        print(f"{slices} slices at 90 digits: {seconds:.2f} s, progress seen {seen} times")
        seconds, slices = cached_scan(client)
        print(f"the same {slices} slices from the cache: {seconds:.2f} s")
        client.post("/v1/cusp-tables", json=ONE, headers={"Prefer": "wait=30"}).raise_for_status()
        with closing(HTTPConnection("127.0.0.1", stack.port)) as connection:
            health = milliseconds(connection, "GET", "/healthz")
            cached = milliseconds(connection, "POST", "/v1/cusp-tables", ONE)
        against = f"{cached / health:.1f} × GET /healthz ({health:.2f} ms)"
        print(f"POST of a cached slice: {cached:.2f} ms, {against}")


def cached_scan(client: httpx.Client) -> tuple[float, int]:
    """Repeats the scan, which one POST answers; returns the seconds and the number of slices."""
    start = time.perf_counter()
    response = client.post("/v1/cusp-tables", json=SCAN)
    assert response.status_code == 200, response.status_code
    return time.perf_counter() - start, len(response.json()["slices"])


if __name__ == "__main__":
    main()
