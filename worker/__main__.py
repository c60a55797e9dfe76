"""`python -m worker`: one worker process; the Redis URL comes from the environment."""

from __future__ import annotations

import argparse
import os
import sys

from pydantic import ValidationError

from rpr_solver.errors import InputError
from worker.logs import log_uncaught, program_line
from worker.process.program import WorkerError, run_worker
from worker.settings import DUTIES, settings_problem


def main() -> int:
    """Run one worker."""
    log_uncaught("worker")
    parser = argparse.ArgumentParser(prog="python -m worker", description=__doc__)
    parser.add_argument("--redis-url", default=os.environ.get("RPR_CUSPS_REDIS_URL"))
    parser.add_argument("--name")
    parser.add_argument("--parent-pid", type=int, help="end with this parent process")
    parser.add_argument("--duty", choices=DUTIES, default="all", help="light: small questions only")
    args = parser.parse_args()
    if not args.redis_url:
        parser.error("no Redis URL: give --redis-url or set RPR_CUSPS_REDIS_URL")
    try:
        return run_worker(args.redis_url, name=args.name, parent_pid=args.parent_pid, duty=args.duty)
    except ValidationError as error:
        message, status = settings_problem(error), 2
    except InputError as error:
        message, status = str(error), 2
    except WorkerError as error:
        message, status = str(error), 1
    print(program_line("worker", message), file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
