"""Run one worker that takes jobs from a Redis or Valkey server, on this machine or another."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from rpr_solver.errors import InputError
from service.cli.environment import warn_of_unknown_settings
from worker.connection import has_password
from worker.process.start import WorkerError, run_worker

DESCRIPTION, EXAMPLES = __doc__, None

FAILED = 1


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_redis_url(parser, "the Redis or Valkey server with the queue")


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    if args.redis_url is None:
        hint = "give the address of the queue, for example redis://127.0.0.1:6379/0"
        raise InputError.of("--redis-url", f"is missing; {hint}")
    warn_of_unknown_settings("worker")
    try:
        return run_worker(args.redis_url)
    except WorkerError as error:
        print(f"rpr-cusps worker: {error}", file=sys.stderr)
        return FAILED


def add_redis_url(parser: argparse.ArgumentParser, text: str) -> None:
    """Add `--redis-url`."""
    # argparse also converts a default that is a string, so the environment is checked too
    default = os.environ.get("RPR_CUSPS_REDIS_URL") or None
    parser.add_argument(
        "--redis-url",
        action=_FromCommandLine,
        type=_redis_url,
        default=default,
        metavar="URL",
        help=f"{text}; also RPR_CUSPS_REDIS_URL, which may have a password",
    )


class _FromCommandLine(argparse.Action):
    """Refuses a password, which other users of the computer could read in the list of processes."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, *_: Any
    ) -> None:
        del parser
        if has_password(values):
            raise argparse.ArgumentError(
                self,
                "a password on the command line can be read by others; give the address in "
                "RPR_CUSPS_REDIS_URL, or the password in the file RPR_CUSPS_REDIS_PASSWORD_FILE",
            )
        setattr(namespace, self.dest, values)


def _redis_url(text: str) -> str:
    if not text.startswith(("redis://", "rediss://", "unix://")):
        raise argparse.ArgumentTypeError(
            "the address must begin with redis://, rediss:// or unix://, for example redis://127.0.0.1:6379/0"
        )
    return text
