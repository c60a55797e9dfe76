"""What arguments stand for: the members of a question, and geometries, built-in or from files, folders and
standard input."""

from __future__ import annotations

import argparse
import codecs
import difflib
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.contract import FIXED_LEGS, LENGTHS
from rpr_solver.errors import InputError
from rpr_solver.model.manipulator import geometry_within, notes_on
from service.cli.digits import PRINTED
from service.cli.parsers import STANDARD_INPUT
from service.schemas.document import JsonError, Source, named, parse_json, part, read
from service.schemas.geometry import GeometryField
from service.schemas.lengths import SliceRange, split_ends, split_range
from service.schemas.limits import Limits
from service.schemas.numbers import FixedLeg, whole_number
from service.schemas.questions import Question

Q = TypeVar("Q", bound=Question)

MAX_LOCAL_SLICES = 1_000_000

_OF_REQUIREMENTS = ("max_cusps", "min_cusps", "degenerate", "mode_change", "ignore_windows", "clearance")
_ANGLES = ("alpha", *(f"theta{leg}" for leg in FIXED_LEGS))
_OPTIONS = {name: f"--{name.replace('_', '-')}" for name in ("digits", "fixed_leg", "samples", "method")}
_OPTIONS["deadline_seconds"] = "--deadline"
_WHOLE = re.compile(r"\d{1,4}", re.ASCII)
_MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}


def source(names: Mapping[str, str] | None = None) -> Source:
    """Returns the command line as a source: values are text, and `names` maps members to options.

    The number of slices is practically unlimited, since they are computed locally.
    """
    limits = Limits.of_environment(max_slices=MAX_LOCAL_SLICES, max_article_slices=MAX_LOCAL_SLICES)
    return Source(limits, {**_OPTIONS, **(names or {})}, is_text=True)


def ask(model: type[Q], args: argparse.Namespace, members: Mapping[str, object], origin: Source) -> Q:
    """Returns the question that the options make; None stands for an option that is not given.

    Raises:
        InputError: naming the faulty options and members of the geometry.
    """
    members = {"geometry": geometry_of(args.geometry), "digits": computed_digits(args), **members}
    return read(model, {name: value for name, value in members.items() if value is not None}, origin)


def computed_digits(args: argparse.Namespace) -> str | None:
    """Returns `--digits` as a member of a question: fewer than may be asked for are printed, not computed.

    Raises:
        InputError: it is 0.
    """
    text: str | None = getattr(args, "digits", None)
    if text is None or not _WHOLE.fullmatch(text):
        return text
    limits = Limits.of_environment()
    if int(text) == 0:
        raise InputError.of("--digits", f"is 0; give 1 to {limits.max_digits}")
    return str(max(int(text), limits.min_digits))


def printed_digits(args: argparse.Namespace) -> int:
    """Returns the significant digits of tables: those that `--digits` asks for."""
    text = getattr(args, "digits", None)
    return PRINTED if text is None else whole_number(text, "", is_text=True)


def geometry_of(name: str) -> object:
    """Returns a built-in manipulator, the geometry in words, or that in the JSON of a file or of standard
    input.

    Raises:
        InputError: the file cannot be read or is not JSON.
    """
    if name in EXAMPLES:
        return EXAMPLES[name]
    return in_words(name) or geometry_within(json_of(name, text_of(name)))


def in_words(text: str) -> dict[str, object] | None:
    """Returns a geometry that stands in the words of an argument; None if it is the name of a file.

    Members are separated by semicolons, the numbers of a triangle by spaces or commas.

    >>> in_words("base=equilateral 10; platform=points 0,0 1,0 0,1; orientation=cw")["platform"]
    {'points': [['0', '0'], ['1', '0'], ['0', '1']]}
    >>> in_words("a2x=10; d1=sqrt(3)"), in_words("robot.json")
    ({'a2x': '10', 'd1': 'sqrt(3)'}, None)
    """
    parts = [part.partition("=") for part in text.split(";") if part.strip()]
    members = {name.strip(): value.strip() for name, _, value in parts}
    if next(iter(members), "") not in (*LENGTHS, *_TRIANGLES, "orientation") or "=" not in text:
        return None
    return {name: _triangle(value) if name in _TRIANGLES else value for name, value in members.items()}


