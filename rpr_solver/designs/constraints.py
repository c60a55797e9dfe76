"""What is wanted of a range beside its numbers of cusps, as a search sees it, and as it is proved.

A loop round a cusp exists in a slice if a cusp lies strictly within the joint limits: small enough, it keeps
them. If none does, there is none: what the limits allow is a rectangle of the joint plane, and no closed
curve in it goes round a point outside or on its edge. So that there is no loop is proved by the counts of a
check, and that there is one by a loop.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any

from rpr_solver.contract import MIN_DIGITS
from rpr_solver.designs import EXCLUDED, REQUIRED, Constraints
from rpr_solver.designs.goals import Goal
from rpr_solver.errors import InputError, SolverError
from rpr_solver.margins import LENGTHS
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.paths.loops import loop_in_slice, slice_for_loops
from rpr_solver.paths.path import Path
from rpr_solver.paths.terms import PathTerms
from rpr_solver.slices import kept_eliminant
from rpr_solver.slices.cusp_table import cusp_table
from rpr_solver.transitions import Requirement
from rpr_solver.transitions.census import Census, bare_census, census
from rpr_solver.transitions.check_report import CheckReport, check_counts

_PROBES = 5
"""Slices in which the cusps nearest to the limits are sought, to steer a search."""
_TRIED = 8
"""Cusps round which a loop is tried."""


@dataclass(frozen=True)
class Kept:
    """What is proved of constraints.

    Attributes:
        met: whether all are kept.
        loop: a loop round a cusp within the joint limits; None if none is required, or could be proved.
        aspects: the least and the greatest number of aspects in the range; None if they do not matter, or are
            not proved in every interval.
    """

    met: bool
    loop: Path | None
    aspects: tuple[int, int] | None

    def to_json(self) -> dict[str, Any]:
        """The constraints of the best geometry in a design document."""
        least, most = self.aspects or (None, None)
        return {
            "met": self.met,
            "loop": None if self.loop is None else self.loop.to_json(),
            "min_aspects_found": least,
            "max_aspects_found": most,
        }


def document_of(manipulator: Manipulator, goal: Goal) -> dict[str, Any]:
    """What a search needs of a geometry.

    It is the census of all lengths, with the numbers of aspects, a third of its time, only if they matter; or
    the check of the requirement if there are joint limits. Then ``slices`` has the intervals with aspects, if
    they matter, and ``missed`` how far the cusps are from the limits if none is within, but a loop is
    required.

    Raises:
        SolverError: the geometry could not be decided.
    """
    wish, asked = goal.requirement, goal.constraints
    leg = wish.fixed_leg
    if not goal.needs_check:
        if asked.bound_aspects:
            return census(manipulator, fixed_leg=leg, digits=MIN_DIGITS).to_json()
        return bare_census(manipulator, leg, MIN_DIGITS).to_json()
    document = check_counts(manipulator, wish, digits=MIN_DIGITS).to_json()
    if asked.bound_aspects:
        table = census(manipulator, fixed_leg=leg, start=wish.start, stop=wish.stop, digits=MIN_DIGITS)
        document["slices"] = table.to_json()["intervals"]
    if asked.loop == REQUIRED and not document["max_cusps_found"]:
        document["missed"] = _missed(manipulator, wish)
    return document


def kept_constraints(asked: Constraints, report: CheckReport, table: Census) -> Kept:
    """Proves constraints, or not.

    Args:
        asked: the constraints.
        report: the check of the geometry, over the range, within the joint limits.
        table: its census over the range.
    """
    loop = proved_loop(report) if asked.loop == REQUIRED else None
    met = loop is not None if asked.loop == REQUIRED else True
    if asked.loop == EXCLUDED:
        met = not any(x.count for x in report.intervals)
    aspects = None
    if asked.bound_aspects:
        numbers = [x for x in table.aspects if x is not None]
        if len(numbers) == len(table.counts):
            aspects = min(numbers), max(numbers)
        least, most = asked.min_aspects or 0, asked.max_aspects or inf
        met = met and aspects is not None and least <= aspects[0] and aspects[1] <= most
    return Kept(met, loop, aspects)


def proved_loop(report: CheckReport) -> Path | None:
    """A loop round a cusp, within the joint limits, in a slice of the range; None if none could be proved.

    It is sought in the intervals with cusps, the widest first.
    """
    wish = report.requirement
    terms = PathTerms.of(limits=wish.limits, fixed_leg=wish.fixed_leg)
    eliminant = kept_eliminant(report.manipulator, wish.fixed_leg)
    tried = 0
    for x in sorted((x for x in report.intervals if x.count), key=lambda x: x.width, reverse=True):
        try:
            table = slice_for_loops(eliminant, x.example)
        except SolverError:
            continue
        for number in range(1, table.count + 1):
            try:
                return loop_in_slice(eliminant, table, number, terms)
            except InputError:  # the limits exclude this cusp
                continue
            except SolverError:
                tried += 1
                if tried == _TRIED:
                    return None
    return None


def _missed(manipulator: Manipulator, wish: Requirement) -> float:
    """How far the nearest cusps of some slices are from the joint limits, in sizes of the manipulator.

    It is 1 at most, and if there are none.
    """
    size = max(abs(getattr(manipulator, name)) for name in LENGTHS)
    span = (wish.start + 2 * size if wish.stop is None else wish.stop) - wish.start
    lengths = [wish.start + span * (2 * k + 1) / (2 * _PROBES) for k in range(_PROBES)]
    tables = cusp_table(manipulator, lengths, digits=MIN_DIGITS, fixed_leg=wish.fixed_leg)
    joints = (cusp.coordinates[2:] for table in tables for cusp in table.cusps)
    far = (max(_outside(wish, joint)) / size for joint in joints)
    return float(min(far, default=Fraction(1), key=lambda x: min(x, Fraction(1))))


def _outside(wish: Requirement, joint: tuple[str, ...]) -> Iterator[Fraction]:
    """How far each leg is outside its limits."""
    for leg, text in zip(free_legs(wish.fixed_leg), joint, strict=True):
        low, high = wish.limits.get(leg, (None, None))
        length = Fraction(text)
        yield max(Fraction(0), length - (high or length), (low or length) - length)
