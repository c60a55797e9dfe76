"""Write a cusp table or a census as a script for another system, which computes the same anew from the
geometry and compares: its last line is "agrees" or "differs". For msolve, a slice is written as a system of
equations."""

from __future__ import annotations

import argparse
from pathlib import Path

import rpr_solver
from rpr_solver.errors import InputError
from rpr_solver.exports.export import SYSTEMS
from service.cli import output
from service.cli.document_file import read_document
from service.schemas.document import renamed

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98 --digits 30 --format json > table.json
  rpr-cusps export table.json --to pari -o table.gp && gp -q table.gp
  rpr-cusps census robot.json --digits 20 --format json | rpr-cusps export - --to sympy | python
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("document", metavar="FILE", help="a cusp table or a census as JSON, or -")
    parser.add_argument(
        "--to", required=True, choices=SYSTEMS, help="the system that runs it; msolve takes one slice only"
    )
    parser.add_argument(
        "-o", "--output", metavar="SCRIPT", help="the file to write (default: standard output)"
    )


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
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
