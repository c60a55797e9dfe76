"""Withdraw from a job of a service and print its state. It is canceled unless others wait for it too."""

from __future__ import annotations

import argparse

from service.cli import remote
from service.cli.status import print_job

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps cancel ct-0f3a… --url http://127.0.0.1:8000
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    remote.add_job(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    with remote.client_of(args.url) as client:
        print_job(client.cancel(args.job))
    return 0
