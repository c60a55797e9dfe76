"""Which poses of a joint vector, or of two, are joined by paths without a singularity: all pairs at once.

The document of :meth:`PoseConnections.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "fixed_leg": 1, "digits": 15, "solver_version": "…",
     "l1": "27", "l2": "20", "l3": "20", "between": null, "limits": {"l2": {"min": null, "max": "21"}},
     "poses": [{"pose": 1, "alpha_deg": "…", "theta1_deg": "…", "sign": -1}, …],
     "groups": [[1], [2], [3, 4]],
     "matrix": [["joined", "separated-by-limits", "opposite-signs", "opposite-signs"], …],
     "resolution": {"angle_deg": "2.8125", "length": null}}

Where limits leave pairs undecided, ``"undecided": [{"poses": [1, 2], "near": {"alpha_deg": "1.1", …}}]``
follows. If the parts of the allowed region were asked for: ``"allowed": {"count": 2, "parts": [{"sign": 1,
"is_one": true, "poses": [3, 4], "pose": {"alpha_deg": "…", …}}, …], "resolution": {…}}``.

``groups`` and ``matrix`` name poses by their places in ``poses``, from 1. For one joint vector these are the
numbers of the poses. With two, each pose has its own ``l1``, ``l2`` and ``l3``, and the document has none.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import Any, TypedDict, Unpack

from rpr_solver.contract import LENGTHS, document_head
from rpr_solver.errors import FieldProblem, InputError, SolverError, Unproved, shown
from rpr_solver.exact.rationals import Exact, exact_str, parse_all, parse_positive
from rpr_solver.margins.options import changes, check_margins
from rpr_solver.model.lengths import Bounds, ExactLimits, limits_json
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.pose_table import poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.joined_regions import AllowedParts, AspectName, Lengths, Matrix, Span, aspects_of
from rpr_solver.modes.tolerant import Neighbours
from rpr_solver.notebook import counted
from rpr_solver.notebook.figure import Figure, Pictured, draw, shown_as_svg
from rpr_solver.paths import DecimalPose
from rpr_solver.paths.between_poses import (
    NoPath,
    Obstacle,
    checked_range,
    narrowed,
    pose_path,
    route_without_limits,
)
from rpr_solver.paths.boxes import Resolution
from rpr_solver.paths.path import Path
from rpr_solver.paths.path_poses import PathPose, legs_text, of_table
from rpr_solver.paths.proofs import BEST, NO_BOUNDS, PathLimits, outside
from rpr_solver.paths.question import End, Ends, PathOptions, PathTerms, document_lengths, span_json
from rpr_solver.paths.search import Outcome
from rpr_solver.paths.within_limits import LimitedSearch, Searches
from rpr_solver.singular.aspects import UnionFind


class ConnectionOptions(TypedDict, total=False):
    """What may be asked of all paths: options of a path."""

    limits: ExactLimits | None
    fixed_leg: int
    digits: int


@dataclass(frozen=True)
class PoseConnections(Pictured):
    """Which poses of one joint vector, or of two, are joined by paths without a singularity.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length is held in the slice.
        digits: significant digits of the angles.
        lengths: L1, L2 and L3 of one joint vector, or of both, exact, in the user's unit.
        between: the lengths between which the fixed leg may move; None if it is held.
        limits: the joint limits, by legs.
        poses: of the first joint vector, then of the second, in the order of their tables (:func:`poses`).
        signs: of J at each of them: 1, −1, 0 for a singular pose, None if it is too near one.
        matrix: for each pair of poses None if a path joins them within the limits, or both are the same pose;
            else why none does. Symmetric.
        resolution: where joint limits separate poses, or leave them undecided: the size of the smallest
            boxes of poses that were examined. None otherwise.
        near: for pairs of poses (their places, from 1) that limits leave undecided, a pose near which it is;
            not for each pair that follows from others.
        allowed: the parts of the allowed region, if they were asked for.
        clearance: how far, in degrees, the paths keep from singular poses.
        tolerance: how much each of the six lengths may be off; None if they are exact.
        clear: with one of both, for pairs of poses (their places, from 1) for which a path was found, its
            clearance in degrees.

    >>> from rpr_solver import EXAMPLES, pose_connections
    >>> pose_connections(EXAMPLES["innocenti"], 27, 20, 20)
    <PoseConnections of 4 poses of L1=27 L2=20 L3=20: 1-2, 3-4>
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    lengths: tuple[Lengths, ...]
    between: Span | None
    limits: Mapping[int, Bounds]
    poses: tuple[PathPose, ...]
    signs: tuple[int | None, ...]
    matrix: Matrix
    resolution: Resolution | None = None
    near: Mapping[tuple[int, int], DecimalPose] = field(default_factory=dict)
    allowed: AllowedParts | None = None
    clearance: Fraction = Fraction(0)
    tolerance: tuple[Fraction, ...] | None = None
    clear: Mapping[tuple[int, int], Fraction] = field(default_factory=dict)

    def __repr__(self) -> str:
        vectors = " and ".join(legs_text([exact_str(x) for x in lengths]) for lengths in self.lengths)
        groups = ", ".join("-".join(map(str, group)) for group in self.groups)
        return f"<PoseConnections of {counted(len(self.poses), 'pose')} of {vectors}: {groups or 'none'}>"

    @property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """The places of the poses, from 1, in groups: those of one group are joined.

        Poses of different groups are not, or it is undecided. Singular poses, those outside the limits, and
        those too near a singularity are in no group.
        """
        found = (
            tuple(place for place, obstacle in enumerate(row, 1) if obstacle is None) for row in self.matrix
        )
        return tuple(dict.fromkeys(group for group in found if group))

    def figure(self) -> Figure:
        """The matrix as a picture, poses that are joined beside each other."""
        return draw(self.to_json())

    def _repr_svg_(self) -> str | None:
        return shown_as_svg(self)

    def to_json(self) -> dict[str, Any]:
        """The document described at the top of this module."""
        leg = self.fixed_leg
        undecided = [{"poses": list(pair), "near": near.to_json(leg)} for pair, near in self.near.items()]
        return {
            **document_head(self.manipulator, self.digits, leg),
            **document_lengths(self.lengths[0] if len(self.lengths) == 1 else None),
            "between": span_json(self.between),
            "limits": limits_json(self.limits) or None,
            "poses": [
                {**pose.to_json(leg), "sign": sign} for pose, sign in zip(self.poses, self.signs, strict=True)
            ],
            "groups": [list(group) for group in self.groups],
            "matrix": [
                ["joined" if obstacle is None else obstacle.value for obstacle in row] for row in self.matrix
            ],
            "resolution": self.resolution and self.resolution.to_json(),
            **({"undecided": undecided} if undecided else {}),
            **({} if self.allowed is None else {"allowed": self.allowed.to_json(leg)}),
            **self._thresholds(),
        }

    def _thresholds(self) -> dict[str, Any]:
        """What is asked of clearance and tolerance, and the clearances of paths that were found, if so."""
        if not self.clearance and self.tolerance is None:
            return {}
        paths = [{"poses": list(pair), "clearance": exact_str(x)} for pair, x in self.clear.items()]
        return {**thresholds_json(self.clearance, self.tolerance), "paths": paths}


