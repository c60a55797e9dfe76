"""Compute cusp tables and print them."""

from __future__ import annotations

import argparse
import sys
from typing import Any

import rpr_solver
from rpr_solver.article.audit import article_document
from rpr_solver.errors import InputError
from service.cli import arguments
from service.cli.pages import failures, progress_bar, write_table
from service.errors import ServiceError
from service.schemas.tables import ARTICLE, METHODS, CuspTableRequest

DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98
  rpr-cusps solve innocenti --l1 14.98 --method article
  rpr-cusps solve zein-flat --l1 2 --l1 5/2 --digits 200 --format json
  rpr-cusps solve robot.json --l1-range 0.1:50.1:0.1 --digits 30 --format csv > cusps.csv
  echo '{"a2x":15.91,"a3x":0,"a3y":10,"d1":17.04,"d2":16.54,"d3":20.84}' | rpr-cusps solve - --l1 14.98

A terminal shows as many digits as fit; every other output has all of them.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    text = "the fixed length of a slice; repeatable (--l2 with fixed leg 2, …)"
    arguments.add_options(parser, "--l{}", "slices", "X", text)
    text = "slices from START to STOP in steps of STEP; STOP is included if a step meets it"
    arguments.add_options(parser, "--l{}-range", "slices", "START:STOP:STEP", text)
    arguments.add_digits(parser, 90)
    parser.add_argument("--fixed-leg", default="1", metavar="LEG", help="the fixed leg (default: 1)")
    arguments.add_format(parser, csv=True)
    parser.add_argument(
        "--method",
        choices=METHODS,
        default=METHODS[0],
        help="article: the article's own algorithm with an audit; slower, leg 1 only (default: fast)",
    )
    parser.add_argument(
        "--url", help="compute by the service at this address, for example http://127.0.0.1:8000"
    )


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    question = _question(args)
    slices = list(dict.fromkeys(question.slices))
    with progress_bar(len(slices)) as progress:
        if args.url is not None:
            table = _ask_service(args.url, question, progress)
        elif question.method == ARTICLE:
            table = article_document(question.geometry, slices, question.digits, progress)
        else:
            leg, digits = question.fixed_leg, question.digits
            table = rpr_solver.table_document(
                question.geometry, slices, fixed_leg=leg, digits=digits, progress=progress
            )
    write_table(table, args.format)
    return report(table)


def _question(args: argparse.Namespace) -> CuspTableRequest:
    leg = arguments.fixed_leg_of(args.fixed_leg)
    name = f"l{leg}"
    origin = arguments.source({name: f"--{name}"})
    slices: list[object] = []
    for option, text in args.slices:
        if not option.startswith(f"--{name}"):
            raise InputError.of(option, f"with --fixed-leg {leg} the slices are --{name}")
        slices += arguments.range_values(text, option, origin) if option.endswith("-range") else [text]
    if not slices:
        raise InputError.of(f"--{name}", f"is missing; give a slice, for example --{name} 14.98")
    members = {"fixed_leg": leg, name: slices, "method": args.method}
    return arguments.ask(CuspTableRequest, args, members, origin)


def _ask_service(url: str, question: CuspTableRequest, progress: rpr_solver.Progress) -> dict[str, Any]:
    from service.client import ServiceClient  # imported here: httpx is slow to load

    try:
        client = ServiceClient(url)
    except ServiceError as error:
        raise InputError.of("--url", str(error)) from None
    with client:
        return client.cusp_table(question.body(), progress)


def report(table: dict[str, Any]) -> int:
    """Report the slices without an answer on stderr; returns the exit status."""
    failed = failures(table)
    for where, error in failed:
        print(f"rpr-cusps solve: {where}: no answer ({error['type']}): {error['detail']}", file=sys.stderr)
    if not failed:
        return 0
    return 2 if any(error["type"] == "input-error" for _, error in failed) else 1
