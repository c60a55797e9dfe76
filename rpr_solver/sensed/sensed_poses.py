"""Poses from lengths and angles of legs, at least three data: what sensors at the joints say.

The document of :meth:`SensedPoses.to_json`::

    {"geometry": {…}, "geometry_hash": "sha256:…", "digits": 15, "solver_version": "…",
     "sensed": {"l1": "15", "angle2": "30", "angle3": "45.5"}, "angle_tolerance_deg": null,
     "solved_from": ["l1", "angle2", "angle3"], "count": 2,
     "poses": [{"alpha_deg": "…", "theta1_deg": "…", "theta2_deg": "…", "theta3_deg": "…",
                "b1_x": "…", "b1_y": "…", "l1": "…", "l2": "…", "l3": "…", "off_deg": {}}, …],
     "others": [], "disagree": [], "is_curve": false}

The angle of a leg is that of the vector from its base joint A to its platform joint B, from the x-axis of
the frame of the base: of the points by which this was given, else of the article; ``angle1`` and so on are in
that frame, ``theta1_deg`` is in the article's always. Three data are solved exactly; the angles beyond these,
which are measured, must agree within the tolerance: ``off_deg`` is by how much each pose's differ from them.
``others`` are poses that do not agree, and ``disagree`` the angles with which none does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any

from flint import arb, ctx

from rpr_solver.contract import DEFAULT_DIGITS, LEGS, check_digits, check_type, document_head
from rpr_solver.errors import FieldProblem, InputError, Unproved
from rpr_solver.exact.decimals import angle_text
from rpr_solver.exact.precision import precisions
from rpr_solver.exact.rationals import Exact, exact_or_none, exact_str, parse_all, parse_exact, parse_positive
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.given_poses import (
    IN_GIVEN_FRAME,
    digits_before,
    enclosed,
    placed,
    settled,
    working_bits,
)
from rpr_solver.model.jets import direction
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.pose_table import poses
from rpr_solver.notebook import Row, counted, html_table, shortened, with_floats
from rpr_solver.notebook.figure import Figure, Pictured, draw
from rpr_solver.sensed.angles import ANGLES, LEAST, read_tolerance
from rpr_solver.sensed.closure import Candidate, Curve, Legs, Pair, candidates
from rpr_solver.sensed.reals import GREATEST_BITS, Reals
from rpr_solver.triangles import UserFrame
from rpr_solver.triangles.surds import Surd
from rpr_solver.workspaces.tower import Open

_FIRST_BITS = 128
_OFF_DIGITS = 6
"""Significant digits of differences of angles."""


@dataclass(frozen=True)
class SensedPose:
    """A pose that fulfils three data.

    Attributes:
        texts: its coordinates by the names of documents, correctly rounded.
        off_deg: angle that was not used → by how much the pose's differs from it, in degrees.

    >>> SensedPose({"alpha_deg": "12.5"}, {})
    <SensedPose alpha_deg=12.5>
    """

    texts: Mapping[str, str]
    off_deg: Mapping[str, str]

    def __repr__(self) -> str:
        return f"<SensedPose alpha_deg={shortened(self.texts['alpha_deg'])}>"

    def to_json(self) -> dict[str, Any]:
        """The document's pose object."""
        return {**self.texts, "off_deg": dict(self.off_deg)}


