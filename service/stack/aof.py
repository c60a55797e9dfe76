"""The append-only files of an embedded Valkey: what is wrong with them, and its repair if that loses nothing.

They are a manifest, a base (a snapshot) and increments (commands). Valkey starts empty if the manifest is
missing, and overwrites the others; it ends if an increment is damaged. The program that would repair it,
`valkey-check-aof`, is not part of the package, and would cut off whatever follows the damage.
"""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path

from service.stack.errors import EmbeddedError
from service.stack.resp import Damage, damage_of

DIRECTORY = "appendonlydir"

_MANIFEST = "appendonly.aof.manifest"
_PART = re.compile(r"appendonly\.aof\.(\d+)\.(base|incr)\.(rdb|aof)")
_ENTRY = re.compile(r"file (\S+) seq \d+ type ([bi])")


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
            f"{manifest} is missing, and its content cannot be told from the files beside it ({names}); "
            f"restore {directory} from a back-up, or move it away to start empty"
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
        f"{path} is damaged at byte {damage.start}, and {follows}; restore {path.parent} from a back-up"
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
    """Write a file that is there as a whole or not at all."""
    draft = path.with_suffix(".draft")
    with draft.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    draft.chmod(0o600)
    draft.replace(path)
