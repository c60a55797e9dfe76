"""Margins: how far the lengths may change before a property is lost, proved below and refuted above."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import chain
from typing import Any, Unpack

from rpr_solver.contract import (
    LENGTHS,
    MIN_DIGITS,
    Progress,
    check_leg,
    check_type,
    document_head,
    silent,
)
from rpr_solver.errors import InputError
from rpr_solver.exact.decimals import rounded_down
from rpr_solver.exact.rationals import Exact, exact_or_none, exact_str
from rpr_solver.margins.estimates import Estimate, Mover
from rpr_solver.margins.exclusion import exclude
from rpr_solver.margins.options import (
    OPEN,
    PROVED,
    REFUTED,
    TOO_WIDE,
    MayGoOn,
    SearchOptions,
    changes,
    check_margins,
)
from rpr_solver.margins.problems import Problem, validity
from rpr_solver.margins.subjects import (
    Counterexample,
    Ray,
    RequirementHolds,
    SliceCount,
    Subject,
    WindowExists,
)
from rpr_solver.margins.zones import Zones
from rpr_solver.model.lengths import slice_length
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.transitions import Requirement

MOST_BOXES = 20_000
"""The number of boxes that a search examines, some three seconds."""
_BESIDE_ZONES = 4
"""How many times more boxes a proof beside zones may have: where it fails, it does so soon."""
_PARTS = Fraction(99, 100), Fraction(17, 20), Fraction(13, 20)
"""The first radii that are tried, each as part of the one that failed."""
_DIGITS = 3
_CLOSE = Fraction(51, 50)
_ENOUGH = Fraction(6, 5)
"""The search ends when the radius that failed is at most this many times the proved one."""
_TINY = Fraction(1, 10**9)
"""Radii below this share of an estimate are not tried."""
_FINEST = Fraction(2, 10**13)
"""Below this share of the longest length no margin is tried: roundings of doubles hide it. Measured: proofs
of 3e-13 succeed, those of 3e-14 use all boxes and fail."""
_LEAST_BOXES = 4_000
_CANDIDATES = 4
_DOUBTFUL = 1.1
"""If the first-order radius is below this, a counter-example is sought before a proof."""


@dataclass(frozen=True)
class Margin:
    """How far the lengths of a manipulator may change before a property is lost.

    Radii multiply the weights: within radius r are the geometries with |δ_j| ≤ r w_j for each length.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length is given, or varies.
        asked: what was asked, as the contract has it.
        weights: w, by the names of the lengths; 0 keeps a length as it is.
        count: the number of cusps; None for a requirement that allows several.
        validity: the radius at which a platform is flat or two base points coincide; None if there is none.
        first_order: an estimate, no bound; None if there is none.
        proved: all geometries within this radius have the property; None if nothing was proved.
        counterexample: one that has it not; None if none was found.
        verdict: ``"proved"``, ``"refuted"`` or ``"open"`` for a tolerance, else None.
        boxes: the number of boxes of the proof.
        reason: why the margin is 0 or nothing could be proved, if that is known.

    >>> from rpr_solver import EXAMPLES, margin
    >>> margin(EXAMPLES["innocenti"], "28.1", tolerance="0.0007")
    <Margin refuted: nothing proved, refuted 1>
    """

    manipulator: Manipulator
    fixed_leg: int
    asked: Mapping[str, Any]
    weights: Mapping[str, Fraction]
    count: int | None
    validity: Fraction | None
    first_order: Estimate | None
    proved: Fraction | None
    counterexample: Counterexample | None
    verdict: str | None
    boxes: int
    reason: str | None = None

    def __repr__(self) -> str:
        known = "nothing proved" if self.proved is None else f"proved {exact_str(self.proved)}"
        against = "" if self.counterexample is None else f", refuted {exact_str(self.counterexample.radius)}"
        return f"<Margin {self.verdict or 'radius'}: {known}{against}>"

    def to_json(self) -> dict[str, Any]:
        """The contract's margin document."""
        leg = self.fixed_leg
        return {
            **document_head(self.manipulator, MIN_DIGITS, leg),
            "asked": dict(self.asked),
            "count": self.count,
            "weights": {name: exact_str(w) for name, w in self.weights.items()},
            "validity": None if self.validity is None else exact_str(rounded_down(self.validity, 6)),
            "first_order": None if self.first_order is None else _estimate_json(self.first_order, leg),
            "proved": exact_or_none(self.proved),
            "counterexample": None
            if self.counterexample is None
            else _example_json(self.counterexample, leg),
            "verdict": self.verdict,
            "reason": self.reason,
            "certificate": {
                "method": "exclusion, transitions located"
                if self.proved and self.count is None
                else "exclusion",
                "boxes": self.boxes,
                "arithmetic": "binary64, errors bounded",
            },
        }


