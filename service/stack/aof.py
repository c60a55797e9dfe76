"""The append-only files of an embedded Valkey: which commands are intact, and repair if that loses nothing.

The files are a manifest, a base (a snapshot) and increments (commands). Valkey starts empty if the manifest
is missing, and overwrites the others; it ends if an increment is damaged. The program that would repair it,
`valkey-check-aof`, is not part of the package, and would cut off whatever follows the damage.
"""

from __future__ import annotations

import mmap
import os
import re
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from service.errors import EmbeddedError

_ARRAY = re.compile(rb"\*([1-9]\d{0,8})\r\n")
_STRING = re.compile(rb"\$(\d{1,10})\r\n")
_REMARK = re.compile(rb"#[^\r\n]{0,1000}\r\n")
_COMMAND = re.compile(rb"\*[1-9]\d{0,8}\r\n\$\d{1,2}\r\n[A-Za-z]")


DIRECTORY = "appendonlydir"

_MANIFEST = "appendonly.aof.manifest"

_PART = re.compile(r"appendonly\.aof\.(\d+)\.(base|incr)\.(rdb|aof)")
_ENTRY = re.compile(r"file (\S+) seq \d+ type ([bi])")


@dataclass(frozen=True)
class Damage:
    """What follows the last intact command of a file."""

    start: int
    """Where the damage begins: after the last command, or before a transaction that is not complete."""
    size: int
    """The size of the file."""
    resumes: int | None
    """Where intact commands begin again, if they do."""


def damage_of(path: Path) -> Damage | None:
    """Returns the damage of a file, None if every command in it is intact."""
    with path.open("rb") as file:
        if os.fstat(file.fileno()).st_size == 0:
            return None  # and cannot be mapped
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return find_damage(data)


def find_damage(data: bytes | mmap.mmap) -> Damage | None:
    """Returns the damage in the content of a file.

    >>> find_damage(b"*1\\r\\n$4\\r\\nPING\\r\\n*1\\r\\n$4\\r\\nPI")
    Damage(start=14, size=24, resumes=None)
    """
    size, position, start = len(data), 0, 0
    is_transaction = False
    while position < size and (step := _command(data, position)) is not None:
        end, name = step
        if name == (b"MULTI" if is_transaction else b"EXEC"):
            break
        position, is_transaction = end, name == b"MULTI" or (is_transaction and name != b"EXEC")
        if not is_transaction:
            start = position
    if start == size:
        return None
    resumes = None if position == size else _resumption(data, position)
    return Damage(start, size, resumes)


def _command(data: bytes | mmap.mmap, position: int) -> tuple[int, bytes] | None:
    """Returns the end and the name of the command that begins at a position; None if it is not intact."""
    if remark := _REMARK.match(data, position):
        return remark.end(), b""
    if (array := _ARRAY.match(data, position)) is None:
        return None
    name, end = b"", array.end()
    for index in range(int(array[1])):
        if (string := _STRING.match(data, end)) is None:
            return None
        end = string.end() + int(string[1])
        if data[end : end + 2] != b"\r\n":
            return None
        if index == 0:
            name = data[string.end() : end].upper()
        end += 2
    return end, name


def _resumption(data: bytes | mmap.mmap, position: int) -> int | None:
    """Returns where the first intact command after a position begins."""
    starts = (match.start() for match in _COMMAND.finditer(data, position + 1))
    return next((start for start in starts if _command(data, start) is not None), None)


def check_manifest(data_dir: Path, say: Callable[[str], object]) -> None:
    """Write a missing manifest again if the files leave no doubt about it.

    Raises:
        EmbeddedError: they do.
    """
    directory = data_dir / DIRECTORY
    manifest = directory / _MANIFEST
    parts = [match for path in directory.glob("*") if (match := _PART.fullmatch(path.name))]
    if not parts or (manifest.exists() and manifest.stat().st_size > 0):
        return
    kinds = sorted(match[2] for match in parts)
    if kinds != ["base", "incr"]:
        names = ", ".join(sorted(match[0] for match in parts))
        raise EmbeddedError(
            f"{manifest} is missing, and its content cannot be inferred from the files beside it ({names}); "
            f"restore {directory} from a backup, or move it away to start empty"
        )
    lines = [f"file {match[0]} seq {int(match[1])} type {match[2][0]}\n" for match in parts]
    _write(manifest, "".join(sorted(lines, key=lambda line: line.endswith("i\n"))))
    say(f"{manifest} was missing; wrote it again from the files beside it")


def repair(data_dir: Path, say: Callable[[str], object]) -> None:
    """Cut off a damaged end of the last increment, if there is one, and keep a copy.

    Raises:
        EmbeddedError: the damage is elsewhere, so intact commands would get lost.
    """
    increments = _increments(data_dir / DIRECTORY)
    for path in increments:
        damage = damage_of(path)
        if damage is None:
            continue
        if damage.resumes is not None or path != increments[-1]:
            raise EmbeddedError(_what_to_do(path, damage, is_last=path == increments[-1]))
        copy = _copy(path, data_dir)
        with path.open("r+b") as file:
            file.truncate(damage.start)
            os.fsync(file.fileno())
        say(
            f"cut {damage.size - damage.start} damaged bytes off the end of {path}; {copy} is the file before"
        )


def _what_to_do(path: Path, damage: Damage, *, is_last: bool) -> str:
    follows = (
        f"intact commands follow from byte {damage.resumes} on" if damage.resumes else "other files follow"
    )
    cut = f"; or keep only what precedes it: cp {path} {path}.bak && truncate -s {damage.start} {path}"
    return (
        f"{path} is damaged at byte {damage.start}, and {follows}; restore {path.parent} from a backup"
        f"{cut if is_last else ''}; or move {path.parent} away to start empty"
    )


def _increments(directory: Path) -> list[Path]:
    """The increments, in the order of the manifest."""
    try:
        manifest = (directory / _MANIFEST).read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        return []
    entries = (_ENTRY.match(line) for line in manifest.splitlines())
    paths = [directory / entry[1] for entry in entries if entry is not None and entry[2] == "i"]
    return [path for path in paths if path.is_file()]


def _copy(path: Path, data_dir: Path) -> Path:
    copy = data_dir / f"{path.name}.{time.strftime('%Y%m%dT%H%M%S')}.damaged"
    shutil.copyfile(path, copy)
    copy.chmod(0o600)
    with copy.open("rb") as file:
        os.fsync(file.fileno())
    return copy


def _write(path: Path, text: str) -> None:
    """Write a file atomically."""
    draft = path.with_suffix(".draft")
    with draft.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    draft.chmod(0o600)
    draft.replace(path)
