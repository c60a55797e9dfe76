"""Check a document that rpr-cusps has printed, by independent means: its equations are derived anew from the
geometry by SymPy, and every digit and count is proved again by exact integers and intervals, without the
solver and its libraries."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

import rpr_solver
from service.cli import arguments, remote
from service.cli.document_file import read_document
from service.cli.pages import Page, Section, write_document
from service.cli.progress import progress_bar
from service.schemas.document import read
from service.schemas.verifications import VerificationRequest

DESCRIPTION = f"""{__doc__}

Exit status: 0 every claim is established, 1 a claim is refused, 2 bad input, 3 nothing is refused, but the
claims that the first line names are not established."""
EXAMPLES = """\
examples:
  rpr-cusps solve innocenti --l1 14.98 --format json > table.json
  rpr-cusps verify table.json
  rpr-cusps solve robot.json --l1 27 --format json | rpr-cusps verify - --json
"""

STATUS = {"established": 0, "refused": 1, "not established": 3}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("document", metavar="FILE", help="a document as JSON, or - for standard input")
    arguments.add_format(parser)
    parser.add_argument(
        "--effort",
        metavar="N",
        default="1",
        help="do N times the work that the length of the document allows, about ten seconds for each 100 kB; "
        "what is left then is not established (default: 1)",
    )
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    members = {"document": read_document(args.document), "effort": args.effort, **remote.deadline_of(args)}
    question = read(VerificationRequest, members, arguments.source())

    def here() -> dict[str, Any]:
        with progress_bar(1, "parts") as progress:
            verification = rpr_solver.verify_document(
                question.document, effort=question.effort, progress=progress
            )
        return {**question.geometry.identity_json(), **verification.to_json()}

    answer = remote.here_or_there(args.url, question, here)
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
