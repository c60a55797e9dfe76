"""Scripts for other systems, run where their program is."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from rpr_solver import Manipulator, export, table_document

PROGRAMS = {"pari": ["gp", "-q"], "sage": ["sage", "-python"], "sympy": [sys.executable]}
RATIONAL = Manipulator("4", "1", "3", "3", "4", "5")
"""With a rational height, so that SymPy is quick."""


def table(m: Manipulator, *lengths: str, leg: int = 1) -> dict[str, Any]:
    return table_document(m, lengths, fixed_leg=leg, digits=20)


def installed(system: str) -> bool:
    """Whether the program of a system is there."""
    return system in PROGRAMS and shutil.which(PROGRAMS[system][0]) is not None


def said(document: dict[str, Any], system: str, folder: Path) -> tuple[int, list[str]]:
    """The exit status, and what is printed, of the script."""
    path = folder / "script"
    path.write_text(export(document, system), encoding="utf-8")
    command = [*PROGRAMS[system], str(path)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    return done.returncode, done.stdout.splitlines()


def verdict(document: dict[str, Any], system: str, folder: Path) -> str:
    """``"agrees"``, ``"differs"`` or ``"cannot decide"``, if the exit status says so, too."""
    status, lines = said(document, system, folder)
    words = lines[-1] if lines else "nothing"
    for code, word in enumerate(("agrees", "differs")):
        if (status, words) == (code, word):
            return word
    return "cannot decide" if status == 3 and words.startswith("cannot decide with ") else f"{status} {words}"
