"""Compute cusp tables and print them."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, closing
from typing import Any

from rpr_solver import DEFAULT_DIGITS, Progress
from rpr_solver.contract import document_head
from rpr_solver.errors import InputError
from rpr_solver.exports import latex_table
from rpr_solver.notebook import near_words
from service.cli import arguments, asking, output, parsers
from service.cli.output import progress_bar
from service.cli.pages import failures, say_near, write_table
from service.cli.parsers import Command
from service.schemas.answers import csv_header, csv_lines, ndjson_line
from service.schemas.document import named, unnamed
from service.schemas.tables import CuspTableRequest
from worker.answers import Store, tables

_LATEX = "latex"
STREAMED = ("csv", "ndjson")
"""Formats that are printed slice by slice."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Options:
        --method: article: the article's own algorithm with an audit; slower, leg 1 only (default: fast)
    """
    parsers.add_geometry(parser)
    text = "the fixed length of a slice; repeatable (--l2: leg 2 is fixed, …)"
    parsers.add_options(parser, "--l{}", "slices", "X", text)
    text = "slices from FROM to TO in steps of STEP; TO is included if a step reaches it"
    parsers.add_options(parser, "--l{}-range", "slices", "FROM:TO:STEP", text)
    parsers.add_digits(parser, DEFAULT_DIGITS)
    parsers.add_fixed_leg(parser, "slices")
    parsers.add_format(parser, *STREAMED, _LATEX)
    parser.add_argument("--method", choices=tables.METHODS, default=tables.METHODS[0])
    parsers.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Compute cusp tables and print them.

    examples:
      rpr-cusps solve innocenti --l1 14.98
      rpr-cusps solve innocenti --l1 14.98 --method article
      rpr-cusps solve zein-flat --l1 2 --l1 5/2 --digits 200 --format json
      rpr-cusps solve robot.json --l1-range 0.1:50.1:0.1 --format csv > cusps.csv
      rpr-cusps solve innocenti --l1 14.98 --format latex --digits 8 > table.tex
      rpr-cusps solve - --l2 17 < robot.json                      leg 2 fixed

    JSON, CSV and NDJSON have all digits that are computed. CSV and NDJSON are printed slice by slice, and
    Ctrl-C keeps what is done.
    """
    question = question_of(args)
    request = question.job_request()
    count = len(request.content["l1"])
    head: Mapping[str, Any]
    slices: Iterable[Mapping[str, Any]]
    with ExitStack() as stack:
        progress = stack.enter_context(progress_bar(count, is_streamed=args.format in STREAMED))
        if args.url is None:
            head, slices = tables.head(request), _counted(tables.solved(request, Store()), count, progress)
        else:
            head, slices = _of_service(args, question, count, progress, stack)
        table = {**head, "slices": _printed(head, slices, args.format)}
    if args.format == _LATEX:
        with named("--digits"), unnamed("digits"):
            output.write(latex_table(table, min(arguments.printed_digits(args), table["digits"])))
    elif args.format not in STREAMED:
        write_table(table, args.format, arguments.printed_digits(args))
    return report(table)


def _of_service(
    args: argparse.Namespace, question: CuspTableRequest, count: int, progress: Progress, stack: ExitStack
) -> tuple[Mapping[str, Any], Iterable[Mapping[str, Any]]]:
    """Returns the head of a table and its slices, as the service at `--url` computes them."""
    from service.client import Asked

    if args.format not in STREAMED:
        table = asking.document_of(args.url, question, progress)
        return table, table["slices"]
    client = stack.enter_context(asking.client_of(args.url))
    head = document_head(question.geometry, question.digits, question.fixed_leg)
    head["solver_version"] = client.version()["solver_version"]
    slices = stack.enter_context(closing(client.slices(Asked.of(question))))  # which withdraws the question
    return head, _counted(slices, count, progress)


def _counted(
    slices: Iterable[Mapping[str, Any]], count: int, progress: Progress
) -> Iterator[Mapping[str, Any]]:
    """Yields slices as they are solved."""
    progress(0, count)
    for done, part in enumerate(slices, 1):
        yield part
        progress(done, count)


def _printed(
    head: Mapping[str, Any], slices: Iterable[Mapping[str, Any]], form: str
) -> list[Mapping[str, Any]]:
    """Returns the slices; as CSV or NDJSON each is printed at once, and only those without an answer are
    kept."""
    if form not in STREAMED:
        return list(slices)
    failed = []
    if form == "csv":
        output.write(csv_header(head))
    for part in slices:
        with output.unbroken():
            output.write(csv_lines(head, part) if form == "csv" else ndjson_line(head, part))
            output.flush()
        if "error" in part:
            failed.append(part)
    output.flush()
    say_near(near_words(head))
    return failed


def question_of(args: argparse.Namespace) -> CuspTableRequest:
    """Returns the question that the options ask."""
    leg = arguments.leg_of(args.slices, args.fixed_leg, "slices")
    name = f"l{leg}"
    origin = arguments.source({name: f"--{name}"})
    slices: list[object] = []
    for option, text in args.slices:
        slices += arguments.range_values(text, option, origin) if option.endswith("-range") else [text]
    if not slices:
        raise InputError.of(f"--{name}", f"is missing; give a slice, for example --{name} 14.98")
    members = {"fixed_leg": leg, name: slices, "method": args.method, **asking.deadline_of(args)}
    return arguments.ask(CuspTableRequest, args, members, origin)


def report(table: dict[str, Any]) -> int:
    """Report the slices without an answer on stderr; returns the exit status."""
    failed = failures(table)
    for where, error in failed:
        output.say(f"rpr-cusps solve: {where}: no answer ({error['type']}): {error['detail']}")
    if not failed:
        return 0
    return 2 if any(error["type"] == "input-error" for _, error in failed) else 1


COMMANDS = {"solve": Command.of(run, configure)}
