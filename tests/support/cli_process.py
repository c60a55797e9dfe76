"""The command line as a user runs it: a process, its output and its exit status."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

from tests.support.processes import completed, environment

ENVIRONMENT = {**environment(), "COLUMNS": "100"}
ENVIRONMENT.pop("GITHUB_ACTIONS", None)

Run = Callable[..., subprocess.CompletedProcess[str]]


def command(*args: str) -> list[str]:
    return [sys.executable, "-m", "service", *args]


def run(*args: str, stdin: str = "", **variables: str) -> subprocess.CompletedProcess[str]:
    in_full = any(name.startswith("PYTHON") for name in variables)  # which Python reads at its start
    return completed(command(*args), {**ENVIRONMENT, **variables}, stdin, in_full=in_full)
