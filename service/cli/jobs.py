"""List the jobs and batches of a service: those of the key RPR_CUSPS_API_KEY. All with a key of scope admin
and, without keys, on the computer of the service itself."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from heapq import merge
from itertools import islice

from service.cli import output, remote
from service.cli.options import whole
from service.schemas.job_list import ListedJob, ListedStatus

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps jobs                                 what is queued or running, the newest first
  rpr-cusps jobs --all --limit 20                also what has ended
  rpr-cusps jobs --url https://cusps.example.com --format json

ESTIMATE is the estimated work in seconds of one core, RUNS how long it has run; a job that runs for many
times its estimate is one to look at. rpr-cusps cancel JOB --force ends one for all who asked for it.
"""
_COLUMNS = ("id", "kind", "status", "created_at", "estimate_s", "runs_s", "overruns", "key")
_TITLES = ("ID", "KIND", "STATUS", "CREATED", "ESTIMATE", "RUNS", "OVERRUNS", "KEY")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--all", action="store_true", help="also those that have ended")
    parser.add_argument(
        "--limit",
        type=whole("a number of jobs", 10**6),
        default=100,
        metavar="N",
        help="the newest N at most (default: 100)",
    )
    parser.add_argument("--format", choices=("table", "json"), default="table", help="default: table")
    remote.add_service(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    status: ListedStatus | None = None if args.all else "active"
    with remote.client_of(args.url) as client:
        both = merge(
            client.jobs(status), client.batches(status), key=lambda job: job.created_at, reverse=True
        )
        jobs = list(islice(both, args.limit))
    if args.format == "json":
        output.write(json.dumps([job.model_dump() for job in jobs], indent=2) + "\n")
    else:
        output.write("".join(f"{line}\n" for line in _lines(jobs)))
    return 0


def _lines(jobs: list[ListedJob]) -> Iterator[str]:
    rows = [_TITLES, *(tuple(_cell(getattr(job, name)) for name in _COLUMNS) for job in jobs)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.1f} s"
    return "-" if value is None else str(value)
