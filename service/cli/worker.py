"""Run one worker that takes jobs from a Redis or Valkey server, on this machine or another."""

from __future__ import annotations

import argparse
import sys

from rpr_solver.errors import InputError
from service.cli.environment import warn_of_unknown_settings
from service.cli.options import add_redis_url
from worker.jobs.lanes import DUTIES
from worker.logs import log_uncaught, told
from worker.process.start import WorkerError, run_worker

DESCRIPTION, EXAMPLES = __doc__, None

FAILED = 1


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_redis_url(parser, "the Redis or Valkey server with the queue")
    parser.add_argument(
        "--duty",
        choices=DUTIES,
        default="all",
        help="light: only chunks of about a second, so that short questions never wait for long ones; at "
        "least one worker must do all (default: all)",
    )


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    if args.redis_url is None:
        hint = "give the address of the queue, for example redis://127.0.0.1:6379/0"
        raise InputError.of("--redis-url", f"is missing; {hint}")
    log_uncaught("rpr-cusps worker")
    warn_of_unknown_settings("worker")
    try:
        return run_worker(args.redis_url, duty=args.duty)
    except WorkerError as error:
        print(told("rpr-cusps worker", str(error)), file=sys.stderr)
        return FAILED
