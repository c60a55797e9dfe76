"""Cusp curves: each cusp followed from the transition where it is born to the one where it dies.

Along a curve α, θ and the two free legs are analytic functions of the fixed length L. The curves are named
C1, C2, … in the order in which they begin, and by the fixed leg's angle if several begin together; the names
depend on the manipulator and its fixed leg only, not on the range or the samples of a request.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from math import cos, pi
from typing import Any

from rpr_solver.contract import (
    DEFAULT_DIGITS,
    Progress,
    check_digits,
    check_integer,
    check_leg,
    check_type,
    document_head,
    silent,
)
from rpr_solver.curves.cusp_curve import CurveEnd, CurvePoint, CuspCurve, name_cusps, tracks
from rpr_solver.curves.follower import Tracker
from rpr_solver.exact.rationals import Exact, exact_str
from rpr_solver.model.joint_points import JointPoint
from rpr_solver.model.lengths import LengthRange, slice_lengths
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.notebook import Row, counted, degenerate_words, html_table, with_floats
from rpr_solver.notebook.figure import Figure, Pictured, draw
from rpr_solver.slices import Eliminant, eliminate
from rpr_solver.transitions.census import LengthKind, transition_at
from rpr_solver.transitions.degeneracies import Degeneracy, degeneracies
from rpr_solver.transitions.event_systems import ELIMINATION_STEPS, length_text
from rpr_solver.transitions.survey import Survey, survey


@dataclass(frozen=True)
class CuspCurves(Pictured):
    """The cusp curves of a manipulator that meet a range of lengths of the fixed leg.

    Proved: these are all curves, and the curve of each cusp and every printed digit is right.

    Attributes:
        manipulator: the geometry.
        fixed_leg: the leg whose length varies along the curves.
        digits: significant digits of every printed number.
        curves: the curves, in the order of their names.
        range: the lengths of the fixed leg, in the user's unit.
        degenerate: what is degenerate in every slice of an interval, or along a whole curve of one slice.

    >>> from rpr_solver import EXAMPLES, cusp_curves
    >>> curves = cusp_curves(EXAMPLES["zein-flat"], digits=15)
    >>> curves
    <CuspCurves L1 from 0: 14 curves, 80 points, 15 digits>
    >>> near = curves.sampled(["30.5", 31]).within(30, 40)
    >>> [(row["curve"], row["l1"], row["cusp"]) for row in near.rows()][:3]
    [('C1', 30.5, 1), ('C1', 31.0, 1), ('C2', 30.5, 6)]
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    curves: tuple[CuspCurve, ...]
    range: LengthRange
    degenerate: tuple[Degeneracy, ...] = ()

    def __repr__(self) -> str:
        points = counted(sum(len(curve.points) for curve in self.curves), "point")
        curves = counted(len(self.curves), "curve")
        extra = ", degenerate" if self.degenerate else ""
        return f"<CuspCurves L{self.fixed_leg} {self.range}: {curves}, {points}{extra}, {self.digits} digits>"

    def to_json(self) -> dict[str, Any]:
        """The document; :meth:`from_json` reads it."""
        leg = self.fixed_leg
        return {
            **document_head(self.manipulator, self.digits, leg),
            "range": self.range.to_json(),
            "curves": [
                {
                    "name": curve.name,
                    "from": curve.start.to_json(leg),
                    "to": curve.stop.to_json(leg),
                    "points": [
                        {f"l{leg}": exact_str(p.length), "cusp": p.cusp, **p.point.to_json()}
                        for p in curve.points
                    ],
                }
                for curve in self.curves
            ],
            "degenerate": [part.to_json() for part in self.degenerate],
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
            LengthRange(Fraction(ends["from"]), None if ends["to"] is None else Fraction(ends["to"])),
            tuple(Degeneracy.from_json(part, leg) for part in obj.get("degenerate", ())),
        )

    def rows(self) -> list[Row]:
        """A row for each point, curve by curve, for ``pandas.DataFrame(curves.rows())``.

        Lengths and angles are floats; ``l2_text`` has all digits of ``l2``, and so on.
        """
        return with_floats(
            {"curve": curve["name"], **point}
            for curve in self.to_json()["curves"]
            for point in curve["points"]
        )

    def _repr_html_(self) -> str:
        leg = f"l{self.fixed_leg}"
        records = [
            {
                "curve": curve.name,
                f"{leg} from": curve.start.length,
                "begins": curve.start.kind,
                f"{leg} to": curve.stop.length or "∞",
                "ends": curve.stop.kind,
                "joins": ", ".join(end.joins for end in (curve.start, curve.stop) if end.joins),
                "points": len(curve.points),
            }
            for curve in self.curves
        ]
        notes = [degenerate_words(part.to_json(), self.fixed_leg) for part in self.degenerate]
        return html_table(repr(self)[1:-1], records, notes, first=self.manipulator.remark)

    def figure(self, view: str = "space") -> Figure:
        """A picture of the curves in joint space; sample them first, as with ``part(samples=14)``.

        Args:
            view: ``"space"``, seen from a corner, or ``"projections"``, in the planes of any two lengths.

        Raises:
            InputError: naming ``view``, or the lengths are too large to be drawn.
        """
        return draw(self.to_json(), view=view)

    def within(self, start: Exact = 0, stop: Exact | None = None) -> CuspCurves:
        """The curves and points of a smaller range. Sample first: sampling needs the points of whole curves.

        Args:
            start: the lower end, exact, in the user's unit, included.
            stop: the upper end, included; None is an open end.

        Raises:
            InputError: naming ``start`` or ``stop``.
        """
        span = LengthRange.of(start, stop)
        curves = tuple(
            replace(curve, points=tuple(p for p in curve.points if p.length in span))
            for curve in self.curves
            if curve.meets(span)
        )
        degenerate = tuple(filter(None, (part.within(span) for part in self.degenerate)))
        return replace(self, curves=curves, range=span, degenerate=degenerate)

    def spread(self, count: int, start: Exact = 0, stop: Exact | None = None) -> list[Fraction]:
        """``count`` lengths in each interval of a range between ends of curves, denser near these ends.

        They are short decimals. An open range is sampled up to twice the length of the last end of a curve.
        In an interval too narrow for the digits of its ends, the lengths are those of the present points.

        Args:
            count: the number of lengths in an interval, > 0.
            start: the lower end of the range, exact, in the user's unit.
            stop: the upper end; None is an open end.

        Raises:
            InputError: naming ``count``, ``start`` or ``stop``.
        """
        count = check_integer(count, "count", "1 or more", 1)
        lengths: set[Fraction] = set()
        for low, high in pairwise(self._borders(LengthRange.of(start, stop))):
            if not any(curve.meets(LengthRange(low, high)) for curve in self.curves):
                continue
            width, doubt = high - low, high / 10 ** (self.digits - 1)
            step = Fraction(1)
            while step > width / (16 * count**2):
                step /= 10
            if step > doubt:
                # floats are harmless here: any lengths will do
                shares = (Fraction((1 - cos(pi * (2 * i + 1) / (2 * count))) / 2) for i in range(count))
                lengths |= {round((low + share * width) / step) * step for share in shares}
            else:
                lengths |= {p.length for curve in self.curves for p in curve.points if low < p.length < high}
        return sorted(lengths)

    def sampled(
        self,
        lengths: Exact | Iterable[Exact],
        *,
        eliminant: Eliminant | None = None,
        progress: Progress | None = None,
    ) -> CuspCurves:
        """The same curves with their points at other lengths of the fixed leg.

        Cusps are followed from the present points; every curve must have one between any two neighbouring
        ends of curves, as in the result of :func:`cusp_curves`.

        Args:
            lengths: one length or several, exact, > 0, in the user's unit.
            eliminant: of the manipulator and the fixed leg; computed if it is None.
            progress: callback ``progress(done, total)``.

        Raises:
            InputError: naming each length at fault by the leg and its place (``l1[0]``).
            SolverError: a slice could not be decided, or a cusp not followed to it.
        """
        exact = slice_lengths(lengths, self.fixed_leg)
        if eliminant is None:
            eliminant = eliminate(self.manipulator, self.fixed_leg)
        check_type(eliminant, Eliminant, "eliminant")
        tracker = Tracker(eliminant, self.digits)
        starts: dict[Fraction, dict[int, int]] = {}
        for number, curve in enumerate(self.curves):
            for p in curve.points:
                starts.setdefault(p.length, {})[number] = p.cusp - 1
        points: list[list[CurvePoint]] = [[] for _ in self.curves]
        total = len(set(exact))

        def holds(number: int, length: Fraction) -> bool:
            return self.curves[number].holds(length, self.digits)

        for done, (length, names) in enumerate(name_cusps(tracker, starts, exact, holds), 1):
            for number, index in names.items():
                points[number].append(_point(tracker, length, index))
            (progress or silent)(done, total)
        return replace(
            self,
            curves=tuple(
                replace(curve, points=tuple(sorted(samples, key=lambda p: p.length)))
                for curve, samples in zip(self.curves, points, strict=True)
            ),
        )

    def part(
        self,
        start: Exact = 0,
        stop: Exact | None = None,
        *,
        lengths: Exact | Iterable[Exact] = (),
        samples: int | None = None,
        progress: Progress | None = None,
    ) -> CuspCurves:
        """The curves that meet a range, with their points at other lengths.

        Without ``lengths`` and ``samples`` the points in the range are kept.

        Args:
            start: the lower end of the range, exact, in the user's unit.
            stop: the upper end; None is an open end.
            lengths: one length or several, exact, > 0, in the user's unit.
            samples: the number of further points of each curve in every interval (see :meth:`spread`).
            progress: callback ``progress(done, total)``.

        Raises:
            InputError: naming ``start``, ``stop``, each length at fault, or the ``count`` of samples.
            SolverError: a slice could not be decided, or a cusp not followed to it.
        """
        exact = slice_lengths(lengths, self.fixed_leg)
        if samples is not None:
            exact += self.spread(samples, start, stop)
        whole = self.sampled(exact, progress=progress) if exact or samples is not None else self
        return whole.within(start, stop)

    def _borders(self, span: LengthRange) -> list[Fraction]:
        """The ends of a range and of the curves inside it, ascending."""
        texts = {end.length for curve in self.curves for end in (curve.start, curve.stop)}
        ends = {x for x in map(Fraction, filter(None, texts)) if x in span}
        last = span.stop or 2 * (max(ends, default=span.start) or Fraction(1))
        return sorted({span.start, *ends, last})