@dataclass(frozen=True)
class SensedPoses(Pictured):
    """All poses with given lengths and angles of legs.

    Proved: with the data in ``solved_from`` there are these poses and no other, and each digit is right.

    Attributes:
        manipulator: the geometry.
        sensed: lengths, and angles in degrees, by name, exact.
        tolerance: how far angles beyond three data may be off, in degrees; None if there are none.
        digits: significant digits of every printed number.
        solved_from: the three data from which poses were found.
        poses: those that agree with all data, by α.
        others: those that fulfil the three data, but disagree with an angle.
        disagree: the angles with which no pose agrees.
        is_curve: whether a whole curve of poses fulfils the data, so that none is listed.

    >>> from rpr_solver import EXAMPLES, sensed_poses
    >>> sensed_poses(EXAMPLES["innocenti"], {"l1": 15}, {"angle1": 40, "angle2": 150}, digits=15)
    <SensedPoses l1=15 angle1=40 angle2=150: 1 pose>
    """

    manipulator: Manipulator
    sensed: Mapping[str, Fraction]
    tolerance: Fraction | None
    digits: int
    solved_from: tuple[str, ...]
    poses: tuple[SensedPose, ...]
    others: tuple[SensedPose, ...]
    disagree: tuple[str, ...]
    is_curve: bool = False

    def __repr__(self) -> str:
        given = " ".join(f"{name}={shortened(exact_str(x))}" for name, x in self.sensed.items())
        found = "a curve of poses" if self.is_curve else counted(len(self.poses), "pose")
        return f"<SensedPoses {given}: {found}>"

    def to_json(self) -> dict[str, Any]:
        """The document described at the top of this module."""
        return {
            **document_head(self.manipulator, self.digits),
            "sensed": {name: exact_str(x) for name, x in self.sensed.items()},
            "angle_tolerance_deg": exact_or_none(self.tolerance),
            "solved_from": list(self.solved_from),
            "count": len(self.poses),
            "poses": [pose.to_json() for pose in self.poses],
            "others": [pose.to_json() for pose in self.others],
            "disagree": list(self.disagree),
            "is_curve": self.is_curve,
        }

    def rows(self) -> list[Row]:
        """A row for each pose, for ``pandas.DataFrame(found.rows())``; lengths and angles are floats."""
        return with_floats(pose.texts for pose in self.poses)

    def figure(self, pose: int = 1) -> Figure:
        """A picture of the manipulator at one pose, with the other poses behind it.

        Args:
            pose: the number of the pose, from 1.

        Raises:
            InputError: naming ``pose``: there is no such pose.
        """
        return draw(self.to_json(), pose=pose)

    def _repr_html_(self) -> str:
        rows = [dict(pose.texts) for pose in self.poses]
        return html_table(repr(self)[1:-1], rows, [], first=self.manipulator.remark)


def sensed_poses(
    manipulator: Manipulator,
    lengths: Mapping[str, Exact],
    angles: Mapping[str, Exact],
    *,
    angle_tolerance_deg: Exact | None = None,
    digits: int = DEFAULT_DIGITS,
) -> SensedPoses:
    """All poses with given lengths and angles of legs, together at least three.

    Args:
        manipulator: the geometry.
        lengths: the lengths of legs by name, exact, > 0: ``{"l1": 15}``.
        angles: the angles of legs in degrees, exact: ``{"angle1": 40, "angle2": 150}``; each is that of the
            vector from A to B, in the frame of the base's points, or of the article.
        angle_tolerance_deg: in degrees, exact: how far the angles beyond three data may be off. Lengths count
            first, then angles, in the order of the legs.
        digits: significant digits of every printed number, 15 to 10000; all are proved.

    Raises:
        InputError: naming ``lengths``, ``angles``, ``angle_tolerance_deg`` or ``digits``.
        SolverError: two poses, or whether an angle agrees, could not be decided.

    >>> from rpr_solver import EXAMPLES
    >>> found = sensed_poses(EXAMPLES["innocenti"], {"l1": "14.98", "l2": 15}, {"angle3": 20}, digits=15)
    >>> [pose.texts["l3"] for pose in found.poses]
    ['8.58576925924079', '1.14241475930240', '30.7706213925699', '21.5886468632198']
    """
    check_type(manipulator, Manipulator, "manipulator")
    digits = check_digits(digits)
    sensed = read_sensed(lengths, angles)
    extra = len(sensed) - LEAST
    tolerance = read_tolerance(angle_tolerance_deg, is_needed=extra > 0)
    asked = _Question(manipulator, sensed, tolerance, digits)
    for names in combinations(sensed, LEAST):
        if any(name in LEGS for name in sensed if name not in names):
            continue  # lengths are exact, and not compared
        try:
            return asked.answer(names)
        except Curve:
            continue
    return SensedPoses(
        manipulator, sensed, tolerance, digits, tuple(sensed)[:LEAST], (), (), (), is_curve=True
    )


def read_sensed(lengths: Mapping[str, Exact], angles: Mapping[str, Exact]) -> dict[str, Fraction]:
    """Lengths, then angles in degrees, by name in the order of legs.

    Raises:
        InputError: naming what is unknown or invalid, or ``angles`` if there are fewer than three data.

    >>> read_sensed({"l2": 5}, {"angle3": "7.5", "angle1": 0})
    {'l2': Fraction(5, 1), 'angle1': Fraction(0, 1), 'angle3': Fraction(15, 2)}
    """
    wrong = [("lengths", lengths, LEGS), ("angles", angles, ANGLES)]
    for field, given, names in wrong:
        if unknown := [name for name in given if name not in names]:
            raise InputError.of(field, f"has {unknown[0]!r}; known are {', '.join(names)}")
    own = parse_all({name: lengths[name] for name in LEGS if name in lengths}, parse_positive)
    turns = parse_all({name: angles[name] for name in ANGLES if name in angles}, parse_exact)
    if far := [name for name, angle in turns.items() if abs(angle) > 360]:
        raise InputError([FieldProblem(name, "is beyond a turn; give -360 to 360 degrees") for name in far])
    if len(own) + len(turns) < LEAST:
        raise InputError.of(
            "angles", f"make {len(own) + len(turns)} data with the lengths; a pose needs three"
        )
    return {**own, **turns}


