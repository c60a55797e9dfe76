"""`python -m tests.support.odd_worker VERSION SECONDS …`: a worker with another version of the solver, and
with its own limit on how long Redis may take to answer."""

from __future__ import annotations

import importlib
import sys

import rpr_solver
import worker.connection


def main() -> int:
    """Run the worker with the other arguments."""
    version, seconds = sys.argv[1:3]
    del sys.argv[1:3]
    worker.connection.SOCKET_TIMEOUT = float(seconds)
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == rpr_solver.__name__ and hasattr(module, "SOLVER_VERSION"):
            module.SOLVER_VERSION = version
    program = importlib.import_module("worker.__main__")  # now, so that its modules see that version
    status: int = program.main()
    return status


if __name__ == "__main__":
    sys.exit(main())
