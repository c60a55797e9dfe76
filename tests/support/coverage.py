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

FLOORS = {
    "rpr_solver.errors": 99,
    "rpr_solver.notebook": 97,
    "rpr_solver.contract": 99,
    "rpr_solver.exact": 98,
    "rpr_solver.legs": 99,
    "rpr_solver.model": 97,
    "rpr_solver.slices": 98,
    "rpr_solver.transitions": 96,
    "rpr_solver.singular": 94,
    "rpr_solver.margins": 94,
    "rpr_solver.article": 97,
    "rpr_solver.curves": 96,
    "rpr_solver.paths": 95,
    "rpr_solver.designs": 84,
    "rpr_solver.modes": 93,
    "rpr_solver.exports": 98,
    "rpr_solver.verify": 94,
    "rpr_solver.figures": 98,
    "rpr_solver": 99,
    "worker.logs": 96,
    "worker.tracing": 48,
    "worker.limits": 99,
    "worker.settings": 96,
    "worker.connection": 80,
    "worker.lua": 99,
    "worker.jobs": 90,
    "worker.answers": 90,
    "worker.process": 81,
    "worker.__main__": 74,
    "service.errors": 99,
    "service.commit": 89,
    "service.schemas": 98,
    "service.webhooks": 93,
    "service.api": 96,
    "service.openapi_yaml": 87,
    "service.stack": 65,
    "service.client": 95,
    "service.cli": 95,
    "service.__main__": 99,
    "service": 99,
}
"""Room → percent of its lines: a little below what its own tests reach. The whole suite runs more."""

SETTINGS = """
[run]
source = rpr_solver, worker, service
data_file = {folder}/data
parallel = true
patch = subprocess, fork, _exit, execv
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