def pose_connections(
    manipulator: Manipulator,
    l1: Exact,
    l2: Exact,
    l3: Exact,
    *,
    to: Sequence[Exact] | None = None,
    between: tuple[Exact, Exact] | None = None,
    parts: bool = False,
    clearance: Exact | None = None,
    tolerance: Exact | Mapping[str, Exact] | None = None,
    **options: Unpack[ConnectionOptions],
) -> PoseConnections:
    """Which poses of a joint vector, or of two, are joined by paths without a singularity.

    For each pair of poses the answer is that of :func:`joint_path` or :func:`pose_path`, without the path.
    What the pairs share is done once: aspects, and the subdivision within joint limits. Since being joined is
    transitive, a pair may be decided here by others where it is undecided alone.

    Args:
        manipulator: the geometry.
        l1: the length of leg 1, exact, > 0, in the user's unit.
        l2: the length of leg 2.
        l3: the length of leg 3.
        to: L1, L2 and L3 of a second joint vector, whose poses are included; None for one alone.
        between: two lengths between which the fixed leg may move. None holds it, or lets it move between its
            lengths at both joint vectors.
        parts: whether the parts of the allowed region are counted, too: of all poses with J ≠ 0 in the slice
            or in the range that keep the limits (:class:`~rpr_solver.modes.AllowedParts`).
        clearance: how far, in degrees, > 0, a path must keep from singular poses; poses are joined if one is
            found that does, by way of other poses too, and not joined if it is proved that none does.
        tolerance: how much all lengths may be off, or single ones by their names, the others being exact: for
            every manipulator within it the paths must join the poses of the joint vectors.
        options: ``limits``, ``fixed_leg`` and ``digits``, as for paths.

    Raises:
        InputError: naming the argument at fault.
        SolverError: the singular curves of the slice are not supported.

    >>> from rpr_solver import EXAMPLES
    >>> pose_connections(EXAMPLES["innocenti"], 27, 20, 20, to=(30, 21, 19))
    <PoseConnections of 6 poses of L1=27 L2=20 L3=20 and L1=30 L2=21 L3=19: 1-2-5, 3-4-6>
    """
    for name in options.keys() - ConnectionOptions.__optional_keys__:
        raise InputError.of(name, "is an option of one path; leave it out")
    terms = PathTerms.of(**options)
    leg, digits, bounds = terms.leg, terms.digits, terms.bounds
    first = parse_all({"l1": l1, "l2": l2, "l3": l3}, parse_positive)
    vectors = [(first["l1"], first["l2"], first["l3"]), *([] if to is None else [_vector(to)])]
    if len(set(vectors)) < len(vectors):
        raise InputError.of("to", "is the same joint vector; leave it out")
    fixed = [lengths[leg - 1] for lengths in vectors]
    ends = min(fixed), max(fixed)
    own = None if ends[0] == ends[1] else ends
    span = own if between is None else checked_range(between, ends, leg)
    reader = Ends(manipulator, SliceMap.of(manipulator, leg), digits)
    places = [place for lengths in vectors for place in _places(reader, lengths, len(vectors) > 1)]
    pairs = _Pairs(reader.slice_map, bounds, span, places)
    matrix, resolution = pairs.matrix()
    named, signs = tuple(place.named for place in places), tuple(place.sign for place in places)
    head = manipulator, leg, digits, tuple(vectors)
    allowed = pairs.parts(fixed[0]) if parts else None
    matrix = allowed.decided(matrix) if allowed else matrix
    asked = Fraction(0) if clearance is None else parse_positive(clearance, "clearance")
    within = None if tolerance is None else changes(None, tolerance)
    if within is not None:
        check_margins(manipulator)
    clear: Mapping[tuple[int, int], Fraction] = {}
    if asked or within is not None:
        thresholds = _Thresholds(reader.slice_map, manipulator, bounds, span, places, asked, within)
        matrix, clear = thresholds.matrix(matrix)
    near = {(i + 1, k + 1): x for (i, k), x in pairs.near.items() if matrix[i][k] is Obstacle.UNDECIDED}
    found = PoseConnections(*head, span, bounds, named, signs, matrix, resolution, near, allowed)
    return replace(found, clearance=asked, tolerance=within, clear=clear)


