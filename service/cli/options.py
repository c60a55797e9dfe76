"""Options and environment of the commands that run or manage a service; they need nothing of the solver.

What an installation without a service lacks is imported when a command runs, so that each prints its help.
"""

from __future__ import annotations

import argparse
import difflib
import logging
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from service.errors import ServiceError
from worker.logs import told

if TYPE_CHECKING:
    from pydantic import BaseModel
    from redis import Redis


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
        from worker.connection import has_password

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


PREFIX = "RPR_CUSPS_"


def models() -> tuple[type[BaseModel], ...]:
    """Returns the models that read settings from the environment."""
    from service.api.settings import Settings  # imported here to keep the start of commands quick
    from service.client import ClientSettings
    from service.schemas.limits import Limits
    from service.stack.supervisor import SupervisorSettings
    from service.webhooks.settings import WebhookSettings
    from worker.settings import ConnectionSettings, WorkerSettings

    ours = (Limits, Settings, WebhookSettings, SupervisorSettings, ClientSettings)
    return *ours, WorkerSettings, ConnectionSettings


def names() -> set[str]:
    """Returns the names of all settings."""
    return {PREFIX + name.upper() for model in models() for name in model.model_fields}


def unknown_settings(environment: Mapping[str, str]) -> Iterator[str]:
    """Yields a sentence for each variable that has the prefix of settings and is none."""
    set_here = sorted(name for name in environment if name.upper().startswith(PREFIX))
    known = names() if set_here else set()
    for name in set_here:
        if name.upper() not in known:
            yield f"{name} is not a setting and has no effect{_hint(name.upper(), known)}"


def warn_of_unknown_settings(command: str) -> None:
    """Say those sentences on stderr, at the start of a process."""
    for sentence in unknown_settings(os.environ):
        print(told(f"rpr-cusps {command}", sentence, logging.WARNING), file=sys.stderr)


def _hint(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.75)
    return f"; did you mean {near[0]}?" if near else ""


def add_source(parser: argparse.ArgumentParser, which: str = "of the service") -> None:
    """Add `--redis-url` and `--data-dir`."""
    add_redis_url(parser, f"the Redis or Valkey server {which} (default: an embedded one)")
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
    from redis.exceptions import RedisError

    from service.errors import StackError
    from service.stack.embedded_valkey import attached
    from worker.connection import UnreachableError, check, connect

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
