"""The share of lines that the tests run, for each room: ``python -m tests.support.coverage [ARGUMENTS]``

Runs the suite on all cores, the processes that it starts included, and ends with 1 if a room is below its
floor. With arguments of pytest, a part of the suite for instance, it shows the shares and holds no floor.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from coverage import Coverage

from tests.test_rooms import FILES, MAY_IMPORT, ROOT, room_of

FLOORS: dict[str, int] = {}
"""Room → percent of its lines, a little below what was measured."""

SETTINGS = """
[run]
source = rpr_solver, worker, service
data_file = {folder}/data
parallel = true
patch = subprocess, _exit, execv
sigterm = true
"""


def shares(data: Path) -> dict[str, float]:
    """Room → percent of its statements that ran."""
    coverage = Coverage(data_file=str(data))
    coverage.combine([str(data.parent)])
    statements, missed = Counter[str](), Counter[str]()
    for module, path in FILES.items():
        _, lines, _, missing, _ = coverage.analysis2(str(path))
        statements[room_of(module)] += len(lines)
        missed[room_of(module)] += len(missing)
    return {room: 100 * (1 - missed[room] / statements[room]) for room in statements if statements[room]}


def main() -> int:
    """The command."""
    arguments = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        settings = folder / "coveragerc"
        settings.write_text(SETTINGS.format(folder=folder), encoding="utf-8")
        command = [sys.executable, "-m", "coverage", "run", f"--rcfile={settings}", "-m", "pytest"]
        outcome = subprocess.run([*command, *(arguments or ["-n", "auto", "-q"])], cwd=ROOT, check=False)
        measured = shares(folder / "data")
    below = False
    for room in MAY_IMPORT:
        if room in measured:
            floor = FLOORS.get(room, 0)
            is_below = not arguments and measured[room] < floor
            below |= is_below
            print(f"{room:24} {measured[room]:5.1f} %  floor {floor}" + ("  BELOW" if is_below else ""))
    return outcome.returncode or int(below)


if __name__ == "__main__":
    sys.exit(main())