def _vector(to: Sequence[Exact]) -> Lengths:
    if isinstance(to, str) or not isinstance(to, Sequence) or len(to) != 3:
        raise InputError.of("to", f"is {shown(to)}; give L1, L2 and L3")
    try:
        l1, l2, l3 = parse_all(dict(zip(("l1", "l2", "l3"), to, strict=True)), parse_positive).values()
    except InputError as error:
        raise InputError([FieldProblem(f"to.{p.field}", p.message) for p in error.problems]) from None
    return l1, l2, l3


@dataclass(frozen=True)
class _Place:
    """A pose of a joint vector: as documents have it, its lengths, the sign of J as for
    :class:`PoseConnections`, and the pose itself, None if it is not regular."""

    named: PathPose
    lengths: Lengths
    sign: int | None
    end: End | None


def _places(reader: Ends, lengths: Lengths, with_lengths: bool) -> Iterator[_Place]:
    """All poses of a joint vector."""
    table = poses(reader.manipulator, *lengths, digits=reader.digits)
    for number, pose in enumerate(table.poses, 1):
        named = of_table(table, number, reader.slice_map.fixed_leg)
        if with_lengths:
            l1, l2, l3 = map(exact_str, lengths)
            named = replace(named, lengths=(l1, l2, l3))
        if pose.multiplicity > 1:
            yield _Place(named, lengths, 0, None)
            continue
        try:
            end = reader.end_of(table, lengths, number)
        except Unproved:
            yield _Place(named, lengths, None, None)
        else:
            yield _Place(named, lengths, end.sign or None, end if end.sign else None)


