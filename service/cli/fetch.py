"""Wait for a job of a service and print its result."""

from __future__ import annotations

import argparse
import json

from service.cli import output, remote
from service.cli.progress import progress_bar

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps fetch ct-0f3a… --url http://127.0.0.1:8000
  rpr-cusps fetch ct-0f3a… --format csv > cusps.csv

Ctrl-C leaves the job as it is.
"""

_TYPES = {"json": "application/json", "csv": "text/csv", "ndjson": "application/x-ndjson"}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    remote.add_job(parser)
    text = "csv: not of checks and poses; ndjson: of cusp tables (default: json)"
    parser.add_argument("--format", choices=tuple(_TYPES), default="json", help=text)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    with remote.client_of(args.url) as client, progress_bar(1, "steps") as progress:
        content = client.result(args.job, _TYPES[args.format], progress).decode()
    if args.format == "json":
        content = json.dumps(json.loads(content), indent=2, ensure_ascii=False) + "\n"
    output.write(content)
    return 0