def _triangle(text: str) -> object:
    """Returns the triangle that words describe: the name of its spelling, and numbers."""
    name, *numbers = re.split(r"[\s,]+", text)
    if name == "points":
        corners = [numbers[k : k + 2] for k in range(0, len(numbers), 2)]
        return {name: corners}
    return {name: numbers[0] if len(numbers) == 1 else numbers}


def text_of(name: str) -> bytes:
    """Returns the UTF-8 text of a file or of standard input; a byte order mark is taken off.

    Raises:
        InputError: it cannot be read.
    """
    try:
        content = sys.stdin.buffer.read() if name == STANDARD_INPUT else Path(name).read_bytes()
    except OSError as error:
        near = difflib.get_close_matches(name, EXAMPLES, n=1)
        known = f"a JSON file, -, or one of {', '.join(EXAMPLES)}"
        hint = f"did you mean {near[0]}?" if near else f"give {known}"
        raise InputError.of("GEOMETRY", f"{name!r} cannot be read ({error.strerror}); {hint}") from None
    for mark, encoding in _MARKS.items():
        if content.startswith(mark):
            return content.decode(encoding, "replace").encode()
    return content


def json_of(name: str, text: bytes) -> object:
    """Returns the JSON in a file.

    Raises:
        InputError: it is not JSON.
    """
    try:
        return parse_json(text, "the text", Limits.of_environment())
    except JsonError as error:
        raise InputError.of("GEOMETRY", f"in {shown_name(name)}: {error.detail}") from None


def shown_name(name: str) -> str:
    """Returns the name of a source of geometry as messages give it."""
    return "standard input" if name == STANDARD_INPUT else repr(name)


def read_option(kind: Any, given: object, option: str) -> Any:
    """Returns what an option gives, read as a member of this type of a question would be.

    Raises:
        InputError: naming the option.
    """
    with named(option):
        return part(TypeAdapter(kind).validate_python, given, source())


def joint_limits(given: Sequence[tuple[str, str]]) -> tuple[dict[str, object], dict[str, str]]:
    """Returns joint limits by legs, and the options that give them, by members.

    Raises:
        InputError: naming an option that is given twice, or is no range.
    """
    limits: dict[str, object] = {}
    names = {}
    for option, text in given:
        leg = option[2:4]
        if leg in limits:
            raise InputError.of(option, "is given twice")
        names[f"limits.{leg}"] = option
        with named(option):
            limits[leg] = split_ends(text, ("min", "max"))
    return limits, names


def leg_and_range(args: argparse.Namespace) -> tuple[int, dict[str, str | None], str]:
    """Returns the fixed leg, the range (whose option implies the leg), and the name of that option."""
    if len(args.ranges) > 1:
        raise InputError.of(args.ranges[1][0], "is a second range; give one")
    leg = None if args.fixed_leg is None else read_option(FixedLeg, args.fixed_leg, "--fixed-leg")
    if not args.ranges:
        return leg or 1, {}, f"--l{leg or 1}-range"
    [(option, text)] = args.ranges
    if leg not in (None, int(option[3])):
        raise InputError.of(option, f"with --fixed-leg {leg} the range is --l{leg}-range")
    with named(option):
        return int(option[3]), split_ends(text), option


def requirement_of(args: argparse.Namespace) -> tuple[dict[str, object], dict[str, str]]:
    """Returns the requirement that the options of a range ask for, and the options of its members."""
    of, span, option = leg_and_range(args)
    limits, places = joint_limits(args.limits)
    own = {name: getattr(args, name, None) for name in _OF_REQUIREMENTS}
    members = {"fixed_leg": of, "range": span, "limits": limits or None, **own}
    options = {"range": option, **places, **{name: f"--{name.replace('_', '-')}" for name in own}}
    return {name: value for name, value in members.items() if value is not None}, options


def requirement_if_any(
    args: argparse.Namespace, needs_range: bool
) -> tuple[dict[str, object] | None, dict[str, str]]:
    """Returns the same; None if no option asks for one.

    Raises:
        InputError: the range is missing, which joint limits need.
    """
    counts = args.max_cusps, args.min_cusps, args.ignore_windows
    has_counts = any(count is not None for count in counts)
    if args.ranges or (has_counts and not needs_range):
        members, options = requirement_of(args)
        return members, {f"requirement.{name}": option for name, option in options.items()}
    if args.limits or has_counts:
        raise InputError.of("--l1-range", "is missing; a requirement needs the range of lengths")
    return None, {}


def between_of(args: argparse.Namespace) -> dict[str, str | None] | None:
    """Returns the lengths between which the fixed leg may vary, if they are given."""
    with named("--between"):
        return None if args.between is None else split_ends(args.between)