def thresholds_json(clearance: Fraction, tolerance: tuple[Fraction, ...] | None) -> dict[str, Any]:
    """A clearance and a tolerance as documents have them, without what is not asked for."""
    found: dict[str, Any] = {"clearance": exact_str(clearance)} if clearance else {}
    if tolerance is not None:
        found["tolerance"] = {name: exact_str(x) for name, x in zip(LENGTHS, tolerance, strict=True)}
    return found


@dataclass(frozen=True)
class _Thresholds:
    """Pairs of poses that are joined, and by which paths they are so with a clearance, for all manipulators.

    Attributes:
        slice_map: of the manipulator and its fixed leg.
        manipulator: the given one.
        bounds: the joint limits.
        span: the lengths between which the fixed leg may move; None if it is held.
        places: the poses.
        clearance: in degrees; 0 for any.
        tolerance: of each length; None if they are exact.
    """

    slice_map: SliceMap
    manipulator: Manipulator
    bounds: Mapping[int, Bounds]
    span: Span | None
    places: Sequence[_Place]
    clearance: Fraction
    tolerance: tuple[Fraction, ...] | None

    def matrix(self, known: Matrix) -> tuple[Matrix, dict[tuple[int, int], Fraction]]:
        """The matrix with these thresholds, from that without, and the clearances of the paths.

        Being joined is transitive: paths follow one another.
        """
        classes = UnionFind(range(len(known)))
        words: dict[tuple[int, int], Obstacle] = {}
        clear: dict[tuple[int, int], Fraction] = {}
        for i, k in combinations(range(len(known)), 2):
            if known[i][k] is None:
                found = self._path(i, k)
                if isinstance(found, Path) and found.clearance is not None:
                    clear[i + 1, k + 1] = found.clearance.proved
                words[i, k] = self._judged(found)
                if words[i, k] is Obstacle.UNDECIDED and self._joins(found):
                    classes.join(i, k)

        def entry(i: int, k: int) -> Obstacle | None:
            word = known[i][k]
            if i == k or word not in (None, *self._changed):
                return word
            if word is not None:
                return (
                    word
                    if word is Obstacle.OPPOSITE_SIGNS and signs[i] * signs[k] < 0
                    else Obstacle.UNDECIDED
                )
            return None if classes.root(i) == classes.root(k) else words[min(i, k), max(i, k)]

        signs = [self._sign(place) for place in self.places]
        places = range(len(known))
        return tuple(tuple(entry(i, k) for k in places) for i in places), clear

    def _sign(self, place: _Place) -> int:
        """The sign of J at a pose, of all manipulators; 0 if it is not proved."""
        if place.end is None or self._around is None:
            return 0
        return self._around.sign_near(place.end.pose)

    @cached_property
    def _around(self) -> Neighbours | None:
        """All manipulators within the tolerance; None if there is none, or one of them is flat."""
        if self.tolerance is None:
            return None
        most = max(place.lengths[self.slice_map.fixed_leg - 1] for place in self.places)
        most = max(most, self.span[1] if self.span else most) * self.slice_map.scale
        return Neighbours.of(self.manipulator, self.slice_map, self.tolerance, most)

    @property
    def _changed(self) -> tuple[Obstacle, ...]:
        """What is proved of the given manipulator, and not of others: all but what lengths alone tell."""
        kept = Obstacle.UNDECIDED, Obstacle.OUTSIDE_LIMITS
        return () if self.tolerance is None else tuple(x for x in Obstacle if x not in kept)

    def _path(self, i: int, k: int) -> Path | NoPath | None:
        """The widest path that is found between two poses; None if none is proved."""
        ends = [self._asked(self.places[n]) for n in (i, k)]
        options = PathOptions(limits=self.bounds, fixed_leg=self.slice_map.fixed_leg, clearance=BEST)
        with suppress(InputError, SolverError):
            return pose_path(self.manipulator, *ends, between=self.span, **options)
        return None

    @staticmethod
    def _asked(place: _Place) -> dict[str, Any]:
        legs = {f"l{leg}": exact_str(x) for leg, x in enumerate(place.lengths, 1)}
        return {**legs, "pose": place.named.number}

    def _judged(self, found: Path | NoPath | None) -> Obstacle:
        """Why no path of all manipulators keeps the clearance, if none does."""
        if not isinstance(found, Path) or found.clearance is None or self.tolerance is not None:
            return Obstacle.UNDECIDED
        bound = found.clearance.bound
        return Obstacle.TOO_NARROW if bound is not None and bound < self.clearance else Obstacle.UNDECIDED

    def _joins(self, found: Path | NoPath | None) -> bool:
        """Whether a path keeps the clearance, for all manipulators."""
        if not isinstance(found, Path) or found.clearance is None or found.clearance.proved < self.clearance:
            return False
        if self.tolerance is None:
            return True
        around = self._around
        return around is not None and around.joins(found.route, found.sign, self.bounds, self.clearance)


