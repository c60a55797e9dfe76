"""Poses along a leg: two lengths are given, and how many poses there are at each length of the third leg.

The document of :meth:`LegPoses.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "digits": 90, "solver_version": "…",
     "moving_leg": 2, "l1": "5", "l2": {"from": "0", "to": "12"}, "l3": "3",
     "ends": [{"l2": "4.5…", "kind": "fold",
               "poses": [{"alpha_deg": "…", "theta1_deg": "…", "theta2_deg": "…", "theta3_deg": "…",
                          "b1_x": "…", "b1_y": "…"}]}, …],
     "intervals": [{"from": "0", "to": "4.5…", "count": 0, "at": "2", "poses": []},
                   {"from": "4.5…", "to": "6.1…", "count": 2, "at": "5.3",
                    "poses": [{"alpha_deg": "…", …, "sign": 1, "aspect": 1}, …]}, …]}

Intervals have no singular pose inside, so that the number of poses, the sign of J and the aspect of each hold
throughout; ``poses`` are those at ``at``, an exact length inside. Of an end, ``poses`` are the singular
ones; where the moving leg has length 0, it has no angle. Where base or platform were given by points, all
poses have ``x``, ``y`` and ``phi_deg``. ``sign`` and ``aspect`` are null where they could not be decided.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from math import radians, sin
from typing import Any

from flint import arb, ctx

from rpr_solver.along.fold_poses import FoldPose
from rpr_solver.along.folds import Fold, folds
from rpr_solver.contract import DEFAULT_DIGITS, check_digits, document_head
from rpr_solver.errors import InputError, SolverError, Unproved
from rpr_solver.exact import decided
from rpr_solver.exact.decimals import digit_bits, round_all, round_fraction, rounded_near
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.rationals import Exact, exact_str, parse_all, parse_positive, short_between
from rpr_solver.exact.real_roots import ball_of, fraction_of
from rpr_solver.model.joint_points import free_legs
from rpr_solver.model.lengths import LengthRange
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.pose_table import PlatformPose, PoseTable, poses
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.modes.joined_regions import Aspects
from rpr_solver.notebook import Row, counted, csv_text, html_table, shortened, with_floats
from rpr_solver.notebook.figure import Figure, Pictured, draw
from rpr_solver.paths.joint_paths import sign_of
from rpr_solver.paths.path_poses import isolated
from rpr_solver.paths.proofs import PROOF_BITS
from rpr_solver.slices.shared_joints import line_at
from rpr_solver.triangles import UserFrame
from rpr_solver.triangles.triangle import SIDES

_FIRST_BITS = 128
_LEAST_SINE = 1e-9
"""Sines from angles of 15 digits have smaller errors."""
_NAMES = ("l1", "l2", "l3")


class EndKind(StrEnum):
    """What is singular at an end of intervals.

    >>> EndKind("fold")
    <EndKind.FOLD: 'fold'>
    """

    FOLD = "fold"
    """One pose at which two merge."""
    CLOSED_LEG = "closed-leg"
    """The moving leg has length 0."""
    DEGENERATE = "degenerate"
    """Several singular poses, or one of a higher kind."""


@dataclass(frozen=True)
class LegEnd:
    """A length of the moving leg at which poses are singular.

    Attributes:
        length: the length, correctly rounded.
        kind: what is singular.
        poses: the singular poses by α: their coordinates by the names of :class:`PlatformPose`, correctly
            rounded; where the moving leg has length 0, without its angle. Of a whole circle of poses, as
            congruent triangles have one, none is listed.

    >>> LegEnd("4.5", EndKind.FOLD, ())
    <LegEnd 4.5: fold>
    """

    length: str
    kind: EndKind
    poses: tuple[Mapping[str, str], ...]

    def __repr__(self) -> str:
        return f"<LegEnd {shortened(self.length)}: {self.kind.value}>"


@dataclass(frozen=True)
class LegInterval:
    """Lengths of the moving leg between which no pose is singular.

    Attributes:
        start, stop: its ends: exact if they are those of the range, else correctly rounded; None is no end.
        at: a length inside, exact.
        poses: the poses there.
        signs: the sign of J of each, throughout the interval; None if it could not be decided.
        aspects: the aspect in which each of them is, by numbers from 1 in the slice of the first held leg, so
            that a path joins two poses within the slice exactly if their numbers are equal; None as above.

    >>> LegInterval("0", "4.5", "2", (), (), ())
    <LegInterval from 0 to 4.5: 0 poses>
    """

    start: str
    stop: str | None
    at: str
    poses: tuple[PlatformPose, ...]
    signs: tuple[int | None, ...]
    aspects: tuple[int | None, ...]

    def __repr__(self) -> str:
        end = "" if self.stop is None else f" to {shortened(self.stop)}"
        return f"<LegInterval from {shortened(self.start)}{end}: {counted(self.count, 'pose')}>"

    @property
    def count(self) -> int:
        """The number of poses."""
        return len(self.poses)

    def to_json(self) -> dict[str, Any]:
        """The document's interval object."""
        named = zip(self.poses, self.signs, self.aspects, strict=True)
        listed = [{**pose.to_json(), "sign": sign, "aspect": aspect} for pose, sign, aspect in named]
        return {"from": self.start, "to": self.stop, "count": self.count, "at": self.at, "poses": listed}


