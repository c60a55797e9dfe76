"""What a design is sought for, and how near a geometry comes to it, by its census or by a check.

The numbers here steer a search, in floats; what a geometry reaches is proved when it is the answer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import groupby, pairwise
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rpr_solver import contract
from rpr_solver.contract import MIN_DIGITS
from rpr_solver.designs.plan import EXCLUDED, LEAST_CHANGE, LONGEST_RANGE, MOST_CUSPS, REQUIRED, Goal
from rpr_solver.designs.space import Space
from rpr_solver.exact.numerals import double, fraction
from rpr_solver.margins.estimates import Estimate
from rpr_solver.margins.systems import slopes_in_floats
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.slices.cusp_table import cusp_table
from rpr_solver.transitions import Requirement
from rpr_solver.transitions.census import bare_census, census
from rpr_solver.transitions.check_report import check_counts

_STEP = 1e-6
"""The step of difference quotients of the lengths, as a share of a parameter's bounds."""
_PROBES = 5
"""Slices in which the cusps nearest to the limits are sought, to steer a search."""
_INFEASIBLE = 2.0
"""The extra cost of a geometry that does not meet the requirement."""

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Cut:
    """An end between two intervals: its length, the jump of the count there, and ∂L/∂x for each place.

    The slopes are 0 where no derivative is known.
    """

    length: float
    jump: int
    slopes: Vector


@dataclass
class Profile:
    """The numbers of cusps of a geometry, by length, and how they move with the parameters.

    Attributes:
        space: what varies.
        manipulator: the geometry.
        document: its census, of all lengths, or its check.
        ways: the nearest ways to other numbers of cusps, once they are known.
    """

    space: Space
    manipulator: Manipulator
    document: Mapping[str, Any] = field(repr=False)
    ways: list[Estimate] | None = field(default=None, repr=False)

    @cached_property
    def place(self) -> Vector:
        """Where the geometry is within the bounds, 0 to 1 each."""
        return np.array(self.space.place(self.manipulator))

    @cached_property
    def intervals(self) -> list[tuple[float, float, int]]:
        """The ends and the number of cusps of each interval, ascending."""
        return [
            (double(fraction(x["from"])), inf if x["to"] is None else double(fraction(x["to"])), x["count"])
            for x in self.document["intervals"]
        ]

    @cached_property
    def aspects(self) -> list[tuple[float, float, int | None]]:
        """The ends of intervals and the numbers of aspects there, None where they are not proved."""
        return [
            (double(fraction(x["from"])), inf if x["to"] is None else double(fraction(x["to"])), x["aspects"])
            for x in self.document.get("slices", self.document["intervals"])
        ]

    @cached_property
    def cuts(self) -> list[Cut]:
        """The ends between neighbouring intervals, with derivatives; events of one length move together."""
        chain = self._chain
        transitions = self.document.get("transitions")
        if transitions is None:
            nothing = np.zeros(len(self.place))
            return [Cut(low[1], high[2] - low[2], nothing) for low, high in pairwise(self.intervals)]
        leg = self.document["fixed_leg"]
        found = []
        for transition in transitions:
            length = transition[f"l{leg}"]
            known = (
                slopes_in_floats(self.manipulator, leg, length, event, MIN_DIGITS)
                for event in transition["events"]
            )
            slopes = [each for each in known if each is not None]
            total = np.mean(slopes, axis=0) @ chain if slopes else np.zeros(len(self.place))
            jump = transition["count_after"] - transition["count_before"]
            found.append(Cut(float(length), jump, total))
        return found

    @cached_property
    def _chain(self) -> Vector:
        """The change of the six lengths with the place."""
        moved = []
        for k in range(len(self.place)):
            above, below = ([*self.place] for _ in range(2))
            above[k] += _STEP
            below[k] -= _STEP
            moved.append(np.subtract(self.space.lengths(above), self.space.lengths(below)) / (2 * _STEP))
        return np.array(moved).T

    @property
    def change(self) -> float:
        """The largest change of a parameter, as a share of how far it may change."""
        values = self.space.tie.nearest(self.manipulator)
        return max(
            abs(values[name] - self.space.origin[name]) / double(self.space.reach(name))
            for name in self.space.names
        )


