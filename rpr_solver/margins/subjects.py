"""What a margin is asked for: the count of a slice, a requirement, or a window; and geometries without it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import ceil, floor, inf, log10
from typing import Any, NamedTuple, Protocol

from rpr_solver.contract import LENGTHS, MIN_DIGITS
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.decimals import rounded_near, rounded_up
from rpr_solver.exact.numerals import double, fraction
from rpr_solver.margins.bands import Bands, Span, transitions_of, zones_of
from rpr_solver.margins.estimates import (
    Estimate,
    Mover,
    breaking,
    closing,
    movers,
    nearest,
    widening,
    within,
)
from rpr_solver.margins.options import degenerate_throughout
from rpr_solver.margins.problems import GeometryBox, Problem
from rpr_solver.margins.zones import Zones
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.manipulator import Length, Manipulator
from rpr_solver.slices.cusp_table import cusp_table
from rpr_solver.slices.slice_table import SliceTable
from rpr_solver.transitions import Requirement
from rpr_solver.transitions.census import Census, bare_census
from rpr_solver.transitions.check_report import CheckReport, check_counts
from rpr_solver.transitions.requirement import REFUSED

_DIGITS = 30
_SAME = Fraction(1, 10**25)
"""Printed lengths with a smaller relative difference belong to one transition."""
_AT_A_LIMIT = "a cusp passes a joint limit within the range, where no radius can be proved"
_BEYOND = "that nothing is degenerate beyond the joint limits is not proved for other geometries"
_PARTS = 3
"""Parts of a range, at whose ends degenerate poses are sought."""
_CHECKS = 2
"""Near geometries that are checked, which takes far longer than to count the cusps of a slice."""
_FACTORS = ("1.001", "1.004", "1.016", "1.064", "1.256", "2")
_RADIUS_DIGITS = 4
_PRECISIONS = (4, 7, 10)
"""Digits of radii: the count may differ only just beyond, until a second transition passes."""
_BISECTIONS = 6
_CLOSE = Fraction(21, 20)
"""Two radii are near enough to each other to end a search."""
_FINER = 1000
"""An irrational length is rounded, when it is moved, by less than this part of the way."""


class Found(NamedTuple):
    """A length of the fixed leg, exact, and its number of cusps; None if no single length shows it."""

    length: Fraction | None
    cusps: int | None


class _Inside(NamedTuple):
    """Transitions in and near a range, numbers of cusps between, and why these are not enough for a proof."""

    transitions: Sequence[Mapping[str, Any]]
    counts: Sequence[int]
    obstacle: str | None = None


Task = tuple[Problem, Zones | None]
"""A box to be excluded, and where in it degenerate cusps are known."""


class Subject(Protocol):
    """A property of a manipulator that neighbouring ones should have too."""

    def flaw(self) -> str | None:
        """Why the property holds in no neighbourhood; None if nothing of the kind is known."""

    def count(self) -> int | None:
        """The number of cusps, if the property is one of them."""

    def estimate(self, weights: Sequence[Fraction]) -> Estimate | None:
        """The nearest geometry without the property, to first order; None if there is none."""

    def nearest(self, _weights: Sequence[Fraction], /) -> list[Estimate]:
        """Near geometries with a degenerate pose that may matter, in floats."""
        return []

    def obstacle(self) -> str | None:
        """Why no radius can be proved, although there may be one; None if nothing of the kind is known."""
        return None

    def problems(self, radius: Fraction, weights: Sequence[Fraction]) -> list[Task] | None:
        """Boxes whose exclusion proves the property for all geometries within a radius; None if none do."""

    def stricter(self) -> Subject | None:
        """A property that implies this one, and may be proved more easily; None if none is known."""
        return None

    def broken(self, manipulator: Manipulator) -> Found | None:
        """A length at which the property does not hold for a manipulator, exactly, and the count there."""


@dataclass(frozen=True)
class SliceCount(Subject):
    """The number of cusps of the slice of one length."""

    manipulator: Manipulator
    fixed_leg: int
    length: Fraction

    @cached_property
    def _table(self) -> SliceTable:
        return self._slice(self.manipulator)

    def _slice(self, manipulator: Manipulator) -> SliceTable:
        [table] = cusp_table(manipulator, self.length, digits=MIN_DIGITS, fixed_leg=self.fixed_leg)
        return table

    def flaw(self) -> str | None:
        """A degenerate pose, which the least change may resolve."""
        kinds = {point["kind"] for point in self._table.degenerate_points}
        return f"the slice has degenerate poses ({', '.join(sorted(kinds))})" if kinds else None

    def count(self) -> int:
        """The number of cusps."""
        return self._table.count

    def estimate(self, weights: Sequence[Fraction]) -> Estimate | None:
        """The nearest transition passes the length."""
        place = double(self.length)
        found = movers(_all_lengths(self.manipulator, self.fixed_leg))
        return breaking([(place, place, self.count())], found, self.count().__eq__, weights)

    def nearest(self, weights: Sequence[Fraction]) -> list[Estimate]:
        """Those of the slice."""
        return nearest(self.manipulator, self.fixed_leg, [self.length], weights)

    def problems(self, radius: Fraction, weights: Sequence[Fraction]) -> list[Task]:
        """One box, with one length."""
        return [(GeometryBox(self.manipulator, self.fixed_leg, radius, weights).at(self.length), None)]

    def broken(self, manipulator: Manipulator) -> Found | None:
        """The length and another number of cusps."""
        count = self._slice(manipulator).count
        return None if count == self.count() else Found(self.length, count)


@dataclass(frozen=True)
class RequirementHolds(Subject):
    """A requirement on the numbers of cusps in a range.

    Windows that are ignored may have other numbers. A geometry's windows lie where not all geometries have
    admitted numbers; if each stretch of such lengths is narrower than what is ignored, so are they.
    """

    manipulator: Manipulator
    requirement: Requirement

    @cached_property
    def _report(self) -> CheckReport:
        return check_counts(self.manipulator, self.requirement)

    def flaw(self) -> str | None:
        """A violation, or what is degenerate throughout the range."""
        if not self._report.passed:
            return "the manipulator does not satisfy the requirement"
        return degenerate_throughout(part.kind for part in self._report.degenerate)

    def count(self) -> int | None:
        """The number of cusps, if it is the same in the whole range."""
        counts = {interval.count for interval in self._report.intervals}
        return counts.pop() if len(counts) == 1 else None

    def stricter(self) -> Subject | None:
        """The same with no window ignored, if the range has one number of cusps."""
        asked = self.requirement
        if not asked.ignore_windows or self.count() is None:
            return None
        return replace(self, requirement=asked.ignoring(Fraction(0)))

    def estimate(self, weights: Sequence[Fraction]) -> Estimate | None:
        """The nearest transition that brings a number which is not admitted into the range, or those that
        make a window too wide to be ignored."""
        asked = self.requirement
        if asked.ignore_windows:
            table = _all_lengths(self.manipulator, asked.fixed_leg)
            ends = double(asked.start), inf if asked.stop is None else double(asked.stop)
            least = double(asked.ignore_windows)
            # which cusps are within limits is known of the range alone
            return None if asked.limits else widening(table, ends, asked.admits, least, weights)
        intervals = [
            (double(fraction(x.start)), inf if x.stop is None else double(fraction(x.stop)), x.count)
            for x in self._report.intervals
        ]
        found = movers(_all_lengths(self.manipulator, self.requirement.fixed_leg), self.requirement.limits)
        return breaking(intervals, found, self.requirement.admits, weights)

    def nearest(self, weights: Sequence[Fraction]) -> list[Estimate]:
        """Those of some slices of the range, if all of it has one number of cusps, and must have."""
        if self.count() is None or self.requirement.ignore_windows:
            return []
        asked, free = self.requirement, free_legs(self.requirement.fixed_leg)
        start, stop = asked.start, asked.stop
        parts = [] if stop is None else [start + (stop - start) * Fraction(k, _PARTS) for k in range(_PARTS)]
        limits = [(free.index(leg), x) for leg, both in asked.limits.items() for x in both if x is not None]
        lengths = [*parts, start if stop is None else stop]
        return nearest(self.manipulator, asked.fixed_leg, lengths, weights, limits)[:_CHECKS]

    @cached_property
    def _inside(self) -> _Inside | None:
        """The transitions in and near the range; None if it is to have one number of cusps."""
        asked = self.requirement
        if self.count() is not None and not asked.ignore_windows:
            return None
        whole = _all_lengths(self.manipulator, asked.fixed_leg).to_json()
        if not asked.limits:
            return _Inside(whole["transitions"], [interval["count"] for interval in whole["intervals"]])
        return _inside_limits(
            asked, whole["transitions"], check_counts(self.manipulator, asked, digits=_DIGITS)
        )

    def obstacle(self) -> str | None:
        """A cusp that passes a joint limit within the range, or degenerate poses beyond the limits."""
        if self.requirement.limits and self.requirement.degenerate == REFUSED:
            return _BEYOND
        return None if self._inside is None else self._inside.obstacle

    def problems(self, radius: Fraction, weights: Sequence[Fraction]) -> list[Task] | None:
        """The range, in one or two boxes; None if the transitions in it may bring a forbidden number."""
        asked = self.requirement
        box = GeometryBox(self.manipulator, asked.fixed_leg, radius, weights)
        boxes = box.over(asked.start, asked.stop, asked.limits)
        if self._inside is None:
            return [(problem, None) for problem in boxes]
        span = Span(asked.start, asked.stop)
        transitions = transitions_of(self._inside.transitions, box, span)
        if any(one.span.meets(span) and not one.is_whole for one in transitions):
            return None
        bands = Bands(span, transitions, (), self._inside.counts)
        if not all(
            width is not None and width < asked.ignore_windows for width in bands.windows(asked.admits)
        ):
            return None
        return [(problem, zones_of(problem, box, transitions)) for problem in boxes]

    def broken(self, manipulator: Manipulator) -> Found | None:
        """A length of the range and its number of cusps."""
        report = check_counts(manipulator, self.requirement, digits=MIN_DIGITS)
        return next((Found(x.example, x.count) for x in report.violations), None)


@dataclass(frozen=True)
class WindowExists(Subject):
    """That slices with a number of cusps exist near a length: an interval between two transitions."""

    manipulator: Manipulator
    fixed_leg: int
    length: Fraction

    @cached_property
    def _place(self) -> tuple[int, Census]:
        """The interval of the length: the number of transitions below it."""
        table = _all_lengths(self.manipulator, self.fixed_leg)
        return sum(Fraction(transition.length) <= self.length for transition in table.transitions), table

    @cached_property
    def _ends(self) -> tuple[Mover | None, Mover | None]:
        place, table = self._place
        found = movers(table)

        def end(k: int) -> Mover | None:
            if not 0 <= k < len(table.transitions):
                return None
            length = double(fraction(table.transitions[k].length))
            return next((mover for mover in found if mover.length == length), None)

        return end(place - 1), end(place)

    def flaw(self) -> str | None:
        """A degenerate pose in all slices."""
        place, table = self._place
        if reason := degenerate_throughout(part.kind for part in table.degenerate):
            return reason
        bare = [k for k, end in zip((place - 1, place), self._ends, strict=True) if end is None]
        if any(0 <= k < len(table.transitions) for k in bare):
            return "an end of the window is no simple transition, which any change may resolve"
        return None

    def count(self) -> int:
        """The number of cusps in the window."""
        place, table = self._place
        return table.counts[place]

    def estimate(self, weights: Sequence[Fraction]) -> Estimate | None:
        """The ends meet."""
        lower, upper = self._ends
        return None if lower is None or upper is None else closing(lower, upper, weights)

    @cached_property
    def _path(self) -> tuple[Fraction, tuple[Fraction, ...]]:
        """The length of a slice that moves as the middle of the window does, and the rates, nearly."""
        ends = [end for end in self._ends if end is not None]
        length = self.length
        if len(ends) == 2:
            length = (Fraction(ends[0].length) + Fraction(ends[1].length)) / 2
        rates = [sum(slopes) / len(ends) for slopes in zip(*(end.slopes for end in ends), strict=True)]
        return rounded_near(length, 15), tuple(Fraction(f"{rate:.6g}") for rate in rates)

    def problems(self, radius: Fraction, weights: Sequence[Fraction]) -> list[Task]:
        """One slice, whose length moves with the geometry as the middle of the window does."""
        length, rates = self._path
        box = GeometryBox(self.manipulator, self.fixed_leg, radius, weights)
        drift = tuple(map(float, rates)) or (0.0,) * len(LENGTHS)
        return [(replace(box.at(length), drift=drift), None)]

    def broken(self, manipulator: Manipulator) -> Found | None:
        """Nothing but the fact: no length has the number of cusps."""
        return None if self.count() in _all_lengths(manipulator, self.fixed_leg).counts else Found(None, None)


def _inside_limits(asked: Requirement, listed: Sequence[Mapping[str, Any]], report: CheckReport) -> _Inside:
    """The transitions of a range with a pose within joint limits, and the numbers of cusps within them."""
    name = f"l{asked.fixed_leg}"
    kept = [one for one in listed if Fraction(one[name]) in asked.range]
    kept = [one for one in kept if any(within(pose, asked.limits) for pose in one["events"])]
    lengths = [Fraction(one[name]) for one in kept]
    starts = [Fraction(interval.start) for interval in report.intervals]
    for cut in starts[1:]:
        if all(abs(cut - length) > cut * _SAME for length in lengths):
            return _Inside([], [], f"{_AT_A_LIMIT} (at {name.upper()} = {double(cut):.6g})")
    ends = [asked.start, *lengths, 2 * max(lengths) if asked.stop is None else asked.stop]
    places = (sum(start < (a + b) / 2 for start in starts) for a, b in pairwise(ends))
    return _Inside(kept, [report.intervals[place - 1].count for place in places])


def _all_lengths(manipulator: Manipulator, fixed_leg: int) -> Census:
    return bare_census(manipulator, fixed_leg, _DIGITS)


@dataclass(frozen=True)
class Counterexample:
    """A geometry, exact, in few decimals, that does not have the property.

    Attributes:
        radius: max |δ_j|/w_j of its difference from the given geometry; a little more where that is
            irrational.
        manipulator: the geometry.
        found: where it fails: ``length`` of the fixed leg and number of ``cusps`` there; None for a window,
            where no length has the number.

    >>> from rpr_solver import EXAMPLES, margin
    >>> example = margin(EXAMPLES["innocenti"], "28.1", tolerance="0.0007").counterexample
    >>> example.manipulator.d1, example.found.cusps
    (Fraction(170407, 10000), 8)
    """

    radius: Fraction
    manipulator: Manipulator
    found: Found


def _moved(length: Length, bounds: tuple[Fraction, Fraction], change: Fraction) -> Length:
    """A length and a change; of an irrational one a rational number, nearer to it by a small part of that."""
    if isinstance(length, Fraction):
        return length + change
    if not change:
        return length
    step = Fraction(10) ** -ceil(log10(_FINER / abs(change)))
    low, high = bounds
    return ceil((high + change) / step) * step if change < 0 else floor((low + change) / step) * step


@dataclass(frozen=True)
class Ray:
    """Geometries on the ray of an estimate."""

    subject: Subject
    manipulator: Manipulator
    weights: tuple[Fraction, ...]
    estimate: Estimate
    validity: Fraction | None

    def at(self, radius: Fraction) -> Manipulator:
        """The geometry at a radius."""
        m = self.manipulator
        steps = zip(LENGTHS, m.lengths, m.bounds(), self.weights, self.estimate.change, strict=True)
        moved = {g: _moved(x, bounds, radius * w * int(sign)) for g, x, bounds, w, sign in steps}
        return Manipulator(**{**m.to_dict(), **moved})

    def shows(self, radius: Fraction) -> Counterexample | None:
        """The counter-example at a radius, if it is one; None as well if it has no answer."""
        if radius <= 0 or (self.validity is not None and radius >= self.validity):
            return None
        try:
            manipulator = self.at(radius)
            found = self.subject.broken(manipulator)
        except (InputError, SolverError):
            return None
        return None if found is None else Counterexample(radius, manipulator, found)

    def beyond(self) -> Counterexample | None:
        """A counter-example just beyond the radius, that of a degenerate geometry."""
        radii = {rounded_up(Fraction(self.estimate.radius), digits): None for digits in _PRECISIONS}
        return next((example for radius in radii if (example := self.shows(radius))), None)

    def twice(self) -> Counterexample | None:
        """A counter-example at twice the radius, where none that is nearer would tell more."""
        return self.shows(rounded_up(2 * Fraction(self.estimate.radius), _RADIUS_DIGITS))

    def nearest(self) -> Counterexample | None:
        """A counter-example, the nearest that a short search finds."""
        whole = Fraction(self.estimate.radius)
        sound = whole * 9 / 10
        while best := self.shows(rounded_up(sound, _RADIUS_DIGITS)):
            sound = sound * 4 / 5
            if sound < whole / 10:
                return best
        for factor in map(Fraction, _FACTORS):
            if best := self.shows(rounded_up(whole * factor, _RADIUS_DIGITS)):
                return self._between(sound, best)
            sound = whole * factor
        return None

    def _between(self, sound: Fraction, best: Counterexample) -> Counterexample:
        """One that is nearer, by a few bisections."""
        for _ in range(_BISECTIONS):
            if best.radius <= sound * _CLOSE:
                break
            middle = rounded_up((sound + best.radius) / 2, _RADIUS_DIGITS)
            if middle >= best.radius:
                break
            if nearer := self.shows(middle):
                best = nearer
            else:
                sound = middle
        return best
