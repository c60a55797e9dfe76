"""Draw a slice, a census, how its transitions move, margins, the cusp curves, a loop round a cusp, the
mechanism, or a design, of which the JSON document is given in place of the geometry. The suffix of the file
selects SVG, PNG or PDF; without a file, SVG is printed. PNG and PDF need the extra `plot`."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

from rpr_solver.errors import InputError
from rpr_solver.notebook.figure import Figure, suffix_of
from rpr_solver.notebook.scene import THEMES
from service.cli import arguments, output, remote
from service.cli.help import Command
from service.cli.output import progress_bar
from service.schemas.document import named
from service.schemas.lengths import LEGS
from service.schemas.plots import PlotRequest
from worker.answers.plots import PLOTS, figure
from worker.answers.requests import Store

_DESIGN = "design"
DESCRIPTION = f"{__doc__}\n\n{arguments.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps plot innocenti --l1 27 -o slice.svg
  rpr-cusps plot innocenti --kind census -o census.pdf
  rpr-cusps plot innocenti --kind margin --l1-range 20:32 -o margin.svg
  rpr-cusps plot innocenti --kind loop --l1 27 --cusp B -o loop.svg
  rpr-cusps plot design.json --kind design -o design.svg
  rpr-cusps plot robot.json --kind mechanism --l1 15 --l2 16 --l3 20 --theme dark -o pose.png
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_geometry(parser)
    parser.add_argument(
        "--kind",
        dest="plot",
        choices=(*PLOTS, _DESIGN),
        default="slice",
        metavar="KIND",
        help="the type of picture: a slice in the plane of the free legs (slice, the default) or on the "
        "torus of poses (torus), the census, the sensitivities of its transitions, the margin against the "
        "length of the leg, the cusp curves in joint space (locus), a loop in motion, the mechanism, or a "
        "design",
    )
    arguments.add_options(parser, "--l{}", "lengths", "X", "the length of a leg")
    arguments.add_ranges(parser, "the range of a census, sensitivities, margins or a locus (default: all)")
    parser.add_argument(
        "--cusp",
        metavar="CUSP",
        help="the number or letter of the cusp in the table of the slice (default: A)",
    )
    parser.add_argument(
        "--pose", metavar="N", help="the number of the pose with these three lengths (default: 1)"
    )
    parser.add_argument("--theme", choices=THEMES, default="auto", help="default: auto, the reader's setting")
    parser.add_argument("-o", "--output", metavar="FILE", help="a file that ends in .svg, .png or .pdf")
    remote.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    suffix = _suffix(args)
    if args.plot == _DESIGN:
        return _written(_design(args).encoded(suffix), args.output)
    question = _question(args)
    with progress_bar(1, "steps") as progress:
        if args.url is None:
            content = figure(question.job_request(), Store(), progress).encoded(suffix)
        else:
            content = remote.document_of(args.url, question, progress)["svg"].encode()
    return _written(content, args.output)


def _design(args: argparse.Namespace) -> Figure:
    """The figure of a design document in a file."""
    from rpr_solver.figures.designs import design_figure

    known = "give what design --format json writes"
    try:
        document = json.loads(arguments.text_of(args.geometry))
        figure = design_figure(document)
    except (ValueError, TypeError, KeyError):
        raise InputError.of("GEOMETRY", f"{args.geometry!r} is no design; {known}") from None
    return replace(figure, theme=args.theme)


def _written(content: bytes, target: str | None) -> int:
    if target is None:
        output.write(content.decode())
        return 0
    try:
        Path(target).write_bytes(content)
    except OSError as error:
        raise InputError.of("--output", f"{target!r} cannot be written: {error.strerror}") from None
    return 0


def _suffix(args: argparse.Namespace) -> str:
    if args.output is None:
        return ".svg"
    with named("--output"):
        try:
            suffix = suffix_of(Path(args.output))
        except InputError as error:
            raise InputError.of("", error.problems[0].message) from None
    if args.url is not None and suffix != ".svg":
        raise InputError.of("--output", "a service draws SVG; leave out --url for PNG or PDF")
    return suffix


def _question(args: argparse.Namespace) -> PlotRequest:
    if args.ranges:
        leg, ends, option = arguments.leg_and_range(args)
    else:
        own = args.lengths if len(args.lengths) == 1 else ()
        fixed = args.fixed_leg
        leg, ends, option = arguments.leg_of(own, fixed, "lengths"), None, "range"
    members = {
        "plot": args.plot,
        "theme": args.theme,
        "fixed_leg": leg,
        **{option[2:]: text for option, text in args.lengths},
        "range": ends,
        "cusp": args.cusp,
        "pose": args.pose,
        **remote.deadline_of(args),
    }
    names = {"range": option, **{name: f"--{name}" for name in (*LEGS, "cusp", "pose")}}
    return arguments.ask(PlotRequest, args, members, arguments.source(names))


COMMANDS = {"plot": Command(DESCRIPTION, EXAMPLES, configure, run)}