@dataclass(frozen=True)
class LegPoses(Pictured):
    """The numbers of poses while one leg moves and two keep their lengths.

    Proved: the ends are all lengths in the range at which a pose is singular, each digit is right, and so is
    every number of poses.

    Attributes:
        manipulator: the geometry.
        moving_leg: the leg whose length varies.
        lengths: those of both others, by name, exact.
        range: the lengths of the moving leg.
        digits: significant digits of every printed number.
        ends: the lengths with singular poses, ascending.
        intervals: what is between them.

    >>> from rpr_solver import EXAMPLES, leg_poses
    >>> leg_poses(EXAMPLES["zein-flat"], {"l1": 17, "l3": 15}, digits=15)
    <LegPoses of L2 from 0, L1=17 L3=15: 0, 2, 0 poses>
    """

    manipulator: Manipulator
    moving_leg: int
    lengths: Mapping[str, Fraction]
    range: LengthRange
    digits: int
    ends: tuple[LegEnd, ...]
    intervals: tuple[LegInterval, ...]

    def __repr__(self) -> str:
        held = " ".join(f"{name.upper()}={shortened(exact_str(x))}" for name, x in self.lengths.items())
        counts = ", ".join(str(interval.count) for interval in self.intervals)
        return f"<LegPoses of L{self.moving_leg} {self.range}, {held}: {counts} poses>"

    def to_json(self) -> dict[str, Any]:
        """The document described at the top of this module."""
        moving = f"l{self.moving_leg}"
        legs = {**{name: exact_str(x) for name, x in self.lengths.items()}, moving: self.range.to_json()}
        ends = [
            {moving: end.length, "kind": end.kind.value, "poses": [dict(pose) for pose in end.poses]}
            for end in self.ends
        ]
        return {
            **document_head(self.manipulator, self.digits),
            "moving_leg": self.moving_leg,
            **{name: legs[name] for name in _NAMES},
            "ends": ends,
            "intervals": [interval.to_json() for interval in self.intervals],
        }

    def rows(self) -> list[Row]:
        """A row for each interval, for ``pandas.DataFrame(found.rows())``; lengths are floats."""
        return with_floats({"from": x.start, "to": x.stop, "count": x.count} for x in self.intervals)

    def figure(self) -> Figure:
        """A picture of the number of poses against the length of the moving leg.

        Narrow intervals are widened and marked; a fan of lines leads to an axis that is true to scale.

        Raises:
            InputError: the lengths are too large to be drawn.
        """
        return draw(self.to_json())

    def _repr_html_(self) -> str:
        rows = [{"from": x.start, "to": x.stop or "", "poses": str(x.count)} for x in self.intervals]
        return html_table(repr(self)[1:-1], rows, [], first=self.manipulator.remark)


