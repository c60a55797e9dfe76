"""The Redis of a service, by an address or by a data directory."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from redis import Redis
from redis.exceptions import RedisError

from service.cli.options import add_redis_url
from service.errors import ServiceError
from service.stack.embedded_valkey import attached
from service.stack.errors import StackError
from worker.connection import UnreachableError, check, connect


def add_source(parser: argparse.ArgumentParser) -> None:
    """Add `--redis-url` and `--data-dir`."""
    add_redis_url(parser, "the Redis or Valkey server of the service (default: an embedded one)")
    parser.add_argument(
        "--data-dir",
        type=Path,
        metavar="DIR",
        help="data directory of the embedded Valkey (default: the user's data directory)",
    )


@contextmanager
def opened(args: argparse.Namespace) -> Iterator[Redis]:
    """A client of the server that is asked for; of a data directory, whether or not its service is running.

    Raises:
        ServiceError: it cannot be reached, or fails meanwhile.
    """
    try:
        if args.redis_url is None:
            with attached(args.data_dir) as url, connect(url) as redis:
                yield redis
        else:
            check(args.redis_url)
            with connect(args.redis_url) as redis:
                yield redis
    except (StackError, UnreachableError, RedisError) as error:
        raise ServiceError(str(error)) from error
