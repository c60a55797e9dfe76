"""Find a loop of the leg lengths round a cusp that carries one pose to another without a singularity. It is
proved along the whole path, not only at the samples."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

import rpr_solver
from rpr_solver.paths.path import DEFAULT_SAMPLES, PATH_DIGITS, letter
from rpr_solver.paths.timing import TIMINGS
from service.cli import arguments, remote
from service.cli.pages import Page, Section, about, counted, rows_of, write_document
from service.cli.progress import progress_bar
from service.schemas.paths import PathRequest

DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps paths innocenti --l1 27 --cusp B
  rpr-cusps paths innocenti --l1 28.1 --cusp 7 --samples 501 --duration 10 --format csv
"""

_SHOWN_ROWS = 25


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    arguments.add_options(parser, "--l{}", "lengths", "X", "the length of the fixed leg")
    parser.add_argument(
        "--fixed-leg", metavar="LEG", help="the fixed leg (default: the leg of the length, or 1)"
    )
    parser.add_argument(
        "--cusp", metavar="CUSP", help="its number in the table of the slice, or its letter (default: A)"
    )
    parser.add_argument("--samples", metavar="N", help=f"number of samples (default: {DEFAULT_SAMPLES})")
    parser.add_argument("--timing", choices=tuple(TIMINGS), help="the law of time (default: cosine)")
    parser.add_argument("--duration", metavar="T", help="the time of the last sample (default: 1)")
    parser.add_argument(
        "--others", action="store_true", default=None, help="follow the other poses too, as far as they live"
    )
    arguments.add_digits(parser, PATH_DIGITS)
    arguments.add_format(parser, "csv")
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    question = _question(args)
    if args.url is None:
        document = _loop(question)
    else:
        with progress_bar(1, "steps") as progress:
            document = remote.document_of(args.url, question, progress)
    write_document(document, _page(document), args.format, csv=rpr_solver.path_csv)
    return 0


def _loop(question: PathRequest) -> dict[str, Any]:
    loop = rpr_solver.cusp_loop(
        question.geometry,
        question.length,
        question.cusp,
        fixed_leg=question.fixed_leg,
        digits=question.digits,
        samples=question.samples,
        timing=question.timing,
        duration=question.duration,
    )
    return (loop.with_others() if question.others else loop).to_json()


def _question(args: argparse.Namespace) -> PathRequest:
    leg = arguments.leg_of(args.lengths, args.fixed_leg, "lengths")
    members = {
        "fixed_leg": leg,
        **{option[2:]: text for option, text in args.lengths},
        "cusp": args.cusp,
        "samples": args.samples,
        "timing": args.timing,
        "duration": args.duration,
        "others": args.others,
        **remote.deadline_of(args),
    }
    names = {name: f"--{name}" for name in ("l1", "l2", "l3", "cusp", "timing", "duration")}
    return arguments.ask(PathRequest, args, members, arguments.source(names))


def _page(document: Mapping[str, Any]) -> Page:
    legs = ", ".join(f"L{i} = {document[f'l{i}']}" for i in arguments.LEGS)
    sign = "J > 0" if document["sign"] > 0 else "J < 0"
    ends = f"from pose {document['from']['pose']} to pose {document['to']['pose']}"
    title = f"Loop round cusp {letter(document['cusp'])}, {ends} of {legs}: {sign}"
    samples = document["samples"]
    step = -(-(len(samples) - 1) // (_SHOWN_ROWS - 1))
    shown = [*samples[:-1:step], samples[-1]]
    least = document["certificate"]["least_determinant"]
    notes = [f"Proved along the whole path: |determinant| ≥ {least}; once round the cusp, counter-clockwise."]
    if len(shown) < len(samples):
        notes.append(f"{counted(len(samples), 'sample')}, of which {len(shown)} are shown.")
    notes += [_fate(other) for other in document["others"] or ()]
    return Page(about(document), [Section(title, rows_of(shown), notes)], document["digits"])


def _fate(other: Mapping[str, Any]) -> str:
    """What becomes of another pose."""
    pose = f"Pose {other['from']['pose']}"
    if other["to"] is not None:
        return f"{pose} is carried to pose {other['to']['pose']}."
    fold = other["fold"]
    if fold is None:
        return f"{pose}: not decided."
    legs = ", ".join(f"L{i} = {fold[f'l{i}']}" for i in arguments.LEGS)
    return f"{pose} ends on a fold at {legs}."
