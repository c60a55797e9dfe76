"""Checks of requirements: passed or failed by proof.

A range of slices is cut at every transition and, if the other legs have joint limits, at every length at
which a cusp reaches a limit (event_systems.limit_system). Between two neighbouring cuts the number of cusps
within the limits is constant, and one exact slice gives it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import groupby
from math import inf
from typing import Any

from rpr_solver.contract import (
    CHECK_DIGITS,
    MAX_DIGITS,
    Progress,
    about_answer,
    check_digits,
    check_type,
    silent,
)
from rpr_solver.errors import SolverError
from rpr_solver.exact import decided
from rpr_solver.exact.numerals import double, fraction
from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.model.joint_points import JointPoint, free_legs
from rpr_solver.model.lengths import Bounds
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import Row, counted, degenerate_words, html_table, shortened, with_floats
from rpr_solver.slices import Eliminant
from rpr_solver.slices.cusp_table import solve_slice
from rpr_solver.slices.slice_table import SliceTable
from rpr_solver.transitions.degeneracies import Degeneracy, degeneracies
from rpr_solver.transitions.event_systems import Event, NotGeneric, length_text
from rpr_solver.transitions.requirement import REFUSED, REQUIRED, Requirement
from rpr_solver.transitions.shared_joints import shared_degeneracies
from rpr_solver.transitions.survey import LimitEvents, survey
from rpr_solver.transitions.windows import IgnoredWindow, Part, narrow_windows


@dataclass(frozen=True)
class CheckedInterval:
    """An interval of lengths whose slices all have one number of cusps within the limits.

    Attributes:
        start, stop: its ends in the user's unit: exact texts for the ends of the range, else correctly
            rounded decimals; None is an open end.
        count: the number of cusps within the limits in each of its slices.
        example: the length of one of its slices, exact, in the user's unit.
        cusps: the cusps of that slice within the limits.
        is_ignored: whether it is part of a window that is ignored.

    >>> CheckedInterval("31.8632047694475", "31.8635738939382", 8, Fraction("31.8633"), cusps=())
    <CheckedInterval 31.863204… to 31.863573…: 8 cusps>
    """

    start: str
    stop: str | None
    count: int
    example: Fraction
    cusps: tuple[JointPoint, ...]
    is_ignored: bool = False

    def __repr__(self) -> str:
        ends = f"{shortened(self.start)} to {'∞' if self.stop is None else shortened(self.stop)}"
        return f"<CheckedInterval {ends}: {counted(self.count, 'cusp')}>"

    @property
    def width(self) -> float:
        """How long it is, infinite for an open end."""
        return inf if self.stop is None else double(fraction(self.stop) - fraction(self.start))


@dataclass(frozen=True)
class CheckReport:
    """Whether a requirement holds, and the intervals in which it does not.

    Proved: the number of cusps in every interval, what is degenerate, and so whether the requirement holds.
    A report is true if it does: ``assert check(manipulator, requirement)``.

    Attributes:
        manipulator: the geometry.
        requirement: the requirement.
        digits: significant digits of lengths and cusps.
        intervals: the intervals of constant number of cusps within the limits; ascending, they fill the
        range.
        degenerate: what is degenerate in every slice of an interval, or along a whole curve of one slice,
            within the joint limits or not.
        mode_change: whether the assembly mode can change, as the members of a document; None unless asked.
        ignored_windows: the windows that the requirement ignores, since they are narrow.

    >>> from rpr_solver import EXAMPLES, Requirement, check
    >>> check(EXAMPLES["zein-flat"], Requirement(start=30, stop=40, max_cusps=6), digits=15)
    <CheckReport L1 from 30 to 40: failed in 2 intervals of 6>
    >>> check(EXAMPLES["zein-flat"], Requirement(start=30, stop=33, max_cusps=6, ignore_windows="0.001"))
    <CheckReport L1 from 30 to 33: passed of 3, 1 window ignored>
    """

    manipulator: Manipulator
    requirement: Requirement
    digits: int
    intervals: tuple[CheckedInterval, ...]
    degenerate: tuple[Degeneracy, ...] = ()
    mode_change: Mapping[str, Any] | None = None
    ignored_windows: tuple[IgnoredWindow, ...] = ()

    def __repr__(self) -> str:
        bad, of = len(self.violations), len(self.intervals)
        verdict = f"failed in {counted(bad, 'interval')} of {of}" if bad else f"passed of {of}"
        if self.ignored_windows:
            verdict += f", {counted(len(self.ignored_windows), 'window')} ignored"
        if self.degenerate:
            verdict += f", degenerate: {self.requirement.degenerate}"
        leg, span = self.requirement.fixed_leg, self.requirement.range
        return f"<CheckReport L{leg} {span}: {verdict}>"

    def __bool__(self) -> bool:
        return self.passed

    @property
    def violations(self) -> tuple[CheckedInterval, ...]:
        """The intervals whose numbers of cusps violate the requirement, ascending, but for ignored ones."""
        return tuple(x for x in self.intervals if not x.is_ignored and not self.requirement.admits(x.count))

    @property
    def passed(self) -> bool:
        """Whether every slice of the range satisfies the requirement, apart from ignored windows."""
        refused = bool(self.degenerate) and self.requirement.degenerate == REFUSED
        return not self.violations and not refused and self._keeps_mode

    @property
    def _keeps_mode(self) -> bool:
        """Whether the assembly mode can change if that is required, and cannot if it is excluded."""
        if self.mode_change is None:
            return True
        wanted = "possible" if self.requirement.mode_change == REQUIRED else "impossible"
        return bool(self.mode_change["change"] == wanted)

    def to_json(self) -> dict[str, Any]:
        """The contract's check document; lengths are decimals of ``digits`` digits."""
        leg = self.requirement.fixed_leg
        counts = [x.count for x in self.intervals if not x.is_ignored] or [x.count for x in self.intervals]
        narrow = {"ignored_windows": [window.to_json() for window in self.ignored_windows]}
        return {
            **self.manipulator.identity_json(),
            "requirement": self.requirement.to_json(),
            "passed": self.passed,
            "max_cusps_found": max(counts),
            "min_cusps_found": min(counts),
            "intervals": [_span(x) for x in self.intervals],
            "violations": [
                {
                    **_span(x),
                    "example": {f"l{leg}": exact_str(x.example), "cusps": [c.to_json() for c in x.cusps]},
                }
                for x in self.violations
            ],
            **(narrow if self.requirement.ignore_windows else {}),
            "degenerate": [part.to_json() for part in self.degenerate],
            **({} if self.mode_change is None else {"mode_change": dict(self.mode_change)}),
            **about_answer(self.digits),
        }

    def rows(self) -> list[Row]:
        """A row for each interval, with ``admitted``, for ``pandas.DataFrame(report.rows())``.

        Ends are floats, infinite for an open end; ``from_text`` and ``to_text`` have all digits.
        """
        return with_floats(self._records())

    def _records(self) -> list[dict[str, object]]:
        narrow = bool(self.requirement.ignore_windows)
        return [
            {
                **_span(x),
                "admitted": self.requirement.admits(x.count),
                **({"ignored": x.is_ignored} if narrow else {}),
            }
            for x in self.intervals
        ]

    def _repr_html_(self) -> str:
        degenerate = (
            degenerate_words(part.to_json(), self.requirement.fixed_leg) for part in self.degenerate
        )
        notes = repr(self.requirement), *(repr(x)[1:-1] for x in self.ignored_windows), *degenerate
        return html_table(repr(self)[1:-1], self._records(), notes, first=self.manipulator.remark)


