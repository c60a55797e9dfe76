"""Our programs as child processes, each started in full."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

# Unlike `-m`, this does not import a directory with the name of a package from the current directory; and it
# collects no garbage while modules are loaded, which would take a tenth of the start.
_PROGRAM = (
    "import gc, importlib, sys; gc.disable(); sys.path.append(sys.argv.pop(1)); "
    "program = importlib.import_module(sys.argv.pop(1)); gc.enable(); sys.exit(program.main())"
)
_FEW_ARENAS = {"MALLOC_ARENA_MAX": "2"}
"""Or else glibc spreads what some forty threads need over one arena each, and its memory grows for hours."""

Process = subprocess.Popen[Any]


@dataclass(frozen=True)
class Program:
    """``main()`` of one of our modules as a process.

    Attributes:
        module: its name.
        arguments: of its command line. Where there are ``descriptors``, their numbers are appended.
        environment: all of it.
        descriptors: of open files that it inherits.
    """

    module: str
    arguments: Sequence[str] = ()
    environment: Mapping[str, str] = field(default_factory=lambda: dict(os.environ))
    descriptors: Sequence[int] = ()

    def start(self) -> Process:
        """Start it in full, in a session of its own: Ctrl-C on a terminal reaches the caller alone."""
        return subprocess.Popen(
            python_program(self.module, *self.arguments, *map(str, self.descriptors)),
            env={**_FEW_ARENAS, **self.environment},
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            pass_fds=self.descriptors,
        )


def python_program(module: str, *arguments: str) -> list[str]:
    """Returns the command that runs `main` of one of our modules."""
    return [sys.executable, "-P", "-c", _PROGRAM, str(Path(__file__).parents[2]), module, *arguments]
