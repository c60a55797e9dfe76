"""Two versions of the solver on one Redis, as in an upgrade."""

from __future__ import annotations

import random
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import pytest
from redis import Redis

from rpr_solver import SOLVER_VERSION, Manipulator, table_document
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, ROOT, Workers, environment, started, until
from tests.support.service_server import GEOMETRY, NO_WAIT, ended
from worker.connection import connect

OTHER = "99"
DIGITS = 40


_PARTS = ("worker", "service", "tests")


def tree_of(version: str, folder: Path) -> Path:
    """Makes a tree that differs from this one by the version of the solver alone; returns its root."""
    root = folder / f"version-{version}"
    (root / "rpr_solver").mkdir(parents=True)
    for part in _PARTS:
        (root / part).symlink_to(ROOT / part)
    for entry in (ROOT / "rpr_solver").iterdir():
        if entry.name not in ("contract.py", "__pycache__"):
            (root / "rpr_solver" / entry.name).symlink_to(entry)
    text = (ROOT / "rpr_solver" / "contract.py").read_text()
    changed, count = re.subn(r'(?m)^SOLVER_VERSION = ".*"$', f'SOLVER_VERSION = "{version}"', text)
    assert count == 1
    (root / "rpr_solver" / "contract.py").write_text(changed)
    return root


@dataclass
class Side:
    """An API process of one version of the solver, and its workers."""

    version: str
    api: httpx.Client
    workers: Workers


@contextmanager
def side(version: str, root: Path, url: str, folder: Path) -> Iterator[Side]:
    """The service of a tree, with no worker yet, on a Redis."""
    options = ("--redis-url", url, "--port", "0", "--workers", "0")
    command = [sys.executable, "-m", "service", "serve", *options]
    variables = {**environment(access_log="off"), "PYTHONPATH": str(root)}
    with started(command, tree=root, cwd=root, env=variables, stdout=subprocess.PIPE, text=True) as process:
        address = re.search(r"http://\S+", process.stdout.readline() if process.stdout else "")
        assert address is not None
        workers = Workers(url, folder / f"workers-{version}.log", root=root)
        with httpx.Client(base_url=address.group(), timeout=PATIENCE) as api:
            reply = api.get("/v1/version")
            assert reply.status_code == 200, reply.text
            assert reply.json()["solver_version"] == version
            try:
                yield Side(version, api, workers)
            finally:
                workers.stop()


@pytest.fixture(scope="module")
def both(valkey: EmbeddedValkey, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Side, Side]]:
    """The API processes of both versions."""
    with connect(valkey.url) as client:
        client.flushall()  # keys of other tests would close these services
    folder = tmp_path_factory.mktemp("versions")
    trees = {SOLVER_VERSION: ROOT, OTHER: tree_of(OTHER, folder)}
    with ExitStack() as stack:
        old, new = (
            stack.enter_context(side(version, tree, valkey.url, folder)) for version, tree in trees.items()
        )
        yield old, new


@pytest.fixture
def sides(both: tuple[Side, Side], redis: Redis) -> Iterator[tuple[Side, Side]]:  # noqa: ARG001
    """The same on an empty database, without workers."""
    yield both
    for of in both:
        of.workers.stop()


def question(number: int, slices: int) -> dict[str, Any]:
    """A table; each number stands for another manipulator."""
    geometry = {**GEOMETRY, "d1": f"17.{number + 100}"}
    return {"geometry": geometry, "l1": [f"{12 + i / 4}" for i in range(slices)], "digits": DIGITS}


def answer_to(asked: dict[str, Any], version: str) -> dict[str, Any]:
    """The answer as the library gives it."""
    texts = {name: str(value) for name, value in asked["geometry"].items()}
    table = table_document(Manipulator.from_json(texts), asked["l1"], digits=DIGITS)
    return {**table, "solver_version": version}


