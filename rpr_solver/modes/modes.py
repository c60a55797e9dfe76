"""Whether a manipulator can change its assembly mode without a singularity: two poses of one joint vector in
one aspect, of a slice or of a range of the fixed leg, within joint limits.

Two poses and their path prove that it can. A cusp within the limits always leads to some, by a loop round it;
else folds of one joint vector suggest them. If boxes prove that there is neither cusp nor such folds, every
aspect maps one to one, and the mode cannot change (mathematics.md#changes-of-assembly-mode). That of similar
triangles never can (mathematics.md#similar-triangles).

The document of :meth:`AssemblyModes.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "fixed_leg": 1, "digits": 15, "solver_version": "…",
     "asked": {"l1": "27", "limits": null}, "change": "possible",
     "witness": {"l1": "27", "l2": "15.5", "l3": "16.9", "from": 2, "to": 3, "path": {…}},
     "regions": [{"point": {"l1": "27", "l2": "18.1", "l3": "16.3"}, "poses": 6,
                  "joined": [[1, 3], [2, 5], [4], [6]]}],
     "reason": null, "certificate": {"method": "witness", "pairs": null}}

``asked`` has ``"range": {"from": …, "to": …}`` for a range; ``"to"`` is null if it has no upper end.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import islice
from math import cos, degrees, isqrt, pi, sin
from typing import Any

from rpr_solver.contract import PATH_DIGITS, check_leg, document_head
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.rationals import Exact, exact_str
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.model.joint_points import Kind, free_legs
from rpr_solver.model.lengths import Bounds, ExactLimits, LengthRange, limits_json, read_limits, slice_length
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.pose_table import poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.folds import OpenPairs, folds_apart
from rpr_solver.modes.joined import Aspects, JoinedRegion, Lengths, OpenSpan, Span, joined_regions
from rpr_solver.paths.between_poses import joint_path
from rpr_solver.paths.loops import loop_in_slice, slice_for_loops
from rpr_solver.paths.path import Path
from rpr_solver.paths.route import by_leg
from rpr_solver.paths.terms import PathOptions, PathTerms, document_lengths
from rpr_solver.slices import kept_eliminant
from rpr_solver.transitions import Requirement
from rpr_solver.transitions.check_report import check_counts


class Change(Kind):
    """Whether the assembly mode can change.

    >>> Change.POSSIBLE == "possible"
    True
    """

    POSSIBLE = "possible"
    """Two poses of one joint vector are joined by a path without a singularity, which is given."""
    IMPOSSIBLE = "impossible"
    """No two poses of any joint vector are joined, by proof."""
    UNDECIDED = "undecided"
    """Neither was proved; the reason says where."""


@dataclass(frozen=True)
class AssemblyModes:
    """Whether a manipulator can change its assembly mode in a slice, or while the fixed leg keeps a range.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length is held, or keeps the range.
        span: its least and its greatest length, exact, in the user's unit; equal for a slice. None is no
            upper end.
        limits: joint limits of the free legs, by their numbers.
        change: whether the mode can change; all but ``UNDECIDED`` is proved.
        witness: a proved path from a pose to another one of the same joint vector; None if there is none.
        regions: of the slice, or of the slices at both ends of the range, with the poses that are in one
            aspect of the slice or of the range; None with joint limits, without an upper end, or where they
            are not supported.
        reason: why it is undecided; None if it is not.
        pairs: the number of pairs of boxes that were examined; None if there was no need.

    >>> from rpr_solver import EXAMPLES, assembly_modes
    >>> answer = assembly_modes(EXAMPLES["innocenti"], 27)
    >>> answer
    <AssemblyModes L1=27: change possible>
    >>> answer.witness
    <Path round cusp A of L1=27, from pose 1 to pose 2: J < 0, 101 samples, 15 digits>
    >>> assembly_modes(EXAMPLES["innocenti"], "0.1")
    <AssemblyModes L1=0.1: change impossible>
    """

    manipulator: Manipulator
    fixed_leg: int
    span: OpenSpan
    limits: Mapping[int, Bounds]
    change: Change
    witness: Path | None = None
    regions: tuple[JoinedRegion, ...] | None = field(default=None, repr=False)
    reason: str | None = None
    pairs: int | None = None

    def __repr__(self) -> str:
        low, high = self.span
        where = f"={exact_str(low)}" if low == high else f" {LengthRange(low, high)}"
        limited = " within limits" if self.limits else ""
        return f"<AssemblyModes L{self.fixed_leg}{where}{limited}: change {self.change}>"

    def to_json(self) -> dict[str, Any]:
        """The document described at the top of this module."""
        leg, low, high = self.fixed_leg, *self.span
        asked = {f"l{leg}": exact_str(low)} if low == high else {"range": LengthRange(low, high).to_json()}
        return {
            **document_head(self.manipulator, PATH_DIGITS, leg),
            "asked": {**asked, "limits": limits_json(self.limits) or None},
            "change": self.change.value,
            "witness": None if self.witness is None else _witness_json(self.witness),
            "regions": None if self.regions is None else [region.to_json() for region in self.regions],
            "reason": self.reason,
            "certificate": {"method": self._method(), "pairs": self.pairs},
        }

    def _method(self) -> str | None:
        if self.change is Change.IMPOSSIBLE:
            return "similar" if self.pairs is None else "folds"
        return "witness" if self.change is Change.POSSIBLE else None


def _witness_json(path: Path) -> dict[str, Any]:
    return {
        **document_lengths(path.lengths),
        "from": path.start.number,
        "to": path.stop.number,
        "path": path.to_json(),
    }


def assembly_modes(
    manipulator: Manipulator,
    length: Exact | None = None,
    *,
    between: tuple[Exact, Exact | None] | None = None,
    limits: ExactLimits | None = None,
    fixed_leg: int = 1,
    with_regions: bool = True,
) -> AssemblyModes:
    """Whether the assembly mode can change without a singularity, and how; or the proof that it cannot.

    Args:
        manipulator: the geometry.
        length: of the fixed leg of a slice, exact, > 0, in the user's unit; or give ``between``.
        between: the least and the greatest length of the fixed leg, which may move between them; None is no
            upper end.
        limits: joint limits of the other legs, as for :func:`joint_path`.
        fixed_leg: the leg of the slice or of the range, 1, 2 or 3.
        with_regions: whether the regions of the joint plane are wanted, too.

    Raises:
        InputError: naming the argument at fault.
        SolverError: the slices could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> assembly_modes(EXAMPLES["innocenti"], between=("0.05", "0.1"), with_regions=False)
    <AssemblyModes L1 from 0.05 to 0.1: change impossible>
    >>> assembly_modes(EXAMPLES["innocenti"], 27, limits={"l2": (None, 10)}).change
    'possible'
    """
    leg = check_leg(fixed_leg)
    span = _span(length, between, leg)
    bounds = read_limits({} if limits is None else limits, "limits", leg)
    question = _Question(manipulator, SliceMap.of(manipulator, leg), span, bounds)
    answer = question.answer()
    if not with_regions or bounds or span[1] is None:
        return answer
    return replace(answer, regions=question.regions())


def _span(length: Exact | None, between: tuple[Exact, Exact | None] | None, leg: int) -> OpenSpan:
    """The least and the greatest length of the fixed leg.

    Raises:
        InputError: naming the leg or ``between``.
    """
    if (length is None) == (between is None):
        raise InputError.of(f"l{leg}", "give a length, or the range between two")
    if between is None:
        assert length is not None, "one of both is given"
        return (slice_length(length, leg),) * 2
    span = LengthRange.of(*between, ("between.from", "between.to"))
    if not span.start:
        raise InputError.of("between", "give a least length > 0")
    return span.start, span.stop


@dataclass(frozen=True)
class _Question:
    """Whether the mode can change.

    Attributes:
        manipulator: the geometry.
        slice_map: its integer model.
        span: the lengths of the fixed leg, in the user's unit; None is no upper end.
        bounds: the limits of the free legs.
    """

    manipulator: Manipulator
    slice_map: SliceMap
    span: OpenSpan
    bounds: Mapping[int, Bounds]

    @property
    def leg(self) -> int:
        """The fixed leg."""
        return self.slice_map.fixed_leg

    def answer(self) -> AssemblyModes:
        """The answer without the regions."""
        if self.slice_map.similar:
            return self._told(Change.IMPOSSIBLE)
        witness = next(self._loops(self._sampled()), None)
        if witness is not None:
            return self._possible(witness)
        scale, (low, high) = self.slice_map.scale, self.reached
        proof = folds_apart(
            self.slice_map, (low * scale, None if high is None else high * scale), self.bounds
        )
        if not proof.left:
            return self._told(Change.IMPOSSIBLE, pairs=proof.tests)
        witness = next(self._witnesses(proof.left[0]), None)
        if witness is not None:
            return self._possible(witness)
        return self._told(Change.UNDECIDED, pairs=proof.tests, reason=self._reason(proof.left[0]))

    @cached_property
    def reached(self) -> OpenSpan:
        """The lengths at which some pose may be within the limits."""
        return _reached(self.slice_map, self.span, self.bounds)

    @cached_property
    def looked_at(self) -> Span:
        """The lengths at which witnesses are sought, of a range without an end the first of them."""
        low, high = self.reached
        return low, max(2 * low, *(4 * size for size in _sizes(self.slice_map))) if high is None else high

    def regions(self) -> tuple[JoinedRegion, ...] | None:
        """The regions of the slices at the ends; None where they are not supported."""
        try:
            aspects = Aspects.of(self.slice_map, self.looked_at)
            ends = dict.fromkeys(self.looked_at)
            return tuple(r for end in ends for r in joined_regions(self.manipulator, aspects, end))
        except SolverError:
            return None

    def _told(self, change: Change, **more: Any) -> AssemblyModes:
        return AssemblyModes(self.manipulator, self.leg, self.span, self.bounds, change, **more)

    def _possible(self, witness: Path) -> AssemblyModes:
        return self._told(Change.POSSIBLE, witness=witness)

    def _sampled(self) -> Iterator[Fraction]:
        """The length of the slice, or some of the range."""
        low, high = self.looked_at
        yield (low + high) / 2
        if low < high:
            yield from (low, high)

    def _loops(self, lengths: Iterable[Fraction]) -> Iterator[Path]:
        """Loops round cusps of these slices within the limits."""
        eliminant = kept_eliminant(self.manipulator, self.leg)
        terms = PathTerms.of(limits=self.bounds, fixed_leg=self.leg)
        for length in lengths:
            try:
                table = slice_for_loops(eliminant, length)
            except SolverError:
                continue
            for number, cusp in enumerate(table.cusps, 1):
                if self._keeps(cusp.coordinates[2:]):
                    try:
                        yield loop_in_slice(eliminant, table, number, terms)
                    except (InputError, SolverError):
                        continue

    def _keeps(self, texts: Sequence[str]) -> bool:
        """Whether free legs seem to keep the limits."""
        for leg, text in zip(free_legs(self.leg), texts, strict=True):
            low, high = self.bounds.get(leg, (None, None))
            if (low is not None and Fraction(text) <= low) or (high is not None and Fraction(text) >= high):
                return False
        return True

    def _witnesses(self, left: OpenPairs) -> Iterator[Path]:
        """Paths that change the mode: round cusps of windows of the range, or between folds that cross."""
        if self.looked_at[0] < self.looked_at[1]:
            yield from self._loops([self._length_near(left)])
            requirement = Requirement(self.leg, *self.reached, max_cusps=0, limits=self.bounds)
            with suppress(SolverError):
                yield from self._loops(
                    x.example for x in check_counts(self.manipulator, requirement).violations
                )
        try:
            span = self.looked_at[0], max(self.looked_at[1], self._length_near(left))
            aspects = Aspects.of(self.slice_map, span)
            floats = FloatSlice.of(self.slice_map, self._length_near(left) * self.slice_map.scale)
        except SolverError:
            return
        pairs = (
            pair
            for lengths in self._joint_vectors(left, floats)
            for pair in _pairs(self.manipulator, aspects, lengths)
        )
        for lengths, one, other in islice(pairs, _MOST_PATHS):
            yield from self._path(lengths, one, other, span)

    def _length_near(self, left: OpenPairs) -> Fraction:
        """A length of the fixed leg where pairs are left, a short decimal within the range."""
        near = max(Fraction(f"{left.length / self.slice_map.scale:.10g}"), self.span[0])
        return near if self.reached[1] is None else min(near, self.reached[1])

    def _joint_vectors(self, left: OpenPairs, floats: FloatSlice) -> Iterator[Lengths]:
        """Joint vectors near a crossing of folds, on all sides of it, within the limits."""
        length = self._length_near(left)
        for pair in _spread(len(left.first), _CROSSINGS):
            ends = [floats.joints(*place) for place in left.place(pair)]
            middle = [(x + y) / 2 / floats.unit for x, y in zip(*ends, strict=True)]
            for share in _SHARES:
                for k in range(_DIRECTIONS):
                    turn = 2 * pi * k / _DIRECTIONS
                    moves = share * cos(turn), share * sin(turn)
                    texts = [f"{x * (1 + move):.12g}" for x, move in zip(middle, moves, strict=True)]
                    if self._keeps(texts) and all(Fraction(text) > 0 for text in texts):
                        yield by_leg(self.leg, (length, *map(Fraction, texts)))

    def _path(self, lengths: Lengths, one: int, other: int, span: Span) -> Iterator[Path]:
        """A path between two poses of a joint vector, if there is one."""
        between = None if span[0] == span[1] else span
        options = PathOptions(limits=self.bounds, fixed_leg=self.leg)
        try:
            path = joint_path(self.manipulator, *lengths, one, other, between=between, **options)
        except (InputError, SolverError):
            return
        if isinstance(path, Path):
            yield path

    def _reason(self, left: OpenPairs) -> str:
        angles, _ = left.place(0)
        alpha, theta = ((degrees(x) + 180) % 360 - 180 for x in angles)
        length = float(self._length_near(left))
        place = f"L{self.leg} = {length:.6g}, alpha = {alpha:.4f} deg, theta{self.leg} = {theta:.4f} deg"
        return f"near {place}, folds could not be told apart in boxes of {left.size_deg:.2g} deg"


def _reached(slice_map: SliceMap, span: OpenSpan, bounds: Mapping[int, Bounds]) -> OpenSpan:
    """The lengths at which some pose may be within limits: a leg is not shorter than the fixed one less what
    the vectors of platform and base add."""
    low, high = span
    if high is not None:
        return low, high
    free = zip(free_legs(slice_map.fixed_leg), _sizes(slice_map), strict=True)
    most = [bound + size for leg, size in free if (bound := bounds.get(leg, (None, None))[1]) is not None]
    return low, max(low, min(most)) if most else None


def _sizes(slice_map: SliceMap) -> list[Fraction]:
    """For each free leg the lengths of its vectors on platform and base together, or a little more."""
    legs = slice_map.f, slice_map.g
    return [Fraction(isqrt(leg.platform2) + isqrt(leg.base2) + 2) / slice_map.scale for leg in legs]


_CROSSINGS, _DIRECTIONS, _MOST_PATHS = 3, 8, 6
_SHARES = (1e-2, 1e-3, 1e-4)
_FEWEST = 4
"""Poses of a joint vector, of which two have one sign of J."""


def _pairs(
    manipulator: Manipulator, aspects: Aspects, lengths: Lengths
) -> Iterator[tuple[Lengths, int, int]]:
    """Two poses of each group of poses of a joint vector that are in one aspect."""
    table = poses(manipulator, *lengths, digits=PATH_DIGITS)
    if table.count >= _FEWEST:
        for group in aspects.groups(table, lengths) or ():
            if len(group) > 1:
                yield lengths, group[0], group[1]


def _spread(count: int, most: int) -> list[int]:
    """Some numbers below a count, far apart."""
    return sorted({k * (count - 1) // max(most - 1, 1) for k in range(most)})
