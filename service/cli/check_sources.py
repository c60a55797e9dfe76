"""The geometries of a check, built-in or from files, folders and standard input, with the lines of faults."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rpr_solver import EXAMPLES, Manipulator
from rpr_solver.errors import InputError
from service.cli.arguments import STANDARD_INPUT, read_manipulator, text_of
from service.schemas.exact_json import JsonError, parse_json


@dataclass(frozen=True)
class Geometry:
    """A geometry, or why it cannot be read, and at which line of its file.

    Attributes:
        source: the name of the file, a built-in name, or `-`.
        manipulator: the manipulator, or None.
        fault: why there is none.
        line: the line of the fault, or the first line; None if it is not in a file.
    """

    source: str
    manipulator: Manipulator | None = None
    fault: str = ""
    line: int | None = None


def expand(sources: Sequence[str]) -> Iterator[str]:
    """Yields the geometries; a folder stands for its JSON files, sorted by name.

    Raises:
        InputError: a folder without JSON files, or a second `-`.
    """
    if sources.count(STANDARD_INPUT) > 1:
        raise InputError.of("GEOMETRY", "is - twice; standard input can be read only once")
    for source in sources:
        folder = Path(source)
        if source in EXAMPLES or source == STANDARD_INPUT or not folder.is_dir():
            yield source
            continue
        files = sorted(path for path in folder.iterdir() if path.suffix == ".json" and path.is_file())
        if not files:
            raise InputError.of("GEOMETRY", f"the folder {source!r} has no *.json files")
        yield from map(str, files)


def geometry(source: str) -> Geometry:
    """Reads one geometry."""
    name = os.fsencode(source).decode("utf-8", "replace")  # file names are arbitrary bytes
    if source in EXAMPLES:
        return Geometry(name, EXAMPLES[source])
    in_file = source != STANDARD_INPUT
    text = b""
    try:
        text = text_of(source)
        manipulator = read_manipulator(parse_json(text, "The text"))
    except JsonError as error:
        line = error.line or _line_of(text, error.field, last=True)
        return Geometry(name, None, error.detail, line if in_file else None)
    except InputError as error:
        line = _line_of(text, error.problems[0].field.rpartition(".")[2])
        return Geometry(name, None, str(error), line if in_file else None)
    return Geometry(name, manipulator, line=1 if in_file else None)


def _line_of(text: bytes, key: str, *, last: bool = False) -> int:
    """Returns the line of a member of an object, or 1."""
    found = [match.start() for match in re.finditer(rb'"' + re.escape(key.encode()) + rb'"\s*:', text)]
    return 1 + text.count(b"\n", 0, found[-1 if last else 0]) if found else 1
