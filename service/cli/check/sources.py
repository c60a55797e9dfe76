"""The geometries of a check, built-in or from files, folders and standard input, with the lines of faults."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.errors import InputError
from rpr_solver.model.manipulator import geometry_within, notes_on
from service.cli.arguments import read_option, text_of
from service.cli.parsers import STANDARD_INPUT
from service.schemas.document import JsonError, parse_json
from service.schemas.questions import GeometryField

_LENGTHS = frozenset(("a2x", "a3x", "a3y", "d1", "d2", "d3"))
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
    in_file = source != STANDARD_INPUT
    text = b""
    try:
        text = text_of(source)
        whole = parse_json(text, "The text")
        value = geometry_within(whole)
        if not is_named and not _is_meant(value):
            return None
        manipulator = read_option(GeometryField, value, "geometry")
        assert isinstance(whole, Mapping)
        notes = {note: text for part in (whole, value) for note, text in notes_on(part).items()}
        return Geometry(name, manipulator, line=1 if in_file else None, notes=notes)
    except JsonError as error:
        if not is_named and _is_something_else(text):
            return None
        line = error.line or _line_of(text, error.field, last=True)
        return Geometry(name, None, error.detail, line if in_file else None)
    except InputError as error:
        line = _line_of(text, error.problems[0].field.rpartition(".")[2])
        return Geometry(name, None, str(error), line if in_file else None)


def _is_meant(value: object) -> bool:
    """Whether an object is meant to be a geometry, right or wrong."""
    return isinstance(value, Mapping) and len({name.lower() for name in value} & _LENGTHS) >= _MIN_LENGTHS


def _is_something_else(text: bytes) -> bool:
    """Whether a text that is no strict JSON has members, none of them a length of a geometry."""
    names = {name.decode("ascii", "replace").lower() for name in re.findall(rb"(\w+)[\"']?\s*:", text)}
    return bool(names) and not names & _LENGTHS


def _shown(source: str) -> str:
    return os.fsencode(source).decode("utf-8", "replace")  # file names are arbitrary bytes


def _line_of(text: bytes, key: str, *, last: bool = False) -> int:
    """Returns the line of a member of an object, or 1."""
    found = [match.start() for match in re.finditer(rb'"' + re.escape(key.encode()) + rb'"\s*:', text)]
    return 1 + text.count(b"\n", 0, found[-1 if last else 0]) if found else 1