def leg_of(options: Sequence[tuple[str, str]], fixed_leg: str | None, what: str) -> int:
    """Returns the fixed leg: as `--fixed-leg` names it, else that of the first option, else 1.

    Raises:
        InputError: an option is about another leg.
    """
    leg = int(options[0][0][3]) if options else 1
    if fixed_leg is not None:
        leg = read_option(FixedLeg, fixed_leg, "--fixed-leg")
    for option, text in options:
        if option[2:4] != f"l{leg}":
            cause = "--fixed-leg" if fixed_leg is not None else "fixed leg"
            raise InputError.of(option, f"is {text}, but with {cause} {leg} the {what} are --l{leg}")
    return leg


def lengths_once(options: Sequence[tuple[str, str]]) -> dict[str, str]:
    """Returns the lengths of legs, by the names of the members.

    Raises:
        InputError: naming an option that is given twice.
    """
    lengths: dict[str, str] = {}
    for option, text in options:
        if lengths.setdefault(option[2:], text) != text:
            raise InputError.of(option, f"is {text}, but {lengths[option[2:]]} is given already; give one")
    return lengths


def range_values(text: str, option: str, origin: Source) -> tuple[Fraction, ...]:
    """Returns the lengths of `FROM:TO:STEP`."""
    with named(option):
        return part(SliceRange.model_validate, split_range(text), origin).values(origin.limits)


def parts_of(text: str | None) -> object:
    """Returns the members in a text, or a text that has none.

    >>> parts_of("d1=0.01,a3x=0"), parts_of("alpha=12.5,l1=27"), parts_of("d1=16:18"), parts_of("15%")
    ({'d1': '0.01', 'a3x': '0'}, {'alpha_deg': '12.5', 'l1': '27'}, {'d1': {'from': '16', 'to': '18'}}, '15%')
    """
    if text is None or "=" not in text:
        return text
    pairs = [(name.strip(), value.strip()) for name, _, value in (x.partition("=") for x in text.split(","))]
    return {
        f"{name}_deg" if name in _ANGLES else name: split_ends(value) if ":" in value else value
        for name, value in pairs
    }


_TRIANGLES = ("base", "platform")
_MIN_LENGTHS = 2
"""The number of lengths from which on an object counts as a geometry."""


@dataclass(frozen=True)
class Geometry:
    """A geometry, or why it cannot be read, and at which line of its file.

    Attributes:
        source: the name of the file, a built-in name, or `-`.
        manipulator: the manipulator, or None.
        fault: why there is none.
        line: the line of the fault, or the first line; None if it is not in a file.
        notes: its name and its unit, as far as the file gives them.
    """

    source: str
    manipulator: Manipulator | None = None
    fault: str = ""
    line: int | None = None
    notes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """What the arguments of a check stand for.

    Attributes:
        geometries: in the order of the arguments, those of a folder sorted by name.
        ignored: JSON files that hold no geometry.
        files: the number of files that were read.
    """

    geometries: Sequence[Geometry]
    ignored: Sequence[str] = ()
    files: int = 0


def find(sources: Sequence[str], *, ignore_others: bool = False) -> Found:
    """Reads all geometries. A folder stands for all JSON files in it and below, hidden ones excepted.

    Files of a folder that hold no geometry are ignored; so are those that are named, with `ignore_others`.

    Raises:
        InputError: a folder that cannot be read or has no geometry, or a second `-`.
    """
    if sources.count(STANDARD_INPUT) > 1:
        raise InputError.of("GEOMETRY", "is - twice; standard input can be read only once")
    folders = {source: _is_folder(source) for source in sources}
    known = {os.path.normpath(source) for source, is_folder in folders.items() if not is_folder}
    geometries: list[Geometry] = []
    ignored: list[str] = []
    for source in sources:
        is_folder = folders[source]
        names = [file for file in _files(source) if file not in known] if is_folder else [source]
        inside, others = _read(names, is_named=not is_folder and not ignore_others)
        if is_folder and not inside and not _holds_any(source, known):
            what = f"no geometry in its JSON files: {listed(others)}" if others else "no *.json files"
            raise InputError.of("GEOMETRY", f"the folder {source!r} has {what}")
        known.update(names)
        geometries += inside
        ignored += others
    return Found(geometries, ignored, sum(g.line is not None for g in geometries) + len(ignored))


