"""Wait for a job or a batch of a service and print its result."""

from __future__ import annotations

import argparse
import json

from rpr_solver.errors import InputError
from service.cli import batch_output, output, remote
from service.cli.options import whole
from service.cli.progress import progress_bar
from service.schemas.batches import is_batch

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps fetch ct-0f3a… --url http://127.0.0.1:8000
  rpr-cusps fetch ct-0f3a… --format csv > cusps.csv
  rpr-cusps fetch ba-5d41… --no-wait             what is done of a batch

Ctrl-C leaves the job or the batch as it is.
"""

_TYPES = {"json": "application/json", "csv": "text/csv", "ndjson": "application/x-ndjson"}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    remote.add_job(parser)
    text = (
        "csv: not of checks and poses; ndjson: of cusp tables and batches (default: json; of a batch ndjson)"
    )
    parser.add_argument("--format", choices=tuple(_TYPES), help=text)
    parser.add_argument(
        "--no-wait",
        action="store_true",
        help="of a batch: print the answers that there are, in the order asked",
    )
    parser.add_argument(
        "--after",
        type=whole("a number of an item", 10**9 - 1),
        metavar="N",
        help="of a batch: only the items after number N, which count from 0",
    )


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    if is_batch(args.job):
        return _fetch_batch(args)
    for option, given in (("--no-wait", args.no_wait), ("--after", args.after is not None)):
        if given:
            raise InputError.of(option, f"is for batches, whose ids begin with ba-; {args.job!r} is a job")
    form = args.format or "json"
    with remote.client_of(args.url) as client, progress_bar(1, "steps") as progress:
        content = client.result(args.job, _TYPES[form], progress).decode()
    if form == "json":
        content = json.dumps(json.loads(content), indent=2, ensure_ascii=False) + "\n"
    output.write(content)
    return 0


def _fetch_batch(args: argparse.Namespace) -> int:
    form = args.format or batch_output.FORMS[0]
    if form not in batch_output.FORMS:
        raise InputError.of(
            "--format", f"json is one document; of a batch, give {' or '.join(batch_output.FORMS)}"
        )
    after = -1 if args.after is None else args.after
    with remote.client_of(args.url) as client, progress_bar(1, "items", is_streamed=True) as progress:
        results = client.results(args.job, progress, wait=not args.no_wait, after=after)
        return batch_output.print_results("fetch", results, form)
