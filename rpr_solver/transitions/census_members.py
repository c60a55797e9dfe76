"""Members of a census besides its transitions: what is degenerate throughout, and the full certificate.

Transitions are single lengths with single degenerate poses; any manipulator has some. Symmetric and flat
manipulators also have degenerate poses in all slices, or whole curves of them, as congruent triangles
(mathematics.md#what-is-degenerate-throughout). Their numbers of cusps are right all the same, but a table of
these numbers alone would look clean.

The full certificate is what an independent checker needs to check a census without solving it::

    {"systems": [{"name": "swallowtails", "polynomial": {"variable": "v = tan(theta1)", …},
                  "squarefree": {"prime": "…", "omega": "…"},
                  "real_roots": [{"lower": "…", "upper": "…", "multiplicity": 1}, …]}, …],
     "events": [{"kind": "swallowtail", "l1": {"centre": "…", "radius": "…"}, "alpha_deg": …}, …],
     "samples": ["…", …]}

The systems are those of event_systems.py, each with its eliminant P(v), exact, and isolating intervals of all
its real roots (mathematics.md#the-eliminants-of-the-census). ``squarefree`` is null if a root is multiple or
infinite. ``events`` has a box in all unknowns for each degenerate pose, of all lengths, in or out of the
range; tan θ of it lies in the interval of its root. ``samples`` has for each interval the length of the slice
in which its cusps were counted. Where events are not isolated (method ``"components"``), there are no
systems, and the events are those of the transitions.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby, pairwise
from math import floor
from typing import Any

from flint import arb, ctx, nmod_poly

from rpr_solver.exact import GREATEST_BITS, decided
from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.factors import Certified
from rpr_solver.exact.number_field import (
    Algebraic,
    Polynomial,
    adjoin_real_roots,
    exact_omega,
    poly_gcd,
    squarefree_part,
    trimmed,
)
from rpr_solver.exact.numerals import integer_text
from rpr_solver.exact.rationals import exact_or_none, exact_str
from rpr_solver.exact.real_roots import RealRoot, ball_of, fraction_of
from rpr_solver.model.joint_points import PoseKind
from rpr_solver.model.lengths import LengthRange
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.notebook import degenerate_words
from rpr_solver.slices import DEGREE_L, Eliminant
from rpr_solver.slices.reference import divided, formal_resultant
from rpr_solver.transitions.components import once
from rpr_solver.transitions.event_systems import Event, EventSystems, Landmark, System, length_text
from rpr_solver.transitions.isolated_events import BallEvent
from rpr_solver.transitions.survey import Survey, grouped


@dataclass(frozen=True)
class Degeneracy:
    """Degenerate poses that every slice of an interval of lengths has, or a whole curve of them.

    Attributes:
        fixed_leg: the leg whose length varies from slice to slice.
        kind: that of the poses, as a cusp table names it: ``"node"``, ``"quadruple"`` …, or ``"curve"``.
        start, stop: the ends of the interval in the user's unit: exact texts for the ends of the range, else
            correctly rounded decimals; None is an open end. Both are the same where only one length has it.
        count: the number of such poses in each slice; None for a curve.
        equation: that of a curve, exact; None for poses, and for a curve at one irrational length.

    >>> Degeneracy(1, PoseKind.CURVE, "0", None, equation="alpha = 0 deg")
    <Degeneracy curve of degenerate poses in every slice: alpha = 0 deg>
    >>> Degeneracy(2, PoseKind.NODE, "0", "25", count=2).to_json()
    {'kind': 'node', 'from': '0', 'to': '25', 'count': 2}
    """

    fixed_leg: int
    kind: PoseKind
    start: str
    stop: str | None
    count: int | None = None
    equation: str | None = None

    def __repr__(self) -> str:
        return f"<Degeneracy {degenerate_words(self.to_json(), self.fixed_leg)}>"

    def to_json(self) -> dict[str, Any]:
        """The contract's object."""
        about = {"count": self.count, "equation": self.equation}
        known = {name: value for name, value in about.items() if value is not None}
        return {"kind": self.kind.value, "from": self.start, "to": self.stop, **known}

    @classmethod
    def from_json(cls, obj: Mapping[str, Any], fixed_leg: int) -> Degeneracy:
        """The inverse of :meth:`to_json`."""
        kind = PoseKind(obj["kind"])
        return cls(fixed_leg, kind, obj["from"], obj["to"], obj.get("count"), obj.get("equation"))

    def within(self, span: LengthRange) -> Degeneracy | None:
        """The part in a smaller range; None if there is none."""
        low, high = Fraction(self.start), None if self.stop is None else Fraction(self.stop)
        if low == high:
            return self if low in span else None
        if (span.stop is not None and low >= span.stop) or (high is not None and high <= span.start):
            return None
        start = self.start if low > span.start else exact_str(span.start)
        cut = span.stop is not None and (high is None or high >= span.stop)
        return replace(self, start=start, stop=exact_or_none(span.stop) if cut else self.stop)


