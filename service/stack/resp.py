"""Reads the commands in an append-only file of Valkey, as far as they are intact."""

from __future__ import annotations

import mmap
import os
import re
from dataclasses import dataclass
from pathlib import Path

_ARRAY = re.compile(rb"\*([1-9]\d{0,8})\r\n")
_STRING = re.compile(rb"\$(\d{1,10})\r\n")
_REMARK = re.compile(rb"#[^\r\n]{0,1000}\r\n")
_COMMAND = re.compile(rb"\*[1-9]\d{0,8}\r\n\$\d{1,2}\r\n[A-Za-z]")


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