Run = tuple[float, float, int, int]
"""Two ends, not cut to the range, and the numbers of the first and the last interval between."""


def runs(profile: Profile, goal: Goal) -> list[Run]:
    """The longest stretches of lengths with admitted numbers, windows that are ignored included.

    They may lie outside the range.
    """
    found: list[Run] = []
    narrow = _ignored(profile, goal)
    for k, (start, stop, _) in enumerate(profile.intervals):
        if _admitted(profile, goal, k) or k in narrow:
            if found and found[-1][3] == k - 1:
                found[-1] = (found[-1][0], stop, found[-1][2], k)
            else:
                found.append((start, stop, k, k))
    return [run for run in found if any(_admitted(profile, goal, k) for k in range(run[2], run[3] + 1))]


def best_run(profile: Profile, goal: Goal) -> Run | None:
    """The run with the longest part in the range, or else the nearest to it."""
    low, high = goal.ends
    return max(runs(profile, goal), key=lambda run: min(run[1], high) - max(run[0], low), default=None)


def windows(profile: Profile, goal: Goal) -> list[tuple[float, float, int]]:
    """The parts of the range with numbers that are not admitted, without those that are ignored."""
    (low, high), narrow = goal.ends, _ignored(profile, goal)
    return [
        (max(start, low), min(stop, high), k)
        for k, (start, stop, _) in enumerate(profile.intervals)
        if start < high and stop > low and not _admitted(profile, goal, k) and k not in narrow
    ]


def value(profile: Profile, goal: Goal, radius: float) -> float:
    """What a geometry reaches, in the unit of the objective: larger is better, except for the least change.

    Args:
        profile: the geometry.
        goal: the objective.
        radius: the largest margin, to first order, for that objective.
    """
    if goal.objective == LONGEST_RANGE:
        run = best_run(profile, goal)
        low, high = goal.ends
        return 0.0 if run is None else max(0.0, min(run[1], high) - max(run[0], low))
    if goal.objective == MOST_CUSPS:
        return float(most_cusps(profile, goal))
    if goal.objective == LEAST_CHANGE:
        return profile.change
    return radius


def is_met(profile: Profile, goal: Goal) -> bool:
    """Whether a geometry satisfies the requirement and the constraints, apart from ignored windows."""
    return not windows(profile, goal) and not shortfall(profile, goal)


def most_cusps(profile: Profile, goal: Goal) -> int:
    """The largest number of cusps in the range, or more, in a window that is not ignored."""
    low, high = goal.ends
    inside = [(max(a, low), min(b, high), n) for a, b, n in profile.intervals if a < high and b > low]
    for least in sorted({n for *_, n in inside}, reverse=True):
        for is_as_many, same in groupby(inside, key=lambda one: one[2] >= least):
            run = list(same)
            if is_as_many and run[-1][1] - run[0][0] >= goal.requirement.ignore_windows:
                return least
    return 0


def cost(profile: Profile, goal: Goal, radius: float) -> float:
    """What the search makes small.

    Args:
        profile: the geometry.
        goal: the objective.
        radius: to first order, the distance in the bounds to one cusp pair more, or the margin.
    """
    low, high = goal.ends
    short = shortfall(profile, goal)
    if goal.objective == LONGEST_RANGE:
        run = best_run(profile, goal)
        missed = (high - low) * (1 + short) if short else 0.0
        return missed + (high if run is None else max(run[0], low) - min(run[1], high))
    if goal.objective == MOST_CUSPS:
        missed = contract.MOST_CUSPS * (1 + short) if short else 0.0
        return missed + (1 - 1 / (1 + radius)) - most_cusps(profile, goal)
    left = windows(profile, goal)
    if left or short:
        return _INFEASIBLE + excess(profile, goal, left) + short
    return profile.change if goal.objective == LEAST_CHANGE else -radius


def excess(profile: Profile, goal: Goal, left: Sequence[tuple[float, float, int]]) -> float:
    """How far the counts of windows are from what is admitted: pairs of cusps, times shares of the range."""
    least, most = goal.requirement.min_cusps, goal.requirement.max_cusps
    total = 0.0
    for start, stop, k in left:
        total += _beyond(profile.intervals[k][2], least, most) / 2 * _share(profile, goal, start, stop)
    return total


