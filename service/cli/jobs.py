"""Jobs and batches of a running service: what is sent, their state, list, results and end."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Generator, Mapping
from contextlib import closing
from heapq import merge
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rpr_solver.errors import InputError
from rpr_solver.notebook import csv_text
from rpr_solver.slices.cusp_table import table_rows
from service.cli import asking, output, parsers
from service.cli.output import progress_bar
from service.cli.parsers import Command, whole
from service.errors import ServiceError
from service.schemas import all_questions
from service.schemas.answers import FORMATS, JSON
from service.schemas.resources import ListedStatus, is_batch

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
            columns, _ = table_rows({"fixed_leg": self._leg or 1, "slices": []})
            rows: list[Mapping[str, object]] = [{"error": result.reason}]
        else:
            columns, rows = table_rows(self._checked(result))
        item = {"index": result.index, "id": result.name}
        header, _, text = csv_text(["index", "id", *columns], ({**item, **row} for row in rows)).partition(
            "\n"
        )
        before, self._is_begun = "" if self._is_begun else f"{header}\n", True
        return before + text

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


def _configure_submit(parser: argparse.ArgumentParser) -> None:
    """Add the options of `submit`.

    Options:
        FILE: a JSON array, NDJSON or CSV, or -
        --format: ndjson: one answer in each line; csv: cusp tables with one cusp in each line (default:
            ndjson)
        --no-wait: print the id of the batch, and do not wait
        --key: a name for this submission, such as a UUID: repeating it within a day gives the same batch
        --callback-url: URL that the service calls at the end of the batch
    """
    parser.add_argument("file", metavar="FILE")
    parsers.add_service(parser)
    parser.add_argument("--format", choices=FORMS)
    parser.add_argument("--no-wait", action="store_true")
    parser.add_argument("--key")
    parser.add_argument("--callback-url", metavar="URL")


def _run_submit(args: argparse.Namespace) -> int:
    """Send many questions to a service as one batch, and print their answers in order, as they arrive.

    FILE is a JSON array of items, NDJSON with one item in each line, or CSV with one geometry in each row; -
    is standard input. An item is {"id": …, "kind": …, "request": …}; docs/batches.md has the kinds and the
    columns.

    examples:
      rpr-cusps submit batch.ndjson > answers.ndjson
      rpr-cusps submit designs.csv --format csv > cusps.csv
      generate-designs | rpr-cusps submit - --url https://cusps.example.com
      id=$(rpr-cusps submit batch.json --no-wait) && rpr-cusps fetch $id

    Ctrl-C cancels the batch, and prints how to fetch the answers so far.
    """
    if args.no_wait and args.format is not None:
        raise InputError.of("--format", "is about answers, which --no-wait does not print; give it to fetch")
    form = args.format or FORMS[0]
    file = sys.stdin.buffer if args.file == parsers.STANDARD_INPUT else Path(args.file)
    with asking.client_of(args.url) as client:
        with progress_bar(1, "sending"):
            batch = client.submit_file(file, callback_url=args.callback_url, key=args.key)
        back = f"`rpr-cusps fetch {batch.id} --url {args.url}`"
        if args.no_wait:
            output.write(batch.id + "\n")
            output.say(f"rpr-cusps submit: {batch.progress.total} items; {back} prints their answers")
            return 0
        if sys.stderr is not None and sys.stderr.isatty():
            output.say(f"batch {batch.id}: {batch.progress.total} items")
        try:
            with progress_bar(batch.progress.total, "items", is_streamed=True) as progress:
                results = client.watch(batch, progress)
                return print_results("submit", results, form)
        except ServiceError as error:
            error.args = (f"{error}; {back} prints its answers",)
            raise


def _run_status(args: argparse.Namespace) -> int:
    """Print the state of a job or a batch of a service: queued, running, succeeded (a batch:
    completed), failed or canceled, and its progress.

    examples:
      rpr-cusps status ct-0f3a… --url http://127.0.0.1:8000
      rpr-cusps status ba-5d41…                      a batch: its items by state
    """
    with asking.client_of(args.url) as client:
        print_job(client.job(args.job))
    return 0


def print_job(job: dict[str, object]) -> None:
    """Print the state of a job as JSON."""
    output.write(json.dumps(job, indent=2) + "\n")


def _configure_cancel(parser: argparse.ArgumentParser) -> None:
    """Add the options of `cancel`.

    Options:
        --force: end it for all subscribers; needs a key of scope admin, or the computer of a service without
            keys
    """
    parsers.add_job(parser)
    parser.add_argument("--force", action="store_true")


def _run_cancel(args: argparse.Namespace) -> int:
    """Withdraw a question or a batch and print its state. A job is canceled unless other clients wait for it;
    the answers of a batch so far can still be fetched.

    examples:
      rpr-cusps cancel ct-0f3a… --url http://127.0.0.1:8000
      rpr-cusps cancel ba-5d41…
      rpr-cusps cancel ct-0f3a… --force              for all subscribers
    """
    with asking.client_of(args.url) as client:
        print_job(client.cancel(args.job, force=args.force))
    return 0


_COLUMNS = ("id", "kind", "status", "created_at", "started_at", "ended_at", "estimate_seconds", "key")
_TITLES = [name.partition("_")[0].upper() for name in _COLUMNS]


def _configure_jobs(parser: argparse.ArgumentParser) -> None:
    """Add the options of `jobs`.

    Options:
        --all: include those that have ended
        --limit: print at most the newest N (default: 100)
        --format: default: table
    """
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--limit", type=whole("a number of jobs", 10**6), default=100, metavar="N")
    parser.add_argument("--format", choices=("table", "json"), default="table")
    parsers.add_service(parser)


def _run_jobs(args: argparse.Namespace) -> int:
    """List the jobs and batches of a service that were asked for with the key RPR_CUSPS_API_KEY. A key of
    scope admin lists all, and so does the computer of a service without keys.

    examples:
      rpr-cusps jobs                                 queued and running ones, the newest first
      rpr-cusps jobs --all --limit 20                ended ones, too
      rpr-cusps jobs --url https://cusps.example.com --format json

    ESTIMATE is the estimated work in seconds of one core. A job that runs for many
    times its estimate may need attention: rpr-cusps cancel JOB --force ends it for all subscribers.
    """
    status: ListedStatus | None = None if args.all else "active"
    with asking.client_of(args.url) as client:
        both = merge(
            client.jobs(status), client.batches(status), key=lambda job: job.created_at, reverse=True
        )
        jobs = list(islice(both, args.limit))
    if args.format == "json":
        output.write(json.dumps([job.model_dump() for job in jobs], indent=2) + "\n")
    else:
        output.write_columns([_TITLES, *([_cell(getattr(job, name)) for name in _COLUMNS] for job in jobs)])
    return 0


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.1f} s"
    return "-" if value is None else str(value)


def _configure_fetch(parser: argparse.ArgumentParser) -> None:
    """Add the options of `fetch`.

    Options:
        --no-wait: of a batch: print the answers so far, in the order of the questions
        --after: of a batch: only the items after number N; numbers start at 0
    """
    parsers.add_job(parser)
    tags = {
        name: [question.tag for question in all_questions() if media in question.forms]
        for name, media in FORMATS.items()
        if media != JSON
    }
    tags["ndjson"].append("batches")
    kinds = "".join(f"; {name}: of {', '.join(of)}" for name, of in tags.items())
    text = f"default: json, which all documents have; of a batch ndjson{kinds}"
    parser.add_argument("--format", choices=tuple(FORMATS), help=text)
    parser.add_argument("--no-wait", action="store_true")
    parser.add_argument("--after", type=whole("a number of an item", 10**9 - 1), metavar="N")


def _run_fetch(args: argparse.Namespace) -> int:
    """Wait for a job or a batch of a service and print its result.

    examples:
      rpr-cusps fetch ct-0f3a… --url http://127.0.0.1:8000
      rpr-cusps fetch ct-0f3a… --format csv > cusps.csv
      rpr-cusps fetch ba-5d41… --no-wait             the answers so far of a batch

    Ctrl-C does not cancel the job or the batch.
    """
    if is_batch(args.job):
        return _fetch_batch(args)
    for option, given in (("--no-wait", args.no_wait), ("--after", args.after is not None)):
        if given:
            raise InputError.of(option, f"is for batches, whose ids begin with ba-; {args.job!r} is a job")
    form = args.format or "json"
    with asking.client_of(args.url) as client, progress_bar(1, "steps") as progress:
        content = client.result(args.job, FORMATS[form], progress).decode()
    if form == "json":
        content = json.dumps(json.loads(content), indent=2, ensure_ascii=False) + "\n"
    output.write(content)
    return 0


def _fetch_batch(args: argparse.Namespace) -> int:
    form = args.format or FORMS[0]
    if form not in FORMS:
        raise InputError.of("--format", f"{form} is one document; of a batch, give {' or '.join(FORMS)}")
    after = -1 if args.after is None else args.after
    with asking.client_of(args.url) as client, progress_bar(1, "items", is_streamed=True) as progress:
        results = client.results(args.job, progress, wait=not args.no_wait, after=after)
        return print_results("fetch", results, form)


COMMANDS = {
    "submit": Command.of(_run_submit, _configure_submit),
    "status": Command.of(_run_status, parsers.add_job),
    "jobs": Command.of(_run_jobs, _configure_jobs),
    "fetch": Command.of(_run_fetch, _configure_fetch),
    "cancel": Command.of(_run_cancel, _configure_cancel),
}
