"""Design: the best geometry that a bounded search found for what is wanted of its cusps, proved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any, Unpack

from rpr_solver.contract import LENGTHS, MIN_DIGITS, Progress, check_type, document_head, silent
from rpr_solver.designs.goals import document_of
from rpr_solver.designs.plan import (
    EXCLUDED,
    LARGEST_MARGIN,
    LEAST_CHANGE,
    LONGEST_RANGE,
    MOST_CUSPS,
    REQUIRED,
    Constraints,
    Goal,
    Options,
    Plan,
)
from rpr_solver.designs.search import Candidate, Documents, Outcome, searched
from rpr_solver.errors import SolverError
from rpr_solver.exact.decimals import round_fraction
from rpr_solver.exact.rationals import exact_str
from rpr_solver.margins.margin import Margin, margin
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.notebook import counted, csv_text
from rpr_solver.notebook.figure import Figure, Pictured, draw, shown_as_svg
from rpr_solver.paths.loops import loop_in_range
from rpr_solver.paths.path import Path
from rpr_solver.transitions import Requirement
from rpr_solver.transitions.census import Census, census
from rpr_solver.transitions.check_report import CheckedInterval, CheckReport, check_counts
from rpr_solver.triangles import article_lengths

_BOXES = 30_000
"""Boxes of the proof of the margin."""


def examined(manipulator: Manipulator, goal: Goal) -> dict[str, Any] | None:
    """What a search needs of a geometry; None if it could not be decided.

    It is the census of all lengths, or the check of the requirement if there are joint limits; see
    :func:`document_of`.
    """
    try:
        return document_of(manipulator, goal)
    except SolverError:
        return None


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


@dataclass(frozen=True)
class Design(Pictured):
    """The best geometry that a search found, and what is proved of it.

    It is the best *found*: nothing says that there is no better one.

    Attributes:
        manipulator: the geometry from which the search began.
        asked: what was asked, as the contract has it.
        fixed_leg: the leg whose length varies over the range.
        outcome: the improvements, and how the search ended.
        value: what the best geometry is proved to reach, apart from the windows that the requirement
            ignores: the length of the longest admitted part, the largest number of cusps, or the margin; or
            its change.
        met: whether a part of the range is admitted (longest range), a slice has the least number of cusps
            (most cusps), or else whether the requirement is proved; and the constraints, if there are any.
        start: the census of the given geometry over the range.
        report: the check of the best geometry.
        census: its census over the range.
        margin: how far it may change, if it is met: of the requirement, of it within the longest part but
            for a tenth at each end, or of the number of cusps in the middle of its widest window.
        kept: what is proved of the constraints; None if there are none.

    >>> from rpr_solver import EXAMPLES, Requirement, design
    >>> wish = Requirement(start=21, stop=26, max_cusps=4)
    >>> found = design(EXAMPLES["innocenti"], "longest-range", wish, vary="10%", budget=5)
    >>> found.outcome.censuses, found.manipulator == EXAMPLES["innocenti"]
    (5, True)
    """

    manipulator: Manipulator
    asked: Mapping[str, Any]
    fixed_leg: int
    outcome: Outcome
    value: str
    met: bool
    start: Census
    report: CheckReport
    census: Census
    margin: Margin | None
    kept: Kept | None = None

    def __repr__(self) -> str:
        state = "met" if self.met else "not met"
        tried = counted(self.outcome.censuses, "candidate")
        return f"<Design {self.asked['objective']}: {self.value}, {state}, best found of {tried}>"

    @property
    def best(self) -> Manipulator:
        """The best geometry found."""
        return self.outcome.candidates[-1].manipulator

    def figure(self) -> Figure:
        """A picture of what the search reached, over its censuses, and of the numbers of cusps by length of
        the given geometry and of the best one.

        Raises:
            InputError: the lengths are too large to be drawn.
        """
        return draw(self.to_json())

    def _repr_svg_(self) -> str | None:
        return shown_as_svg(self)

    def to_json(self) -> dict[str, Any]:
        """The contract's design document."""
        leg, start = self.fixed_leg, self.outcome.candidates[0]
        return {
            **document_head(self.manipulator, MIN_DIGITS, leg),
            "asked": dict(self.asked),
            "start": {"value": _shown(start), "met": start.met, "census": self.start.to_json()},
            "best": {
                "geometry": self.best.to_json(),
                "value": self.value,
                "met": self.met,
                "change": _changes(self.manipulator, self.best),
                "census": self.census.to_json(),
                "check": self.report.to_json(),
                "margin": None if self.margin is None else self.margin.to_json(),
                **({} if self.kept is None else {"constraints": self.kept.to_json()}),
            },
            "trace": [trace_json(candidate) for candidate in self.outcome.candidates],
            "censuses": self.outcome.censuses,
            "stopped": self.outcome.stopped,
        }


