"""Compute cusp tables and print them."""

from __future__ import annotations

import argparse
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, closing
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rpr_solver import DEFAULT_DIGITS, EXAMPLES, Manipulator, Progress
from rpr_solver.contract import LEGS, document_head
from rpr_solver.errors import InputError
from rpr_solver.exact.rationals import parse_positive
from rpr_solver.exports import latex_table
from rpr_solver.notebook import near_words
from service.cli import output, parsers
from service.cli.output import progress_bar
from service.cli.pages import failures, say_near, write_table
from service.cli.parsers import STANDARD_INPUT, Command
from worker.answers import JobRequest, Store, tables

if TYPE_CHECKING:  # a plain question needs no schema, and to load it would take as long as all the rest
    from service.schemas.tables import CuspTableRequest

_LATEX = "latex"
STREAMED = ("csv", "ndjson")
"""Formats that are printed slice by slice."""

_PLAIN = re.compile(r"\d{1,40}(?:[./]\d{1,40})?", re.ASCII)
_DIGITS = re.compile(r"1[5-9]|[2-9]\d|[1-9]\d\d", re.ASCII)
_OPTIONS = [{f"--{name}"} for name in LEGS]
_SHORT_FILE = 10_000


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Options:
        --shown: with --format latex: the significant digits that are printed (default: all)
        --method: article: the article's own algorithm with an audit; slower, leg 1 only (default: fast)
    """
    parsers.add_geometry(parser)
    text = "the fixed length of a slice; repeatable (--l2: leg 2 is fixed, …)"
    parsers.add_options(parser, "--l{}", "slices", "X", text)
    text = "slices from FROM to TO in steps of STEP; TO is included if a step reaches it"
    parsers.add_options(parser, "--l{}-range", "slices", "FROM:TO:STEP", text)
    parsers.add_digits(parser, 90)
    parsers.add_fixed_leg(parser, "slices")
    parsers.add_format(parser, *STREAMED, _LATEX)
    parser.add_argument("--shown", metavar="N")
    parser.add_argument("--method", choices=tables.METHODS, default=tables.METHODS[0])
    parsers.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Compute cusp tables and print them.

    examples:
      rpr-cusps solve innocenti --l1 14.98
      rpr-cusps solve innocenti --l1 14.98 --method article
      rpr-cusps solve zein-flat --l1 2 --l1 5/2 --digits 200 --format json
      rpr-cusps solve robot.json --l1-range 0.1:50.1:0.1 --format csv > cusps.csv
      rpr-cusps solve innocenti --l1 14.98 --format latex --shown 8 > table.tex
      rpr-cusps solve - --l2 17 < robot.json                      leg 2 fixed

    A terminal shows as many digits as fit; every other output has all of them. CSV and NDJSON are printed
    slice by slice, and Ctrl-C keeps what is done.
    """
    if args.shown is not None and args.format != _LATEX:
        raise InputError.of("--shown", "is for --format latex; --digits is what is computed")
    request, question = plain_request(args), None
    if request is None:
        question = question_of(args)
        request = question.job_request()
    count = len(request.content["l1"])
    head: Mapping[str, Any]
    slices: Iterable[Mapping[str, Any]]
    with ExitStack() as stack:
        progress = stack.enter_context(progress_bar(count, is_streamed=args.format in STREAMED))
        if question is None or args.url is None:
            head, slices = tables.head(request), _counted(tables.solved(request, Store()), count, progress)
        else:
            head, slices = _of_service(args, question, count, progress, stack)
        table = {**head, "slices": _printed(head, slices, args.format)}
    if args.format == _LATEX:
        output.write(_latex(table, args.shown))
    elif args.format not in STREAMED:
        write_table(table, args.format)
    return report(table)


def plain_request(args: argparse.Namespace) -> JobRequest | None:
    """Returns what is asked for if no schema is needed to read it: lengths and digits in plain figures, and a
    manipulator by its name or in a short file.

    None: the question's model must read the arguments, and names all that is wrong with them.
    """
    options = {option for option, _ in args.slices}
    digits = str(DEFAULT_DIGITS) if args.digits is None else args.digits
    is_plain = (
        (args.url, args.deadline, args.fixed_leg) == (None, None, None)
        and args.method == tables.METHODS[0]
        and options in _OPTIONS
        and all(_PLAIN.fullmatch(text) for _, text in args.slices)
        and _DIGITS.fullmatch(digits)
        and not any(name.lower().startswith("rpr_cusps_") for name in os.environ)  # limits may be among them
    )
    if not is_plain:
        return None
    try:
        manipulator = EXAMPLES.get(args.geometry) or _manipulator(args.geometry)
        lengths = [parse_positive(text, "") for _, text in args.slices]
    except (ValueError, OSError, RecursionError):
        return None
    leg = _OPTIONS.index(options) + 1
    return JobRequest(tables.CUSP_TABLE, tables.content(manipulator, int(digits), lengths, leg))


def _manipulator(name: str) -> Manipulator:
    """Returns the manipulator in a short file that holds nothing else.

    Raises:
        ValueError: it does not, or its numbers are not in plain figures.
        OSError: it cannot be read.
    """
    path = Path(name)
    if name == STANDARD_INPUT or not path.is_file() or path.stat().st_size > _SHORT_FILE:
        raise ValueError(name)

    def members(pairs: list[tuple[str, object]]) -> dict[str, object]:
        found = dict(pairs)
        if len(found) < len(pairs) or not all(isinstance(value, str | Decimal) for value in found.values()):
            raise ValueError(name)
        return found

    def number(text: str) -> Decimal:
        if not _PLAIN.fullmatch(text.removeprefix("-")):
            raise ValueError(text)
        return Decimal(text)

    text = path.read_bytes().decode("utf-8")
    return Manipulator.from_json(
        json.loads(text, object_pairs_hook=members, parse_int=number, parse_float=number)
    )


def _of_service(
    args: argparse.Namespace, question: CuspTableRequest, count: int, progress: Progress, stack: ExitStack
) -> tuple[Mapping[str, Any], Iterable[Mapping[str, Any]]]:
    """Returns the head of a table and its slices, as the service at `--url` computes them."""
    from service.cli import asking
    from service.client import Asked

    if args.format not in STREAMED:
        table = asking.document_of(args.url, question, progress)
        return table, table["slices"]
    client = stack.enter_context(asking.client_of(args.url))
    head = document_head(question.geometry, question.digits, question.fixed_leg)
    head["solver_version"] = client.version()["solver_version"]
    slices = stack.enter_context(closing(client.slices(Asked.of(question))))  # which withdraws the question
    return head, _counted(slices, count, progress)


def _latex(table: Mapping[str, Any], digits: str | None) -> str:
    from service.cli.arguments import read_option
    from service.schemas.document import renamed
    from service.schemas.numbers import whole_from

    try:
        shown = None if digits is None else read_option(Annotated[int, whole_from(1)], digits, "--shown")
        return latex_table(table, shown)
    except InputError as error:
        raise renamed(error, lambda _: "--shown") from None


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
    from service.schemas.answers import csv_header, csv_lines, ndjson_line

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
    from service.cli import arguments, asking
    from service.schemas.tables import CuspTableRequest

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
