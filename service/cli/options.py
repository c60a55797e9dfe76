"""Options of the commands that run or manage a service; they need nothing of the solver."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from typing import Any

from worker.connection import has_password


def whole(what: str, high: int, low: int = 0) -> Callable[[str], int]:
    """Returns the conversion of an option that is a whole number."""

    def parse(text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) < 10 and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"{text[:40]!r} is not {what} from {low} to {high}")
        return int(text)

    return parse


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
