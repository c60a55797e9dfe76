"""One cusp curve: its ends and points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.classify import PoseKind
from rpr_solver.model.joint_points import JointPoint, coordinate_names
from rpr_solver.model.lengths import LengthRange
from rpr_solver.notebook import counted, csv_text, degenerate_words, shortened
from rpr_solver.transitions.census import LengthKind, TransitionEvent

_KINDS: dict[str, PoseKind | LengthKind] = {kind.value: kind for kind in (*PoseKind, *LengthKind)}


@dataclass(frozen=True)
class CurveEnd:
    """Where a cusp curve begins or ends.

    Attributes:
        length: of the fixed leg, a correctly rounded decimal in the user's unit or ``"0"``; None if the curve
            extends to infinity.
        kind: that of the transition; ``OPEN`` at 0 and infinity; ``UNDECIDED`` at a degenerate length at
            which curves are cut because it is not proved which cusps continue.
        joins: the name of the curve that meets this one there, if that is proved: both are parts of one
            smooth curve in (α, θ, L), which turns back in L.
        events: the degenerate poses of the transition; if there is only one, it is the end point of the
        curve.

    >>> CurveEnd("26.7863808708888", PoseKind.BEAK_TO_BEAK, joins="C19")
    <CurveEnd at 26.786380…: beak-to-beak, joins C19>
    """

    length: str | None
    kind: PoseKind | LengthKind
    joins: str | None = None
    events: tuple[TransitionEvent, ...] = ()

    def __repr__(self) -> str:
        where = "without end" if self.length is None else f"at {shortened(self.length)}"
        joins = f", joins {self.joins}" if self.joins else ""
        return f"<CurveEnd {where}: {self.kind}{joins}>"

    def to_json(self, fixed_leg: int) -> dict[str, Any]:
        """The document's object."""
        events = [event.to_json() for event in self.events]
        return {f"l{fixed_leg}": self.length, "kind": self.kind.value, "joins": self.joins, "events": events}

    @classmethod
    def from_json(cls, obj: Mapping[str, Any], fixed_leg: int) -> CurveEnd:
        """The inverse of :meth:`to_json`."""
        events = (
            TransitionEvent(PoseKind(e["kind"]), JointPoint.from_json(e, fixed_leg)) for e in obj["events"]
        )
        return cls(obj[f"l{fixed_leg}"], _KINDS[obj["kind"]], obj["joins"], tuple(events))


@dataclass(frozen=True)
class CurvePoint:
    """A point of a cusp curve.

    Attributes:
        length: of the fixed leg, exact, in the user's unit.
        cusp: the number of the cusp, from 1, in the table of that slice.
        point: the cusp.

    >>> from rpr_solver import EXAMPLES, cusp_table
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=15)
    >>> CurvePoint(table.length, 1, table.cusps[0])
    <CurvePoint L1=10 cusp 1: alpha_deg=31.450940… theta1_deg=-129.00691… l2=25.223354… l3=35.509486…>
    """

    length: Fraction
    cusp: int
    point: JointPoint

    def __repr__(self) -> str:
        length = shortened(exact_str(self.length))
        return f"<CurvePoint L{self.point.fixed_leg}={length} cusp {self.cusp}: {repr(self.point)[12:-1]}>"


@dataclass(frozen=True)
class CuspCurve:
    """A curve of cusps over the lengths of the fixed leg between its ends.

    Attributes:
        name: ``"C1"``, ``"C2"``, …; it depends on the manipulator and its fixed leg only, not on the samples.
        start: the end of smaller length.
        stop: the end of greater length.
        points: the sampled points of the curve, ascending in length.

    >>> born = CurveEnd("0.829977410", PoseKind.SWALLOWTAIL)
    >>> CuspCurve("C1", born, CurveEnd(None, LengthKind.OPEN), points=())
    <CuspCurve C1 from 0.82997741… (swallowtail) to ∞ (open): 0 points>
    """

    name: str
    start: CurveEnd
    stop: CurveEnd
    points: tuple[CurvePoint, ...]

    def __repr__(self) -> str:
        ends = " to ".join(f"{shortened(end.length or '∞')} ({end.kind})" for end in (self.start, self.stop))
        return f"<CuspCurve {self.name} from {ends}: {counted(len(self.points), 'point')}>"

    def meets(self, span: LengthRange) -> bool:
        """Whether the curve has points in a range, within the accuracy of its decimals."""
        begins, ends = Fraction(self.start.length or 0), self.stop.length
        return (span.stop is None or begins < span.stop) and (ends is None or Fraction(ends) > span.start)


def curves_csv(document: Mapping[str, Any]) -> str:
    """A document of cusp curves as CSV: a line for each point, curve by curve.

    After these, each thing that is degenerate throughout has a line with its ``kind`` and its description.

    >>> from rpr_solver import EXAMPLES, CurveEnd, CurvePoint, CuspCurve, CuspCurves, cusp_table
    >>> from rpr_solver import LengthKind, LengthRange
    >>> [table] = cusp_table(EXAMPLES["zein-flat"], 10, digits=15)
    >>> points = (CurvePoint(table.length, 1, table.cusps[0]),)
    >>> curve = CuspCurve("C1", CurveEnd("0", LengthKind.OPEN), CurveEnd(None, LengthKind.OPEN), points)
    >>> document = CuspCurves(EXAMPLES["zein-flat"], 1, 15, (curve,), LengthRange()).to_json()
    >>> print(curves_csv(document))
    curve,l1,cusp,alpha_deg,theta1_deg,l2,l3,kind,degenerate
    C1,10,1,31.4509403281135,-129.006918092045,25.2233542007524,35.5094864112439,cusp,
    <BLANKLINE>
    """
    leg = document["fixed_leg"]
    records: list[Mapping[str, object]] = [
        {"curve": curve["name"], "kind": "cusp", **point}
        for curve in document["curves"]
        for point in curve["points"]
    ]
    records += [
        {"kind": part["kind"], "degenerate": degenerate_words(part, leg)}
        for part in document.get("degenerate", ())
    ]
    return csv_text(["curve", f"l{leg}", "cusp", *coordinate_names(leg), "kind", "degenerate"], records)
