"""Documents in files: checked by independent means, or written as scripts for other systems."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from datetime import date
from pathlib import Path
from typing import Any

import rpr_solver
from rpr_solver.errors import InputError
from rpr_solver.exports.export import SYSTEMS
from rpr_solver.exports.papers import bibtex
from service.cli import arguments, asking, output, parsers
from service.cli.pages import Page, Section, write_document
from service.cli.parsers import Command
from service.schemas.document import JsonError, parse_json, plain, read, renamed
from service.schemas.verifications import VerificationRequest


def read_document(name: str) -> Mapping[str, Any]:
    """Returns the document.

    Raises:
        InputError: the file cannot be read, or holds no object.
    """
    shown = arguments.shown_name(name)
    try:
        body = sys.stdin.buffer.read() if name == parsers.STANDARD_INPUT else Path(name).read_bytes()
        document = plain(parse_json(body, shown))
    except OSError as error:
        raise InputError.of("FILE", f"{shown} cannot be read: {error.strerror}") from None
    except JsonError as error:
        raise InputError.of("FILE", error.detail) from None
    if not isinstance(document, dict):
        raise InputError.of("FILE", f"{shown} holds no object; give a document of rpr-cusps")
    return document


_VERIFY = """\
Verify a document of rpr-cusps by independent means: its equations are derived again from the geometry by
SymPy, and every digit and count is proved by exact integers and intervals, without the solver and its
libraries.

Exit status: 0 every claim is established, 1 a claim is refused, 2 bad input, 3 nothing is refused, but the
claims named in the first line are not established."""
_VERIFY_EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98 --format json > table.json
  rpr-cusps verify table.json
  rpr-cusps solve robot.json --l1 27 --format json | rpr-cusps verify - --json
"""

STATUS = {"established": 0, "refused": 1, "not established": 3}


def _configure_verify(parser: argparse.ArgumentParser) -> None:
    """Add the options of `verify`."""
    parser.add_argument("document", metavar="FILE", help="a document as JSON, or - for standard input")
    parsers.add_format(parser)
    parser.add_argument(
        "--effort",
        metavar="N",
        default="1",
        help="allow N times the usual work, which is about ten seconds for each 100 kB of the document; "
        "claims that are left then are not established (default: 1)",
    )
    parsers.add_url(parser)


def _run_verify(args: argparse.Namespace) -> int:
    """Run `verify`; returns the exit status."""
    members = {"document": read_document(args.document), "effort": args.effort, **asking.deadline_of(args)}
    question = read(VerificationRequest, members, arguments.source())
    answer = asking.answer_of(args.url, question, "parts")
    write_document(answer, _page(answer), args.format)
    return STATUS[answer["outcome"]]


def _page(answer: Mapping[str, Any]) -> Page:
    claims, counts, unread = answer["claims"], answer["counts"], answer["unread"]
    numbers = ", ".join(f"{n} {status.replace('_', ' ')}" for status, n in counts.items() if n)
    title = f"{answer['document']['kind']} of {answer['document']['geometry_hash']}: {numbers or 'no claims'}"
    shown = [claim for claim in claims if claim["status"] != "proved"]
    notes = [f"{x['at'] or 'the document'}: {x['status']}: {x['claim']}: {x['reason']}" for x in shown]
    notes += [f"not read, so nothing is said of it: {', '.join(unread)}"] if unread else []
    return Page(answer["summary"], [Section(title, notes=notes, failed=answer["verdict"] == "refused")])


_EXPORT = """\
Write a cusp table or a census as a script for another system. The script repeats the computation from the
geometry and compares: its last line is "agrees" or "differs". For msolve, a slice is written as a system of
equations."""
_EXPORT_EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98 --digits 30 --format json > table.json
  rpr-cusps export table.json --to pari -o table.gp && gp -q table.gp
  rpr-cusps census robot.json --digits 20 --format json | rpr-cusps export - --to sympy | python
"""


def _configure_export(parser: argparse.ArgumentParser) -> None:
    """Add the options of `export`."""
    parser.add_argument("document", metavar="FILE", help="a cusp table or a census as JSON, or -")
    parser.add_argument(
        "--to", required=True, choices=SYSTEMS, help="the system that runs it; msolve takes one slice only"
    )
    parser.add_argument(
        "-o", "--output", metavar="SCRIPT", help="the file to write (default: standard output)"
    )


def _run_export(args: argparse.Namespace) -> int:
    """Run `export`; returns the exit status."""
    document = read_document(args.document)
    try:
        script = rpr_solver.export(document, args.to)
    except InputError as error:
        raise renamed(error, lambda field: "FILE" + field.removeprefix("document")) from None
    if args.output is None:
        output.write(script)
        return 0
    try:
        Path(args.output).write_text(script, encoding="utf-8")
    except OSError as error:
        raise InputError.of("--output", f"{args.output!r} cannot be written: {error.strerror}") from None
    return 0


_CITE = """\
Print a reference to a document, in BibTeX: what was asked of which geometry, and which software answered, so
that a number in a paper can be asked again."""
_CITE_EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98 --format json | rpr-cusps cite - >> references.bib
"""


def _configure_cite(parser: argparse.ArgumentParser) -> None:
    """Add the options of `cite`."""
    parser.add_argument("document", metavar="FILE", help="an answer of rpr-cusps as JSON, or -")


def _run_cite(args: argparse.Namespace) -> int:
    """Run `cite`; returns the exit status."""
    document = read_document(args.document)
    try:
        entry = bibtex(document, rpr_solver.__version__, date.today().year)
    except InputError as error:
        raise renamed(error, lambda field: "FILE" + field.removeprefix("document")) from None
    output.write(entry)
    return 0


COMMANDS = {
    "cite": Command(_CITE, _CITE_EXAMPLES, _configure_cite, _run_cite),
    "verify": Command(_VERIFY, _VERIFY_EXAMPLES, _configure_verify, _run_verify),
    "export": Command(_EXPORT, _EXPORT_EXAMPLES, _configure_export, _run_export),
}