def degeneracies(result: Survey, span: LengthRange, digits: int) -> tuple[Degeneracy, ...]:
    """What is degenerate in a range of lengths: curves first, then poses, ascending by their intervals.

    Args:
        result: the survey of that range.
        span: the range.
        digits: significant digits of the ends of intervals.

    Raises:
        SolverError: an end could not be decided.
    """
    slice_map = result.eliminant.slice_map
    ends = [
        lambda: exact_str(span.start),
        *(lambda group=group: length_text(slice_map, group, digits) for group in result.groups),
        lambda: exact_or_none(span.stop),
    ]
    return (*_curves(result.eliminant, span, digits), *_poses(result, ends))


def _poses(result: Survey, ends: Sequence[Callable[[], str | None]]) -> Iterator[Degeneracy]:
    """Runs of intervals whose slices have the same number of degenerate poses of one kind."""
    numbers = [Counter(point["kind"] for point in part.degenerate_points) for part in result.slices]
    found: list[tuple[int, Degeneracy]] = []
    for kind in {kind for number in numbers for kind in number} - {PoseKind.CURVE}:
        places = enumerate(number[kind] for number in numbers)
        for count, run in groupby(places, key=lambda place: place[1]):
            first, *_, last = [*(k for k, _ in run)] * 2
            if count:
                start, stop = ends[first](), ends[last + 1]()
                leg = result.eliminant.slice_map.fixed_leg
                found.append((first, Degeneracy(leg, PoseKind(kind), str(start), stop, count)))
    yield from (part for _, part in sorted(found, key=lambda item: (item[0], item[1].kind)))


def _curves(eliminant: Eliminant, span: LengthRange, digits: int) -> Iterator[Degeneracy]:
    """The curves that J and E share in every slice, and those in the slices of single lengths."""
    if _has_no_curves(eliminant):
        return
    slice_map = eliminant.slice_map
    leg, ends = slice_map.fixed_leg, (exact_str(span.start), exact_or_none(span.stop))
    omega = exact_omega(slice_map.radicand)
    rows = eliminant.rows(omega)
    j, e = slice_map.singular, slice_map.coalescence
    if all(x.is_zero for row in rows for x in row):
        j, e, curves = divided(j, e)
        for curve in curves:
            equation = curve.in_unit(slice_map.scale).equation(leg)
            yield Degeneracy(leg, PoseKind.CURVE, *ends, equation=equation)
        rows = _rows(BiForm.of(formal_resultant(j, e), slice_map.radicand, 0, 0), omega)
    for length in _common_lengths(rows):
        if _is_inside(length, slice_map, span):
            text = length_text(slice_map, [Landmark(length)], digits)
            for known in _equations(j, e, length, leg):
                yield Degeneracy(leg, PoseKind.CURVE, text, text, equation=known)


