"""The command line as a user runs it: a process, its output and its exit status."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
ENVIRONMENT = {
    **{
        key: value
        for key, value in os.environ.items()
        if not key.startswith("RPR_CUSPS_") and key != "GITHUB_ACTIONS"
    },
    "PYTHONPATH": str(ROOT),
    "COLUMNS": "100",
}


def command(*args: str) -> list[str]:
    return [sys.executable, "-m", "service", *args]


def run(*args: str, stdin: str = "", **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command(*args),
        input=stdin,
        capture_output=True,
        text=True,
        timeout=60,
        env={**ENVIRONMENT, **environment},
        check=False,
    )
