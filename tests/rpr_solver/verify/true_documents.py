"""True documents of every kind: document n of a kind is the same in every run with the same seed.

The manipulators are general, of every degenerate family, with long decimals, and very large or small; the
fixed leg is any. Slices lie also 10^-5 to 10^-40 beside transitions, ranges begin there, poses lie beside
folds, digits are 15 to 200. Paths are loops and paths between poses, numbered or given, in ranges and within
limits, also with limits of motion and clearances.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from rpr_solver import (
    InputError,
    Manipulator,
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
    with_condition,
)
from rpr_solver.exact.decimals import rounded_down
from tests.rpr_solver.long_run import NAMES, manipulator
from tests.support.families import FAMILIES, family

Document = dict[str, Any]
_DIGITS = (15, 30, 90, 200)
_SCALES = (Fraction(1, 10**6), Fraction(1, 1000), Fraction(1000), Fraction(10**6))


@dataclass(frozen=True)
class Question:
    """A random manipulator with what is asked of it.

    Attributes:
        sort: a degenerate family, ``"scaled"``, ``"long"`` or ``"general"``.
        manipulator: the geometry.
        scale: its size, about a tenth of its sides.
        leg: the fixed leg.
        draw: the source of all further choices.
        digits: what the digits of documents are drawn from.
    """

    sort: str
    manipulator: Manipulator
    scale: Fraction
    leg: int
    draw: random.Random
    digits: tuple[int, ...] = _DIGITS

    @property
    def free(self) -> list[int]:
        """The legs that are not fixed."""
        return [leg for leg in (1, 2, 3) if leg != self.leg]

    def length(self, low: int = 20, high: int = 400) -> Fraction:
        """A length in tenths."""
        return self.scale * Fraction(self.draw.randint(low, high), 10)

    def beside(self) -> Fraction | None:
        """In three of ten questions, a length 10^-5 to 10^-40 beside a transition, if there is one."""
        draw = self.draw
        if draw.random() >= 0.3:
            return None
        rows = census(self.manipulator, digits=60, fixed_leg=self.leg).transitions
        off = Fraction(draw.choice([-1, 1]), 10 ** draw.choice([5, 15, 30, 40]))
        return Fraction(draw.choice(rows).length) * (1 + off) if rows else None


def question(seed: int, kind: str, n: int, *, degenerate: bool = True) -> Question:
    """The question of document n of a kind."""
    draw = random.Random(f"{seed} {kind} {n}")
    scale, leg = Fraction(1), draw.choice([1, 2, 3])
    match n % 5:
        case 0 if degenerate:
            sort = list(FAMILIES)[n // 5 % len(FAMILIES)]
            m, leg = family(sort), (n // 5 + n // 5 // len(FAMILIES)) % 3 + 1
        case 1:
            sort, scale, m = "scaled", draw.choice(_SCALES), manipulator(draw)
            m = replace(m, **{name: getattr(m, name) * scale for name in NAMES})
        case 2:
            sort, m = "long", _long(draw)
        case _:
            sort, m = "general", manipulator(draw)
    return Question(sort, m, scale, leg, draw)


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


def _table(q: Question) -> Document:
    lengths = [q.length(1), q.beside() or q.length(1)]
    return table_document(q.manipulator, lengths, digits=q.draw.choice(q.digits), fixed_leg=q.leg)


def _poses(q: Question) -> Document:
    """At random, of equal legs, or 10^-10 to 10^-30 beside a cusp, where there are folds on all sides."""
    lengths, sort = [q.length(10, 250) for _ in range(3)], q.draw.randrange(4)
    if sort == 0:
        lengths[1] = lengths[0]
    if sort == 1 and (cusps := cusp_table(q.manipulator, lengths[0], digits=80)[0].cusps):
        off = 1 + Fraction(q.draw.choice([-1, 1]), 10 ** q.draw.choice([10, 20, 30]))
        _, _, second, third = q.draw.choice(cusps).coordinates
        lengths = [lengths[0], Fraction(second) * off, Fraction(third)]
    table = poses(q.manipulator, *lengths, digits=q.draw.choice(q.digits))
    scale = q.draw.choice([None, Fraction(q.draw.randint(1, 99), 7)])
    return (with_condition(table, scale) if q.draw.random() < 0.5 else table).to_json()


def _census(q: Question) -> Document:
    """Of all lengths, from one beside a transition, or of a window."""
    start, digits = q.beside() or Fraction(0), q.draw.choice(q.digits)
    stop = q.draw.choice([None, start + q.length(10, 300)])
    return census(q.manipulator, digits=digits, fixed_leg=q.leg, start=start, stop=stop).to_json()


def _report(q: Question) -> Document:
    """With joint limits or without; its range may begin beside a transition."""
    draw, start = q.draw, q.beside() or q.scale * q.draw.randint(1, 30)
    limits = {draw.choice(q.free): (q.scale * draw.randint(0, 10), None)} if draw.random() < 0.4 else {}
    stop, most = start + q.scale * draw.choice([1, 3]), draw.choice([0, 2, 4, 24])
    requirement = Requirement(q.leg, start, stop, max_cusps=most, limits=limits)
    return check(q.manipulator, requirement, digits=draw.choice(q.digits)).to_json()


def _curves(q: Question) -> Document:
    """Of a small window, or all of them with a point of each in every interval between transitions."""
    curves = cusp_curves(q.manipulator, digits=q.draw.choice(q.digits[:2]), fixed_leg=q.leg)
    if q.draw.random() < 0.3:
        return curves.to_json()
    start = q.length(1)
    stop = start + q.scale * q.draw.choice([1, 4])
    return curves.part(start, stop, lengths=[start + (stop - start) * k / 3 for k in (1, 2)]).to_json()


def _margin(q: Question) -> Document:
    """Of a slice, of a requirement with joint limits or without, or of a window."""
    draw, scale = q.draw, q.scale
    length = q.length(20, 300)
    form: dict[str, Any] = {"most_boxes": 20_000}
    if draw.random() < 0.5:
        form["weights"] = {name: draw.choice([0, 1, 1]) for name in NAMES} | {"d1": 1}
    else:
        form["tolerance"] = scale * Fraction(1, 10 ** draw.randint(2, 5))
    match draw.randrange(4):
        case 0:
            limits = {draw.choice(q.free): (scale, 100 * scale)} if draw.random() < 0.5 else {}
            stop = None if draw.random() < 0.2 else length + scale / 10
            form["requirement"] = Requirement(q.leg, length, stop, max_cusps=24, limits=limits)
        case 1:
            form["window"] = length
        case _:
            form["length"] = length
    return margin(q.manipulator, fixed_leg=q.leg, **form).to_json()


def _singular(q: Question) -> Document:
    length, digits = q.beside() or q.length(), q.draw.choice(q.digits)
    return singular_curves(q.manipulator, length, fixed_leg=q.leg, digits=digits).to_json()


def _path(q: Question) -> Document:
    return q.draw.choice([_loop, _path_of_joints, _path_to_given])(q, _asked(q))


def _motion(q: Question) -> Document:
    """A path with limits of motion, rows by step or chord, or a clearance."""
    draw, asked = q.draw, _asked(q)
    asked.pop("clearance", None)
    if draw.random() < 0.6:
        asked["clearance"] = draw.choice([Fraction(1, 2), 3, 12, "best"])
    if draw.random() < 0.75:
        for name in ("samples", "timing", "duration"):
            del asked[name]
        sort = draw.choice(["number", "step", "chord", "chord"])
        rows = {"number": draw.randint(2, 9), "step": Fraction(1, 2), "chord": q.scale * draw.randint(1, 3)}
        asked["sampling"] = {sort: rows[sort]}
        if sort == "step" or draw.random() < 0.7:
            sizes = {"speed": 5, "acceleration": 10, "jerk": 50}
            kinds = draw.choice([["speed", "acceleration"], [*sizes]])
            asked["motion"] = {
                kind: {f"l{k}": q.scale * sizes[kind] * draw.randint(1, 3) for k in (1, 2, 3)}
                for kind in kinds
            }
    return draw.choice([_loop, _path_of_joints, _path_to_given])(q, asked)


def _asked(q: Question) -> dict[str, Any]:
    """Digits, samples, and sometimes wide limits or a clearance."""
    draw = q.draw
    limits = {
        leg: (None, q.scale * draw.randint(20, 60)) for leg in draw.sample(q.free, draw.choice([0, 1, 2]))
    }
    more = {"clearance": draw.choice([1, "best"])} if draw.random() < 0.1 else {}
    return {
        "fixed_leg": q.leg,
        "digits": draw.choice(q.digits),
        "samples": draw.randint(2, 9),
        "timing": draw.choice(["cosine", "trapezoid", "constant"]),
        "duration": draw.choice([1, "7.5"]),
        "limits": limits if draw.random() < 0.5 and limits else None,
        **more,
    }


def _loop(q: Question, asked: dict[str, Any]) -> Document:
    length = q.length()
    cusps = cusp_table(q.manipulator, length, fixed_leg=q.leg)[0].cusps
    if not cusps:
        raise SolverError("there is no cusp")
    number = q.draw.randrange(len(cusps))
    if asked["limits"]:
        near = dict(zip(q.free, cusps[number].coordinates[2:], strict=True))
        asked["limits"] = {k: (None, 2 * rounded_down(Fraction(near[k]), 6)) for k in asked["limits"]}
    return cusp_loop(q.manipulator, length, number + 1, **asked).to_json()


def _joints(q: Question) -> tuple[list[Fraction], int]:
    """A joint vector, and the number of its poses, which is at least 2."""
    lengths = [q.length(30, 300) for _ in range(3)]
    number = poses(q.manipulator, *lengths).count
    if number < 2:
        raise SolverError("there are no two poses")
    return lengths, number


def _path_of_joints(q: Question, asked: dict[str, Any]) -> Document:
    lengths, number = _joints(q)
    start, stop = q.draw.sample(range(1, number + 1), 2)
    held = lengths[q.leg - 1]
    if q.draw.random() < 0.4 and "clearance" not in asked:
        shares = q.draw.randint(7, 10), q.draw.randint(11, 14)
        asked["between"] = [held * Fraction(share, 10) for share in shares]
    return joint_path(q.manipulator, *lengths, start, stop, **asked).to_json()


def _path_to_given(q: Question, asked: dict[str, Any]) -> Document:
    lengths, number = _joints(q)
    pose, theta = q.draw.randint(1, number), f"theta{q.leg}_deg"
    row = poses(q.manipulator, *lengths).poses[pose - 1]
    start = {**{f"l{k}": x for k, x in enumerate(lengths, 1)}, "pose": pose}
    angles = {
        name: round(Fraction(getattr(row, name)), 3) + q.draw.randint(-20, 20)
        for name in ("alpha_deg", theta)
    }
    held = lengths[q.leg - 1] * q.draw.choice([1, 1, Fraction(11, 10)])
    if held != lengths[q.leg - 1]:
        asked.pop("clearance", None)
    ends = (start, {**angles, f"l{q.leg}": held})
    return pose_path(q.manipulator, *(ends if q.draw.random() < 0.5 else ends[::-1]), **asked).to_json()


KINDS: Mapping[str, Callable[[Question], Document]] = {
    "tables": _table,
    "poses": _poses,
    "censuses": _census,
    "reports": _report,
    "curves": _curves,
    "margins": _margin,
    "singular": _singular,
    "paths": _path,
    "motions": _motion,
}


def true_document(kind: str, n: int, seed: int = 1, digits: tuple[int, ...] = _DIGITS) -> Document | None:
    """Document n of a kind as JSON has it; None if the solver has none for this question."""
    asked = replace(question(seed, kind, n), digits=digits)
    for _ in range(20):  # a joint vector without poses, a slice without cusps: the next choices are others
        try:
            return json.loads(json.dumps(KINDS[kind](asked)))  # type: ignore[no-any-return]
        except SolverError:
            if kind not in ("paths", "motions"):
                return None
    return None
