"""Whether a manipulator can change its assembly mode without a singularity: two poses of one joint vector in
one aspect, of a slice or of a range of the fixed leg, within joint limits.

Two poses and their path prove that it can. A cusp within the limits always leads to some, by a loop round it;
else folds of one joint vector suggest them. If boxes prove that there is neither cusp nor such folds, every
aspect maps one to one, and the mode cannot change (mathematics.md#changes-of-assembly-mode). That of similar
triangles never can (mathematics.md#similar-triangles), nor where legs share a joint
(mathematics.md#shared-joints). A check of a requirement may ask for it, too.

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
from math import degrees
from typing import Any

from rpr_solver.contract import CHECK_DIGITS, PATH_DIGITS, Progress, check_leg, document_head
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.decimals import rounded_near
from rpr_solver.exact.numerals import double
from rpr_solver.exact.rationals import Exact, exact_str, parse_positive
from rpr_solver.margins.options import TOO_WIDE, changes, check_margins
from rpr_solver.model.float_slice import FloatSlice
from rpr_solver.model.joint_points import Kind, free_legs
from rpr_solver.model.lengths import Bounds, ExactLimits, LengthRange, limits_json, read_limits, slice_length
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.pose_table import PoseTable, poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.connections import thresholds_json
from rpr_solver.modes.fold_boxes import FoldBoxes
from rpr_solver.modes.folds import FoldProof, OpenPairs, folds_apart, reached, vector_sizes
from rpr_solver.modes.joined_regions import Aspects, JoinedRegion, Lengths, OpenSpan, Span, joined_regions
from rpr_solver.modes.tolerant import Neighbours
from rpr_solver.modes.wide_pairs import wide_pairs
from rpr_solver.modes.wide_regions import WideRegions
from rpr_solver.paths import by_leg
from rpr_solver.paths.between_poses import joint_path
from rpr_solver.paths.clearances import with_clearance
from rpr_solver.paths.loops import TooLong, loop_in_slice, slice_for_loops
from rpr_solver.paths.path import Path
from rpr_solver.paths.pose_boxes import LegsInBalls
from rpr_solver.paths.proofs import BEST
from rpr_solver.paths.question import PathOptions, PathTerms, document_lengths
from rpr_solver.slices import kept_eliminant
from rpr_solver.transitions import Requirement
from rpr_solver.transitions.check_report import CheckReport, check_counts


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
        clearance: how far, in degrees, the change must keep from singular poses.
        tolerance: how much each of the six lengths may be off; None if they are exact.
        best: where a clearance or a tolerance leaves it undecided: the greatest clearance of a path that
            changes the mode and was found, in degrees; None if there is none.
        by_regions: whether it is impossible since the poses that keep the clearance are in regions each of
            which maps one to one.
        bound: where a clearance leaves it undecided: one that no path keeps, by proof, in degrees; None if
            none is proved.

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
    clearance: Fraction = Fraction(0)
    tolerance: tuple[Fraction, ...] | None = None
    best: Fraction | None = None
    by_regions: bool = False
    bound: Fraction | None = None

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
            "asked": {**asked, "limits": limits_json(self.limits) or None, **self._thresholds()},
            "change": self.change.value,
            "witness": None if self.witness is None else _witness_json(self.witness),
            "regions": None if self.regions is None else [region.to_json() for region in self.regions],
            "reason": self.reason,
            **({} if self.best is None else {"best_clearance": exact_str(self.best)}),
            **({} if self.bound is None else {"clearance_bound": exact_str(self.bound)}),
            "certificate": {"method": self._method(), "pairs": self.pairs},
        }

    def _thresholds(self) -> dict[str, Any]:
        """What is asked of clearance and tolerance, without what is not."""
        return thresholds_json(self.clearance, self.tolerance)

    def _method(self) -> str | None:
        if self.change is Change.IMPOSSIBLE:
            if self.pairs is not None:
                return "regions" if self.by_regions else "folds"
            return "shared-joints" if self.manipulator.geometry.shared_joints else "similar"
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
    clearance: Exact | None = None,
    tolerance: Exact | Mapping[str, Exact] | None = None,
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
        clearance: how far all poses of a change must keep from singular poses, in degrees, > 0 (paths.md):
            possible if a path is found that does; impossible if it is proved that none does.
        tolerance: how much all lengths may be off, or single ones by their names, the others being exact:
            the answer must hold for every manipulator within it.
        with_regions: whether the regions of the joint plane are wanted, too.

    Raises:
        InputError: naming the argument at fault.
        SolverError: the slices could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> assembly_modes(EXAMPLES["innocenti"], between=("0.05", "0.1"), with_regions=False)
    <AssemblyModes L1 from 0.05 to 0.1: change impossible>
    >>> assembly_modes(EXAMPLES["innocenti"], 27, limits={"l2": (None, 10)}).change
    'possible'
    >>> assembly_modes(EXAMPLES["innocenti"], 27, clearance="0.5", tolerance="0.05").change
    'possible'
    """
    leg = check_leg(fixed_leg)
    asked = Fraction(0) if clearance is None else parse_positive(clearance, "clearance")
    within = None if tolerance is None else changes(None, tolerance)
    if within is not None:
        check_margins(manipulator)
    span = _span(length, between, leg)
    bounds = read_limits({} if limits is None else limits, "limits", leg)
    slice_map = SliceMap.of(manipulator, leg, with_shared=True)
    question = _Question(manipulator, slice_map, span, bounds, asked, within)
    answer = question.answer()
    if not with_regions or bounds or span[1] is None or manipulator.geometry.shared_joints:
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
        clearance: what is asked for, in degrees; 0 for nothing.
        tolerance: of each length; None if they are exact.
    """

    manipulator: Manipulator
    slice_map: SliceMap
    span: OpenSpan
    bounds: Mapping[int, Bounds]
    clearance: Fraction = Fraction(0)
    tolerance: tuple[Fraction, ...] | None = None

    @property
    def leg(self) -> int:
        """The fixed leg."""
        return self.slice_map.fixed_leg

    def answer(self) -> AssemblyModes:
        """The answer without the regions."""
        if self.clearance or self.tolerance is not None:
            return self._with_thresholds()
        return self._plain()

    def _plain(self) -> AssemblyModes:
        """The answer for the given manipulator, however near to a singularity."""
        geometry = self.manipulator.geometry
        if geometry.is_similar or geometry.shared_joints:
            return self._answer(Change.IMPOSSIBLE)
        witness = next(self._loops(self._sampled()), None)
        if witness is not None:
            return self._possible(witness)
        proof = self._folds(self.slice_map, None)
        if not proof.left:
            return self._answer(Change.IMPOSSIBLE, pairs=proof.tests)
        witness = next(self._witnesses(proof.left[0]), None)
        if witness is not None:
            return self._possible(witness)
        return self._answer(Change.UNDECIDED, pairs=proof.tests, reason=self._reason(proof.left[0]))

    def _folds(self, slice_map: SliceMap, around: tuple[Fraction, LegsInBalls] | None) -> FoldProof:
        scale, (low, high) = slice_map.scale, self.reached
        return folds_apart(
            slice_map, (low * scale, None if high is None else high * scale), self.bounds, around=around
        )

    def _possible(self, witness: Path) -> AssemblyModes:
        """With a witness, and its clearance."""
        return self._answer(Change.POSSIBLE, witness=with_clearance(witness, self.clearance))

    def _with_thresholds(self) -> AssemblyModes:
        """The answer that keeps a clearance, or holds for all manipulators within a tolerance.

        The paths that are tried are the same for all thresholds, so that a looser one loses none.
        """
        plain = replace(self, clearance=Fraction(0), tolerance=None)._plain()
        if plain.change is Change.IMPOSSIBLE and self.tolerance is None:
            return self._answer(Change.IMPOSSIBLE, pairs=plain.pairs)
        around = None
        if self.tolerance is not None:
            most = self.looked_at[1] * self.slice_map.scale
            around = Neighbours.of(self.manipulator, self.slice_map, self.tolerance, most)
            if around is None:
                return self._answer(Change.UNDECIDED, reason=TOO_WIDE)
        tried: list[Path] = []
        can_change = plain.change is not Change.IMPOSSIBLE
        if can_change and (path := self._held(around, self._between_wide(self._sampled()), tried)):
            return self._possible(path)
        if not can_change and around is not None and self.reached[1] is not None:
            tests = around.sum_over(self._folds_apart)
            if tests is not None:
                return self._answer(Change.IMPOSSIBLE, pairs=tests)
        if (tests := self._regions_apart(around, self.clearance)) is not None:
            return self._answer(Change.IMPOSSIBLE, pairs=tests, by_regions=True)
        if can_change and (path := self._held(around, self._wide_loops(plain.witness), tried)):
            return self._possible(path)
        best = max((_proved(path) for path in tried), default=None)
        bound = self._bound(best) if can_change else None
        return self._answer(
            Change.UNDECIDED, reason=self._why_open(plain, best, bound), best=best, bound=bound
        )

    def _held(self, around: Neighbours | None, paths: Iterable[Path], tried: list[Path]) -> Path | None:
        """The first of some paths that change the mode that keeps the thresholds, with its clearance; None if
        none does. Paths that were tried are put in the list."""
        for path in map(with_clearance, paths):
            tried.append(path)
            if _proved(path) >= self.clearance and (around is None or self._holds(around, path)):
                return path
        return None

    def _folds_apart(self, some: Neighbours) -> int | None:
        """The number of pairs of boxes that prove that no folds of a joint vector are in the way; None if
        they do not."""
        proof = self._folds(self.slice_map, some.around)
        return None if proof.left else proof.tests

    def _regions_apart(self, around: Neighbours | None, clearance: Fraction) -> int | None:
        """The number of pairs of boxes that prove that no path keeps a clearance; None if they do not."""
        low, high = self.reached
        if high is None or not clearance:
            return None
        middle = (low + high) / 2
        if low < high and self._with_regions(None, (middle, middle), clearance) is None:
            return None  # what a slice does not show is not shown of a range

        def apart(some: Neighbours | None) -> int | None:
            return self._with_regions(some, (low, high), clearance)

        tests = apart(None)
        return tests if around is None or tests is None else around.sum_over(apart)

    def _with_regions(self, some: Neighbours | None, span: Span, clearance: Fraction) -> int | None:
        first, last = (length * self.slice_map.scale for length in span)
        model = FoldBoxes.of(self.slice_map, self.bounds, last, None if some is None else some.around)
        regions = WideRegions.of(model, (first, last), clearance)
        return None if regions is None else regions.tests_apart(is_brief=some is not None and some.is_part)

    def _bound(self, best: Fraction | None) -> Fraction | None:
        """A clearance that no path of a slice keeps, greater than what is asked for; None if none is
        proved."""
        least = max(self.clearance, best or Fraction(0))
        if self.reached[0] != self.reached[1] or not self.clearance:
            return None
        tried = (rounded_near(least * share, 3) for share in _MORE)
        return next((x for x in tried if self._with_regions(None, self.looked_at, x) is not None), None)

    def _holds(self, around: Neighbours, path: Path) -> bool:
        """Whether a path changes the mode of all manipulators, with the clearance that is asked for."""
        return around.keeps(path.route, path.sign, self.bounds, self.clearance)

    def _why_open(self, plain: AssemblyModes, best: Fraction | None, bound: Fraction | None) -> str:
        if plain.change is Change.IMPOSSIBLE:
            return "the given lengths do not allow a change; of others within the tolerance it is not proved"
        if best is None:
            return plain.reason or "no path was found"
        widest = f"the widest path that was found keeps {exact_str(best)} degrees"
        if best >= self.clearance:
            return f"{widest}, but that others within the tolerance can follow one is not proved"
        if bound is None:
            return f"{widest}, and that none keeps more is not proved"
        return f"{widest}; none keeps {exact_str(bound)}, and that none keeps what is asked is not proved"

    def _wide_loops(self, known: Path | None) -> Iterator[Path]:
        """Loops that change the mode, wide ones first."""
        yield from islice(self._loops(self._sampled(), clearance=BEST), _MOST_WIDE)
        if known is not None:
            yield known

    def _between_wide(self, lengths: Iterable[Fraction]) -> Iterator[Path]:
        """Paths between poses that a grid suggests, each in a slice."""
        for length in lengths:
            try:
                pairs = list(wide_pairs(self.slice_map, length * self.slice_map.scale, self.bounds))
            except (SolverError, OverflowError):
                continue
            for joint, spots in pairs:
                lengths_of = by_leg(self.leg, (length, *joint))
                with suppress(InputError, SolverError):
                    table = poses(self.manipulator, *lengths_of, digits=PATH_DIGITS)
                    one, other = (_nearest_pose(table, self.leg, spot) for spot in spots)
                    if one != other:
                        yield from self._path(lengths_of, one, other, (length, length), clearance=BEST)

    @cached_property
    def reached(self) -> OpenSpan:
        """The lengths at which some pose may be within the limits."""
        return reached(self.slice_map, self.span, self.bounds)

    @cached_property
    def looked_at(self) -> Span:
        """The lengths at which witnesses are sought, of a range without an end the first of them."""
        low, high = self.reached
        if high is None:
            high = max(2 * low, *(4 * size for size in vector_sizes(self.slice_map)))
        return low, high

    def regions(self) -> tuple[JoinedRegion, ...] | None:
        """The regions of the slices at the ends; None where they are not supported."""
        try:
            aspects = Aspects.of(self.slice_map, self.looked_at)
            ends = dict.fromkeys(self.looked_at)
            return tuple(r for end in ends for r in joined_regions(self.manipulator, aspects, end))
        except SolverError:
            return None

    def _answer(self, change: Change, **more: Any) -> AssemblyModes:
        more = {**more, "clearance": self.clearance, "tolerance": self.tolerance}
        return AssemblyModes(self.manipulator, self.leg, self.span, self.bounds, change, **more)

    def _sampled(self) -> Iterator[Fraction]:
        """The length of the slice, or some of the range."""
        low, high = self.looked_at
        yield (low + high) / 2
        if low < high:
            yield from (low, high)

    def _loops(self, lengths: Iterable[Fraction], clearance: str | None = None) -> Iterator[Path]:
        """Loops round cusps of these slices within the limits."""
        eliminant = kept_eliminant(self.manipulator, self.leg)
        terms = PathTerms.of(limits=self.bounds, fixed_leg=self.leg, clearance=clearance)
        for length in lengths:
            try:
                table = slice_for_loops(eliminant, length)
            except SolverError:
                continue
            for number, cusp in enumerate(table.cusps, 1):
                if not self._keeps(cusp.coordinates[2:]):
                    continue
                try:
                    yield loop_in_slice(eliminant, table, number, terms, self.manipulator)
                except TooLong:  # so are those round other cusps of the slice
                    break
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
        near = self._length_near(left)
        if self.looked_at[0] < self.looked_at[1]:
            yield from self._loops([near])
            requirement = Requirement(self.leg, *self.reached, max_cusps=0, limits=self.bounds)
            with suppress(SolverError):
                yield from self._loops(
                    x.example for x in check_counts(self.manipulator, requirement).violations
                )
        try:
            span = self.looked_at[0], max(self.looked_at[1], near)
            aspects = Aspects.of(self.slice_map, span)
            floats = FloatSlice.of(self.slice_map, near * self.slice_map.scale)
        except SolverError:
            return
        pairs = (
            pair
            for texts in left.joint_vectors(floats)
            if self._keeps(texts) and min(map(Fraction, texts)) > 0
            for pair in _pairs(self.manipulator, aspects, by_leg(self.leg, (near, *map(Fraction, texts))))
        )
        for lengths, one, other in islice(pairs, _MOST_PATHS):
            yield from self._path(lengths, one, other, span)

    def _length_near(self, left: OpenPairs) -> Fraction:
        """A length of the fixed leg where pairs are left, a short decimal within the range."""
        near = max(rounded_near(left.length / self.slice_map.scale, 10), self.span[0])
        return near if self.reached[1] is None else min(near, self.reached[1])

    def _path(
        self, lengths: Lengths, one: int, other: int, span: Span, clearance: str | None = None
    ) -> Iterator[Path]:
        """A path between two poses of a joint vector, if there is one."""
        between = None if span[0] == span[1] else span
        options = PathOptions(limits=self.bounds, fixed_leg=self.leg, clearance=clearance)
        with suppress(InputError, SolverError):
            path = joint_path(self.manipulator, *lengths, one, other, between=between, **options)
            if isinstance(path, Path):
                yield path

    def _reason(self, left: OpenPairs) -> str:
        angles, _ = left.place(0)
        alpha, theta = ((degrees(x) + 180) % 360 - 180 for x in angles)
        length = double(self._length_near(left))
        place = f"L{self.leg} = {length:.6g}, alpha = {alpha:.4f} deg, theta{self.leg} = {theta:.4f} deg"
        return f"near {place}, folds could not be told apart in boxes of {left.size_deg:.2g} deg"


_MOST_WIDE = 8
"""Wide loops that are tried, half a second each."""
_MORE = tuple(1 + Fraction(k, 20) for k in (1, 3, 8, 20))
"""Times what is asked for, clearances that may be excluded."""
_MOST_PATHS, _FEWEST = 6, 4
"""Paths that are tried; poses of a joint vector, of which two have one sign of J."""


def _proved(path: Path) -> Fraction:
    """The clearance of a path that has one."""
    assert path.clearance is not None
    return path.clearance.proved


def _nearest_pose(table: PoseTable, leg: int, spot: tuple[float, float]) -> int:
    """The number of the pose of a table that is nearest to α and θ in degrees."""

    def far(number: int) -> float:
        pose = table.poses[number - 1].to_json()
        angles = pose["alpha_deg"], pose[f"theta{leg}_deg"]
        return max(abs((float(x) - y + 180) % 360 - 180) for x, y in zip(angles, spot, strict=True))

    return min(range(1, table.count + 1), key=far)


def _pairs(
    manipulator: Manipulator, aspects: Aspects, lengths: Lengths
) -> Iterator[tuple[Lengths, int, int]]:
    """Two poses of each group of poses of a joint vector that are in one aspect."""
    table = poses(manipulator, *lengths, digits=PATH_DIGITS)
    if table.count >= _FEWEST:
        for group in aspects.groups(table, lengths) or ():
            if len(group) > 1:
                yield lengths, group[0], group[1]


def check(
    manipulator: Manipulator,
    requirement: Requirement,
    *,
    digits: int = CHECK_DIGITS,
    tolerance: Mapping[str, Exact] | Exact | None = None,
    progress: Progress | None = None,
) -> CheckReport:
    """Proves or refutes a requirement on the cusps of a range of lengths, and on changes of assembly mode.

    The range is cut at every transition, and at every length at which a cusp reaches a joint limit; one exact
    slice between two neighbouring cuts gives the number of cusps of all slices there. Whether the assembly
    mode can change while the fixed leg keeps the range is decided as by :func:`assembly_modes`; a requirement
    about it fails if that is undecided.

    Args:
        manipulator: the geometry.
        requirement: the fixed leg, the range, the numbers of cusps, the joint limits, and whether a change of
            assembly mode is required or excluded.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
        tolerance: how much the lengths may be off, for the change of assembly mode alone; for the numbers of
            cusps ask for a :func:`~rpr_solver.margin`.
        progress: callback ``progress(done, total)``; ``total`` may grow.

    Raises:
        InputError: naming ``manipulator``, ``requirement``, ``digits`` or ``tolerance``.
        SolverError: a cut could not be decided, or cusps keep the length of a joint limit over a range.

    >>> from rpr_solver import EXAMPLES
    >>> report = check(EXAMPLES["zein-flat"], Requirement(start=30, stop=40, max_cusps=6), digits=15)
    >>> report.passed, [(v.start, v.stop, v.count) for v in report.violations]
    (False, [('31.8632047694475', '31.8635738939382', 8), ('34.0716802345821', '35.2127837717642', 8)])
    >>> safe = Requirement(start="0.1", stop="0.3", mode_change="excluded")
    >>> check(EXAMPLES["zein-flat"], safe, digits=15).passed
    True
    """
    report = check_counts(manipulator, requirement, digits=digits, progress=progress)
    if requirement.mode_change is None:
        if tolerance is not None:
            raise InputError.of("tolerance", "is for changes of assembly mode here; ask for a margin")
        return report
    found = assembly_modes(
        manipulator,
        between=(requirement.start, requirement.stop),
        limits=requirement.limits,
        fixed_leg=requirement.fixed_leg,
        clearance=requirement.clearance or None,
        tolerance=tolerance,
        with_regions=False,
    ).to_json()
    names = ("change", "witness", "reason", "best_clearance", "clearance_bound", "certificate")
    part = {name: found[name] for name in names if name in found}
    return replace(report, mode_change=part)
