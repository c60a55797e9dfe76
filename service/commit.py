"""The commit of the code that runs: noted when it was built, or that of the checkout that it runs in.

`setup.py` uses this file too, before anything is installed: it imports no other module of this project.
"""

from __future__ import annotations

import os
import re
import subprocess
from functools import cache
from pathlib import Path

FILE = "commit.txt"
"""In the package, when it was built: the commit, and its time in seconds since 1970."""

ROOT = Path(__file__).parents[1]

_COMMIT = re.compile(r"([0-9a-f]{40})(-dirty)?")
_PATIENCE = 5.0


@cache
def commit() -> str | None:
    """Returns the commit, with `-dirty` if files were changed after it; None if it is unknown."""
    noted = note_of(ROOT)
    return None if noted is None else noted.partition(" ")[0]


def note_of(root: Path) -> str | None:
    """Returns what is known of the source in a folder, by an earlier build, else by git; or None."""
    try:
        return (root / "service" / FILE).read_text(encoding="ascii").strip()
    except (OSError, ValueError):
        pass
    if not (root / ".git").exists():
        return None
    found = _git(root, "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")
    time = _git(root, "log", "-1", "--format=%ct")
    return f"{found} {time}" if _COMMIT.fullmatch(found) and time.isdigit() else None


def _git(root: Path, *words: str) -> str:
    """Returns what git says, or an empty text."""
    outside = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    try:
        done = subprocess.run(
            ["git", "-C", str(root), *words],
            env={**outside, "GIT_OPTIONAL_LOCKS": "0"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=_PATIENCE,
            check=False,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.decode("ascii", "replace").strip() if done.returncode == 0 else ""
