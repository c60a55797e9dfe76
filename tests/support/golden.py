"""Golden documents: a sample of all answers of this version of the solver, kept as hashes.

    python -m tests.support.golden            compares them with tests/data/golden.json
    python -m tests.support.golden --write    writes that file, after SOLVER_VERSION has been raised

The sample holds every reference vector to 90 digits and, to few digits, each kind of document for each
degenerate family, by public names alone.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

from rpr_solver import (
    EXAMPLES,
    SOLVER_VERSION,
    Manipulator,
    Requirement,
    SolverError,
    article_table,
    assembly_modes,
    census,
    census_csv,
    check,
    curves_csv,
    cusp_curves,
    cusp_loop,
    eliminate,
    joint_path,
    pose_connections,
    pose_path,
    poses,
    singular_curves,
    solve_slice,
    table_csv,
    table_json,
)
from tests.support.families import FAMILIES, family
from tests.support.reference import CASES

FILE = Path(__file__).parents[1] / "data" / "golden.json"

Documents = Iterator[tuple[str, Callable[[], object]]]
"""Name → a call that makes the document."""


def _reference(case: dict[str, Any], legs: tuple[int, ...]) -> Documents:
    """Each slice with leg 1 fixed in full, and one slice for some of the other legs."""
    m = Manipulator.from_json(case["geometry"])
    lengths = [item["l1"] for item in case["slices"]]
    for leg, digits, some in ((1, 90, lengths), *((leg, 30, lengths[:1]) for leg in legs)):
        eliminant = eliminate(m, leg)
        for length in some:
            solve = partial(solve_slice, eliminant, Fraction(length), digits)
            yield f"slice, leg {leg} at {length}", lambda solve=solve: solve().to_json()


def _family(name: str) -> Documents:
    """Every kind of document of a degenerate manipulator, the longer ones for one of its legs."""
    m, leg = family(name), list(FAMILIES).index(name) % 3 + 1
    start, stop = Fraction(5), Fraction(20)
    yield "poses", lambda: poses(m, 7, "9.5", 11, digits=20).to_json()
    yield f"census, leg {leg}", lambda: census(m, fixed_leg=leg, digits=15).to_json()
    if name in ("flat platform", "similar, mirrored", "congruent, mirrored"):
        requirement = Requirement(leg, start, stop, max_cusps=2)
        yield f"check, leg {leg}", lambda: check(m, requirement, digits=15).to_json()
    if name in ("both flat", "congruent"):
        yield f"cusp curves, leg {leg}", lambda: cusp_curves(m, fixed_leg=leg, digits=15).to_json()
    if name in ("flat base", "similar", "congruent"):
        yield "article", lambda: article_table(m, "7.5", digits=15).to_json()


def _forms() -> Documents:
    """Parts, samples, limits and CSV of a generic manipulator."""
    m = EXAMPLES["zein-flat"]
    start, stop, lengths = Fraction(1), Fraction(40), [Fraction(3), Fraction(69, 2)]
    whole = census(m, digits=20)
    curves = cusp_curves(m, digits=20).sampled(lengths)
    limits = {2: (Fraction(10), None), 3: (None, Fraction(30))}
    table = [solve_slice(eliminate(m), length, 20).to_json() for length in lengths]
    yield "census", whole.to_json
    yield "census, part", lambda: census(m, digits=15, start=start, stop=stop).to_json()
    yield "census, CSV", lambda: census_csv(whole.to_json())
    yield "cusp curves, sampled", curves.to_json
    yield "cusp curves, part", lambda: curves.within(start, stop).to_json()
    yield "cusp curves, CSV", lambda: curves_csv(curves.to_json())
    requirement = Requirement(1, start, stop, max_cusps=2, limits=limits)
    yield "check, joint limits", lambda: check(m, requirement, digits=15).to_json()
    innocenti = EXAMPLES["innocenti"]
    yield "loop", lambda: cusp_loop(innocenti, 27, "B", samples=5).with_others().to_json()
    ends = 27, "25.7", "9.2", 2, 4
    yield "path", lambda: joint_path(innocenti, *ends, between=(27, 30), samples=5).to_json()
    yield "no path", lambda: joint_path(innocenti, *ends).to_json()
    yield "table, CSV", lambda: table_csv(table_json(m, 1, 20, table))


def _motions() -> Documents:
    """Aspects, and the questions that they answer."""
    m, limits = EXAMPLES["innocenti"], {"l2": (5, 21)}
    start, stop = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}, {"alpha_deg": -60, "theta1_deg": 30, "l1": 28}
    yield "singular curves", lambda: singular_curves(m, 27).to_json()
    yield "modes", lambda: assembly_modes(m, 27).to_json()
    yield "modes, limits", lambda: assembly_modes(m, 27, limits={"l2": (None, 4)}).to_json()
    yield "modes, range", lambda: assembly_modes(m, between=("0.05", "0.1")).to_json()
    yield "connections", lambda: pose_connections(m, 27, 20, 20, limits=limits).to_json()
    yield "pose path", lambda: pose_path(m, start, stop, samples=5).to_json()
    yield "path, joint limits", lambda: joint_path(m, 27, 20, 20, 3, 4, limits=limits, samples=5).to_json()


SUBJECTS: dict[str, Callable[[], Documents]] = {
    **{case["name"]: partial(_reference, case, ((2,), (), (3,), ())[n % 4]) for n, case in enumerate(CASES)},
    **{f"family {name}": partial(_family, name) for name in FAMILIES},
    "forms": _forms,
    "motions": _motions,
}


def hashes(subject: str) -> dict[str, str]:
    """Name → SHA-256 of the document as JSON, its keys in their order."""
    return {f"{subject}: {name}": _hash(make) for name, make in SUBJECTS[subject]()}


def _hash(make: Callable[[], object]) -> str:
    try:
        document = make()
    except SolverError:
        document = "refused"
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def known() -> dict[str, Any]:
    """The file: `solver_version`, and `sha256` by name."""
    content: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return content


def main() -> int:
    """Compare or write."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.support.golden", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--write", action="store_true", help="write the file")
    write = parser.parse_args().write
    new = {name: value for subject in SUBJECTS for name, value in hashes(subject).items()}
    if write:
        content = {"solver_version": SOLVER_VERSION, "sha256": new}
        FILE.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        return 0
    expected = known()["sha256"]
    different = sorted(name for name in new.keys() | expected if new.get(name) != expected.get(name))
    print("\n".join(different) or f"{len(new)} documents are the same")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
