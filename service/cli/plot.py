"""Draw a slice, a census, how its transitions move, margins, the cusp curves, a loop round a cusp, the
mechanism; or a design or connections of poses, of which the JSON document is given in place of the geometry.
The suffix of the file selects SVG, PNG or PDF; without a file, SVG is printed. PNG and PDF need the extra
`plot`."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from rpr_solver import exact_str, parse_exact
from rpr_solver.errors import InputError
from rpr_solver.notebook import THEMES
from rpr_solver.notebook.figure import Figure, suffix_of
from service.cli import arguments, asking, output, parsers
from service.cli.output import progress_bar
from service.cli.parsers import Command
from service.schemas.document import named, read
from service.schemas.plots import LABELS, PlotRequest, Setting
from worker.answers import Store
from worker.answers.plots import PLOTS, figure

_OF_DOCUMENTS = {"design": "trace", "connections": "matrix"}
"""Pictures of documents in files, and a member that each of these documents has."""
_MILLIMETRES = {
    "mm": Fraction(1),
    "cm": Fraction(10),
    "in": Fraction(127, 5),
    "pt": Fraction(127, 5) / 72,
}
DESCRIPTION = f"{__doc__}\n\n{parsers.GEOMETRY}"
EXAMPLES = """\
examples:
  rpr-cusps plot innocenti --l1 27 -o slice.svg
  rpr-cusps plot innocenti --kind census -o census.pdf
  rpr-cusps plot innocenti --kind margin --l1-range 20:32 -o margin.svg
  rpr-cusps plot innocenti --kind loop --l1 27 --cusp B -o loop.svg
  rpr-cusps plot design.json --kind design -o design.svg
  rpr-cusps plot matrix.json --kind connections -o matrix.png
  rpr-cusps plot innocenti --l1 27 --width 86mm --style paper --unit mm --no-title -o fig1.pdf
  rpr-cusps plot robot.json --kind mechanism --l1 15 --l2 16 --l3 20 --theme dark -o pose.png
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--kind",
        dest="plot",
        choices=(*PLOTS, *_OF_DOCUMENTS),
        default="slice",
        metavar="KIND",
        help="the type of picture: a slice in the plane of the free legs (slice, the default) or on the "
        "torus of poses (torus), the census, the sensitivities of its transitions, the margin against the "
        "length of the leg, the cusp curves in joint space (locus) or in three planes (projections), a "
        "loop in motion, the mechanism, a design, or which poses are joined (connections)",
    )
    _OPTIONS.add_members(parser)
    parser.add_argument("--no-title", action="store_true", help="leave out the title above the picture")
    parser.add_argument("--no-caption", action="store_true", help="leave out the geometry below the picture")
    parser.add_argument("-o", "--output", metavar="FILE", help="a file that ends in .svg, .png or .pdf")
    parsers.add_url(parser)


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    suffix = _suffix(args)
    if args.plot in _OF_DOCUMENTS:
        return _written(_of_document(args).encoded(suffix), args.output)
    question = _OPTIONS.asked(args, plot=args.plot, labels=_labels(args))
    with progress_bar(1, "steps") as progress:
        if args.url is None:
            content = figure(question.job_request(), Store(), progress).encoded(suffix)
        else:
            content = asking.document_of(args.url, question, progress)["svg"].encode()
    return _written(content, args.output)


def _of_document(args: argparse.Namespace) -> Figure:
    """The figure of a document in a file."""
    from rpr_solver.figures import figure_of
    from worker.answers.pictures import style_of

    given = {name: getattr(args, name) for name in ("style", "unit") if getattr(args, name) is not None}
    members = {"labels": _labels(args), **given}
    if args.width_mm is not None:
        members["width_mm"] = _width(args.width_mm)
    origin = arguments.source({"width_mm": "--width", "unit": "--unit"})
    style = style_of(read(Setting, members, origin).setting())
    try:
        document = json.loads(arguments.text_of(args.geometry))
        document[_OF_DOCUMENTS[args.plot]]  # another document has a figure, too
        figure = figure_of(document).styled(style)
    except (ValueError, TypeError, KeyError):
        message = f"{args.geometry!r} has no {args.plot}; give what {args.plot} --format json writes"
        raise InputError.of("GEOMETRY", message) from None
    return replace(figure, theme=args.theme or THEMES[0])


def _written(content: bytes, target: str | None) -> int:
    if target is None:
        output.write(content.decode())
        return 0
    try:
        Path(target).write_bytes(content)
    except OSError as error:
        raise InputError.of("--output", f"{target!r} cannot be written: {error.strerror}") from None
    return 0


def _labels(args: argparse.Namespace) -> str:
    return LABELS[2 * args.no_title + args.no_caption]


def _width(text: str) -> str:
    """A width in millimetres, exactly.

    Raises:
        InputError: naming `--width`: it has no such unit.
    """
    unit = next((unit for unit in _MILLIMETRES if text.endswith(unit)), None)
    if unit is None:
        known = "86mm, 8.6cm, 3.4in or 245pt"
        raise InputError.of("--width", f"is {text[:40]!r}; give a length with its unit, such as {known}")
    with named("--width"):
        return exact_str(parse_exact(text.removesuffix(unit), "") * _MILLIMETRES[unit])


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


_OPTIONS = asking.Options(
    PlotRequest,
    {
        "l1": "the length of a leg",
        "range": "the range of a census, sensitivities, margins, a locus or its projections (default: all)",
        "cusp": "the number or letter of the cusp in the table of the slice (default: A)",
        "pose": "the number of the pose with these three lengths (default: 1)",
        "theme": "default: auto, the reader's setting",
        "width_mm": "for print: 86mm, 8.6cm, 3.4in or 245pt; the letters have 8 to 12 points",
        "style": "paper: symbols in italics with subscripts, and a serif font (default: page)",
        "unit": "the unit of lengths, for the axes, such as mm",
    },
    {"width_mm": "--width", "plot": "", "labels": ""},
    {"width_mm": _width},
)

COMMANDS = {"plot": Command(DESCRIPTION, EXAMPLES, configure, run)}