def shortfall(profile: Profile, goal: Goal) -> float:
    """How far a geometry is from meeting the constraints, without a unit; 0 if it meets them.

    Whether a loop can be proved is not tried: where there is a cusp within the limits, there is one.
    """
    asked, (low, high) = goal.constraints, goal.ends
    inside = [x for x in profile.intervals if x[0] < high and x[1] > low]
    total = 0.0
    if asked.loop == REQUIRED and not any(count for *_, count in inside):
        total += 1 + float(profile.document.get("missed", 0))
    if asked.loop == EXCLUDED:
        total += sum(count * _share(profile, goal, max(a, low), min(b, high)) for a, b, count in inside)
    if asked.bound_aspects:
        for a, b, aspects in profile.aspects:
            if a < high and b > low:
                far = 1 if aspects is None else _beyond(aspects, asked.min_aspects, asked.max_aspects)
                total += far * _share(profile, goal, max(a, low), min(b, high))
    return total


def _beyond(count: int, least: int | None, most: int | None) -> int:
    """By how much a number is outside its bounds."""
    return max(0, (least or 0) - count, 0 if most is None else count - most)


def _share(profile: Profile, goal: Goal, start: float, stop: float) -> float:
    """The weight of a part of the range; even a narrow part has a little."""
    low, high = goal.ends
    whole = (high if high < inf else max(x[0] for x in profile.intervals) + low) - low
    return 0.02 + max(min(stop, low + whole) - start, 0.0) / whole


def _admitted(profile: Profile, goal: Goal, k: int) -> bool:
    return goal.requirement.admits(profile.intervals[k][2])


def _ignored(profile: Profile, goal: Goal) -> set[int]:
    """The intervals of windows of the range that are ignored."""
    (low, high), found = goal.ends, set[int]()
    inside = [k for k, (a, b, _) in enumerate(profile.intervals) if a < high and b > low]
    for is_admitted, same in groupby(inside, key=lambda k: _admitted(profile, goal, k)):
        run = list(same)
        width = min(profile.intervals[run[-1]][1], high) - max(profile.intervals[run[0]][0], low)
        if not is_admitted and width < goal.requirement.ignore_windows:
            found |= set(run)
    return found


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
    if not wish.limits:
        if asked.bound_aspects:
            return census(manipulator, fixed_leg=leg, digits=MIN_DIGITS).to_json()
        return bare_census(manipulator, leg, MIN_DIGITS).to_json()
    document = check_counts(manipulator, wish.ignoring(Fraction(0)), digits=MIN_DIGITS).to_json()
    if asked.bound_aspects:
        table = census(manipulator, fixed_leg=leg, start=wish.start, stop=wish.stop, digits=MIN_DIGITS)
        document["slices"] = table.to_json()["intervals"]
    if asked.loop == REQUIRED and not document["max_cusps_found"]:
        document["missed"] = _missed(manipulator, wish)
    return document


def _missed(manipulator: Manipulator, wish: Requirement) -> float:
    """How far the nearest cusps of some slices are from the joint limits, in sizes of the manipulator.

    It is at most 1, and 1 if there are no cusps.
    """
    size = max(max(-low, high) for low, high in manipulator.bounds())
    span = (wish.start + 2 * size if wish.stop is None else wish.stop) - wish.start
    lengths = [wish.start + span * (2 * k + 1) / (2 * _PROBES) for k in range(_PROBES)]
    tables = cusp_table(manipulator, lengths, digits=MIN_DIGITS, fixed_leg=wish.fixed_leg)
    joints = (cusp.coordinates[2:] for table in tables for cusp in table.cusps)
    far = (max(_outside(wish, joint)) / size for joint in joints)
    return double(min(far, default=Fraction(1), key=lambda x: min(x, Fraction(1))))


def _outside(wish: Requirement, joint: tuple[str, ...]) -> Iterator[Fraction]:
    """How far each leg is outside its limits."""
    for leg, text in zip(free_legs(wish.fixed_leg), joint, strict=True):
        low, high = wish.limits.get(leg, (None, None))
        length = Fraction(text)
        yield max(Fraction(0), length - (high or length), (low or length) - length)
