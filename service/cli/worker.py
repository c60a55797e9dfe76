"""Run one worker that takes jobs from a Redis or Valkey server, on this or another machine."""

from __future__ import annotations

import argparse
import os
import sys

from worker.process.worker import WorkerError, run_worker

DESCRIPTION, EXAMPLES = __doc__, None

FAILED, BAD_INPUT = 1, 2


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_redis_url(parser, "the Redis or Valkey server with the queue")


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    if args.redis_url is None:
        return _fail(
            "--redis-url is missing; give the address of the queue, for example redis://127.0.0.1:6379/0",
            BAD_INPUT,
        )
    try:
        return run_worker(str(args.redis_url))
    except WorkerError as error:
        return _fail(str(error), FAILED)


def add_redis_url(parser: argparse.ArgumentParser, text: str) -> None:
    """Add `--redis-url`."""
    # argparse also checks a default that is a string, so the environment is held to the same
    default = os.environ.get("RPR_CUSPS_REDIS_URL") or None
    parser.add_argument(
        "--redis-url",
        type=_redis_url,
        default=default,
        metavar="URL",
        help=f"{text}; also RPR_CUSPS_REDIS_URL",
    )


def _fail(message: str, status: int) -> int:
    print(f"rpr-cusps worker: {message}", file=sys.stderr)
    return status


def _redis_url(text: str) -> str:
    if not text.startswith(("redis://", "rediss://", "unix://")):
        raise argparse.ArgumentTypeError(
            "the address must begin with redis://, rediss:// or unix://, for example redis://127.0.0.1:6379/0"
        )
    return text
