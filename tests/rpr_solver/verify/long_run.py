"""The long run of the verifier: random documents are accepted, and mutations of them refused.

    python -m tests.rpr_solver.verify.long_run [KIND ...] [--documents 100] [--first 0] [--mutations 2]

Kinds are tables, poses, censuses, curves, reports, margins, singular curves (``singular``), paths, and paths
with limits of motion, rows by number, step or chord, and clearances (``motions``).
Document n of a kind is the same in every run with the same seed, so that a run may be done in parts
(``--first``) and a failure be repeated alone. The manipulators are general, of every degenerate family, with
long decimals, and very large or small; slices are also 10^-40 beside transitions, and ranges begin there,
poses beside folds, of 15 to 200 digits. Paths are loops and paths between poses, numbered or given, in
ranges and within limits. Prints every failure as it is found, then the numbers, and exits with status 1 if
there was a failure.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from rpr_solver import (
    InputError,
    Manipulator,
    NoPath,
    Path,
    Requirement,
    SolverError,
    census,
    check,
    cusp_curves,
    cusp_loop,
    cusp_table,
    joint_path,
    margin,
    pose_path,
    poses,
    singular_curves,
    table_document,
    verify_document,
)
from rpr_solver.exact.decimals import rounded_down
from tests.rpr_solver.long_run import NAMES, manipulator
from tests.support.families import FAMILIES, family
from tests.support.mutations import (
    OF_CENSUSES,
    OF_CURVES,
    OF_MARGINS,
    OF_POSES,
    OF_REPORTS,
    OF_TABLES,
    Document,
    Mutation,
    mutated,
)
from tests.support.verified import is_named, is_refused

_DIGITS = (15, 30, 90, 200)
_TRIES = 20
_SCALES = (Fraction(1, 10**6), Fraction(1, 1000), Fraction(1000), Fraction(10**6))


@dataclass(frozen=True)
class Drawn:
    """A random manipulator with what is asked of it."""

    sort: str
    manipulator: Manipulator
    scale: Fraction
    leg: int
    draw: random.Random
    digits: tuple[int, ...] = _DIGITS
    """What the digits of documents are drawn from."""


Options = Callable[[Drawn, Mapping[int, Fraction]], dict[str, Any]]
"""What a path is asked for with, about some lengths."""


def drawn(seed: int, kind: str, n: int) -> Drawn:
    """The question of document n."""
    draw = random.Random(f"{seed} {kind} {n}")
    scale = Fraction(1)
    match n % 5:
        case 0:
            sort = list(FAMILIES)[n // 5 % len(FAMILIES)]
            m = family(sort)
        case 1:
            sort, scale = "scaled", draw.choice(_SCALES)
            m = manipulator(draw)
            m = replace(m, **{name: getattr(m, name) * scale for name in NAMES})
        case 2:
            sort, m = "long", _long(draw)
        case _:
            sort, m = "general", manipulator(draw)
    # each family with another leg when it comes again
    leg = (n // 5 + n // 5 // len(FAMILIES)) % 3 + 1
    return Drawn(sort, m, scale, leg if n % 5 == 0 else draw.choice([1, 2, 3]), draw)


def _long(draw: random.Random) -> Manipulator:
    """Sides of 15 to 30 digits."""
    while True:
        places = draw.choice([14, 20, 28])
        low = (5, -15, -15, 5, 5, 5)
        values = [Fraction(draw.randint(x * 10**places, 15 * 10**places), 10**places) for x in low]
        try:
            return Manipulator(*values, orientation=draw.choice(["ccw", "cw"]))
        except InputError:
            continue


def _beside(question: Drawn) -> Fraction | None:
    """In three of ten questions, a length 10^-5 to 10^-40 beside a transition, if there is one."""
    draw = question.draw
    if draw.random() >= 0.3:
        return None
    rows = census(question.manipulator, digits=60, fixed_leg=question.leg).transitions
    off = Fraction(draw.choice([-1, 1]), 10 ** draw.choice([5, 15, 30, 40]))
    return Fraction(draw.choice(rows).length) * (1 + off) if rows else None


def table(question: Drawn) -> Document:
    """A table of two slices, one of them 10^-5 to 10^-40 beside a transition if there is one."""
    draw, leg = question.draw, question.leg
    lengths = [question.scale * Fraction(draw.randint(1, 400), 10) for _ in range(2)]
    lengths[1] = _beside(question) or lengths[1]
    return table_document(question.manipulator, lengths, digits=draw.choice(question.digits), fixed_leg=leg)


def some_poses(question: Drawn) -> Document:
    """The poses of a joint vector: at random, of equal legs, or 10^-10 to 10^-60 beside a fold."""
    draw, m = question.draw, question.manipulator
    lengths = [question.scale * Fraction(draw.randint(10, 250), 10) for _ in range(3)]
    match draw.randrange(4):
        case 0:
            lengths[1] = lengths[0]
        case 1:
            cusps = cusp_table(m, lengths[0], digits=80)[0].cusps
            if cusps:  # close to a cusp are folds on all sides
                off = 1 + Fraction(draw.choice([-1, 1]), 10 ** draw.choice([10, 20, 30]))
                _, _, second, third = draw.choice(cusps).coordinates
                lengths = [lengths[0], Fraction(second) * off, Fraction(third)]
        case 2:
            lengths = [question.scale * draw.randint(1, 20) for _ in range(3)]
        case _:
            pass
    return poses(m, *lengths, digits=draw.choice(question.digits)).to_json()


def a_report(question: Drawn) -> Document:
    """A report of a check, with joint limits or without; its range may begin beside a transition."""
    draw = question.draw
    start = _beside(question) or question.scale * draw.randint(1, 30)
    free = [leg for leg in (1, 2, 3) if leg != question.leg]
    limits = {draw.choice(free): (question.scale * draw.randint(0, 10), None)} if draw.random() < 0.4 else {}
    stop, most = start + question.scale * draw.choice([1, 3]), draw.choice([0, 2, 4, 24])
    requirement = Requirement(question.leg, start, stop, max_cusps=most, limits=limits)
    return check(question.manipulator, requirement, digits=draw.choice(question.digits)).to_json()


def whole_census(question: Drawn) -> Document:
    """A census of all lengths or from one beside a transition."""
    digits, start = question.draw.choice(question.digits), _beside(question) or 0
    return census(question.manipulator, digits=digits, fixed_leg=question.leg, start=start).to_json()


def some_curves(question: Drawn) -> Document:
    """The curves of a small window, with a full certificate or without."""
    start = question.scale * Fraction(question.draw.randint(1, 400), 10)
    curves = cusp_curves(question.manipulator, digits=15, fixed_leg=question.leg)
    stop = start + question.scale * question.draw.choice([1, 4])
    lengths = [start + (stop - start) * Fraction(k, 3) for k in (1, 2)]
    certificate = question.draw.choice(["short", "full"])
    return curves.part(start, stop, lengths=lengths).to_json(certificate=certificate)


def whole_curves(question: Drawn) -> Document:
    """All curves with a full certificate, a point of each in every interval between transitions."""
    whole = cusp_curves(question.manipulator, digits=15, fixed_leg=question.leg)
    return whole.to_json(certificate="full")


def some_margin(question: Drawn) -> Document:
    """A margin with its proof: of a slice, of a requirement with joint limits or without, or of a window."""
    draw, m, scale = question.draw, question.manipulator, question.scale
    length = scale * Fraction(draw.randint(20, 300), 10)
    free = [leg for leg in (1, 2, 3) if leg != question.leg]
    weights = {g: draw.choice([0, 1, 1]) for g in ("a2x", "a3x", "a3y", "d1", "d2", "d3")} | {"d1": 1}
    form: dict[str, Any] = {"weights": weights, "certificate": "full", "most_boxes": 20_000}
    if draw.random() < 0.5:
        del form["weights"]
        form["tolerance"] = scale * Fraction(1, 10 ** draw.randint(2, 5))
    match draw.randrange(4):
        case 0:
            limits = {draw.choice(free): (scale, 100 * scale)} if draw.random() < 0.5 else {}
            stop = None if draw.random() < 0.2 else length + scale / 10
            form["requirement"] = Requirement(question.leg, length, stop, max_cusps=24, limits=limits)
        case 1:
            form["window"] = length
        case _:
            form["length"] = length
    return margin(m, fixed_leg=question.leg, **form).to_json()


def some_singular_curves(question: Drawn) -> Document:
    """The singular curves of a slice, which may be beside a transition."""
    draw, leg = question.draw, question.leg
    length = _beside(question) or question.scale * Fraction(draw.randint(20, 400), 10)
    digits = draw.choice(question.digits)
    return singular_curves(question.manipulator, length, fixed_leg=leg, digits=digits).to_json()


def some_path(question: Drawn, options: Options | None = None) -> Document:
    """A loop, a path between two poses of a joint vector, or to a given pose; the first that exists."""
    make = question.draw.choice([_loop, _path_of_joints, _path_to_given])
    for _ in range(_TRIES - 1):
        try:
            return make(question, options or _options).to_json()
        except SolverError:
            continue
    return make(question, options or _options).to_json()


def some_motion(question: Drawn) -> Document:
    """The same with limits of motion, rows by number, step or chord, and in half of them a clearance."""
    return some_path(question, _options_of_motion)


def _options_of_motion(question: Drawn, lengths: Mapping[int, Fraction]) -> dict[str, Any]:
    """Digits, perhaps limits of joints, limits of motion, a clearance; what rows are taken."""
    draw, options = question.draw, _options(question, lengths)
    options.pop("clearance", None)
    if draw.random() < 0.6:
        options["clearance"] = draw.choice([Fraction(1, 2), 3, 12, "best"])
    if draw.random() < 0.25:
        return options
    for name in ("samples", "timing", "duration"):
        del options[name]
    sort = draw.choice(["number", "step", "chord", "chord"])
    if sort == "step" or draw.random() < 0.7:
        options["motion"] = {
            kind: {f"l{leg}": _about(draw, question.scale * size) for leg in (1, 2, 3)}
            for kind, size in (("speed", 5), ("acceleration", 10), ("jerk", 50))
            if kind != "jerk" or draw.random() < 0.5
        }
    rows = {"number": draw.randint(2, 9), "step": Fraction(1, 2), "chord": _about(draw, question.scale)}
    options["sampling"] = {sort: rows[sort]}
    return options


def _about(draw: random.Random, size: Fraction) -> Fraction:
    """A number of this size, up to a factor of 3, of two digits."""
    return Fraction(f"{float(size) * 3 ** draw.uniform(-1, 1):.2g}")


def _options(question: Drawn, lengths: Mapping[int, Fraction]) -> dict[str, Any]:
    """Digits, samples, and perhaps limits about some lengths, or a clearance."""
    draw = question.draw
    limits: dict[int, tuple[Fraction | None, Fraction]] = {}
    if draw.random() < 0.5:
        for leg in draw.sample(sorted(lengths), draw.choice([1, 2])):
            low, high = Fraction(draw.randint(3, 10), 10), Fraction(draw.randint(11, 30), 10)
            limits[leg] = (draw.choice([None, low * lengths[leg]]), high * lengths[leg])
    more = {"clearance": draw.choice([1, "best"])} if draw.random() < 0.1 else {}
    timing = draw.choice(["cosine", "trapezoid", "constant"])
    return {
        "fixed_leg": question.leg,
        "digits": draw.choice(question.digits),
        "samples": draw.randint(2, 9),
        "timing": timing,
        "duration": draw.choice([1, "7.5"]),
        "limits": limits or None,
        **more,
    }


def _loop(question: Drawn, options: Options) -> Path:
    draw, m, leg = question.draw, question.manipulator, question.leg
    length = question.scale * Fraction(draw.randint(20, 400), 10)
    cusps = cusp_table(m, length, fixed_leg=leg)[0].cusps
    if not cusps:
        raise SolverError("there is no cusp")
    number = draw.randrange(len(cusps))
    near = dict(zip([k for k in (1, 2, 3) if k != leg], cusps[number].coordinates[2:], strict=True))
    lengths = {k: rounded_down(Fraction(x), 6) for k, x in near.items()}
    return cusp_loop(m, length, number + 1, **options(question, lengths))


def _joints(question: Drawn) -> tuple[list[Fraction], int]:
    """A joint vector, and the number of its poses."""
    lengths = [question.scale * Fraction(question.draw.randint(30, 300), 10) for _ in range(3)]
    number = poses(question.manipulator, *lengths).count
    if number < 2:
        raise SolverError("there are no two poses")
    return lengths, number


def _path_of_joints(question: Drawn, options: Options) -> Path | NoPath:
    draw, leg = question.draw, question.leg
    lengths, number = _joints(question)
    start, stop = draw.sample(range(1, number + 1), 2)
    held = lengths[leg - 1]
    own = options(question, dict(enumerate(lengths, 1)))
    if draw.random() < 0.4 and ("clearance" not in own or options is not _options):
        own["between"] = (
            held * Fraction(draw.randint(7, 10), 10),
            held * Fraction(draw.randint(11, 14), 10),
        )
    return joint_path(question.manipulator, *lengths, start, stop, **own)


def _path_to_given(question: Drawn, options: Options) -> Path | NoPath:
    draw, leg = question.draw, question.leg
    lengths, number = _joints(question)
    pose = draw.randint(1, number)
    row = poses(question.manipulator, *lengths).poses[pose - 1]
    start = {**{f"l{k}": x for k, x in enumerate(lengths, 1)}, "pose": pose}
    near = row.alpha_deg, getattr(row, f"theta{leg}_deg")
    alpha, theta = (round(Fraction(x), 3) + draw.randint(-20, 20) for x in near)
    held = lengths[leg - 1] * draw.choice([1, 1, Fraction(11, 10)])
    stop = {"alpha_deg": alpha, f"theta{leg}_deg": theta, f"l{leg}": held}
    own = options(question, dict(enumerate(lengths, 1)))
    if held != lengths[leg - 1] or options is _options:
        own.pop("clearance", None)
    ends = (start, stop) if draw.random() < 0.5 else (stop, start)
    return pose_path(question.manipulator, *ends, **own)


KINDS: Mapping[str, tuple[Callable[[Drawn], Document], tuple[Mutation, ...]]] = {
    "tables": (table, OF_TABLES),
    "poses": (some_poses, OF_POSES),
    "censuses": (whole_census, OF_CENSUSES),
    "curves": (some_curves, OF_CURVES),
    "reports": (a_report, OF_REPORTS),
    "margins": (some_margin, OF_MARGINS),
    "singular": (some_singular_curves, ()),
    "paths": (some_path, ()),
    "motions": (some_motion, ()),
}
WHOLE = {"curves": whole_curves}
"""What docs/verify.md says to ask for where a document of this kind leaves claims open."""
EFFORT = {"margins": 20}
"""How many times more work is allowed; 1 if it is not here."""


def run(kind: str, n: int, arguments: Any, counts: Counter[str]) -> None:
    """Document n: a failure is printed and counted."""
    make, mutations = KINDS[kind]
    question = drawn(arguments.seed, kind, n)
    about = f"{kind} {n}: {question.sort}, {question.manipulator}, leg {question.leg}"
    try:
        document = json.loads(json.dumps(make(question)))
    except SolverError as error:
        print(f"{about}: no document: {error}", flush=True)
        counts["no document"] += 1
        return
    answer = verify_document(document, effort=EFFORT.get(kind, 1))
    counts["documents accepted" if answer.accepted else "DOCUMENTS REFUSED"] += 1
    counts["documents established"] += answer.established
    if not answer.established and kind in WHOLE:
        whole = verify_document(json.loads(json.dumps(WHOLE[kind](question))))
        counts["documents established as a whole" if whole.established else "DOCUMENTS LEFT OPEN"] += 1
        for claim in (*whole.refused, *whole.open):
            print(f"{about}: as a whole: {claim.at}: {claim.claim}: {claim.reason}", flush=True)
    counts["proofs of margins"] += kind == "margins" and "full" in document["certificate"]
    counts.update(f"claims {claim.status.value}" for claim in answer.claims)
    why = {re.sub(r"[0-9.]+", "*", claim.reason) for claim in answer.open}
    counts.update(f"documents open as {reason}" for reason in why)
    if not answer.established:
        print(f"{about}: open: {'; '.join(sorted(why))}", flush=True)
    for claim in answer.refused:
        print(f"{about}: REFUSED at {claim.at}: {claim.claim}: {claim.reason}", flush=True)
    first = n % max(len(mutations), 1)
    chosen = mutations[first:] + mutations[:first]
    for done, wrong in mutated(document, chosen, arguments.mutations if mutations else 0, n):
        named = is_named(wrong)
        refused = "refused" if named and is_refused(wrong) else "named as open"
        counts[f"mutations {refused}" if named else "MUTATIONS ACCEPTED"] += 1
        counts[f"{kind}: {done.split(' of ')[0]}"] += 1
        if not named:
            print(f"{about}: ACCEPTED with {done}", flush=True)


def main() -> int:
    """Runs a part of the long run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", default=[*KINDS], metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--documents", type=int, default=100, help="of each kind")
    parser.add_argument("--first", type=int, default=0, help="number of the first document")
    parser.add_argument("--mutations", type=int, default=2, help="of each document")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    failed = False
    for kind in arguments.kinds:
        counts: Counter[str] = Counter()
        start = time.process_time()
        for n in range(arguments.first, arguments.first + arguments.documents):
            run(kind, n, arguments, counts)
            if n % 10 == 9:
                print(f"{kind}: {n + 1} in {time.process_time() - start:.0f} s", flush=True)
        print(kind, *(f"  {number:5} {name}" for name, number in sorted(counts.items())), sep="\n")
        failed = failed or bool(counts["DOCUMENTS REFUSED"] or counts["MUTATIONS ACCEPTED"])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
