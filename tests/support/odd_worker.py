"""`python -m tests.support.odd_worker SECONDS …`: a worker with its own limit on how long Redis may take to
answer."""

from __future__ import annotations

import sys

import worker.connection
from tests.support.template import read_constants_from_the_environment
from worker import __main__ as program


def main() -> int:
    """Run the worker with the other arguments; also where it is started in full, it reads constants."""
    read_constants_from_the_environment()
    worker.connection.SOCKET_TIMEOUT = float(sys.argv.pop(1))
    return program.main()


if __name__ == "__main__":
    sys.exit(main())
