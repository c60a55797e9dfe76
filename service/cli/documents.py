"""Documents: checked by independent means, written as scripts for other systems, and cited; and pictures."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from datetime import date
from fractions import Fraction
from pathlib import Path
from typing import Any

import rpr_solver
from rpr_solver import exact_str, parse_exact
from rpr_solver.errors import InputError, clipped
from rpr_solver.exports import bibtex
from rpr_solver.exports.export import ROBOTS, SYSTEMS
from rpr_solver.notebook.figure import Figure, draw, suffix_of
from service.cli import arguments, asking, output, parsers
from service.cli.output import progress_bar
from service.cli.pages import Page, Section, write_document
from service.cli.parsers import Command
from service.schemas.document import JsonError, named, parse_json, plain, read, renamed, unnamed
from service.schemas.limits import Limits
from service.schemas.plots import LABELS, PlotRequest, Setting, VerificationRequest
from worker.answers import Store
from worker.answers.documents import PLOTS, figure, style_of


def read_document(name: str) -> Mapping[str, Any]:
    """Returns the document.

    Raises:
        InputError: the file cannot be read, or holds no object.
    """
    shown = arguments.shown_name(name)
    try:
        body = sys.stdin.buffer.read() if name == parsers.STANDARD_INPUT else Path(name).read_bytes()
        document = plain(parse_json(body, shown, Limits.of_environment()))
    except OSError as error:
        raise InputError.of("FILE", f"{shown} cannot be read: {error.strerror}") from None
    except JsonError as error:
        raise InputError.of("FILE", error.detail) from None
    if not isinstance(document, dict):
        raise InputError.of("FILE", f"{shown} holds no object; give a document of rpr-cusps")
    return document


STATUS = {"verified": 0, "refused": 1, "not verified": 3}


def _configure_verify(parser: argparse.ArgumentParser) -> None:
    """Add the options of `verify`.

    Options:
        FILE: a document as JSON, or - for standard input
        --verbose: list all claims with their reasons, and the members that claim nothing
    """
    parser.add_argument("document", metavar="FILE")
    parser.add_argument("--verbose", action="store_true")
    parsers.add_format(parser)
    parsers.add_url(parser)


def _run_verify(args: argparse.Namespace) -> int:
    """Verify a document of rpr-cusps by independent means: everything in it is computed again from the
    geometry alone, with equations that SymPy derives from the legs, without the solver.

    Exit status: 0 every claim is proved, 1 a claim is refused, 2 bad input, 3 nothing is refused, but the
    claims named in the first line are open.

    examples:
      rpr-cusps solve innocenti --l1 14.98 --format json > table.json
      rpr-cusps verify table.json
      rpr-cusps solve robot.json --l1 27 --format json | rpr-cusps verify - --json
    """
    members = {"document": read_document(args.document), **asking.deadline_of(args)}
    question = read(VerificationRequest, members, arguments.source())
    answer = asking.answer_of(args.url, question, "parts")
    write_document(answer, _page(answer, args.verbose), args.format)
    return STATUS[answer["verdict"]]


def _page(answer: Mapping[str, Any], is_verbose: bool) -> Page:
    claims = [x for x in answer["claims"] if is_verbose or x["status"] != "proved"]
    notes = [f"{x['at'] or 'the document'}: {x['status']}: {x['claim']}: {x['reason']}" for x in claims]
    notes += [f"no claims: {', '.join(answer['no_claims'])}"] if is_verbose else []
    title = f"{answer['document']['kind']} of {answer['document']['geometry_hash']}"
    return Page(answer["summary"], [Section(title, notes=notes, failed=answer["verdict"] == "refused")])


_OF_ROBOTS = ("unit", "relative", "pose", "name")


def _configure_export(parser: argparse.ArgumentParser) -> None:
    """Add the options of `export`.

    Options:
        FILE: a cusp table or a census as JSON, or -; a path for ROS 2, poses for SDFormat
        --to: maple, msolve (one slice), pari, sage or sympy; ros2-json or ros2-yaml for a path, sdf for poses
        --unit: for robots: the unit of the geometry's lengths, which become metres
        --relative: for ROS 2: positions are changes of lengths since the start of the path
        --pose: for SDFormat: the number of the pose (default: 1)
        --name: for SDFormat: the name of the model
        --output: the file to write (default: standard output)
    """
    parser.add_argument("document", metavar="FILE")
    parser.add_argument("--to", required=True, choices=(*SYSTEMS, *ROBOTS), metavar="SYSTEM")
    parser.add_argument("--unit", metavar="UNIT")
    parser.add_argument("--relative", action="store_true", default=None)
    parser.add_argument("--pose", type=int, metavar="N")
    parser.add_argument("--name")
    parser.add_argument("-o", "--output", metavar="SCRIPT")


def _run_export(args: argparse.Namespace) -> int:
    """Write a cusp table or a census as a script for another system. The script repeats the computation from
    the geometry and compares: its last line is "agrees", "differs" or "cannot decide with N digits". For
    msolve, a slice is written as a system of equations. A path is written as a JointTrajectory of ROS 2, and
    the machine at a pose as a model of SDFormat.

    examples:
      rpr-cusps solve innocenti --l1 14.98 --digits 30 --format json > table.json
      rpr-cusps export table.json --to pari -o table.gp && gp -q table.gp
      rpr-cusps census robot.json --digits 20 --format json | rpr-cusps export - --to sympy | python
      rpr-cusps path robot.json --l1 27 --speed 10 --acceleration 20 --format json > path.json
      rpr-cusps export path.json --to ros2-yaml --unit mm > trajectory.yaml
      rpr-cusps poses robot.json --l1 27 --l2 20 --l3 20 --format json > poses.json
      rpr-cusps export poses.json --to sdf --unit mm --pose 2 -o robot.sdf
    """
    document = read_document(args.document)
    options = {name: getattr(args, name) for name in _OF_ROBOTS}

    def place(field: str) -> str:
        inside = field.removeprefix("document").removeprefix(".")
        return f"--{field}" if field in _OF_ROBOTS else f"FILE.{inside}" if inside else "FILE"

    try:
        script = rpr_solver.export(document, args.to, **options)
    except InputError as error:
        raise renamed(error, place) from None
    return _written(script.encode(), args.output)


def _configure_cite(parser: argparse.ArgumentParser) -> None:
    """Add the options of `cite`.

    Options:
        FILE: an answer of rpr-cusps as JSON, or -
    """
    parser.add_argument("document", metavar="FILE")


def _run_cite(args: argparse.Namespace) -> int:
    """Print a reference to a document, in BibTeX: what was asked of which geometry, and which software
    answered, so that readers can reproduce a number in a paper.

    examples:
      rpr-cusps solve innocenti --l1 14.98 --format json | rpr-cusps cite - >> references.bib
    """
    document = read_document(args.document)
    with named("FILE"), unnamed("document"):
        entry = bibtex(document, rpr_solver.__version__, date.today().year)
    output.write(entry)
    return 0


_OF_DOCUMENTS = {"design": "trace", "connections": "matrix", "along": "moving_leg"}
"""Pictures of documents in files, and a member that each of these documents has."""
_KINDS = (*PLOTS, *_OF_DOCUMENTS)
_MILLIMETRES = {"mm": Fraction(1), "cm": Fraction(10), "in": Fraction(127, 5), "pt": Fraction(127, 5) / 72}


def _configure_plot(parser: argparse.ArgumentParser) -> None:
    """Add the options.

    Options:
        --kind: the type of picture: a slice in the plane of the free legs (slice, the default) or on the
            torus of poses (torus), the census, the sensitivities of its transitions, the margin against the
            length of the leg, the cusp curves in joint space (locus) or in three planes (projections), a
            loop, the mechanism, the workspace at an orientation, a design, which poses are joined
            (connections), poses along a leg (along)
        --no-title: leave out the title above the picture
        --no-caption: leave out the geometry below the picture
        --output: a file that ends in .svg, .png or .pdf
    """
    parser.add_argument("--kind", dest="plot", choices=_KINDS, default="slice", metavar="KIND")
    _OPTIONS.add_members(parser)
    parser.add_argument("--no-title", action="store_true")
    parser.add_argument("--no-caption", action="store_true")
    parser.add_argument("-o", "--output", metavar="FILE")
    parsers.add_url(parser)


def _run_plot(args: argparse.Namespace) -> int:
    """Draw a slice, a census, how its transitions move, margins, the cusp curves, a loop round a cusp, the
    mechanism, or the workspace at an orientation. To draw a design, connections of poses or poses along a
    leg, give the JSON document instead of the geometry. The suffix of the file selects SVG, PNG or PDF;
    without a file, SVG is printed. Drawing needs the extra `plot` (matplotlib).

    Options:
        l1: the length of a leg
        range: the range of a census, sensitivities, margins, a locus or its projections (default: all)
        cusp: the number or letter of the cusp in the table of the slice (default: A)
        pose: the number of the pose with these three lengths (default: 1)
        phi: the orientation of a workspace, in degrees
        limits: a leg, of a workspace
        width_mm: for print: 86mm, 8.6cm, 3.4in or 245pt; the type has 8 to 12 points

    examples:
      rpr-cusps plot innocenti --l1 27 -o slice.svg
      rpr-cusps plot innocenti --kind census -o census.pdf
      rpr-cusps plot innocenti --kind margin --l1-range 20:32 -o margin.svg
      rpr-cusps plot innocenti --kind loop --l1 27 --cusp B -o loop.svg
      rpr-cusps plot innocenti --kind workspace --phi 30 --l1-limits 5:30 --l2-limits 5:25 -o places.svg
      rpr-cusps plot design.json --kind design -o design.svg
      rpr-cusps plot matrix.json --kind connections -o matrix.png
      rpr-cusps plot along.json --kind along -o along.svg
      rpr-cusps plot innocenti --l1 27 --width 86mm --style paper --unit mm --no-title -o fig1.pdf
      rpr-cusps plot robot.json --kind mechanism --l1 15 --l2 16 --l3 20 --theme dark -o pose.png
    """
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
    """The figure of a document in a file.

    Raises:
        InputError: an option says what is drawn, which the document does.
    """
    spare = dict([*args.lengths, *args.ranges])
    spare |= {"--fixed-leg": args.fixed_leg, "--cusp": args.cusp, "--pose": args.pose}
    spare |= {"--url": args.url, "--deadline": args.deadline}
    for option, value in spare.items():
        if value is not None:
            what = f"says nothing about the plot {args.plot!r}, which is drawn from a document; leave it out"
            raise InputError.of(option, what)

    given = {name: getattr(args, name) for name in ("style", "unit") if getattr(args, name) is not None}
    members = {"labels": _labels(args), **given}
    if args.width_mm is not None:
        members["width_mm"] = _width(args.width_mm)
    origin = arguments.source({"width_mm": "--width", "unit": "--unit"})
    style = style_of(read(Setting, members, origin).setting())
    try:
        document = json.loads(arguments.text_of(args.geometry))
        document[_OF_DOCUMENTS[args.plot]]  # another document has a figure, too
        return draw(document).styled(style, theme=args.theme or style.theme)
    except (ValueError, TypeError, KeyError):
        message = f"{args.geometry!r} has no {args.plot}; give what {args.plot} --format json writes"
        raise InputError.of("GEOMETRY", message) from None


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
    number: int = 2 * args.no_title + args.no_caption
    return LABELS[number]


def _width(text: str) -> str:
    """A width in millimetres, exactly.

    Raises:
        InputError: naming `--width`: it has no such unit.
    """
    unit = next((unit for unit in _MILLIMETRES if text.endswith(unit)), None)
    if unit is None:
        known = "86mm, 8.6cm, 3.4in or 245pt"
        raise InputError.of("--width", f"is {clipped(text)!r}; give a length with its unit, such as {known}")
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
    parsers.said_of(_run_plot),
    {"width_mm": "--width", "plot": "", "labels": ""},
    {"width_mm": _width},
)

COMMANDS = {
    "cite": Command.of(_run_cite, _configure_cite),
    "verify": Command.of(_run_verify, _configure_verify),
    "export": Command.of(_run_export, _configure_export),
    "plot": Command.of(_run_plot, _configure_plot),
}