@pytest.mark.parametrize(
    ("jobs", "kills", "slices"),
    [
        pytest.param(4, 2, 6, marks=pytest.mark.long),
        pytest.param(200, 20, 60, marks=[pytest.mark.long, pytest.mark.timeout(1200)]),
    ],
)
def test_workers_of_two_versions_are_killed(
    redis: Redis, sides: tuple[Side, Side], jobs: int, kills: int, slices: int
) -> None:
    """Two versions have waiting and running jobs, while workers of either version are missing, killed and
    return. Each job is computed by its own version, and the API of its version gives the correct answer.
    """
    chance = random.Random(f"{jobs} {kills}")
    taken: list[tuple[Side, dict[str, Any], str]] = []
    for _ in range(kills):
        victim = chance.choice(sides)
        if not victim.workers.alive():
            victim.workers.start()
        for of in sides:
            for _ in range(jobs // (2 * kills)):
                asked = question(len(taken), slices)
                answer = of.api.post("/v1/cusp-tables", json=asked, headers=NO_WAIT)
                assert answer.status_code == 202
                taken.append((of, asked, answer.json()["id"]))
        until(partial(is_busy_or_done, redis, victim))
        time.sleep(chance.uniform(0, 0.1))
        [worker] = victim.workers.alive()
        worker.kill()
        worker.wait(PATIENCE)
        if chance.random() < 0.5:
            victim.workers.start()
    for of in sides:
        if not of.workers.alive():
            of.workers.start()

    assert len(taken) == jobs
    for of, asked, job_id in taken:
        assert ended(of.api, job_id)["status"] == "succeeded"
        result = of.api.get(f"/v1/jobs/{job_id}/result")
        assert result.json() == answer_to(asked, of.version)
    for of in sides:
        assert count(redis, f"cusps:slice:{of.version}:*") == slices * jobs / 2
        assert redis.zcard(f"cusps:active:{of.version}") == 0
    assert count(redis, "rq:queue:*") == 0


def test_a_job_is_asked_for_at_the_api_of_another_version(redis: Redis, sides: tuple[Side, Side]) -> None:
    """A job is looked up and canceled, and a batch sent again, at an API process of another version than the
    one that took it. It is unknown there, 404, and unharmed; the batch and the same question are new ones.
    """
    first, second = sides
    job = first.api.post("/v1/cusp-tables", json=question(0, 2), headers=NO_WAIT).json()
    items = {"items": [{"kind": "cusp-table", "request": question(1, 2)}]}
    once = {"Idempotency-Key": "upgrade"}
    batch = first.api.post("/v1/batches", json=items, headers=once).json()
    for here in (job["links"]["self"], batch["links"]["self"]):
        assert second.api.get(here).status_code == 404
        assert second.api.delete(here).status_code == 404
        assert first.api.get(here).json()["status"] == "queued"
    again = until(lambda: made(second.api.post("/v1/batches", json=items, headers=once)))

    for of in sides:
        of.workers.start()
    for of, asked in ((first, batch), (second, again)):
        done = until(lambda of=of, url=asked["links"]["self"]: end_of(of.api.get(url)))  # type: ignore[misc]
        assert done["status"] == "completed", done
        line = of.api.get(asked["links"]["results"]).json()
        assert line["result"] == answer_to(question(1, 2), of.version)
    assert ended(first.api, job["id"])["status"] == "succeeded"
    wait = {"Prefer": "wait=60"}
    assert (
        second.api.post("/v1/cusp-tables", json=question(0, 2), headers=wait).json()["solver_version"]
        == OTHER
    )
    assert redis.zcard(f"cusps:active:{SOLVER_VERSION}") == 0


def made(answer: httpx.Response) -> dict[str, Any] | None:
    """Returns a batch, unless the submission is taken for one that is still being received."""
    assert answer.status_code in (202, 409), answer.text
    found: dict[str, Any] = answer.json()
    return found if answer.status_code == 202 else None


def end_of(answer: httpx.Response) -> dict[str, Any] | None:
    """Returns a batch that has ended."""
    found: dict[str, Any] = answer.json()
    return None if found["status"] in ("queued", "running") else found


def is_busy_or_done(redis: Redis, of: Side) -> bool:
    """Whether a worker of a version runs a chunk, or none is left."""
    names = {
        key.removeprefix(b"rq:worker:") for key in redis.smembers(f"rq:workers:cusps-{of.version}-small")
    }
    beats = (redis.get(key) for key in redis.scan_iter("cusps:beat:*", count=1000))
    return any(name in names for name in beats) or not redis.exists(f"cusps:active:{of.version}")


def count(redis: Redis, pattern: str) -> int:
    return sum(1 for _ in redis.scan_iter(pattern, count=1000))