def _estimate_json(estimate: Estimate, leg: int) -> dict[str, Any]:
    def mover(one: Mover) -> dict[str, Any]:
        slopes = {name: f"{slope:.6g}" for name, slope in zip(LENGTHS, one.slopes, strict=True)}
        return {f"l{leg}": f"{one.length:.12g}", "kind": one.kind, "sensitivity": slopes}

    return {"radius": f"{estimate.radius:.5g}", "binding": [mover(one) for one in estimate.movers]}


def _example_json(example: Counterexample, leg: int) -> dict[str, Any]:
    return {
        "radius": exact_str(example.radius),
        "geometry": example.manipulator.to_json(),
        f"l{leg}": exact_or_none(example.found.length),
        "count": example.found.cusps,
    }


def margin(
    manipulator: Manipulator,
    length: Exact | None = None,
    *,
    requirement: Requirement | None = None,
    window: Exact | None = None,
    fixed_leg: int | None = None,
    weights: Mapping[str, Exact] | None = None,
    tolerance: Exact | Mapping[str, Exact] | None = None,
    **search: Unpack[SearchOptions],
) -> Margin:
    """How far the lengths of a manipulator may change before the number of cusps does.

    Args:
        manipulator: the geometry.
        length: of the fixed leg, exact, in the user's unit: the number of cusps of this slice is to stay.
        requirement: or what all geometries are to satisfy; it names the fixed leg.
        window: or a length between two transitions: slices with the number of cusps there are to exist.
        fixed_leg: 1, 2 or 3; that of the requirement, or 1, unless given.
        weights: how much each of ``a2x``, ``a3x``, ``a3y``, ``d1``, ``d2``, ``d3`` may change in comparison;
            1 unless given, 0 for a length that is exact.
        tolerance: a change of all lengths, times the weights, or those of single lengths, the others being
            exact. Then it is only decided whether the property holds within it, and radii multiply it.
        search: ``most_boxes``, the number of boxes of all proofs together, after which the best radius so far
            is the answer, the same on every machine; ``may_go_on``, asked now and then, which ends the search
            as well when it returns False; and ``progress(done, total)``.

    Raises:
        InputError: naming the argument at fault; exactly one of ``length``, ``requirement`` and ``window``
            is wanted.
        SolverError: the given geometry could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> answer = margin(EXAMPLES["innocenti"], "28.1", tolerance="0.0005")
    >>> answer.count, answer.verdict
    (10, 'proved')
    """
    check_type(manipulator, Manipulator, "manipulator")
    manipulator.geometry.apart_from_shared()
    leg, subject, asked = _subject(manipulator, length, requirement, window, fixed_leg)
    given = changes(weights, tolerance)
    if tolerance is not None:
        asked["tolerance"] = {g: exact_str(w) for g, w in zip(LENGTHS, given, strict=True)}
    run = _Search(subject, manipulator, given, _Budget(**search))
    answer = run.within_one() if tolerance is not None else run.radius()
    named = dict(zip(LENGTHS, given, strict=True))
    return Margin(manipulator, leg, asked, named, subject.count(), **answer)


