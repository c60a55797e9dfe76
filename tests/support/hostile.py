"""A folder of a stranger: a module of every name that a program may load."""

from __future__ import annotations

import sys
from importlib.metadata import packages_distributions
from pathlib import Path

_MODULE = """\
import os
with open({mark!r}, "a") as file:
    file.write(__name__ + "\\n")
os._exit(0)
"""


def put_modules(folder: Path, *, packages: bool = False) -> Path:
    """Puts a module of each name into a folder: a file, or a folder.

    Returns the file in which each that was run leaves its name; it also ends its process with status 0.
    """
    mark = folder / ".marks"
    names = {*sys.stdlib_module_names, *packages_distributions(), "sitecustomize", "usercustomize"}
    for name in sorted({*names, "rpr_solver", "worker", "service"} - {"__main__"}):
        if name.isidentifier():
            place = folder / name / "__init__.py" if packages else folder / f"{name}.py"
            place.parent.mkdir(exist_ok=True)
            place.write_text(_MODULE.format(mark=str(mark)))
    return mark