def check_counts(
    manipulator: Manipulator,
    requirement: Requirement,
    *,
    digits: int = CHECK_DIGITS,
    progress: Progress | None = None,
) -> CheckReport:
    """The numbers of cusps that :func:`rpr_solver.check` proves, without changes of assembly mode.

    The range is cut at every transition, and at every length at which a cusp reaches a joint limit; one exact
    slice between two neighbouring cuts gives the number of cusps of all slices there. Arguments and errors
    are those of that function.
    """
    check_type(requirement, Requirement, "requirement")
    check_type(manipulator, Manipulator, "manipulator")
    digits = check_digits(digits)
    if manipulator.geometry.shared_joints:
        return _without_cusps(manipulator, requirement, digits)
    low, high = requirement.start, requirement.stop
    result = survey(
        manipulator,
        requirement.fixed_leg,
        progress or silent,
        start=low,
        stop=high,
        digits=digits,
        extra_events=partial(_limit_cuts, requirement),
    )
    slice_map = result.eliminant.slice_map
    cuts = [length_text(slice_map, group, digits) for group in result.groups]
    texts = [exact_str(low), *cuts, exact_or_none(high)]
    intervals = []
    for start, stop, part in zip(texts, texts[1:], result.tables, strict=False):
        cusps = _within(result.eliminant, part, requirement)
        intervals.append(CheckedInterval(str(start), stop, len(cusps), part.length, cusps))
    degenerate = degeneracies(result, requirement.range, digits)
    return _report(manipulator, requirement, digits, slice_map, result.groups, intervals, degenerate)


