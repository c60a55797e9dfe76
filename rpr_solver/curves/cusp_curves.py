"""Cusp curves: each cusp followed from the transition where it is born to the one where it dies.

Along a curve α, θ and the two free legs are analytic functions of the fixed length L. The curves are named
C1, C2, … in the order in which they begin, and by the fixed leg's angle where several begin together; the
names belong to the manipulator and its fixed leg, and do not depend on what range or samples are asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from math import cos, pi
from typing import Any

from rpr_solver.contract import DEFAULT_DIGITS, Progress, check_digits, document_head, silent
from rpr_solver.curves.destinations import Tracker
from rpr_solver.curves.naming import name_cusps, tracks
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.slices.cusp_table import check_slice
from rpr_solver.slices.eliminant import Eliminant, eliminate
from rpr_solver.slices.joint_points import JointPoint
from rpr_solver.transitions.census import LengthKind, TransitionPoint, length_text, transition_at
from rpr_solver.transitions.event_systems import ELIMINATION_STEPS
from rpr_solver.transitions.survey import Survey, survey

_KINDS: dict[str, PoseKind | LengthKind] = {kind.value: kind for kind in (*PoseKind, *LengthKind)}


@dataclass(frozen=True)
class CurveEnd:
    """Where a curve begins or ends.

    ``length`` is a correctly rounded decimal in the user's unit, "0", or None for a curve that goes on for
    ever. ``kind`` is that of the transition; ``OPEN`` at 0 and without end; ``UNDECIDED`` at a degenerate
    length of which it is not proved which cusps pass it, so that curves are cut there. ``joins`` is the
    name of the curve that meets this one there, where that is proved: both are parts of one smooth curve
    in (α, θ, L), which turns back in L. ``points`` are the degenerate poses of the transition; a single
    one is the end point of the curve.
    """

    length: str | None
    kind: PoseKind | LengthKind
    joins: str | None = None
    points: tuple[TransitionPoint, ...] = ()

    def to_json(self, fixed_leg: int) -> dict[str, object]:
        """A plain object."""
        events = [{"kind": p.kind.value, **p.point.to_json(fixed_leg)} for p in self.points]
        return {f"l{fixed_leg}": self.length, "kind": self.kind.value, "joins": self.joins, "events": events}

    @classmethod
    def from_json(cls, obj: Mapping[str, Any], fixed_leg: int) -> CurveEnd:
        """The inverse of :meth:`to_json`."""
        points = (
            TransitionPoint(PoseKind(p["kind"]), JointPoint.from_json(p, fixed_leg)) for p in obj["events"]
        )
        return cls(obj[f"l{fixed_leg}"], _KINDS[obj["kind"]], obj["joins"], tuple(points))


@dataclass(frozen=True)
class CurvePoint:
    """A point of a curve: the cusp of this number, from 1, in the table of the slice ``length``."""

    length: Fraction
    cusp: int
    point: JointPoint


@dataclass(frozen=True)
class CuspCurve:
    """A curve of cusps over the lengths between its ends, and points of it, ascending in L."""

    name: str
    start: CurveEnd
    stop: CurveEnd
    points: tuple[CurvePoint, ...]

    def meets(self, start: Fraction, stop: Fraction | None) -> bool:
        """Whether the curve has points in a range, as far as its decimals tell."""
        begins, ends = Fraction(self.start.length or 0), self.stop.length
        return (stop is None or begins < stop) and (ends is None or Fraction(ends) > start)


@dataclass(frozen=True)
class CuspCurves:
    """The curves of a manipulator that meet a range of lengths; None is a range without end."""

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    curves: tuple[CuspCurve, ...]
    start: Fraction = Fraction(0)
    stop: Fraction | None = None

    def to_json(self) -> dict[str, object]:
        """A plain document; :meth:`from_json` reads it back."""
        leg = self.fixed_leg
        return {
            **document_head(self.manipulator, self.digits, leg),
            "range": {
                "from": exact_str(self.start),
                "to": None if self.stop is None else exact_str(self.stop),
            },
            "curves": [
                {
                    "name": curve.name,
                    "from": curve.start.to_json(leg),
                    "to": curve.stop.to_json(leg),
                    "points": [
                        {f"l{leg}": exact_str(p.length), "cusp": p.cusp, **p.point.to_json(leg)}
                        for p in curve.points
                    ],
                }
                for curve in self.curves
            ],
        }

    @classmethod
    def from_json(cls, obj: Mapping[str, Any]) -> CuspCurves:
        """The inverse of :meth:`to_json`."""
        leg, ends = obj["fixed_leg"], obj["range"]
        curves = tuple(
            CuspCurve(
                curve["name"],
                CurveEnd.from_json(curve["from"], leg),
                CurveEnd.from_json(curve["to"], leg),
                tuple(
                    CurvePoint(Fraction(p[f"l{leg}"]), p["cusp"], JointPoint.from_json(p, leg))
                    for p in curve["points"]
                ),
            )
            for curve in obj["curves"]
        )
        return cls(
            Manipulator.from_json(obj["geometry"], max_digits=1 << 20),
            leg,
            obj["digits"],
            curves,
            Fraction(ends["from"]),
            None if ends["to"] is None else Fraction(ends["to"]),
        )

    def within(self, start: Fraction, stop: Fraction | None) -> CuspCurves:
        """The curves and points of a smaller range. To sample curves is done before: it needs all points."""
        curves = tuple(
            replace(curve, points=tuple(p for p in curve.points if _in_range(p.length, start, stop)))
            for curve in self.curves
            if curve.meets(start, stop)
        )
        return replace(self, curves=curves, start=start, stop=stop)

    def spread(
        self, count: int, start: Fraction = Fraction(0), stop: Fraction | None = None
    ) -> list[Fraction]:
        """``count`` lengths in each interval of a range between ends of curves, denser near these ends.

        They are short decimals. Beyond the last end of all curves a range without end is sampled up to twice
        that length. An interval too narrow for the digits of its ends gets the length of the points that the
        curves have there.
        """
        found: set[Fraction] = set()
        for low, high in pairwise(self._borders(start, stop)):
            if not any(curve.meets(low, high) for curve in self.curves):
                continue
            width, doubt = high - low, high / 10 ** (self.digits - 1)
            step = Fraction(1)
            while step > width / (16 * count**2):
                step /= 10
            if step > doubt:
                # hints only: wherever they lie, they are lengths
                shares = (Fraction((1 - cos(pi * (2 * i + 1) / (2 * count))) / 2) for i in range(count))
                found |= {round((low + share * width) / step) * step for share in shares}
            else:
                found |= {p.length for curve in self.curves for p in curve.points if low < p.length < high}
        return sorted(found)

    def sampled(
        self,
        lengths: Sequence[Fraction],
        *,
        eliminant: Eliminant | None = None,
        progress: Progress | None = None,
    ) -> CuspCurves:
        """The same curves with their points at other lengths of the fixed leg.

        The cusps set out from the points that the curves have now; every curve must have one between any
        two neighbouring ends of curves, as :func:`cusp_curves` makes them.

        Raises:
            InputError: a length is not positive.
            SolverError: a slice could not be decided, or a cusp not followed to it.
        """
        for length in lengths:
            check_slice(self.fixed_leg, length, self.digits)
        tracker = Tracker(eliminant or eliminate(self.manipulator, self.fixed_leg), self.digits)
        starts: dict[Fraction, dict[int, int]] = {}
        for number, curve in enumerate(self.curves):
            for p in curve.points:
                starts.setdefault(p.length, {})[number] = p.cusp - 1
        points: list[list[CurvePoint]] = [[] for _ in self.curves]
        wanted = set(lengths)
        for done, (length, names) in enumerate(name_cusps(tracker, starts, lengths), 1):
            for number, index in names.items():
                points[number].append(_point(tracker, length, index))
            (progress or silent)(done, len(wanted))
        return replace(
            self,
            curves=tuple(
                replace(curve, points=tuple(sorted(found, key=lambda p: p.length)))
                for curve, found in zip(self.curves, points, strict=True)
            ),
        )

    def part(
        self,
        start: Fraction = Fraction(0),
        stop: Fraction | None = None,
        *,
        lengths: Sequence[Fraction] = (),
        samples: int | None = None,
        progress: Progress | None = None,
    ) -> CuspCurves:
        """The curves that meet a range, with their points at other lengths.

        Args:
            start, stop: the range; None is no end.
            lengths: where points are wanted.
            samples: how many more points each curve has in every interval (see :meth:`spread`).
            progress: callback ``progress(done, total)``.

        Without ``lengths`` and ``samples`` the points of the range stay as they are.

        Raises:
            InputError: a length is not positive.
            SolverError: a slice could not be decided, or a cusp not followed to it.
        """
        if samples is not None:
            lengths = [*lengths, *self.spread(samples, start, stop)]
        whole = self.sampled(lengths, progress=progress) if lengths or samples is not None else self
        return whole.within(start, stop)

    def _borders(self, start: Fraction, stop: Fraction | None) -> list[Fraction]:
        """The ends of a range and of the curves inside it, ascending."""
        texts = {end.length for curve in self.curves for end in (curve.start, curve.stop)}
        ends = {x for x in map(Fraction, filter(None, texts)) if _in_range(x, start, stop)}
        last = stop or 2 * (max(ends, default=start) or Fraction(1))
        return sorted({start, *ends, last})


def _in_range(length: Fraction, start: Fraction, stop: Fraction | None) -> bool:
    return start <= length and (stop is None or length <= stop)


def cusp_curves(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    progress: Progress | None = None,
) -> CuspCurves:
    """Every cusp curve of the slices of one leg over all lengths > 0, with a point in each interval.

    Args:
        manipulator: the geometry.
        fixed_leg: the leg that is held, 1, 2 or 3.
        digits: significant digits of every printed number.
        progress: told the steps done and their number.

    Raises:
        InputError: ``fixed_leg`` or ``digits`` is out of range.
        SolverError: a transition could not be decided, or a cusp not followed; nothing was guessed.
    """
    check_digits(digits)
    report = progress or silent
    found = survey(
        manipulator, fixed_leg, lambda done, of: report(done, 2 * of - ELIMINATION_STEPS), digits=digits
    )
    tracker, steps = Tracker(found.eliminant, digits, found.slices), len(found.slices)
    total = ELIMINATION_STEPS + 2 * steps
    named = tracks(found, tracker, lambda done, _: report(total - steps + done, total))
    cuts = [_end(found, k, digits) for k in range(len(found.groups))]
    ends = [CurveEnd("0", LengthKind.OPEN), *cuts, CurveEnd(None, LengthKind.OPEN)]

    def end(k: int, other: int | None) -> CurveEnd:
        if other is not None:
            return replace(ends[k], joins=_name(other))
        return replace(ends[k], kind=LengthKind.UNDECIDED) if k - 1 in named.undecided else ends[k]

    curves = []
    for number, track in enumerate(named.tracks):
        start = end(min(track.cusps), track.born_with)
        stop = end(max(track.cusps) + 1, track.dies_with)
        points = (_point(tracker, found.slices[k].length, index) for k, index in track.cusps.items())
        curves.append(CuspCurve(_name(number), start, stop, tuple(points)))
    return CuspCurves(manipulator, fixed_leg, digits, tuple(curves))


def _name(number: int) -> str:
    return f"C{number + 1}"


def _point(tracker: Tracker, length: Fraction, index: int) -> CurvePoint:
    return CurvePoint(length, index + 1, tracker.table(length).cusps[index])


def _end(found: Survey, k: int, digits: int) -> CurveEnd:
    """The end of curves at the group of events k."""
    transition = transition_at(found, k, digits)
    if transition is not None:
        return CurveEnd(transition.length, transition.kind, points=transition.points)
    return CurveEnd(length_text(found.eliminant.slice_map, found.groups[k], digits), LengthKind.UNCLASSIFIED)