def leg_poses(
    manipulator: Manipulator,
    lengths: Mapping[str, Exact],
    start: Exact | None = None,
    stop: Exact | None = None,
    *,
    digits: int = DEFAULT_DIGITS,
) -> LegPoses:
    """The numbers of poses at all lengths of one leg, while two legs keep theirs.

    Args:
        manipulator: the geometry.
        lengths: two lengths by the names of their legs, exact, > 0, in the user's unit:
            ``{"l1": 5, "l3": 3}``.
        start: the least length of the third leg, exact; 0 or None is an open end.
        stop: its greatest length; None is an open end.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: naming ``manipulator``, ``lengths``, ``start``, ``stop`` or ``digits``.
        SolverError: the length of the third leg is the same along a whole curve of poses, or the poses could
            not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> found = leg_poses(EXAMPLES["innocenti"], {"l1": 17, "l3": 15}, 10, 20, digits=15)
    >>> [(x.count, x.start) for x in found.intervals]
    [(2, '10'), (4, '11.0573535481772'), (6, '11.7786325277852'), (4, '18.5556714758269')]
    """
    digits, held = check_digits(digits), held_lengths(lengths)
    span = LengthRange.of(start, stop)
    [moving] = (leg for leg, name in enumerate(_NAMES, 1) if name not in held)
    (first, own), (_, other) = held.items()
    slice_map = SliceMap.of(manipulator, _NAMES.index(first) + 1, with_shared=True)
    which = free_legs(slice_map.fixed_leg).index(moving)
    scale = slice_map.scale
    found = folds(slice_map, which, ((own * scale) ** 2, (other * scale) ** 2))
    inside = [fold for fold in found if _is_inside(fold, span, scale)]
    along = _Along(manipulator, slice_map, moving, held, digits)
    intervals = along.intervals(inside, span)
    return LegPoses(manipulator, moving, held, span, digits, along.ends(inside), intervals)


def held_lengths(lengths: Mapping[str, Exact]) -> dict[str, Fraction]:
    """The lengths of two legs, exact, by their names in order.

    Raises:
        InputError: naming ``lengths``, or a length that is not an exact number > 0.

    >>> held_lengths({"l3": 3, "l1": "5.5"})
    {'l1': Fraction(11, 2), 'l3': Fraction(3, 1)}
    """
    if not isinstance(lengths, Mapping) or len(lengths) != 2 or not set(lengths) < set(_NAMES):
        raise InputError.of("lengths", "must have two of l1, l2 and l3")
    return dict(sorted(parse_all(dict(lengths), parse_positive).items()))


def poses_csv(document: Mapping[str, Any]) -> str:
    """The document of poses as CSV: a line for each pose; of poses along a leg, a line for each interval.

    Those with angles of legs have all lengths, and by how much further angles are off.

    >>> from rpr_solver import EXAMPLES
    >>> found = leg_poses(EXAMPLES["zein-flat"], {"l1": 17, "l3": 15}, digits=15)
    >>> print(poses_csv(found.to_json()).replace("\\r", ""), end="")
    from,to,count,at
    0,11.8847650960032,0,5
    11.8847650960032,46.6647725256986,2,29
    46.6647725256986,,0,70
    """
    if "intervals" in document:
        return csv_text(("from", "to", "count", "at"), document["intervals"])
    names = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg", "b1_x", "b1_y")
    rows = document["poses"]
    asked = ("condition", "clearance_deg") if "condition" in document else ()
    given = ("x", "y", "phi_deg") if any("x" in pose for pose in rows) else ()
    if "sensed" not in document:
        return csv_text((*names, "multiplicity", *asked, *given), rows)
    rows = [{**pose, **{f"off_{name}": text for name, text in pose["off_deg"].items()}} for pose in rows]
    off = [f"off_{name}" for name in document["sensed"] if name not in document["solved_from"]]
    return csv_text((*names, *_NAMES, *given, *off), rows)


