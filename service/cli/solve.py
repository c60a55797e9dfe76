"""Compute cusp tables and print them."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, closing
from typing import Any

import rpr_solver
from rpr_solver.errors import InputError
from rpr_solver.exports.papers import latex_table
from service.cli import arguments, asking, output
from service.cli.help import Command
from service.cli.output import progress_bar
from service.cli.pages import failures, write_table
from service.schemas.answers import csv_header, csv_lines, ndjson_line
from service.schemas.document import named, renamed
from service.schemas.numbers import whole_number
from service.schemas.tables import METHODS, CuspTableRequest
from worker.answers import tables
from worker.answers.requests import Store

DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98
  rpr-cusps solve innocenti --l1 14.98 --method article
  rpr-cusps solve zein-flat --l1 2 --l1 5/2 --digits 200 --format json
  rpr-cusps solve robot.json --l1-range 0.1:50.1:0.1 --format csv > cusps.csv
  rpr-cusps solve innocenti --l1 14.98 --format latex --shown 8 > table.tex
  rpr-cusps solve - --l2 17 < robot.json                      leg 2 fixed

A terminal shows as many digits as fit; every other output has all of them. CSV and NDJSON are printed slice
by slice, and Ctrl-C keeps what is done.
"""

_LATEX = "latex"
STREAMED = ("csv", "ndjson")
"""Formats that are printed slice by slice."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    text = "the fixed length of a slice; repeatable (--l2: leg 2 is fixed, …)"
    arguments.add_options(parser, "--l{}", "slices", "X", text)
    text = "slices from FROM to TO in steps of STEP; TO is included if a step reaches it"
    arguments.add_options(parser, "--l{}-range", "slices", "FROM:TO:STEP", text)
    arguments.add_digits(parser, 90)
    parser.add_argument(
        "--fixed-leg", metavar="LEG", help="the fixed leg (default: the leg of the slices, or 1)"
    )
    arguments.add_format(parser, *STREAMED, _LATEX)
    parser.add_argument(
        "--shown",
        metavar="N",
        help="with --format latex: the significant digits that are printed (default: all)",
    )
    parser.add_argument(
        "--method",
        choices=METHODS,
        default=METHODS[0],
        help="article: the article's own algorithm with an audit; slower, leg 1 only (default: fast)",
    )
    arguments.add_certificate(parser)
    asking.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    if args.shown is not None and args.format != _LATEX:
        raise InputError.of("--shown", "is for --format latex; --digits is what is computed")
    question = _question(args)
    count = len(dict.fromkeys(question.slices))
    slices: Iterable[Mapping[str, Any]]
    with ExitStack() as stack:
        progress = stack.enter_context(progress_bar(count, is_streamed=args.format in STREAMED))
        if args.url is None:
            request = question.job_request()
            head, slices = tables.head(request), _counted(tables.solved(request, Store()), count, progress)
        elif args.format in STREAMED:
            client = stack.enter_context(asking.client_of(args.url))
            head, coming = asking.slices_of(client, question, progress)
            slices = stack.enter_context(closing(coming))  # which withdraws the question
        else:
            head = asking.document_of(args.url, question, progress)
            slices = head["slices"]
        table = {**head, "slices": _printed(head, slices, args.format)}
    if args.format == _LATEX:
        output.write(_latex(table, args.shown))
    elif args.format not in STREAMED:
        write_table(table, args.format)
    return report(table)


def _latex(table: Mapping[str, Any], digits: str | None) -> str:
    try:
        with named("digits"):
            shown = None if digits is None else whole_number(digits, "1 or more", is_text=True)
        return latex_table(table, shown)
    except InputError as error:
        raise renamed(error, lambda _: "--shown") from None


def _counted(
    slices: Iterable[dict[str, Any]], count: int, progress: rpr_solver.Progress
) -> Iterator[dict[str, Any]]:
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
    return failed


def _question(args: argparse.Namespace) -> CuspTableRequest:
    leg = arguments.leg_of(args.slices, args.fixed_leg, "slices")
    name = f"l{leg}"
    origin = arguments.source({name: f"--{name}"})
    slices: list[object] = []
    for option, text in args.slices:
        slices += arguments.range_values(text, option, origin) if option.endswith("-range") else [text]
    if not slices:
        raise InputError.of(f"--{name}", f"is missing; give a slice, for example --{name} 14.98")
    members = {
        "fixed_leg": leg,
        name: slices,
        "method": args.method,
        "certificate": args.certificate,
        **asking.deadline_of(args),
    }
    return arguments.ask(CuspTableRequest, args, members, origin)


def report(table: dict[str, Any]) -> int:
    """Report the slices without an answer on stderr; returns the exit status."""
    failed = failures(table)
    for where, error in failed:
        output.say(f"rpr-cusps solve: {where}: no answer ({error['type']}): {error['detail']}")
    if not failed:
        return 0
    return 2 if any(error["type"] == "input-error" for _, error in failed) else 1


COMMANDS = {"solve": Command(DESCRIPTION, EXAMPLES, configure, run)}