def _changes(start: Manipulator, best: Manipulator) -> dict[str, str]:
    """How far each length changed, exact; rounded where it was irrational."""
    each = zip(LENGTHS, start.lengths, best.lengths, start.bounds(), best.bounds(), strict=True)
    return {
        name: exact_str(high[0] - low[0])
        if isinstance(x, Fraction) and isinstance(y, Fraction)
        else "0"
        if x == y
        else round_fraction(high[0] - low[0], MIN_DIGITS)
        for name, x, y, low, high in each
    }


def trace_json(candidate: Candidate) -> dict[str, Any]:
    """An improvement, as documents and events have it; its value is an estimate of the search."""
    return {
        "census": candidate.number,
        "value": _shown(candidate),
        "met": candidate.met,
        "geometry": candidate.manipulator.to_json(),
    }


def design_csv(document: Mapping[str, Any]) -> str:
    """The trace of a design document as CSV: a line for each improvement.

    >>> print(design_csv({"trace": [{"census": 1, "value": "0", "met": False, "geometry": {"a2x": "2"}}]}))
    census,value,met,a2x
    1,0,false,2
    <BLANKLINE>
    """
    rows = [
        {
            "census": one["census"],
            "value": one["value"],
            "met": str(one["met"]).lower(),
            **article_lengths(one["geometry"]),
        }
        for one in document["trace"]
    ]
    return csv_text(list(rows[0]), rows)


def _shown(candidate: Candidate) -> str:
    return f"{candidate.value:.10g}"


def design(
    manipulator: Manipulator,
    objective: str,
    requirement: Requirement | None = None,
    *,
    progress: Progress = silent,
    **options: Unpack[Options],
) -> Design:
    """Searches for a geometry with a longer range, a smaller change, a larger margin, or more cusps.

    Each candidate is examined by an exact census. An evolution strategy looks for regions of good geometries,
    and linear programmes on the sensitivities of the transitions improve the best ones, but not margins,
    which the strategy alone makes larger. The same question has the same answer, which is proved by a check,
    a census and a margin of its own. It is the best that was found, not proved to be the best that exists.

    Args:
        manipulator: the geometry from which the search begins.
        objective: ``"longest-range"``, the longest part of the requirement's range in which it holds;
            ``"least-change"``, the nearest geometry that satisfies it; ``"largest-margin"``, the one that
            satisfies it with the largest margin; or ``"most-cusps"``, the most cusps in a slice of the range.
        requirement: numbers of cusps, a range, and joint limits; may be omitted for the most cusps.
        progress: callback ``progress(done, total)``, in censuses. If it raises ``SearchStopped("deadline")``
            or ``SearchStopped("canceled")``, the answer is the best found in whole generations so far.
        options: ``vary``, how far lengths may change: ``"15%"``, or bounds by name, the others keeping their
            values; ``fixed``, names that keep their values; ``decimals`` of the lengths that vary, 4 unless
            given; ``min_height`` of both triangles, else a hundredth of their longest sides; ``family``, a
            tie between the lengths such as ``"isosceles-1"``; ``loop``, ``"required"`` or ``"excluded"`` in
            the range and within the joint limits; ``min_aspects`` and ``max_aspects`` of every slice of the
            range; ``budget`` in censuses; ``seed`` of the random numbers.

    Raises:
        InputError: naming the argument at fault.
        SolverError: the given geometry could not be decided, or the extra ``design`` is not installed.

    >>> from rpr_solver import EXAMPLES, design
    >>> found = design(EXAMPLES["fourteen-cusps"], "most-cusps", vary="1%", budget=2)
    >>> found.value, found.outcome.stopped
    ('14', 'budget')
    """
    wish = Requirement(min_cusps=0) if requirement is None and objective == MOST_CUSPS else requirement
    check_type(wish, Requirement, "requirement")
    assert wish is not None
    plan = Plan.of(manipulator, objective, wish, **options)
    done = 0

    def examine(asked: Sequence[Manipulator]) -> Documents:
        nonlocal done
        found = []
        for one in asked:
            found.append(examined(one, plan.goal))
            done += 1
            progress(done, plan.budget)
        return found

    return proved(manipulator, plan, searched(plan, examine))