@dataclass(frozen=True)
class _View:
    """A pose in balls, in the frame of the article: cos α and sin α, B1, and the vectors of the legs."""

    turned: Pair
    b1: Pair
    legs: tuple[Pair, Pair, Pair]


@dataclass(frozen=True)
class _Question:
    """What is asked."""

    manipulator: Manipulator
    sensed: Mapping[str, Fraction]
    tolerance: Fraction | None
    digits: int

    def answer(self, names: Sequence[str]) -> SensedPoses:
        """The poses with three of the data, compared with the others.

        Raises:
            Curve: there is a whole curve of them.
        """
        legs = self._legs(names)
        found: Sequence[Any] = self._by_lengths() if not legs.turns else candidates(legs)
        turns = {name: int(name[-1]) for name in names if name in ANGLES}
        right = [one for one in found if all(self._has_sense(legs, one, leg) for leg in turns.values())]
        rest = [name for name in self.sensed if name not in names]
        judged = [(one, {name: self._agrees(legs, one, name) for name in rest}) for one in right]
        shown = {id(one): self._pose(legs, one, rest) for one, _ in judged}
        good = [shown[id(one)] for one, verdicts in judged if all(verdicts.values())]
        bad = [shown[id(one)] for one, verdicts in judged if not all(verdicts.values())]
        disagree = [name for name in rest if judged and not any(verdicts[name] for _, verdicts in judged)]
        return SensedPoses(
            self.manipulator,
            self.sensed,
            self.tolerance,
            self.digits,
            tuple(names),
            tuple(sorted(good, key=_order)),
            tuple(sorted(bad, key=_order)),
            tuple(disagree),
        )

    def _legs(self, names: Sequence[str]) -> Legs:
        """What three data say; the unit vectors of all angles, in the article's frame."""
        geometry = self.manipulator.geometry
        zero, (a2x, a3x, a3y, *_), triangle = Surd.of(0), geometry.lengths, geometry.platform
        axis, (x, y) = Surd.root(triangle.axis2), triangle.corner3
        second = axis if triangle.squares[0] else zero
        base = [(zero, zero), (a2x, zero), (a3x, a3y)]
        platform = [(zero, zero), (second, zero), (axis * x, axis * y)]
        frame = UserFrame.of(geometry)
        ours = ((Surd.of(1), zero), (zero, zero)) if frame is None else frame.base.direction
        angles = {name: self.sensed[name] for name in names if name in ANGLES}
        surds = [z for corner in (*base, *platform, *ours) for z in corner]
        reals = Reals.of(list(angles.values()), surds)
        p, q = (reals.surd(u) + reals.surd(v) for u, v in ours)
        turns = {}
        for name, angle in angles.items():
            c, s = reals.angles[angle]
            turns[int(name[-1])] = (p * c + q * s, p * s - q * c)
        pairs = combinations(angles.items(), 2)
        parallel = {frozenset((int(a[-1]), int(b[-1]))) for (a, x), (b, y) in pairs if (x - y) % 180 == 0}
        return Legs(
            reals,
            [(reals.surd(u), reals.surd(v)) for u, v in base],
            [(reals.surd(u), reals.surd(v)) for u, v in platform],
            {int(name[-1]): self.sensed[name] for name in names if name in LEGS},
            turns,
            frozenset(parallel),
        )

    def _by_lengths(self) -> list[_Known]:
        """The poses with three lengths, with digits to spare."""
        table = poses(
            self.manipulator, *(self.sensed[leg] for leg in LEGS), digits=digits_before(self.digits)
        )
        if table.curves:
            raise Curve
        with ctx.workprec(working_bits(self.digits)):
            return [
                _Known((enclosed(pose.alpha_deg), enclosed(pose.b1_x), enclosed(pose.b1_y)))
                for pose in table.poses
            ]

    def _view(self, legs: Legs, one: Candidate | _Known, bits: int) -> _View:
        turned, b1 = one.pose(bits)
        vectors = []
        for leg in (1, 2, 3):
            w = legs.around_ball(leg, turned, bits)
            vectors.append((b1[0] + w[0], b1[1] + w[1]))
        return _View(turned, b1, (vectors[0], vectors[1], vectors[2]))

    def _has_sense(self, legs: Legs, one: Candidate | _Known, leg: int) -> bool:
        """Whether the vector of a leg has the sense of its angle, and not the opposite one."""
        for bits in precisions(_FIRST_BITS, GREATEST_BITS):
            with ctx.workprec(bits):
                try:
                    v, u = self._view(legs, one, bits).legs[leg - 1], legs.turn_ball(leg, bits)
                except Open:
                    continue
                along = v[0] * u[0] + v[1] * u[1]
            if along > 0 or along < 0:
                return bool(along > 0)
        raise Unproved(f"leg {leg} has length 0 at a pose, or nearly so, and so no angle")

    def _off(self, legs: Legs, one: Candidate | _Known, name: str, bits: int) -> arb:
        """By how much the angle of a leg at a pose differs from a measured one, in degrees."""
        frame = UserFrame.of(self.manipulator.geometry)
        x, y = self._view(legs, one, bits).legs[int(name[-1]) - 1]
        if frame is not None:
            p, q = (u.ball() + v.ball() for u, v in frame.base.direction)
            x, y = p * x - q * y, p * y + q * x
        given = ball_of(self.sensed[name]) * arb.pi() / 180
        c, s = given.cos(), given.sin()
        return direction(c * x + s * y, c * y - s * x)

    def _agrees(self, legs: Legs, one: Candidate | _Known, name: str) -> bool:
        assert self.tolerance is not None
        for bits in precisions(_FIRST_BITS, max(GREATEST_BITS, working_bits(self.digits))):
            with ctx.workprec(bits):
                try:
                    off = abs(self._off(legs, one, name, bits)) - ball_of(self.tolerance)
                except Open:
                    continue
            if off > 0 or off < 0:
                return bool(off < 0)
        raise Unproved(f"whether {name} agrees within the tolerance is undecided: it is at its end")

    def _pose(self, legs: Legs, one: Candidate | _Known, rest: Sequence[str]) -> SensedPose:
        bits = working_bits(self.digits)
        frame = UserFrame.of(self.manipulator.geometry)
        with ctx.workprec(bits):
            view = self._opened(legs, one, bits)
            unit = sum((abs(z) for v in (view.b1, *view.legs) for z in v), arb(0))
            alpha = _direction(*view.turned)
            texts = {"alpha_deg": angle_text(settled(alpha, arb(1), self.digits))}
            sizes = [(x * x + y * y).sqrt() for x, y in view.legs]
            for leg, (vector, size) in enumerate(zip(view.legs, sizes, strict=True), 1):
                if not size.contains(0):
                    texts[f"theta{leg}_deg"] = angle_text(settled(_direction(*vector), arb(1), self.digits))
            texts |= {
                name: settled(z, unit, self.digits) for name, z in zip(("b1_x", "b1_y"), view.b1, strict=True)
            }
            texts |= {leg: settled(x, unit, self.digits) for leg, x in zip(LEGS, sizes, strict=True)}
            if frame is not None:
                radians = alpha * arb.pi() / 180
                x, y, phi = placed(frame, (radians, *view.b1), self.digits)
                words = (x, y, angle_text(settled(phi, arb(1), self.digits)))
                texts |= dict(zip(IN_GIVEN_FRAME, words, strict=True))
            off = {name: settled(self._off(legs, one, name, bits), arb(1), _OFF_DIGITS) for name in rest}
        return SensedPose(texts, off)

    def _opened(self, legs: Legs, one: Candidate | _Known, bits: int) -> _View:
        for finer in precisions(bits, max(8 * bits, GREATEST_BITS)):
            try:
                return self._view(legs, one, finer)
            except Open:
                continue
        raise Unproved("the digits of a pose could not be decided")


@dataclass(frozen=True, eq=False)
class _Known:
    """A pose by its decimals: α in degrees, and B1."""

    decimals: tuple[arb, arb, arb]

    def pose(self, _bits: int) -> tuple[Pair, Pair]:
        """cos α and sin α, and B1."""
        alpha, x, y = self.decimals
        s, c = (alpha * arb.pi() / 180).sin_cos()
        return (c, s), (x, y)


def _direction(x: arb, y: arb) -> arb:
    """The angle of a vector in degrees; at the negative x-axis that of the opposite one, plus 180."""
    return 180 + direction(-x, -y) if y.contains(0) and x < 0 else direction(x, y)


def _order(pose: SensedPose) -> tuple[float, float]:
    return float(pose.texts["alpha_deg"]), float(pose.texts["b1_x"])