def cusp_curves(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    progress: Progress | None = None,
) -> CuspCurves:
    """Every cusp curve of the slices of one leg over all lengths > 0, with a point in each interval.

    Between two transitions a cusp moves on a smooth curve. It is followed through tubes that contain a single
    curve, by Krawczyk's test, and matched with the complete tables of slices; nothing is decided by
    proximity.

    Args:
        manipulator: the geometry.
        fixed_leg: the leg whose length varies along the curves, 1, 2 or 3.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
        progress: callback ``progress(done, total)``; ``total`` may grow.

    Raises:
        InputError: naming ``manipulator``, ``fixed_leg`` or ``digits``.
        SolverError: a transition could not be decided, or a cusp not followed; or that would take too long.

    >>> from rpr_solver import EXAMPLES
    >>> curves = cusp_curves(EXAMPLES["zein-flat"], digits=15)
    >>> [(curve.name, curve.start.kind, curve.stop.kind) for curve in curves.curves[:2]]
    [('C1', 'swallowtail', 'open'), ('C2', 'swallowtail', 'swallowtail')]
    """
    digits, fixed_leg = check_digits(digits), check_leg(fixed_leg)
    report = progress or silent
    result = survey(
        manipulator, fixed_leg, lambda done, of: report(done, 2 * of - ELIMINATION_STEPS), digits=digits
    )
    tracker, steps = Tracker(result.eliminant, digits, result.tables), len(result.slices)
    total = ELIMINATION_STEPS + 2 * steps
    tracker.refuse_too_much([(slice_.length, slice_.count) for slice_ in result.slices])
    named = tracks(result, tracker, lambda done, _: report(total - steps + done, total))
    cuts = [_end(result, k, digits) for k in range(len(result.groups))]
    ends = [CurveEnd("0", LengthKind.OPEN), *cuts, CurveEnd(None, LengthKind.OPEN)]

    def end(k: int, other: int | None) -> CurveEnd:
        if other is not None:
            return replace(ends[k], joins=_name(other))
        return replace(ends[k], kind=LengthKind.UNDECIDED) if k - 1 in named.undecided else ends[k]

    curves = []
    for number, track in enumerate(named.tracks):
        start = end(min(track.cusps), track.born_with)
        stop = end(max(track.cusps) + 1, track.dies_with)
        points = (_point(tracker, result.slices[k].length, index) for k, index in track.cusps.items())
        curves.append(CuspCurve(_name(number), start, stop, tuple(points)))
    degenerate = degeneracies(result, LengthRange(), digits)
    return CuspCurves(manipulator, fixed_leg, digits, tuple(curves), LengthRange(), degenerate)


def _name(number: int) -> str:
    return f"C{number + 1}"


def _point(tracker: Tracker, length: Fraction, index: int) -> CurvePoint:
    return CurvePoint(length, index + 1, tracker.table(length).cusps[index])


def _end(result: Survey, k: int, digits: int) -> CurveEnd:
    """The end of curves at the k-th group of events."""
    transition = transition_at(result, k, digits)
    if transition is not None:
        return CurveEnd(transition.length, transition.kind, events=transition.events)
    length = length_text(result.eliminant.slice_map, result.groups[k], digits)
    return CurveEnd(length, LengthKind.UNCLASSIFIED)