def _is_inside(fold: Fold, span: LengthRange, scale: Fraction) -> bool:
    low, high = span.start * scale, None if span.stop is None else span.stop * scale
    return fold.compared(low**2) >= 0 and (high is None or fold.compared(high**2) <= 0)


@dataclass(frozen=True)
class _Along:
    """What ends and intervals are made from."""

    manipulator: Manipulator
    slice_map: SliceMap
    moving: int
    held: Mapping[str, Fraction]
    digits: int

    def intervals(self, inside: Sequence[Fold], span: LengthRange) -> tuple[LegInterval, ...]:
        """The intervals between folds and the ends of the range, ascending."""
        low: list[_Bound] = [_Exact(span.start), *(self._bound(fold) for fold in inside)]
        high = [*low[1:], None if span.stop is None else _Exact(span.stop)]
        aspects = self._aspects()
        names: dict[Hashable, int] = {}
        found = []
        for start, stop in zip(low, high, strict=True):
            if stop is not None and start.is_same(stop):
                continue
            at = _inside(start, stop)
            table = poses(self.manipulator, *self._lengths(at), digits=self.digits)
            known = [self._known(table, at, number, aspects, names) for number in range(1, table.count + 1)]
            ends = start.text(self.digits), None if stop is None else stop.text(self.digits)
            signs, places = (tuple(column) for column in zip(*known, strict=True)) if known else ((), ())
            found.append(LegInterval(*ends, exact_str(at), table.poses, signs, places))
        return tuple(found)

    def ends(self, inside: Sequence[Fold]) -> tuple[LegEnd, ...]:
        """The ends, with what is singular there."""
        return tuple(
            LegEnd(self._bound(fold).text(self.digits), self._kind(fold), self._singular(fold))
            for fold in inside
        )

    def _singular(self, fold: Fold) -> tuple[Mapping[str, str], ...]:
        is_closed = self._kind(fold) is EndKind.CLOSED_LEG
        frame = UserFrame.of(self.manipulator.geometry)
        places = (FoldPose(fold.four_bar, self.moving, place, is_closed) for place in fold.places)
        found = [place.texts(self.digits, frame) for place in places]
        return tuple(sorted(found, key=lambda pose: [float(pose[name]) for name in ("alpha_deg", "b1_x")]))

    def _kind(self, fold: Fold) -> EndKind:
        if fold.compared(Fraction(0)) == 0:
            return EndKind.CLOSED_LEG
        return EndKind.FOLD if fold.is_simple else EndKind.DEGENERATE

    def _bound(self, fold: Fold) -> _Bound:
        return _Exact(Fraction(0)) if fold.compared(Fraction(0)) == 0 else _Root(fold, self.slice_map.scale)

    def _lengths(self, at: Fraction) -> tuple[Fraction, Fraction, Fraction]:
        l1, l2, l3 = ({**self.held, f"l{self.moving}": at}[name] for name in _NAMES)
        return l1, l2, l3

    def _aspects(self) -> Aspects | None:
        length = self.held[f"l{self.slice_map.fixed_leg}"]
        try:
            return Aspects.of(self.slice_map, (length, length))
        except SolverError:
            return None

    def _known(
        self,
        table: PoseTable,
        at: Fraction,
        number: int,
        aspects: Aspects | None,
        names: dict[Hashable, int],
    ) -> tuple[int | None, int | None]:
        """The sign of J at a pose, and the number of its aspect."""
        leg = self.slice_map.fixed_leg
        lengths = self._lengths(at)
        fixed, first, second = (lengths[k - 1] * self.slice_map.scale for k in (leg, *free_legs(leg)))
        try:
            with ctx.workprec(PROOF_BITS):
                pose = isolated(self.slice_map, (fixed, first, second), table, number)
            sign = sign_of(pose) or None
            name = None
            if aspects is not None and sign is not None:
                name = aspects.name(pose)
            elif self.manipulator.geometry.shared_joints:
                name = self._areas(table.poses[number - 1])
        except Unproved:
            return None, None
        return sign, None if name is None else names.setdefault(name, len(names) + 1)

    def _areas(self, pose: PlatformPose) -> Hashable | None:
        """The signs of K and K′, which tell the aspects apart where legs share a joint
        (mathematics.md#shared-joints); None in a slice that may have others, or if decimals do not decide."""
        slice_map, geometry = self.slice_map, self.manipulator.geometry
        if line_at(slice_map, self.held[f"l{slice_map.fixed_leg}"] * slice_map.scale):
            return None
        of_base = geometry.base.shared
        side = of_base if of_base is not None else geometry.platform.shared
        assert side is not None, "legs share a joint"
        angles = [radians(float(x)) for x in (pose.theta1_deg, pose.theta2_deg, pose.theta3_deg)]
        first, second = SIDES[side]
        third = angles[3 - first - second] - (0.0 if of_base is not None else radians(float(pose.alpha_deg)))
        areas = sin(angles[second] - angles[first]), sin(third)
        return None if min(map(abs, areas)) < _LEAST_SINE else tuple(x > 0 for x in areas)


