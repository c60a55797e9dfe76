"""Search for a geometry by what is wanted of its cusps: the longest range of lengths in which a requirement
holds, the least change that meets it, the largest margin, or the most cusps.

Every candidate is examined by an exact census, and the best one found is proved anew. Nothing says that there
is no better one. The search needs the extra design: pip install 'rpr-cusps[design]'."""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections.abc import Mapping
from math import inf
from typing import Any

from rpr_solver import Progress, design_csv
from rpr_solver.contract import letter
from rpr_solver.designs.questions import CANCELED, DEADLINE
from rpr_solver.errors import InputError
from service.cli import arguments, remote
from service.cli.help import Command
from service.cli.output import progress_bar
from service.cli.pages import Page, Section, about, rows_of, write_document
from service.schemas.designs import DesignRequest
from service.schemas.lengths import split_ends
from worker.answers.designs import Observer
from worker.answers.requests import Store, answer

DESCRIPTION = f"""{__doc__}

{arguments.GEOMETRY}

Ctrl-C, or --deadline, ends the search with the proof of the best found so far.

Exit status: 0 the wish is met, 1 it is not met within the budget, 2 bad input."""
EXAMPLES = """\
examples:
  rpr-cusps design innocenti --objective longest-range --l1-range 5:30 --max-cusps 4 --vary 15% --fix a2x
  rpr-cusps design robot.json --objective least-change --l1-range 5:30 --max-cusps 6 --ignore-windows 0.001
  rpr-cusps design robot.json --objective most-cusps --family isosceles-1 --vary t1=0.05:3,d1=1:40,d2=1:70
"""

MET, NOT_MET = 0, 1
_OPTIONS = {
    "objective": "longest-range, least-change, largest-margin or most-cusps",
    "vary": "how far lengths may change: 15%% of each, or d1=16:18,a2x=15:17 alone (default: 10%%)",
    "family": "tie the lengths: isosceles-1, isosceles-2, isosceles-3, similar, congruent or mirror",
    "decimals": "decimals of the lengths that vary (default: 4)",
    "min_height": "the least height of both triangles (default: a hundredth of their longest sides)",
    "ignore_windows": "windows up to this width are left aside in the search, not in the proof (default: 0)",
    "loop": "required or excluded: a loop round a cusp, in the range and within the joint limits",
    "min_aspects": "the least number of aspects of every slice of the range",
    "max_aspects": "the greatest one",
    "seed": "of the random numbers (default: 1)",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    arguments.add_requirement(parser, "the range of lengths; either end may be omitted")
    for name, text in _OPTIONS.items():
        parser.add_argument(_option(name), dest=name, metavar="X", required=name == "objective", help=text)
    parser.add_argument("--fix", metavar="NAMES", help="lengths that keep their values, as a2x,d1")
    parser.add_argument("--budget", metavar="N", help="how many geometries are examined (default: 300)")
    arguments.add_format(parser, "csv")
    remote.add_url(parser, "end with the best found until then; with --url, the proof of it is in this time")


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    members: dict[str, object] = {name: getattr(args, name) for name in _OPTIONS}
    names = {name: _option(name) for name in _OPTIONS} | {"fixed": "--fix", "budget.censuses": "--budget"}
    members["vary"] = _bounds(args.vary) if "=" in (args.vary or "") else args.vary
    members["fixed"] = None if args.fix is None else [name.strip() for name in args.fix.split(",")]
    members["budget"] = None if args.budget is None else {"censuses": args.budget}
    if args.ranges or args.max_cusps is not None or args.min_cusps is not None:
        members["requirement"], places = arguments.requirement_of(args)
        names |= places
    elif args.limits:
        raise InputError.of("--l1-range", "is missing; a requirement needs the range of lengths")
    members["deadline_s"] = args.deadline
    asked = arguments.ask(DesignRequest, args, members, arguments.source(names))
    document = _computed(asked) if args.url is None else remote.answer_of(args.url, asked)
    write_document(document, _page(document), args.format, csv=design_csv)
    return MET if document["best"]["met"] else NOT_MET


class _Stoppable(Observer):
    """The progress of a search that Ctrl-C or a deadline ends; a second Ctrl-C ends the command."""

    def __init__(self, report: Progress, end: float) -> None:
        super().__init__(report)
        self.end, self.is_canceled = end, False

    def cancel(self, *_: object) -> None:
        """Ask for the end."""
        self.is_canceled = True
        signal.signal(signal.SIGINT, signal.default_int_handler)
        print("proving the best found so far; Ctrl-C again ends at once", file=sys.stderr)

    def reason_to_stop(self) -> str | None:
        """Returns why the search is to end, or None."""
        return CANCELED if self.is_canceled else DEADLINE if time.monotonic() > self.end else None


def _computed(question: DesignRequest) -> dict[str, Any]:
    end = inf if question.deadline_s is None else time.monotonic() + question.deadline_s
    with progress_bar(1, "censuses") as progress:
        stoppable = _Stoppable(progress, end)
        before = signal.signal(signal.SIGINT, stoppable.cancel)
        try:
            return answer(question.job_request(), Store(), stoppable)
        finally:
            signal.signal(signal.SIGINT, before)


def _option(member: str) -> str:
    return f"--{member.replace('_', '-')}"


def _bounds(text: str) -> dict[str, object]:
    """The bounds in d1=16:18,a2x=15:17."""
    pairs = [part.partition("=") for part in text.split(",")]
    return {name.strip(): split_ends(ends) for name, _, ends in pairs}


def _page(document: Mapping[str, Any]) -> Page:
    best, start, asked = document["best"], document["start"], document["asked"]
    margin = best["margin"]
    values = [
        ("value", best["value"]),
        ("of the given geometry", start["value"]),
        ("met", "yes" if best["met"] else "no"),
        ("margin, proved", None if margin is None else margin["proved"]),
        *_kept(best.get("constraints"), asked["requirement"]["fixed_leg"]),
        ("narrow windows left", str(len(best["windows_left"])) if asked["ignore_windows"] != "0" else None),
        ("geometries examined", f"{document['censuses']}; stopped: {document['stopped']}"),
    ]
    lengths = {name: x for name, x in best["geometry"].items() if name != "orientation"}
    change = {name: best["change"][name] for name in lengths}
    rows = [{"": "best found", **lengths}, {"": "change", **change}]
    trace = [{"census": one["census"], "value": one["value"], **one["geometry"]} for one in document["trace"]]
    shown = [["", ""], *([name, text] for name, text in values if text is not None)]
    sections = [
        Section(f"Best found: {asked['objective']}", shown),
        Section("Geometry", rows_of(rows)),
        Section("Improvements", rows_of(trace)),
    ]
    return Page(about(document), sections, document["digits"])


def _kept(kept: Mapping[str, Any] | None, leg: int) -> list[tuple[str, str | None]]:
    """What is proved of the constraints."""
    if kept is None:
        return []
    loop, least, most = kept["loop"], kept["min_aspects_found"], kept["max_aspects_found"]
    return [
        ("constraints kept", "yes" if kept["met"] else "no"),
        ("loop, proved", loop and f"round cusp {letter(loop['cusp'])} of L{leg} = {loop[f'l{leg}']}"),
        ("aspects", None if least is None else str(least) if least == most else f"{least} to {most}"),
    ]


COMMANDS = {"design": Command(DESCRIPTION, EXAMPLES, configure, run)}