def _has_no_curves(eliminant: Eliminant) -> bool:
    """Proof modulo a prime that the eliminant in u is 0 for no L; False if there is none.

    A common factor of coefficients, polynomials in L, keeps its degree where one of them does.
    """
    p, residues = eliminant.residues
    common, is_full = nmod_poly([], p), False
    for coefficients in residues.tolist():
        row = nmod_poly(coefficients, p)
        common, is_full = common.gcd(row), is_full or row.degree() == DEGREE_L
        if is_full and common.degree() == 0:
            return True
    return False


def _rows(form: BiForm, omega: Algebraic) -> list[list[Algebraic]]:
    """For each power of u the coefficients of L⁰, L¹, … of a form without t."""
    [powers] = form.coefficients
    degree = max((max(p.a.degree(), p.b.degree()) for p in powers), default=0)
    return [[p.coefficient(i, omega) for p in powers] for i in range(degree + 1)]


def _common_lengths(rows: Sequence[Sequence[Algebraic]]) -> Iterator[Algebraic]:
    """The L > 0 (scaled) at which all polynomials in L vanish: there the eliminant in u is 0."""
    lowest = min((k for row in rows for k, x in enumerate(row) if not x.is_zero), default=0)
    common: Polynomial = []
    for row in rows:
        common = poly_gcd(common, trimmed(row[lowest:]))
        if len(common) == 1:
            return
    field = rows[0][0].field
    for extension in adjoin_real_roots(field, squarefree_part(common)):
        if extension.root.sign > 0:
            yield extension.root


def _is_inside(length: Algebraic, slice_map: SliceMap, span: LengthRange) -> bool:
    """Whether a *scaled* length is strictly within a range."""
    low, high = (None if x is None else length.field(x * slice_map.scale) for x in (span.start, span.stop))
    return (low is None or (length - low).sign > 0) and (high is None or (high - length).sign > 0)


def _equations(j: BiForm, e: BiForm, length: Algebraic, fixed_leg: int) -> list[str | None]:
    """Those of the curves that J and E share at a *scaled* length; [None] if it is irrational."""
    if length.rational is None:
        return [None]
    _, _, curves = divided(j.sliced(length.rational), e.sliced(length.rational))
    return [curve.equation(fixed_leg) for curve in curves]


_FIRST_BITS = 128
_BITS_OF_AN_END, _BITS_OF_A_PLACE = 8, 4
"""Bits of precision for each decimal place of an isolating interval, and of a box, which is to be smaller."""
End = tuple[Fraction, Fraction]


def full_certificate(result: Survey, transitions: Sequence[int]) -> dict[str, Any]:
    """The member ``full`` of a census's certificate.

    Args:
        result: the survey of the range.
        transitions: the numbers of its groups that are transitions.

    Raises:
        SolverError: an event could not be enclosed.
    """
    slice_map = result.eliminant.slice_map
    isolated = [_Isolated.of(name, system) for name, system in _systems(result.systems)]
    groups = map(once, grouped(result.events)) if isolated else (result.groups[k] for k in transitions)
    events = [event for group in groups for event in group]
    samples = [result.slices[0], *(result.slices[k + 1] for k in transitions)]
    return {
        "systems": [system.to_json() for system in isolated],
        "events": [_event_json(slice_map, event, isolated) for event in _ascending(events)],
        "samples": [exact_str(part.length) for part in samples],
    }


def _systems(systems: EventSystems | None) -> Iterator[tuple[str, System]]:
    if systems is not None:
        yield "swallowtails", systems.swallowtails
        yield "critical poses", systems.critical
        for system in systems.near_shared_angles:
            yield "beside shared angles", system


def _ascending(events: Sequence[Event]) -> list[Event]:
    """Those with a pose, by middles of their lengths."""
    return sorted((e for e in events if e.pose), key=lambda e: fraction_of(e.scaled_length(_FIRST_BITS)))


