"""Send many questions to a service as one batch, and print their answers in the order asked, as they come."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from service.cli import arguments, batch_output, output, remote
from service.cli.progress import progress_bar
from service.errors import ServiceError

DESCRIPTION = f"""{__doc__}

FILE is a JSON array of items, NDJSON with an item a line, or CSV with a geometry a row; - is standard input.
An item is {{"id": …, "kind": …, "request": …}}; docs/batches.md has the kinds and the columns."""
EXAMPLES = """\
examples:
  rpr-cusps submit batch.ndjson > answers.ndjson
  rpr-cusps submit designs.csv --format csv > cusps.csv
  generate-designs | rpr-cusps submit - --url https://cusps.example.com
  id=$(rpr-cusps submit batch.json --no-wait) && rpr-cusps fetch $id

Ctrl-C cancels the batch, and says how to fetch what was done.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("file", metavar="FILE", help="a JSON array, NDJSON or CSV, or -")
    remote.add_service(parser)
    parser.add_argument(
        "--format",
        choices=batch_output.FORMS,
        default=batch_output.FORMS[0],
        help="ndjson: an answer a line; csv: of cusp tables, a cusp a line (default: ndjson)",
    )
    parser.add_argument(
        "--as-done", action="store_true", help="print each answer once it is done, not in the order asked"
    )
    parser.add_argument("--no-wait", action="store_true", help="print the id of the batch, and do not wait")
    parser.add_argument(
        "--key",
        help="a name for this submission, such as a UUID: repeated within a day, it is the same batch",
    )
    parser.add_argument("--callback-url", metavar="URL", help="where the service tells the end of the batch")


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    file = sys.stdin.buffer if args.file == arguments.STANDARD_INPUT else Path(args.file)
    with remote.client_of(args.url) as client:
        with progress_bar(1, "sending"):
            batch = client.submit_file(file, callback_url=args.callback_url, key=args.key)
        back = f"`rpr-cusps fetch {batch.id} --url {args.url}`"
        if args.no_wait:
            output.write(batch.id + "\n")
            output.say(f"rpr-cusps submit: {batch.total} items; {back} prints their answers")
            return 0
        if sys.stderr is not None and sys.stderr.isatty():
            output.say(f"batch {batch.id}: {batch.total} items")
        try:
            with progress_bar(batch.total, "items", is_streamed=True) as progress:
                results = client.watch(batch, progress, as_done=args.as_done)
                return batch_output.print_results("submit", results, args.format)
        except ServiceError as error:
            error.args = (f"{error}; {back} comes back to the batch",)
            raise
