"""Check a document that rpr-cusps has printed, by independent means: its equations are derived anew from the
geometry by SymPy, and every digit and count is proved again by exact integers and intervals, without the
solver and its libraries."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import rpr_solver
from rpr_solver.errors import InputError
from service.cli import arguments, remote
from service.cli.pages import Page, Section, counted, write_document
from service.cli.progress import progress_bar
from service.schemas.document import read
from service.schemas.verifications import VerificationRequest

DESCRIPTION = f"{__doc__}\n\nExit status: 0 accepted, 1 refused, 2 bad input."
EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98 --format json > table.json
  rpr-cusps verify table.json
  rpr-cusps solve robot.json --l1 27 --format json | rpr-cusps verify - --json
"""

REFUSED = 1
_SHOWN = ("refused", "not checked")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("document", metavar="FILE", help="a document as JSON, or - for standard input")
    arguments.add_format(parser)
    parser.add_argument(
        "--json", dest="format", action="store_const", const="json", help="the same as --format json"
    )
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    members = {"document": _read(args.document), **remote.deadline_of(args)}
    question = read(VerificationRequest, members, arguments.source())

    def here() -> dict[str, Any]:
        with progress_bar(1, "parts") as progress:
            verification = rpr_solver.verify_document(question.document, progress=progress)
        return {**question.geometry.identity_json(), **verification.to_json()}

    answer = remote.here_or_there(args.url, question, here)
    write_document(answer, _page(answer), args.format)
    return 0 if answer["verdict"] == "accepted" else REFUSED


def _read(name: str) -> Mapping[str, Any]:
    shown = arguments.shown_name(name)
    try:
        body = sys.stdin.buffer.read() if name == arguments.STANDARD_INPUT else Path(name).read_bytes()
        document = json.loads(body)
    except OSError as error:
        raise InputError.of("FILE", f"{shown} cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputError.of("FILE", f"{shown} is not JSON: {error}") from None
    if not isinstance(document, dict):
        raise InputError.of("FILE", f"{shown} holds no object; give a document of rpr-cusps")
    return document


def _page(answer: Mapping[str, Any]) -> Page:
    claims, counts = answer["claims"], answer["counts"]
    numbers = ", ".join(f"{n} {status.replace('_', ' ')}" for status, n in counts.items() if n)
    title = f"{answer['verdict'].capitalize()}: {counted(len(claims), 'claim')}, {numbers}"
    shown = [claim for claim in claims if claim["status"] in _SHOWN]
    notes = [f"{x['at']}: {x['status']}: {x['claim']}: {x['reason']}" for x in shown]
    about = f"Verification of {answer['document']['kind']} of {answer['document']['geometry_hash']}"
    return Page(about, [Section(title, notes=notes, failed=answer["verdict"] == "refused")])
