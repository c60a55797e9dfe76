"""Print the state of a job or a batch of a service: queued, running, succeeded, failed or canceled, and its
progress."""

from __future__ import annotations

import argparse
import json

from service.cli import output, remote

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps status ct-0f3a… --url http://127.0.0.1:8000
  rpr-cusps status ba-5d41…                      a batch: its items by state
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    remote.add_job(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    with remote.client_of(args.url) as client:
        print_job(client.job(args.job))
    return 0


def print_job(job: dict[str, object]) -> None:
    """Print the state of a job as JSON."""
    output.write(json.dumps(job, indent=2) + "\n")
