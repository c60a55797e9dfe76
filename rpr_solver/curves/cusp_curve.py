"""Cusp curves: their ends and points, and names for the cusps of many slices.

Each cusp is followed from slice to slice. In the slice of a degenerate pose, whose length may be irrational,
the cusps are counted exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from rpr_solver.contract import Progress
from rpr_solver.curves.follower import Cusp, Follower, Tracker
from rpr_solver.errors import Unproved
from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.number_field import (
    Algebraic,
    Polynomial,
    adjoin_real_roots,
    evaluate,
    poly_gcd,
    poly_mod,
    real_balls,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.joint_points import ExactPose, JointPoint, PoseKind, coordinate_names, cos_sin, poses_at
from rpr_solver.model.lengths import LengthRange
from rpr_solver.notebook import counted, csv_text, degenerate_words, shortened
from rpr_solver.slices import Eliminant
from rpr_solver.slices.eliminant import DEGREE_U
from rpr_solver.transitions.census import LengthKind, TransitionEvent
from rpr_solver.transitions.event_systems import Event
from rpr_solver.transitions.survey import Survey

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
        events: the degenerate poses of the transition; a single one is the end point of the curve.

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
        at = ((PoseKind(e["kind"]), JointPoint.from_json(e, fixed_leg)) for e in obj["events"])
        events = tuple(TransitionEvent(*parts) for parts in at)
        return cls(obj[f"l{fixed_leg}"], _KINDS[obj["kind"]], obj["joins"], events)


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

    def holds(self, length: Fraction, digits: int) -> bool:
        """Whether a length lies between the ends, of which these digits are known; at an end, it does."""
        begins, ends = Fraction(self.start.length or 0), self.stop.length
        # an end is wrong by half a unit of its last digit at most
        half_unit = Fraction(10) ** (1 - digits) / 2
        return length >= begins * (1 - half_unit) and (
            ends is None or length <= Fraction(ends) * (1 + half_unit)
        )


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


_GREATEST_DEGREE = 8
"""Of number fields in which this is tried; others take too long."""
_GREATEST_SIZE = 1000
"""Of the bits of Q at an algebraic L, times the squared degree of its field: a few tenths of a second. With
824 bits in a field of degree 4, the common divisor of Q and its derivative takes 80 s."""


def most_cusps(eliminant: Eliminant, pose: ExactPose) -> int | None:
    """At least the number of cusps in the slice of a pose, and mostly this number.

    A simple root of Q has at most one cusp above it, and poses above other roots are classified
    (mathematics.md#curves-that-end). Returns None if the number field or its numbers are too large, J and E
    share a curve, or leg f may be closed and stretched at once.
    """
    length, omega = pose.length, pose.local.pose.omega
    leg = eliminant.slice_map.f
    stretched = length * length - (leg.platform2 + leg.base2)
    if (
        length.field.degree > _GREATEST_DEGREE
        or (stretched * stretched - 4 * leg.platform2 * leg.base2).is_zero
    ):
        return None
    q = _eliminant_at(eliminant, length, omega)
    if not q or max(c.bits for c in q) * length.field.degree**2 > _GREATEST_SIZE:
        return None
    common = poly_gcd(q, trimmed([c * i for i, c in enumerate(q)][1:]))
    once = poly_mod(q, common)[0]
    simple = poly_mod(once, poly_gcd(once, common))[0]
    count = len(real_balls(simple)) if len(simple) > 1 else 0
    places: list[tuple[Algebraic | None, Algebraic, Algebraic]] = [
        (extension.root, extension.lift(length), extension.lift(omega))
        for extension in adjoin_real_roots(length.field, squarefree_part(common))
    ]
    if len(q) <= DEGREE_U:
        places.append((None, length, omega))
    for place in places:
        poses = _poses_above(eliminant, *place)
        if poses is None:
            return None
        count += sum(each.kind is PoseKind.CUSP for each in poses)
    return count


def _eliminant_at(eliminant: Eliminant, length: Algebraic, omega: Algebraic) -> Polynomial:
    """Q at an algebraic scaled L."""
    return trimmed([evaluate(row, length) for row in eliminant.rows(omega)])


def _poses_above(
    eliminant: Eliminant, u: Algebraic | None, length: Algebraic, omega: Algebraic
) -> list[ExactPose] | None:
    """The real common zeros of J and E above a root u (None: ∞); None if every t is one."""
    slice_map = eliminant.slice_map
    j, e = (_above(form, u, length, omega) for form in (slice_map.singular, slice_map.coalescence))
    rho = slice_map.rho
    poses = poses_at(j, e, *cos_sin(u, length.field, rho), length, omega, rho)
    return None if poses is None else [ExactPose.of(slice_map, pose) for pose in poses]


def _above(form: BiForm, u: Algebraic | None, length: Algebraic, omega: Algebraic) -> Polynomial:
    """The coefficients of tⁱ."""

    def at(polynomial: QuadraticPoly) -> Algebraic:
        return polynomial.coefficient(form.degree_u, omega) if u is None else polynomial(u, omega)

    return [evaluate([at(c) for c in row], length) for row in form.coefficients]


@dataclass
class Track:
    """One cusp through the slices of a survey.

    ``cusps`` gives its index in the table of each slice, by the slice's number. ``born_with`` and
    ``dies_with`` are the numbers of the tracks into which the curve turns back at its ends, if that is
    proved.
    """

    cusps: dict[int, int]
    born_with: int | None = None
    dies_with: int | None = None


@dataclass(frozen=True)
class Tracks:
    """All cusps of a survey.

    ``undecided`` are the groups of events at which tracks end and others begin that may be the same.
    """

    tracks: tuple[Track, ...]
    undecided: frozenset[int]


def tracks(survey: Survey, tracker: Tracker, progress: Progress) -> Tracks:
    """Follows every cusp of a survey from slice to slice."""
    everything: list[Track] = []
    undecided = set()
    alive: dict[int, Follower] = {}

    def begin(k: int, indices: Sequence[int]) -> None:
        for index in indices:
            alive[len(everything)] = tracker.follower((survey.slices[k].length, index), upwards=True)
            everything.append(Track({k: index}))

    begin(0, range(survey.slices[0].count))
    for k, (below, above) in enumerate(pairwise(survey.slices)):
        names = {everything[name].cusps[k]: name for name in alive}
        starts = {(below.length, index): name for index, name in names.items()}
        met = tracker.destinations(alive, below.length, above.length, starts=starts)
        for name, (length, index) in met.items():
            if length == above.length:
                everything[name].cusps[k + 1] = index
            else:
                everything[name].dies_with = names[index]
        alive = {name: alive[name] for name, (length, _) in met.items() if length == above.length}
        taken = {everything[name].cusps[k + 1] for name in alive}
        born = [index for index in range(above.count) if index not in taken]
        first = len(everything)
        begin(k + 1, born)
        _pair(everything, range(first, len(everything)), born, tracker, (below.length, above.length))
        unpaired = any(track.born_with is None for track in everything[first:])
        if unpaired and len(met) < len(names) and not _only(tracker, survey.groups[k], len(taken)):
            undecided.add(k)
        progress(k + 2, len(survey.slices))
    return Tracks(tuple(everything), frozenset(undecided))


def _pair(
    everything: Sequence[Track],
    names: Sequence[int],
    born: Sequence[int],
    tracker: Tracker,
    lengths: tuple[Fraction, Fraction],
) -> None:
    """Notes which new tracks begin together: the branches of a curve that turns back between two lengths."""
    below, above = lengths
    for name, index in zip(names, born, strict=True):
        # a curve that turns back from one cusp to another does so from the other to the one
        if everything[name].born_with is None:
            sibling = _sibling(tracker, below, (above, index))
            if sibling is not None:
                other = names[born.index(sibling)]
                everything[name].born_with, everything[other].born_with = other, name


def _only(tracker: Tracker, group: Sequence[Event], passing: int) -> bool:
    """Proves that at most ``passing`` cusps continue through events: their slice itself has no more.

    See mathematics.md#curves-that-end.
    """
    exact = next((x.rational for e in group if (x := e.exact_length) and x.rational is not None), None)
    if exact is not None:
        return tracker.table(exact / tracker.eliminant.slice_map.scale).count == passing
    pose = next((e.pose for e in group if isinstance(e.pose, ExactPose)), None)
    if pose is None or any(e.pose is None or e.pose.kind is not PoseKind.QUADRUPLE for e in group):
        return False
    most = most_cusps(tracker.eliminant, pose)
    return most is not None and most <= passing


def _sibling(tracker: Tracker, low: Fraction, cusp: Cusp) -> int | None:
    """The cusp of the same slice to which the curve downwards from a cusp turns back."""
    length, _ = cusp
    met = tracker.destinations({0: tracker.follower(cusp, upwards=False)}, low, length)
    return met[0][1] if met and met[0][0] == length else None


Holds = Callable[[int, Fraction], bool]
"""Whether a curve, by its name, holds a slice between its ends; within the rounding of an end, it may."""


def name_cusps(
    tracker: Tracker,
    starts: Mapping[Fraction, Mapping[int, int]],
    lengths: Sequence[Fraction],
    holds: Holds | None = None,
) -> Iterator[tuple[Fraction, dict[int, int]]]:
    """The names of the cusps of more slices, from those of a slice in each interval between transitions.

    Tubes may lead through a transition at which a curve is cut, to cusps of the one that begins there. So a
    name goes only to slices that its curve holds, and no cusp has two names: within the rounding of an end,
    where both curves may hold the slice, it has that of the curve which ends there.

    Args:
        tracker: of the manipulator.
        starts: for each slice with known names, the indices of its cusps in the table by name.
        lengths: the slices to name.
        holds: tells which curves have a cusp in a slice; None: all to which tubes lead.

    Yields:
        Each length, in arbitrary order, with the indices of its cusps in the table by name.

    Raises:
        Unproved: a cusp of some slice could not be named.
    """
    targets = sorted(set(lengths))
    for low, high in pairwise([None, *sorted(starts), None]):
        inside = [x for x in targets if (low is None or low < x) and (high is None or x < high)]
        names: dict[Fraction, dict[int, int]] = {length: {} for length in inside}
        for start, order in ((low, inside), (high, inside[::-1])):
            if start is not None:
                _pass(tracker, start, starts[start], order, names, holds)
        for length in inside:
            if len(names[length]) < tracker.table(length).count:
                raise Unproved(f"not all cusps of the slice {exact_str(length)} could be followed to it")
            yield length, names[length]
    yield from ((length, dict(starts[length])) for length in targets if length in starts)


def _pass(
    tracker: Tracker,
    start: Fraction,
    cusps: Mapping[int, int],
    order: Sequence[Fraction],
    names: Mapping[Fraction, dict[int, int]],
    holds: Holds | None,
) -> None:
    """Follows the cusps of one slice through others, nearest first, until one has all names."""
    alive: dict[int, Follower] | None = None
    for length in order:
        known = names[length]
        free = tracker.table(length).count - len(known)
        if not free:
            return
        if alive is None:
            upwards = length > start
            alive = {name: tracker.follower((start, i), upwards=upwards) for name, i in cusps.items()}
        # a curve that has ended holds no slice farther on either
        if holds is not None:
            alive = {name: follower for name, follower in alive.items() if holds(name, length)}
        low, high = sorted((start, length))
        met = tracker.destinations(alive, low, high, until_full=length)
        alive = {name: alive[name] for name, (where, _) in met.items() if where == length}
        named = set(known.values())
        known.update({name: met[name][1] for name in alive if met[name][1] not in named})
