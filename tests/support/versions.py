"""The whole program with another version of the solver, as its own tree of files."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx

from tests.support.processes import PATIENCE, ROOT, Workers, environment, started

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
def side(version: str, root: Path, url: str, folder: Path, **settings: object) -> Iterator[Side]:
    """The service of a tree, with no worker yet, on a Redis."""
    options = ("--redis-url", url, "--port", "0", "--workers", "0")
    command = [sys.executable, "-m", "service", "serve", *options]
    variables = {**environment(access_log="off", **settings), "PYTHONPATH": str(root)}
    with started(command, tree=root, cwd=root, env=variables, stdout=subprocess.PIPE, text=True) as process:
        address = re.search(r"http://\S+", process.stdout.readline() if process.stdout else "")
        assert address is not None
        workers = Workers(url, folder / f"workers-{version}.log", root=root)
        with httpx.Client(base_url=address.group(), timeout=PATIENCE) as api:
            reply = api.get("/version")
            assert reply.status_code == 200, reply.text
            assert reply.json()["solver_version"] == version
            try:
                yield Side(version, api, workers)
            finally:
                workers.stop()