def _subject(
    manipulator: Manipulator,
    length: Exact | None,
    requirement: Requirement | None,
    window: Exact | None,
    fixed_leg: int | None,
) -> tuple[int, Subject, dict[str, Any]]:
    """The fixed leg, what is asked for, and how documents say it."""
    if sum(x is not None for x in (length, requirement, window)) != 1:
        raise InputError.of("length", "give exactly one of length, requirement and window")
    if requirement is not None:
        check_type(requirement, Requirement, "requirement")
        if fixed_leg is not None and check_leg(fixed_leg) != requirement.fixed_leg:
            other = f"the requirement is about leg {requirement.fixed_leg}"
            raise InputError.of("fixed_leg", f"is {fixed_leg}, but {other}; leave one of them out")
        check_margins(manipulator)
        asked = {"requirement": requirement.to_json()}
        return requirement.fixed_leg, RequirementHolds(manipulator, requirement.of_cusps_alone()), asked
    leg = check_leg(1 if fixed_leg is None else fixed_leg)
    if window is not None:
        exact = slice_length(window, leg)
        check_margins(manipulator, {"window": exact})
        return leg, WindowExists(manipulator, leg, exact), {"window": exact_str(exact)}
    exact = slice_length(0 if length is None else length, leg)
    check_margins(manipulator, {f"l{leg}": exact})
    return leg, SliceCount(manipulator, leg, exact), {f"l{leg}": exact_str(exact)}


@dataclass
class _Budget:
    """How much a search may cost."""

    most_boxes: int = MOST_BOXES
    may_go_on: MayGoOn = lambda: True
    progress: Progress = silent
    boxes: int = 0

    @property
    def left(self) -> int:
        """The number of boxes left, 0 when the search has to end."""
        return max(self.most_boxes - self.boxes, 0) if self.may_go_on() else 0

    def exclude(self, problem: Problem, zones: Zones | None, most_boxes: int) -> bool:
        """Whether a problem is proved with at most this many boxes."""
        if zones is not None:
            result = exclude(problem, _BESIDE_ZONES * self.left, self.may_go_on, zones)
            self.boxes += result.boxes // _BESIDE_ZONES
        else:
            result = exclude(problem, most_boxes, self.may_go_on)
            self.boxes += result.boxes
        self.progress(min(self.boxes, self.most_boxes), self.most_boxes)
        return result.proved


