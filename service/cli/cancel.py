"""Withdraw from a job or a batch of a service and print its state. A job is canceled unless others wait for
it too; what is done of a batch can still be fetched."""

from __future__ import annotations

import argparse

from service.cli import remote
from service.cli.status import print_job

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps cancel ct-0f3a… --url http://127.0.0.1:8000
  rpr-cusps cancel ba-5d41…
  rpr-cusps cancel ct-0f3a… --force              whoever else waits for it
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    remote.add_job(parser)
    text = "end it for all: with a key of scope admin, or on the computer of a service without keys"
    parser.add_argument("--force", action="store_true", help=text)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    with remote.client_of(args.url) as client:
        print_job(client.cancel(args.job, force=args.force))
    return 0