@dataclass(frozen=True)
class _Exact:
    """An end that is a rational length."""

    length: Fraction

    def ball(self, bits: int) -> arb:
        """The length."""
        with ctx.workprec(bits):
            return ball_of(self.length)

    def text(self, _digits: int) -> str:
        """The length as in documents."""
        return exact_str(self.length)

    def is_same(self, other: _Bound) -> bool:
        """Whether another end, not less, is equal."""
        if isinstance(other, _Exact):
            return self.length == other.length
        return other.fold.compared((self.length * other.scale) ** 2) == 0


@dataclass(frozen=True)
class _Root:
    """An end at a fold, not 0."""

    fold: Fold
    scale: Fraction

    def ball(self, bits: int) -> arb:
        """The length."""
        square = self.fold.square(bits)
        with ctx.workprec(bits):
            return square.sqrt() / ball_of(self.scale)

    def text(self, digits: int) -> str:
        """The length, correctly rounded."""
        start = digit_bits(digits) + _FIRST_BITS

        def rounded(bits: int) -> str | None:
            with ctx.workprec(bits):
                texts = round_all([self.ball(bits)], digits)
            return None if texts is None else texts[0]

        if text := rounded(start):
            return text
        # the length may be half way between two decimals, so that it has one digit more
        exact = rounded_near(fraction_of(self.ball(start).mid()), digits + 1)
        if self.fold.compared((exact * self.scale) ** 2) == 0:
            return round_fraction(exact, digits)
        return decided(rounded, start, GREATEST_BITS, "the digits of a length could not be decided")

    def is_same(self, other: _Bound) -> bool:
        """Whether another end, not less, is equal."""
        return isinstance(other, _Exact) and self.fold.compared((other.length * self.scale) ** 2) == 0


_Bound = _Exact | _Root


def _ends(x: arb, bits: int) -> tuple[Fraction, Fraction]:
    with ctx.workprec(2 * bits):
        return fraction_of(x.lower()), fraction_of(x.upper())


def _inside(start: _Bound, stop: _Bound | None) -> Fraction:
    """A length with few digits between two that differ."""

    def between(bits: int) -> Fraction | None:
        low = _ends(start.ball(bits), bits)[1]
        high = 2 * low + 1 if stop is None else _ends(stop.ball(bits), bits)[0]
        return short_between(low, high) if low < high else None

    return decided(between, _FIRST_BITS, GREATEST_BITS, "two lengths could not be told apart")