@dataclass(frozen=True)
class _Search:
    """The search for a margin."""

    subject: Subject
    manipulator: Manipulator
    weights: tuple[Fraction, ...]
    budget: _Budget

    def within_one(self) -> dict[str, Any]:
        """Whether all geometries within the radius 1 have the property."""
        if reason := self._reason():
            return self._answer(verdict=OPEN, reason=reason, estimated=False)
        if self._validity is not None and self._validity <= 1:
            return self._answer(verdict=OPEN, reason=TOO_WIDE, estimated=False)
        if example := self._refuted_within_one():
            return self._answer(example=example, verdict=REFUTED)
        if reason := self.subject.obstacle():
            return self._answer(verdict=OPEN, reason=reason)
        if self._prove(Fraction(1), self.budget.left):
            return self._answer(proved=Fraction(1), verdict=PROVED)
        return self._answer(verdict=OPEN)

    def radius(self) -> dict[str, Any]:
        """The greatest radius that is proved, and a counter-example beyond it."""
        if reason := self._reason():
            return self._answer(proved=Fraction(0), reason=reason, estimated=False)
        example = self._refuted()
        if reason := self.subject.obstacle():
            return self._answer(example=example, reason=reason)
        proved, failed, tries = Fraction(0), self._possible(self._top(example)), iter(_PARTS)
        if (stricter := self.subject.stricter()) is not None:
            proved = replace(self, subject=stricter).radius()["proved"] or proved
        while self.budget.left > _LEAST_BOXES and failed > max(proved * _ENOUGH, self._finest):
            radius = rounded_down(
                (proved + failed) / 2 if proved else failed * next(tries, Fraction(1, 2)), _DIGITS
            )
            if not proved < radius < failed:
                break
            if self._prove(radius, max(self.budget.left // (2 if proved else 4), _LEAST_BOXES)):
                proved = radius
            else:
                failed = radius
        return self._answer(proved=proved or None, example=example)

    def _possible(self, top: Fraction) -> Fraction:
        """A radius, at most a given one, near which there is something to exclude; 0 if none is found."""
        known, radius, least = Fraction(0), top, max(top * _TINY, self._finest)
        while top > known * _ENOUGH and radius > least and self.budget.left:
            if self.subject.problems(radius * _PARTS[0], self.weights) is not None:
                known = radius
            else:
                top = radius
            radius = (known + top) / 2
        return known

    def _top(self, example: Counterexample | None) -> Fraction:
        """A radius within which the property probably holds."""
        bounds = [Fraction(near.radius) for near in self._near[:1]]
        bounds += [] if self._validity is None else [self._validity]
        if example is not None:
            bounds.append(example.radius)
        elif self._estimate is not None:
            bounds.append(Fraction(self._estimate.radius))
        return min(bounds) if bounds else self._longest

    @property
    def _longest(self) -> Fraction:
        return max(max(-low, high) for low, high in self.manipulator.bounds())

    @property
    def _finest(self) -> Fraction:
        """The least radius of which a proof is tried."""
        return self._longest * _FINEST / max(self.weights)

    @cached_property
    def _near(self) -> list[Estimate]:
        return self.subject.nearest(self.weights)

    @cached_property
    def _estimate(self) -> Estimate | None:
        return self.subject.estimate(self.weights)

    @cached_property
    def _validity(self) -> Fraction | None:
        return validity(self.manipulator, self.weights)

    def _reason(self) -> str | None:
        if flaw := self.subject.flaw():
            return flaw
        return "the least change makes it no manipulator" if self._validity == 0 else None

    def _prove(self, radius: Fraction, most_boxes: int) -> bool:
        # the stricter property first, so that no proof is lost when a property is loosened
        subjects = (self.subject.stricter(), self.subject)
        return any(self._proved(one, radius, most_boxes) for one in subjects if one is not None)

    def _proved(self, subject: Subject, radius: Fraction, most_boxes: int) -> bool:
        tasks = subject.problems(radius, self.weights)
        return tasks is not None and all(
            self.budget.exclude(*task, most_boxes // len(tasks)) for task in tasks
        )

    def _ray(self, estimate: Estimate) -> Ray:
        return Ray(self.subject, self.manipulator, self.weights, estimate, self._validity)

    def _refuted(self) -> Counterexample | None:
        """A counter-example, the nearest that is found."""
        estimate = self._estimate
        near = self._near[:_CANDIDATES] if self.budget.left else []
        fine = [one for one in (*near, estimate) if one and Fraction(one.radius) < self._finest]
        tries = (self._ray(one).twice() for one in fine)
        if (example := next(filter(None, tries), None)) is not None:
            return example
        tries = (self._ray(one).beyond() for one in near if one not in fine)
        best = next(filter(None, tries), None)
        if estimate is None or not self.budget.left:
            return best
        if best is not None and Fraction(estimate.radius) * _CLOSE > best.radius:
            return best
        other = self._ray(estimate).nearest()
        return min((x for x in (best, other) if x is not None), key=lambda x: x.radius, default=None)

    def _refuted_within_one(self) -> Counterexample | None:
        """A counter-example at most at the radius 1."""
        nearer = [near for near in self._near[:_CANDIDATES] if near.radius < 1]
        if self._estimate is not None and self._estimate.radius < _DOUBTFUL:
            nearer.append(self._estimate)
        rays = list(map(self._ray, nearer))
        tries = chain((ray.shows(Fraction(1)) for ray in rays), (ray.beyond() for ray in rays))
        return next((example for example in tries if example and example.radius <= 1), None)

    def _answer(
        self,
        *,
        proved: Fraction | None = None,
        example: Counterexample | None = None,
        verdict: str | None = None,
        reason: str | None = None,
        estimated: bool = True,
    ) -> dict[str, Any]:
        return {
            "validity": self._validity,
            "first_order": self._estimate if estimated else None,
            "proved": proved,
            "counterexample": example,
            "verdict": verdict,
            "boxes": self.budget.boxes,
            "reason": reason,
        }
