"""Requirements on the number of cusps over a range of lengths, passed or failed by proof.

A range of slices is cut at every transition, at its own ends, and, where the other legs have joint
limits, at every length at which a cusp stands on a limit (event_systems.limit_system). Between two
neighbouring cuts the number of cusps within the limits is constant, and one exact slice tells it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from itertools import groupby
from typing import Any

from rpr_solver.contract import CHECK_DIGITS, Progress, about_answer, silent
from rpr_solver.contract import MAX_DIGITS as MOST_DIGITS
from rpr_solver.errors import FieldProblem, InputError, SolverError
from rpr_solver.exact.precision import decided
from rpr_solver.exact.rationals import MAX_DIGITS, exact_str, parse_exact, shown
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.cusp_table import SliceTable, solve_slice
from rpr_solver.slices.eliminant import Eliminant
from rpr_solver.slices.joint_points import JointPoint, free_legs
from rpr_solver.transitions.census import length_text
from rpr_solver.transitions.event_systems import EventSystems, NotGeneric
from rpr_solver.transitions.event_types import Event
from rpr_solver.transitions.events import limit_events
from rpr_solver.transitions.length_range import range_problems
from rpr_solver.transitions.survey import survey

_FIELDS = ("fixed_leg", "range", "max_cusps", "min_cusps", "limits")

Bounds = tuple[Fraction | None, Fraction | None]


@dataclass(frozen=True)
class Requirement:
    """How many cusps the slices of a range may have, or must have, strictly within joint limits.

    Attributes:
        fixed_leg: the leg whose length runs over the range.
        start, stop: the range in the user's unit; 0 and None are its open ends.
        max_cusps: at most so many in every slice (0: cusp-free), or None.
        min_cusps: at least so many, or None. A single length at which cusps merge is no violation.
        limits: for each other leg its least and its greatest length, None where it has none.

    Raises:
        InputError: naming every field at fault.
    """

    fixed_leg: int = 1
    start: Fraction = Fraction(0)
    stop: Fraction | None = None
    max_cusps: int | None = None
    min_cusps: int | None = None
    limits: Mapping[int, Bounds] = field(default_factory=dict)

    def __post_init__(self) -> None:
        problems = list(self._problems())
        if problems:
            raise InputError(problems)

    @classmethod
    def from_json(cls, obj: Mapping[str, Any], *, max_digits: int = MAX_DIGITS) -> Requirement:
        """Read ``{"fixed_leg", "range": {"from", "to"}, "max_cusps", "min_cusps", "limits"}``.

        ``limits`` is ``{"l2": {"min", "max"}, "l3": …}``; every number is exact, every part optional.

        Raises:
            InputError: naming every field at fault.
        """
        if not isinstance(obj, Mapping):
            raise InputError.of("requirement", f"{shown(obj)} is not an object")
        unknown = [name for name in obj if name not in _FIELDS]
        if unknown:
            known = ", ".join(_FIELDS)
            raise InputError(
                [FieldProblem(f"requirement.{n}", f"unknown field; known are {known}") for n in unknown]
            )

        def number(value: Any, name: str) -> Fraction | None:
            return None if value is None else parse_exact(value, f"requirement.{name}", max_digits=max_digits)

        def part(source: Mapping[str, Any], name: str, keys: tuple[str, str]) -> Bounds:
            if not isinstance(source, Mapping) or any(key not in keys for key in source):
                raise InputError.of(
                    f"requirement.{name}", f'is {shown(source)}; give {{"{keys[0]}", "{keys[1]}"}}'
                )
            low, high = (number(source.get(key), f"{name}.{key}") for key in keys)
            return low, high

        def count(name: str) -> int | None:
            value = number(obj.get(name), name)
            if value is not None and value.denominator != 1:
                raise InputError.of(f"requirement.{name}", f"is {exact_str(value)}; give a whole number")
            return None if value is None else int(value)

        start, stop = part(obj.get("range") or {}, "range", ("from", "to"))
        raw = obj.get("limits") or {}
        if not isinstance(raw, Mapping) or any(key not in ("l1", "l2", "l3") for key in raw):
            raise InputError.of(
                "requirement.limits", f"is {shown(raw)}; its keys are the free legs, such as l2 and l3"
            )
        limits = {int(key[1]): part(value, f"limits.{key}", ("min", "max")) for key, value in raw.items()}
        leg = obj.get("fixed_leg", 1)
        return cls(leg, start or Fraction(0), stop, count("max_cusps"), count("min_cusps"), limits)

    def to_json(self) -> dict[str, object]:
        """The inverse of :meth:`from_json`, numbers in canonical text."""

        def text(x: Fraction | None) -> str | None:
            return None if x is None else exact_str(x)

        return {
            "fixed_leg": self.fixed_leg,
            "range": {"from": exact_str(self.start), "to": text(self.stop)},
            "max_cusps": self.max_cusps,
            "min_cusps": self.min_cusps,
            "limits": {
                f"l{leg}": {"min": text(low), "max": text(high)}
                for leg, (low, high) in sorted(self.limits.items())
            },
        }

    def admits(self, count: int) -> bool:
        """Whether a slice may have so many cusps within the limits."""
        return (self.max_cusps is None or count <= self.max_cusps) and (
            self.min_cusps is None or count >= self.min_cusps
        )

    def _problems(self) -> Iterator[FieldProblem]:
        if isinstance(self.fixed_leg, bool) or self.fixed_leg not in (1, 2, 3):
            yield FieldProblem(
                "requirement.fixed_leg", f"{shown(self.fixed_leg)} is not a leg; give 1, 2 or 3"
            )
            return
        yield from range_problems(self.start, self.stop, "requirement.range")
        if self.max_cusps is None and self.min_cusps is None:
            yield FieldProblem("requirement.max_cusps", "is missing; give max_cusps or min_cusps")
        for name, value in (("max_cusps", self.max_cusps), ("min_cusps", self.min_cusps)):
            if value is not None and value < 0:
                yield FieldProblem(f"requirement.{name}", f"is {value}; a number of cusps is at least 0")
        for leg, (low, high) in self.limits.items():
            if leg == self.fixed_leg:
                yield FieldProblem(f"requirement.limits.l{leg}", "is the fixed leg; its limits are the range")
            for end, bound in (("min", low), ("max", high)):
                if bound is not None and bound < 0:
                    yield FieldProblem(
                        f"requirement.limits.l{leg}.{end}", f"is {exact_str(bound)}; a length is at least 0"
                    )
            if low is not None and high is not None and high <= low:
                yield FieldProblem(
                    f"requirement.limits.l{leg}.max", f"is {exact_str(high)}; it must exceed {exact_str(low)}"
                )


@dataclass(frozen=True)
class CheckedInterval:
    """Lengths between two cuts, all with one number of cusps within the limits, and a slice among them."""

    start: str
    stop: str | None
    count: int
    example: Fraction
    cusps: tuple[JointPoint, ...]


@dataclass(frozen=True)
class CheckReport:
    """The proof that a requirement holds, or where it does not."""

    manipulator: Manipulator
    requirement: Requirement
    digits: int
    intervals: tuple[CheckedInterval, ...]

    @property
    def violations(self) -> tuple[CheckedInterval, ...]:
        """The intervals that the requirement does not admit, ascending."""
        return tuple(x for x in self.intervals if not self.requirement.admits(x.count))

    @property
    def passed(self) -> bool:
        """Whether every slice of the range is admitted."""
        return not self.violations

    def to_json(self) -> dict[str, object]:
        """A plain document; lengths are decimals of ``digits`` digits."""
        leg = self.requirement.fixed_leg
        counts = [x.count for x in self.intervals]
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
                    "example": {f"l{leg}": exact_str(x.example), "cusps": [c.to_json(leg) for c in x.cusps]},
                }
                for x in self.violations
            ],
            **about_answer(self.digits),
        }


def check(
    manipulator: Manipulator,
    requirement: Requirement,
    *,
    digits: int = CHECK_DIGITS,
    progress: Progress | None = None,
) -> CheckReport:
    """Prove or refute a requirement.

    Raises:
        InputError: ``digits`` is out of range.
        SolverError: a cut could not be decided, or joint limits are asked of a degenerate geometry
            whose cusps this version cannot follow.
    """
    low, high = requirement.start, requirement.stop
    found = survey(
        manipulator,
        requirement.fixed_leg,
        progress or silent,
        start=low,
        stop=high,
        digits=digits,
        more=partial(_limit_cuts, requirement),
    )
    limited = any(bound for bounds in requirement.limits.values() for bound in bounds)
    if limited and found.method == "discriminant" and any(table.count for table in found.slices):
        raise SolverError("joint limits are not supported for this degenerate geometry")
    slice_map = found.eliminant.slice_map
    cuts = [length_text(slice_map, group, digits) for group in found.groups]
    ends = [exact_str(low), *cuts, None if high is None else exact_str(high)]
    intervals = []
    for start, stop, table in zip(ends, ends[1:], found.slices, strict=False):
        cusps = _within(found.eliminant, table, requirement)
        intervals.append(CheckedInterval(str(start), stop, len(cusps), table.length, cusps))
    return CheckReport(manipulator, requirement, digits, tuple(_merged(intervals)))


def _limit_cuts(
    requirement: Requirement, slice_map: SliceMap, systems: EventSystems | None
) -> Iterator[Event]:
    if systems is None:
        return
    for leg, bounds in requirement.limits.items():
        for bound in filter(None, bounds):
            seen = (slice_map.f, slice_map.g)[free_legs(requirement.fixed_leg).index(leg)]
            try:
                yield from limit_events(systems, seen, (bound * slice_map.scale) ** 2)
            except NotGeneric:
                raise SolverError(
                    f"l{leg} = {exact_str(bound)} is no isolated limit: cusps keep that length over a range"
                ) from None


def _within(eliminant: Eliminant, table: SliceTable, requirement: Requirement) -> tuple[JointPoint, ...]:
    """The cusps of a slice strictly within the limits; none of them stands on one."""
    first, second = free_legs(requirement.fixed_leg)

    def within(digits: int) -> tuple[JointPoint, ...] | None:
        cusps = (table if digits == table.digits else solve_slice(eliminant, table.length, digits)).cusps
        sides = [
            [_side(text, requirement.limits.get(leg, (None, None)), digits) for leg, text in legs]
            for legs in ([(first, c.first), (second, c.second)] for c in cusps)
        ]
        if any(None in side for side in sides):
            return None
        return tuple(c for c, side in zip(table.cusps, sides, strict=True) if all(side))

    message = f"the cusps of the slice {exact_str(table.length)} could not be told from the joint limits"
    return decided(within, table.digits, MOST_DIGITS, message)


def _side(text: str, bounds: Bounds, digits: int) -> bool | None:
    """Whether a rounded length lies within, or None if its digits do not tell."""
    x = Fraction(text)
    doubt = x / 10 ** (digits - 1)
    low, high = bounds
    if any(b is not None and abs(x - b) <= doubt for b in bounds):
        return None
    return (low is None or x > low) and (high is None or x < high)


def _merged(intervals: list[CheckedInterval]) -> Iterator[CheckedInterval]:
    """Neighbours of equal count joined: a cut that changes nothing is not shown."""
    for _, same in groupby(intervals, key=lambda x: x.count):
        run = list(same)
        yield CheckedInterval(run[0].start, run[-1].stop, run[0].count, run[0].example, run[0].cusps)


def _span(x: CheckedInterval) -> dict[str, object]:
    return {"from": x.start, "to": x.stop, "count": x.count}
