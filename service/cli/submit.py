"""Batches: their submission, and their results on stdout, each as soon as it is done."""

from __future__ import annotations

import argparse
import csv
import io
import sys
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rpr_solver
from rpr_solver.errors import InputError
from service.cli import arguments, output, remote
from service.cli.help import Command
from service.cli.output import progress_bar
from service.errors import ServiceError

if TYPE_CHECKING:
    from service.client import ItemResult

FORMS = ("ndjson", "csv")

_ERROR = b'"error":{'
_TABLE = "cusp-table"


def print_results(name: str, results: Generator[ItemResult, None, None], form: str) -> int:
    """Print results as they arrive, and the number of failures on stderr; returns the exit status.

    Ctrl-C never cuts a line; it is handed on to the iterator, which knows what becomes of the batch.

    Raises:
        InputError: one is no cusp table, and cannot be printed as CSV.
    """
    text = _Rows().text if form == "csv" else _line
    count = without = 0
    with closing(results):
        try:
            for result in results:
                with output.unbroken():
                    output.write(text(result))
                    output.flush()
                count += 1
                without += result.answer is None or _ERROR in result.answer.content
        except KeyboardInterrupt as interrupt:
            results.throw(interrupt)
    if without:
        output.say(f"rpr-cusps {name}: {without} of {count} items have no complete answer; each says why")
    return 1 if without else 0


def _line(result: ItemResult) -> str:
    return result.line.decode() + "\n"


class _Rows:
    """Cusp tables as CSV: the rows of each, after the number and the name of its item."""

    def __init__(self) -> None:
        self._leg: int | None = None
        self._is_begun = False

    def text(self, result: ItemResult) -> str:
        """Returns the rows of a result; the header comes before those of the first."""
        if result.answer is None:
            table: Mapping[str, Any] = {"fixed_leg": self._leg or 1, "slices": []}
        else:
            table = self._checked(result)
        columns, *rows = csv.reader(io.StringIO(rpr_solver.table_csv(table)))
        if result.answer is None:
            rows = [[_reason(result) if column == "error" else "" for column in columns]]
        header = [] if self._is_begun else [["index", "id", *columns]]
        self._is_begun = True
        return _csv([*header, *([str(result.index), result.name or "", *row] for row in rows)])

    def _checked(self, result: ItemResult) -> Mapping[str, Any]:
        assert result.answer is not None
        if result.kind != _TABLE:
            raise InputError.of("--format", f"csv is for cusp tables; items[{result.index}] is {result.kind}")
        table = result.answer.document
        leg = table["fixed_leg"]
        if self._leg not in (None, leg):
            other = f"items[{result.index}] fixes leg {leg}, those before it leg {self._leg}"
            raise InputError.of("--format", f"csv has the columns of one fixed leg; {other}")
        self._leg = leg
        return table


def _reason(result: ItemResult) -> str:
    return result.status if result.problem is None else result.problem.detail


def _csv(rows: Sequence[Sequence[str]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


_SUBMIT = """\
Send many questions to a service as one batch, and print their answers in order, as they arrive.

FILE is a JSON array of items, NDJSON with one item in each line, or CSV with one geometry in each row; - is
standard input. An item is {"id": …, "kind": …, "request": …}; docs/batches.md has the kinds and the
columns."""
_SUBMIT_EXAMPLES = """\
examples:
  rpr-cusps submit batch.ndjson > answers.ndjson
  rpr-cusps submit designs.csv --format csv > cusps.csv
  generate-designs | rpr-cusps submit - --url https://cusps.example.com
  id=$(rpr-cusps submit batch.json --no-wait) && rpr-cusps fetch $id

Ctrl-C cancels the batch, and prints how to fetch the answers so far.
"""


def _configure_submit(parser: argparse.ArgumentParser) -> None:
    """Add the options of `submit`."""
    parser.add_argument("file", metavar="FILE", help="a JSON array, NDJSON or CSV, or -")
    remote.add_service(parser)
    parser.add_argument(
        "--format",
        choices=FORMS,
        default=FORMS[0],
        help="ndjson: one answer in each line; csv: cusp tables with one cusp in each line (default: ndjson)",
    )
    parser.add_argument(
        "--as-done",
        action="store_true",
        help="print each answer as soon as it is done, not in the order of the questions",
    )
    parser.add_argument("--no-wait", action="store_true", help="print the id of the batch, and do not wait")
    parser.add_argument(
        "--key",
        help="a name for this submission, such as a UUID: repeating it within a day gives the same batch",
    )
    parser.add_argument(
        "--callback-url", metavar="URL", help="URL that the service calls at the end of the batch"
    )


def _run_submit(args: argparse.Namespace) -> int:
    """Run `submit`; returns the exit status."""
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
                return print_results("submit", results, args.format)
        except ServiceError as error:
            error.args = (f"{error}; {back} prints its answers",)
            raise


COMMANDS = {
    "submit": Command(_SUBMIT, _SUBMIT_EXAMPLES, _configure_submit, _run_submit),
}
