"""Measures pictures, in seconds of processor time: from a document, and with the document; and their memory.

python benchmarks/figures.py [--memory]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from statistics import median
from time import process_time

from rpr_solver import EXAMPLES, Figure, census, cusp_curves, cusp_loop, poses, singular_curves
from rpr_solver.singular import SingularCurves

REPEATS = 9
SLICES = (("innocenti", "14.98"), ("innocenti", "27"), ("innocenti", "28.1"), ("fourteen-cusps", "5.96"))


def timed(work: Callable[[], object]) -> float:
    """Returns the median time of a call, in milliseconds."""
    times = []
    for _ in range(REPEATS):
        start = process_time()
        work()
        times.append(process_time() - start)
    return 1000 * median(times)


def row(name: str, draw: Callable[[], Figure]) -> None:
    """Prints the time of a figure and its size."""
    print(f"{name:32} {timed(lambda: draw().svg()):6.0f} ms {len(draw().svg()) / 1000:6.0f} kB", flush=True)


def resident() -> float:
    """Returns the memory of this process now, in MB."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.partition("VmRSS:")[2].split()[0]) / 1024


def memory() -> None:
    """Measure what pictures add to a process that has solved slices."""
    answers = [singular_curves(EXAMPLES[name], length) for name, length in SLICES]
    before = resident()
    print(f"without pictures: {before:.0f} MB")
    import_module("rpr_solver.figures")
    loaded = resident()
    print(f"matplotlib: {loaded - before:.0f} MB")
    for count in (1, 60, 180):
        for k in range(count):
            answers[k % len(answers)].figure().svg()
        print(f"after {count} more pictures: {resident() - loaded:.0f} MB", flush=True)


def main() -> None:
    """Measure every kind of picture."""
    if "--memory" in sys.argv:
        memory()
        return
    print("from a document that is known:")
    slices: dict[tuple[str, str], SingularCurves] = {
        (name, length): singular_curves(EXAMPLES[name], length) for name, length in SLICES
    }
    for (name, length), curves in slices.items():
        row(f"slice {name} {length}", curves.figure)
        row(f"torus {name} {length}", lambda curves=curves: curves.figure("torus"))  # type: ignore[misc]
    manipulator = EXAMPLES["innocenti"]
    loop, curves = cusp_loop(manipulator, 27, "B"), slices["innocenti", "27"]
    row("loop round cusp B", lambda: loop.figure(curves))
    row("census", census(manipulator, digits=15).figure)
    row("cusp locus", cusp_curves(manipulator, digits=15).part(samples=14).figure)
    row("mechanism at six poses", poses(manipulator, "14.98", 16, 20, digits=15).figure)
    print("with everything that it takes:")
    for name, length in SLICES:
        work = lambda name=name, length=length: singular_curves(EXAMPLES[name], length).figure().svg()  # noqa: E731
        print(f"slice {name} {length:14} {timed(work):6.0f} ms", flush=True)


if __name__ == "__main__":
    main()