@dataclass(frozen=True)
class _Pairs:
    """The pairs of poses, and what may be asked of all.

    Attributes:
        slice_map: of the manipulator and its fixed leg.
        bounds: the joint limits, in the user's unit.
        span: the lengths between which the fixed leg may move, in the user's unit; None if it is held.
        places: the poses.
        searches: the subdivisions within limits.
        resolutions: of those that did not join two poses.
        near: pairs that were undecided alone, with a pose near which they were.
    """

    slice_map: SliceMap
    bounds: Mapping[int, Bounds]
    span: Span | None
    places: Sequence[_Place]
    searches: Searches = field(default_factory=dict)
    resolutions: list[Resolution] = field(default_factory=list)
    near: dict[tuple[int, int], DecimalPose] = field(default_factory=dict)

    def matrix(self) -> tuple[Matrix, Resolution | None]:
        """Whether each pair is joined, and the size of the smallest boxes that were examined.

        Raises:
            SolverError: the singular curves of the slice are not supported.
        """
        alone, ends = [self._alone(place) for place in self.places], self.ends
        names = aspects_of(self.slice_map, self.free, ends)
        found: dict[tuple[int, int], Obstacle | None] = {}
        open_pairs: dict[tuple[int, int], bool] = {}
        has_walls = bool(PathLimits.of(self.slice_map, self.bounds).walls)
        for i, k in combinations(ends, 2):
            own = _without_limits((ends[i], ends[k]), (names.get(i), names.get(k)))
            if has_walls and own in (None, Obstacle.UNDECIDED):
                open_pairs[i, k] = own is None
            else:
                found[i, k] = own
        found |= self._within_limits(ends, open_pairs)

        def entry(i: int, k: int) -> Obstacle | None:
            own = max(filter(None, (alone[i], alone[k])), key=_ALONE.index, default=None)
            return own or (None if i == k else found[min(i, k), max(i, k)])

        places = range(len(self.places))
        matrix = tuple(tuple(entry(i, k) for k in places) for i in places)
        return matrix, min(self.resolutions, key=lambda size: size.angle_deg, default=None)

    def _alone(self, place: _Place) -> Obstacle | None:
        """What is wrong with a pose, whatever the other one is."""
        if place.sign == 0:
            return Obstacle.SINGULAR_POSE
        if outside(self.bounds, place.lengths):
            return Obstacle.OUTSIDE_LIMITS
        return Obstacle.UNDECIDED if place.end is None else None

    def parts(self, length: Fraction) -> AllowedParts:
        """The parts of the allowed region, and which poses are in them; the length is that of a slice."""
        held = next((end.length for end in self.ends.values()), length)
        ends = {k + 1: end for k, end in self.ends.items()}
        return AllowedParts.of(self.slice_map, self.bounds, self.free or (held, held), ends)

    @cached_property
    def ends(self) -> dict[int, End]:
        """The regular poses within the limits, by their numbers, from 0."""
        return {k: x.end for k, x in enumerate(self.places) if x.end is not None and self._alone(x) is None}

    @cached_property
    def free(self) -> Span | None:
        """The lengths between which the fixed leg may move within its own limits."""
        return narrowed(self.span, self.bounds.get(self.slice_map.fixed_leg, NO_BOUNDS))

    def _within_limits(
        self, ends: Mapping[int, End], open_pairs: Mapping[tuple[int, int], bool]
    ) -> dict[tuple[int, int], Obstacle | None]:
        """Whether limits separate pairs of poses, each with whether both are known to be in one aspect."""
        classes = UnionFind(ends)
        apart: list[tuple[int, int]] = []

        def are_apart(pair: tuple[int, int]) -> bool:
            sides = {classes.root(k) for k in pair}
            return any({classes.root(k) for k in other} == sides for other in apart)

        for pair, is_same in open_pairs.items():
            if classes.root(pair[0]) != classes.root(pair[1]) and not are_apart(pair):
                answer = self._is_joined(ends, pair, is_same)
                if answer:
                    classes.join(*pair)
                elif answer is not None:
                    apart.append(pair)
        return {
            pair: None
            if classes.root(pair[0]) == classes.root(pair[1])
            else Obstacle.SEPARATED_BY_LIMITS
            if are_apart(pair)
            else Obstacle.UNDECIDED
            for pair in open_pairs
        }

    def _is_joined(self, known: Mapping[int, End], pair: tuple[int, int], is_same: bool) -> bool | None:
        """Whether a path within the limits joins two poses; None if that is undecided."""
        ends, sign = (known[pair[0]].pose, known[pair[1]].pose), known[pair[0]].sign
        limited = LimitedSearch.of(*ends, sign, self.bounds, self.free)
        limited = replace(limited, searches=self.searches)
        with suppress(Unproved):
            outcome = limited.found(None)
            if not isinstance(outcome, Outcome):
                return True
            self.resolutions.append(limited.resolution(outcome))
            if outcome.is_separated:
                return False
            if near := limited.near(outcome):
                self.near[pair] = near
        if is_same:
            # what is too narrow for boxes may have room for the route without limits
            with suppress(SolverError):
                route = route_without_limits(ends, sign, None if self.free is None else limited.span)
                if not isinstance(route, Obstacle) and limited.kept(route):
                    return True
        return None


def _without_limits(
    ends: tuple[End, End], names: tuple[AspectName | None, AspectName | None]
) -> Obstacle | None:
    """Why no path joins two regular poses, joint limits apart; None if one does."""
    first, last = names
    if ends[0].sign != ends[1].sign:
        return Obstacle.OPPOSITE_SIGNS
    if first is None or last is None:
        return Obstacle.UNDECIDED
    if first == last:
        return None
    return Obstacle.OTHER_ASPECT if first.are_apart(last) else Obstacle.UNDECIDED


_ALONE = (Obstacle.UNDECIDED, Obstacle.OUTSIDE_LIMITS, Obstacle.SINGULAR_POSE)
"""What is wrong with poses, the strongest last."""