def _read(names: Sequence[str], *, is_named: bool) -> tuple[list[Geometry], list[str]]:
    """Returns the geometries of files, and the names of the files that hold none."""
    found = [(name, _geometry(name, is_named=is_named)) for name in names]
    inside = [geometry for _, geometry in found if geometry is not None]
    return inside, [_shown(name) for name, geometry in found if geometry is None]


def listed(names: Sequence[str], most: int = 5) -> str:
    """Returns names in a line, the first few of many.

    >>> listed(["a", "b", "c"], most=2)
    'a, b and 1 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def _is_folder(source: str) -> bool:
    return source not in EXAMPLES and source != STANDARD_INPUT and Path(source).is_dir()


def _holds_any(folder: str, files: Iterable[str]) -> bool:
    """Whether one of these files, which are read elsewhere, is in the folder."""
    return any(Path(file).is_relative_to(os.path.normpath(folder)) for file in files)


def _files(folder: str) -> Iterator[str]:
    """Yields the JSON files in a folder and in those within it, each folder once, sorted by name."""

    def refuse(error: OSError) -> None:
        raise InputError.of("GEOMETRY", f"the folder {error.filename!r} cannot be read ({error.strerror})")

    seen = set()
    for root, folders, files in os.walk(folder, onerror=refuse, followlinks=True):
        is_new = (place := os.path.realpath(root)) not in seen
        seen.add(place)
        folders[:] = sorted(name for name in folders if is_new and not name.startswith("."))
        for name in sorted(files) if is_new else ():
            path = Path(root, name)
            is_file = path.is_file() or not path.exists()  # a broken link is reported
            if path.suffix.lower() == ".json" and not name.startswith(".") and is_file:
                yield os.path.normpath(path)


def _geometry(source: str, *, is_named: bool) -> Geometry | None:
    """Reads one geometry; returns None for JSON that holds none, unless it is named."""
    name = _shown(source)
    if source in EXAMPLES:
        return Geometry(name, EXAMPLES[source])
    if (spelled := in_words(source)) is not None:
        return _spelled(name, spelled)
    in_file = source != STANDARD_INPUT
    text = b""
    try:
        text = text_of(source)
        whole = parse_json(text, "The text", Limits.of_environment())
        value = geometry_within(whole)
        if not is_named and not _is_meant(value):
            return None
        manipulator = read_option(GeometryField, value, "geometry")
        assert isinstance(whole, Mapping)
        notes = {**notes_on(whole), **notes_on(value)}
        return Geometry(name, manipulator, line=1 if in_file else None, notes=notes)
    except JsonError as error:
        if not is_named and _is_something_else(text):
            return None
        line = error.line or _line_of(text, *error.field.split("."), last=True)
        return Geometry(name, None, error.detail, line if in_file else None)
    except InputError as error:
        line = _line_of(text, *error.problems[0].field.split("."))
        return Geometry(name, None, str(error), line if in_file else None)


def _spelled(name: str, members: Mapping[str, object]) -> Geometry:
    """Reads a geometry in words."""
    try:
        return Geometry(name, read_option(GeometryField, members, "geometry"))
    except InputError as error:
        return Geometry(name, None, str(error))


def _is_meant(value: object) -> bool:
    """Whether an object is meant to be a geometry, right or wrong."""
    names = {name.lower() for name in value} if isinstance(value, Mapping) else set()
    return len(names & {*LENGTHS}) >= _MIN_LENGTHS or names >= {*_TRIANGLES}


def _is_something_else(text: bytes) -> bool:
    """Whether a text that is no strict JSON has members, none of them a part of a geometry."""
    found = re.findall(rb"(?<!\w)(\w++)[\"']?\s*+:", text)  # in linear time
    names = {name.decode("ascii", "replace").lower() for name in found}
    return bool(names) and names.isdisjoint((*LENGTHS, *_TRIANGLES))


def _shown(source: str) -> str:
    return os.fsencode(source).decode("utf-8", "replace")  # file names are arbitrary bytes


def _line_of(text: bytes, *path: str, last: bool = False) -> int:
    """Returns the line of a member, of one in an object that is a member, and so on; or 1."""
    place = 0
    for member in path:
        key = member.partition("[")[0].encode()
        found = [m.start() for m in re.compile(rb'"' + re.escape(key) + rb'"\s*:').finditer(text, place)]
        place = found[-1 if last else 0] if found else place
    return 1 + text.count(b"\n", 0, place)