def proved(manipulator: Manipulator, plan: Plan, outcome: Outcome) -> Design:
    """The answer of a search, with its proofs, which do not use what the search knew.

    Raises:
        SolverError: the best geometry could not be decided at the digits of a document.
    """
    goal, requirement = plan.goal, plan.goal.requirement
    best, leg = outcome.candidates[-1].manipulator, requirement.fixed_leg
    report = check_counts(best, requirement, digits=MIN_DIGITS)
    tables = {
        one: census(one, fixed_leg=leg, start=requirement.start, stop=requirement.stop, digits=MIN_DIGITS)
        for one in {manipulator, best}
    }
    given, table = tables[manipulator], tables[best]
    value, met, found = _reached(best, goal, report)
    if value is None:
        value = _shown(outcome.candidates[-1])
    kept = kept_constraints(goal.constraints, report, table) if goal.constraints else None
    met = met and (kept is None or kept.met)
    return Design(manipulator, plan.to_json(), leg, outcome, value, met, given, report, table, found, kept)


def kept_constraints(asked: Constraints, report: CheckReport, table: Census) -> Kept:
    """Proves constraints, or not.

    Args:
        asked: the constraints.
        report: the check of the geometry, over the range, within the joint limits.
        table: its census over the range.
    """
    loop = loop_in_range(report) if asked.loop == REQUIRED else None
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


def _reached(best: Manipulator, goal: Goal, report: CheckReport) -> tuple[str | None, bool, Margin | None]:
    """The proved value, if it is not the change, whether the wish is met, and the margin."""
    requirement, leg = goal.requirement, goal.requirement.fixed_leg
    if goal.objective == LONGEST_RANGE:
        part = _longest(report)
        if part is None:
            return "0", False, None
        inside = _inside(requirement, part, Fraction(1, 10))
        return exact_str(part[1] - part[0]), True, margin(best, requirement=inside, most_boxes=_BOXES)
    if goal.objective == MOST_CUSPS:
        most, widest = _most_cusps(best, requirement, report)
        met = most >= (requirement.min_cusps or 0)
        if widest is None:
            return str(most), met, None
        return str(most), met, margin(best, widest.example, fixed_leg=leg, most_boxes=_BOXES)
    if not report.passed:
        return None if goal.objective == LEAST_CHANGE else "0", False, None
    known = margin(best, requirement=requirement, most_boxes=_BOXES)
    is_margin = goal.objective == LARGEST_MARGIN
    return exact_str(known.proved or 0) if is_margin else None, True, known


def _most_cusps(
    best: Manipulator, requirement: Requirement, report: CheckReport
) -> tuple[int, CheckedInterval | None]:
    """The largest number of cusps that a window which is not ignored has in all of its slices, or more, and
    the widest interval with as many; 0 and None if every window is ignored."""
    numbers = sorted({x.count for x in report.intervals}, reverse=True)
    if not requirement.ignore_windows:
        return numbers[0], max(report.intervals, key=lambda x: (x.count, x.width))
    for most in numbers[:-1] if not numbers[-1] else numbers:
        fewer = {**requirement.to_json(), "max_cusps": most - 1, "min_cusps": None}
        found = check_counts(best, Requirement.from_json(fewer, max_digits=1 << 20), digits=MIN_DIGITS)
        if found.violations:
            return most, max(found.violations, key=lambda x: x.width)
    return 0, None


def _inside(requirement: Requirement, part: tuple[Fraction, Fraction], share: Fraction) -> Requirement:
    """The same requirement in a part of the range, without a share of it at each end."""
    start, stop = part
    less = (stop - start) * share
    inside = {"from": exact_str(start + less), "to": exact_str(stop - less)}
    return Requirement.from_json({**requirement.to_json(), "range": inside})


def _longest(report: CheckReport) -> tuple[Fraction, Fraction] | None:
    """The longest part of a range, which has two ends, in which the requirement is proved."""
    parts: list[tuple[Fraction, Fraction]] = []
    for x in report.intervals:
        if (x.is_ignored or report.requirement.admits(x.count)) and x.stop is not None:
            start, stop = Fraction(x.start), Fraction(x.stop)
            if parts and parts[-1][1] == start:
                parts[-1] = parts[-1][0], stop
            else:
                parts.append((start, stop))
    return max(parts, key=lambda part: part[1] - part[0], default=None)