@dataclass(frozen=True)
class _Isolated:
    """A system with isolating intervals of the roots of its eliminant, ascending, with multiplicities."""

    name: str
    system: System
    eliminant: Certified
    intervals: tuple[tuple[Fraction, Fraction, int], ...]

    @classmethod
    def of(cls, name: str, system: System) -> _Isolated:
        eliminant = Certified.of(system.eliminant)

        def disjoint(bits: int) -> list[tuple[Fraction, Fraction, int]] | None:
            ends = [(_ends(root, bits), multiplicity) for root, multiplicity in eliminant.roots]
            found = sorted((*end, multiplicity) for end, multiplicity in ends if end is not None)
            apart = all(x[1] < y[0] for x, y in pairwise(found))
            return found if apart and len(found) == len(ends) else None

        message = "the roots of the eliminant of transitions could not be isolated"
        return cls(name, system, eliminant, tuple(decided(disjoint, _FIRST_BITS, GREATEST_BITS, message)))

    def isolates(self, v: arb) -> bool:
        """Whether one of the intervals holds a ball."""
        return any(ball_of(low) < v < ball_of(high) for low, high, _ in self.intervals)

    def to_json(self) -> dict[str, Any]:
        leg = self.system.slice_map.fixed_leg
        return {"name": self.name, **self.eliminant.to_json(f"v = tan(theta{leg})", self.intervals)}


def _ends(root: RealRoot, bits: int) -> End | None:
    """Two short decimals on either side of a root; None if its ball is too wide for these."""
    ball, unit = root.refined(bits), Fraction(1, 10 ** (bits // _BITS_OF_AN_END))
    with ctx.workprec(2 * bits):
        below = floor(fraction_of(ball) / unit) - 1
        low, high = below * unit, (below + 3) * unit
        return (low, high) if ball_of(low) < ball < ball_of(high) else None


def _event_json(slice_map: SliceMap, event: Event, systems: Sequence[_Isolated]) -> dict[str, Any]:
    """The kind, and a box of the length and both angles."""
    assert event.pose is not None
    pose, leg = event.pose, slice_map.fixed_leg
    mine = [part for part in systems if isinstance(event, BallEvent) and part.system is event.system]

    def box(bits: int) -> list[_Side] | None:
        alpha, theta, *_ = pose.coordinates(2 * bits)
        length = event.scaled_length(2 * bits)
        with ctx.workprec(2 * bits):
            balls = (length / slice_map.scale_ball(), alpha, theta)
            sides = [_Side.of(x, bits // _BITS_OF_A_PLACE) for x in balls]
            if not all(side.holds(x) for side, x in zip(sides, balls, strict=True)):
                return None
            v = (sides[2].ball() * arb.pi() / 180).tan()
            return sides if all(part.isolates(v) for part in mine) else None

    sides = decided(box, _FIRST_BITS, GREATEST_BITS, "a transition could not be enclosed in a short box")
    names = (f"l{leg}", "alpha_deg", f"theta{leg}_deg")
    boxes = {name: side.to_json() for name, side in zip(names, sides, strict=True)}
    return {"kind": pose.kind.value, **boxes}


@dataclass(frozen=True)
class _Side:
    """A side of a box: a decimal centre, and two units of its last place as the radius."""

    centre: Fraction
    places: int

    @classmethod
    def of(cls, x: arb, places: int) -> _Side:
        """Round the middle of a ball; a number far below 1 gets more places."""
        middle = fraction_of(x)
        if middle:
            places += max(0, len(integer_text(middle.denominator)) - len(integer_text(abs(middle.numerator))))
        return cls(Fraction(round(middle * 10**places), 10**places), places)

    def ball(self) -> arb:
        """All its numbers."""
        return ball_of(self.centre) + arb(0, 1) * self._radius

    def holds(self, x: arb) -> bool:
        """Whether a ball lies within."""
        return bool(abs(x - ball_of(self.centre)) < self._radius)

    @property
    def _radius(self) -> arb:
        return arb(2) / arb(10) ** self.places

    def to_json(self) -> dict[str, str]:
        return {"centre": exact_str(self.centre), "radius": f"2e-{self.places}"}