def _report(
    manipulator: Manipulator,
    requirement: Requirement,
    digits: int,
    slice_map: SliceMap,
    groups: Sequence[Sequence[Event]],
    intervals: Sequence[CheckedInterval],
    degenerate: tuple[Degeneracy, ...],
) -> CheckReport:
    """The report of intervals, which end at the groups of events."""
    ends = [requirement.start, *groups, requirement.stop]
    parts = [
        Part(start, stop, (x.start, x.stop), x.count)
        for start, stop, x in zip(ends, ends[1:], intervals, strict=False)
    ]
    narrow, windows = set[int](), []
    for run, window in narrow_windows(slice_map, parts, requirement.admits, requirement.ignore_windows):
        if window is not None:
            windows.append(window)
            narrow |= set(map(id, run))
    marked = [replace(x, is_ignored=id(part) in narrow) for x, part in zip(intervals, parts, strict=True)]
    merged = tuple(_merged(marked))
    return CheckReport(manipulator, requirement, digits, merged, degenerate, ignored_windows=tuple(windows))


def _without_cusps(manipulator: Manipulator, requirement: Requirement, digits: int) -> CheckReport:
    """The report where legs share joints (mathematics.md#shared-joints)."""
    low, high = requirement.start, requirement.stop
    example = (low + (2 * low + 1 if high is None else high)) / 2
    whole = CheckedInterval(exact_str(low), exact_or_none(high), 0, example, ())
    slice_map = SliceMap.of(manipulator, requirement.fixed_leg, with_shared=True)
    degenerate = shared_degeneracies(slice_map, requirement.range, digits)
    return _report(manipulator, requirement, digits, slice_map, (), (whole,), degenerate)


def _limit_cuts(requirement: Requirement, slice_map: SliceMap, events: LimitEvents) -> Iterator[Event]:
    for leg, bounds in requirement.limits.items():
        for bound in filter(None, bounds):
            seen = (slice_map.f, slice_map.g)[free_legs(requirement.fixed_leg).index(leg)]
            try:
                yield from events(seen, (bound * slice_map.scale) ** 2)
            except NotGeneric:
                raise SolverError(
                    f"l{leg} = {exact_str(bound)} is no isolated limit: cusps keep that length over a range"
                ) from None


def _within(eliminant: Eliminant, table: SliceTable, requirement: Requirement) -> tuple[JointPoint, ...]:
    """The cusps of a slice strictly within the limits; no cusp of the slice is at a limit."""
    legs = free_legs(requirement.fixed_leg)

    def within(digits: int) -> tuple[JointPoint, ...] | None:
        cusps = (table if digits == table.digits else solve_slice(eliminant, table.length, digits)).cusps
        sides = [
            [
                _side(text, requirement.limits.get(leg, (None, None)), digits)
                for leg, text in zip(legs, cusp.coordinates[2:], strict=True)
            ]
            for cusp in cusps
        ]
        if any(None in side for side in sides):
            return None
        return tuple(c for c, side in zip(table.cusps, sides, strict=True) if all(side))

    message = f"the cusps of the slice {exact_str(table.length)} could not be told from the joint limits"
    return decided(within, table.digits, MAX_DIGITS, message)


def _side(text: str, bounds: Bounds, digits: int) -> bool | None:
    """Whether a rounded length lies within the bounds, or None if its digits are insufficient."""
    x = Fraction(text)
    doubt = x / 10 ** (digits - 1)
    low, high = bounds
    if any(b is not None and abs(x - b) <= doubt for b in bounds):
        return None
    return (low is None or x > low) and (high is None or x < high)


def _merged(intervals: list[CheckedInterval]) -> Iterator[CheckedInterval]:
    """The intervals with neighbours of equal count merged."""
    for _, same in groupby(intervals, key=lambda x: x.count):
        run = list(same)
        yield replace(run[0], stop=run[-1].stop)


def _span(x: CheckedInterval) -> dict[str, object]:
    return {"from": x.start, "to": x.stop, "count": x.count}
