"""The events of all slices of a fixed leg, all found anew: where cusps are born or die.

Above each simple real root of their eliminants is one event, or a pose with the length 0 or ∞, and nothing
else (mathematics.md#completeness-of-the-events); each event is proved by Krawczyk's test. So are the lengths
at which a cusp crosses a joint limit (mathematics.md#joint-limits).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

from rpr_solver.verify.angles import (
    beside,
    degenerate_lengths,
    divided,
    exactly,
    in_pairs,
    is_level,
    landmarks_on,
    lengths_at_limit,
    without_length,
)
from rpr_solver.verify.claims import ClaimStatus, Finding
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.krawczyk import Directions, Equations, Pair, value
from rpr_solver.verify.core.numbers import Printed
from rpr_solver.verify.core.reader import Record
from rpr_solver.verify.core.roots import Root, has_root, quotients, real_roots, refined
from rpr_solver.verify.core.surds import ZERO, Poly, Surd, trimmed
from rpr_solver.verify.core.system import Graded, Leg, Surface, less, multiple, slope
from rpr_solver.verify.cusps import UNLIMITED, Count, Limits, Slice, common_angles
from rpr_solver.verify.event_lines import (
    AT_LIMIT,
    CRITICAL,
    SWALLOWTAILS,
    EventEliminant,
    EventLine,
    EventSystem,
    event_eliminant,
)
from rpr_solver.verify.landmarks import (
    Event,
    Landmark,
    Shape,
    Throughout,
    Unclear,
    distinct,
)
from rpr_solver.verify.mirrored import shape_of
from rpr_solver.verify.permanent import permanent_poses

_SPARE_BITS = 40
_STARTS = (128, 512)


def systems(surface: Surface, kind: str) -> Iterator[Equations]:
    """The systems of three equations of a generic kind, any of which finds its events."""
    radicand, j = surface.ring.radicand, surface.singular
    if kind in ("lips", "beak-to-beak"):
        yield Equations((j, *surface.slopes), radicand)
    elif kind == "swallowtail":
        for leg in surface.legs:
            yield Equations((j, leg.kernel, leg.kernel2), radicand)


def event_near(
    surface: Surface, kind: str, start: tuple[Interval, Interval], length: Fraction, bits: int
) -> Event | None:
    """The event of a generic kind near angles in radians and a scaled length; None if none is proved."""
    for equations in systems(surface, kind):
        event = _proved(equations, kind, start, length, bits)
        if event and _is_generic(surface, event):
            return exactly(event, [p for each in systems(surface, kind) for p in each.functions])
    return None


def _proved(
    equations: Equations, kind: str, start: tuple[Interval, Interval], length: Fraction, bits: int
) -> Event | None:
    """The zero of equations near angles in radians and a scaled length; None if none of a length > 0 is."""
    shift = (abs(length.numerator) // length.denominator).bit_length()
    # the length in units of 2^shift, so that it is of the size of the angles
    rows = (tuple(multiple(row, 1 << (shift * k)) for k, row in enumerate(p)) for p in equations.functions)
    near_one = Interval.of(length / (1 << shift), start[0].bits)
    zero = Equations(tuple(rows), equations.radicand).zero_near((*start, near_one), bits + shift)
    if zero is None or zero[2].sign <= 0:
        return None
    here = Directions.of(zero[0], zero[1], equations.radicand)
    return Event(zero[2].scaled(1 << shift), kind=kind, pose=(zero[0], zero[1]), directions=here)


def _is_regular(leg: Leg[Graded], event: Event) -> bool:
    """Whether the gradient of a leg is not 0."""
    return any(value(event.directions, p, event.scaled).sign for p in (leg.alpha, leg.theta))


def _is_generic(surface: Surface, event: Event) -> bool:
    """Whether the zero of the system of a kind is an event of this kind."""
    here, length = event.directions, event.scaled
    regular = [leg for leg in surface.legs if _is_regular(leg, event)]
    if not regular:
        return False
    if event.kind == "swallowtail":
        return any(value(here, p, length).sign for p in surface.slopes)
    rows = [[value(here, slope(p, theta=side), length) for side in (False, True)] for p in surface.slopes]
    (a, b), (c, d) = rows
    if (a * d - b * c).sign != (1 if event.kind == "lips" else -1):
        return False
    return event.kind == "lips" or bool(value(here, regular[0].kernel2, length).sign)


def _crossing_near(
    surface: Surface, system: EventSystem, start: tuple[Interval, Interval], length: Fraction, bits: int
) -> Event | None:
    """The pose at a joint limit with J = E = 0 near angles in radians and a scaled length, or None."""
    squared, radicand = less(surface.legs[system.leg].squared, system.square), surface.ring.radicand
    for leg in surface.legs:
        equations = Equations((surface.singular, leg.kernel, squared), radicand)
        event = _proved(equations, "limit", start, length, bits)
        if event and _is_regular(leg, event) and event.directions.value(surface.singular[1]).sign:
            return exactly(event, (surface.singular, *(leg.kernel for leg in surface.legs), squared))
    return None


def event_finding(surface: Surface, length: Printed, event: Record, events: Events) -> Finding:
    """What is found about a printed event, its length, its digits and its kind, among all that are found."""
    for own in events.found:
        if own.is_printed(surface, length, event):
            return own.exactly(surface, event, "it is one of the events that are found anew, with its digits")
    status = ClaimStatus.REFUSED if events.named else ClaimStatus.NOT_CHECKED
    return status, f"it is none of the {len(events.found)} events that are found anew"


class Events:
    """All events of a manipulator and a fixed leg.

    Attributes:
        surface: the equations.
        shape: a special shape, whose events are known; the next three are empty then.
        lines: those at which the eliminants are computed, with their forms.
        known: those of permanent poses that are known exactly.
        eliminants: of both systems.
        found: the proved events, by their length.
        unnamed: the lengths of others, whose kind is not found.
        open: what is left open about their completeness; empty if there are no others.
    """

    def __init__(self, surface: Surface, bits: int) -> None:
        self.surface, self.bits = surface, bits
        self.shape = shape_of(surface)
        self.lines: dict[int, EventLine] = {}
        self.known: list[EventLine] = []
        self.eliminants: list[EventEliminant] = []
        reasons: set[str] = set()
        unnamed: list[Landmark] = []
        found = self._of_shape(self.shape, reasons) if self.shape else self._isolated(reasons, unnamed)
        self.unnamed = distinct(unnamed)
        self.found = sorted(found, key=lambda event: event.scaled.middle)
        self.open = tuple(sorted(reasons))
        if not (self.open or self.shape):
            self.found = in_pairs(surface, self.found, self.unnamed)

    def _of_shape(self, shape: Shape, reasons: set[str]) -> list[Event]:
        try:
            return shape.events(self.bits)
        except (Unclear, ZeroDivisionError):
            reasons.add("events of a special shape are not told apart")
            return []

    def _isolated(self, reasons: set[str], unnamed: list[Landmark]) -> list[Event]:
        surface, bits = self.surface, self.bits
        systems = SWALLOWTAILS, CRITICAL
        more: list[EventEliminant] = []
        self.eliminants = [self._eliminant(system, more) for system in systems]
        self.known = _permanent_lines(surface)
        searches = [_Search(surface, eliminant, bits, self.known) for eliminant in self.eliminants]
        self.eliminants += more
        others: dict[object, Landmark] = {}
        found = [event for search in searches for event in search.found(reasons, others)]
        try:
            others |= {object(): x for x in degenerate_lengths(surface, bits)}
        except (Unclear, ZeroDivisionError):
            reasons.add("poses that are singular for every length may be degenerate")
        unnamed += (x for x in others.values() if not isinstance(x, Event))
        return [*found, *(x for x in others.values() if isinstance(x, Event))]

    def _eliminant(self, system: EventSystem, others: list[EventEliminant]) -> EventEliminant:
        """The eliminant, without shared angles if there are any; that beside them is added to the list."""
        whole = event_eliminant(self.surface, system, self.lines)
        rest = None if any(map(any, whole.form)) else divided(self.surface, system)
        if rest is None:
            return whole
        if not system.is_critical:
            others.append(beside(self.surface, *rest))
        return event_eliminant(self.surface, rest[0], self.lines)

    def counter(self, limits: Limits) -> Count:
        """What counts the cusps of a slice within joint limits."""
        shape = self.shape
        if shape is None or self.open:
            return limits.counted
        return lambda part: shape.counted(part.system.length, limits)

    def slice_of(self, length: Fraction) -> Slice:
        """A slice, with the number of its cusps where the shape tells it."""
        found = self.shape.counted(length, UNLIMITED) if self.shape and not self.open else None
        return Slice(self.surface.at(length), found[0] if found else None)

    def throughout(self, start: Fraction, stop: Fraction | None) -> list[Throughout] | None:
        """What is degenerate in all slices of a range but those of single lengths; None if that is open."""
        if self.open:
            return None
        try:
            return self.shape.throughout(start, stop, self.bits) if self.shape else []
        except (Unclear, ZeroDivisionError):
            return None

    @property
    def named(self) -> bool:
        """Whether all events are found with their kinds."""
        return not (self.open or self.unnamed)


class Crossings:
    """All lengths at which a cusp crosses a joint limit.

    Attributes:
        found: the proved crossings, and where a pose that is singular for every length may be one.
        open: what is left open about their completeness; empty if there are no others.
    """

    def __init__(self, events: Events, limits: Iterable[tuple[int, Fraction]], bits: int) -> None:
        surface = events.surface
        self.found: list[Event | Landmark] = []
        reasons: set[str] = set()
        for number, limit in limits:
            # no cusp has a leg of length 0 (mathematics.md#stationary-legs)
            if not limit:
                continue
            leg = next(k for k, leg in enumerate(surface.legs) if leg.number == number)
            if events.shape:
                try:
                    self.found += events.shape.crossings(leg, limit, bits)
                except (Unclear, ZeroDivisionError):
                    reasons.add("cusps are not told apart")
                continue
            system = replace(AT_LIMIT, leg=leg, square=(limit * surface.unit) ** 2)
            search = _Search(surface, event_eliminant(surface, system, events.lines), bits, events.known)
            others: dict[object, Landmark] = {}
            self.found += search.found(reasons, others)
            self.found += others.values()
            try:
                self.found += lengths_at_limit(surface, less(surface.legs[leg].squared, system.square), bits)
            except (Unclear, ZeroDivisionError):
                reasons.add("a pose that is singular for every length may be a cusp")
        self.open = tuple(f"{reason}, at a joint limit" for reason in sorted(reasons))


@dataclass(frozen=True)
class _Search:
    """The events above the roots of an eliminant.

    Attributes:
        surface: the equations.
        eliminant: the eliminant.
        bits: to which the events are needed.
        known: the lines of permanent poses that are known exactly.
    """

    surface: Surface
    eliminant: EventEliminant
    bits: int
    known: Sequence[EventLine]

    def found(self, reasons: set[str], others: dict[object, Landmark]) -> list[Event]:
        """The proved ones; those of exact lines, by names, and what is left open are added."""
        ring, system = self.surface.ring, self.eliminant.system
        if not any(map(any, self.eliminant.form)):
            reasons.add("the events are not isolated")
            return []
        own: list[Event] = []
        for multiplicity, part in self.eliminant.parts.items():
            lines = {line: line.clear(system) for line in self._lines(part)}
            rest: Sequence[Surd] = part
            for line, clear in lines.items():
                if clear or multiplicity > 1:
                    rest = line.v.divided(rest)
                if not clear and multiplicity > 1:
                    others |= landmarks_on(line, system, self.bits, self._near)
            if multiplicity == 1:
                self._simple(rest, lines, own, reasons, others)
            elif real_roots(ring, rest):
                reasons.add("an eliminant has multiple real roots")
        return own

    def _simple(
        self,
        part: Sequence[Surd],
        lines: Iterable[EventLine],
        own: list[Event],
        reasons: set[str],
        others: dict[object, Landmark],
    ) -> None:
        """Adds the events above the roots of a part of the simple ones."""
        ring, system = self.surface.ring, self.eliminant.system
        finite = trimmed(part)
        rest = ring.field_quotient(finite, ring.gcd(finite, self._without_length))
        part = rest + (ZERO,) * (len(part) - len(finite))
        for root in real_roots(ring, part):
            event = self._above(root, part)
            if event is not None and all(_apart(event.directions.theta, x.directions.theta) for x in own):
                own.append(event)
            elif event is not None:
                reasons.add("two events are above one root, as far as intervals tell")
            else:
                line = next((line for line in lines if has_root(ring, tuple(part), root, line.v.form)), None)
                if line is None:
                    reasons.add("above a root the length is 0 or infinite, as far as intervals tell")
                else:
                    others |= landmarks_on(line, system, self.bits, self._near)

    @cached_property
    def _without_length(self) -> Poly:
        return without_length(self.surface, self.eliminant.system)

    def _lines(self, part: Poly) -> Iterator[EventLine]:
        """The lines that are known exactly, and are roots of a part."""
        ring = self.surface.ring
        if (exact := quotients(ring, part)) is None:
            roots = [root.ratio for root in real_roots(ring, part) if not root.width]
            exact = [((n, 0), (d, 0)) for n, d in roots]
        seen: list[EventLine] = []
        for line in (*(EventLine(self.surface, *pair) for pair in exact), *self.known):
            if line.v.is_root(part) and not any(line.v.is_same(other.v) for other in seen):
                seen.append(line)
                yield line

    def _above(self, root: Root, part: Sequence[Surd]) -> Event | None:
        """The event above a simple root, one of a part; None if none is proved."""
        ring, system = self.surface.ring, self.eliminant.system
        for fine in _STARTS:
            narrow = refined(ring, part, root, Fraction(1, 1 << fine))
            n, d = narrow.ratio
            line = EventLine(self.surface, (n, 0), (d, 0))
            try:
                p, q, _ = line.pair(system)
            except ZeroDivisionError:  # beside the line of a permanent pose
                continue
            for alpha in common_angles(ring, p, q, fine):
                for theta in line.angles(fine):
                    length = line.length(alpha, theta)
                    if length is None:
                        continue
                    event = self._near((alpha, theta), length)
                    if event is not None and line.near(event.directions.theta, narrow):
                        known = narrow.width == 0
                        level = (
                            p[0] == q[0] == ZERO
                            if known
                            else is_level(self.surface, system, event, tuple(part), root)
                        )
                        zeros = {"alpha_deg"} if level else set()
                        zeros |= {f"theta{self.surface.fixed}_deg"} if known and n == 0 else set()
                        return replace(event, zeros=frozenset(zeros))
        return None

    def _near(self, start: tuple[Interval, Interval], length: Fraction) -> Event | None:
        surface, system, bits = self.surface, self.eliminant.system, max(self.bits, 2 * _SPARE_BITS)
        if system.kinds == ("limit",):
            return _crossing_near(surface, system, start, length, bits)
        found = (event_near(surface, kind, start, length, bits) for kind in system.kinds)
        event = next((event for event in found if event is not None), None)
        # else it may be a permanent pose
        return event if event and event.directions.value(surface.singular[1]).sign else None


def _permanent_lines(surface: Surface) -> list[EventLine]:
    """The lines of the permanent poses whose tan θ is in ℚ(ω)."""
    try:
        poses = permanent_poses(surface)
    except Unclear:
        return []
    return [EventLine(surface, y[0], x[0]) for x, y in (p.along for p in poses) if x[1] == y[1] == ZERO]


def _apart(first: Pair, second: Pair) -> bool:
    """Whether two directions, each of either sense, are different."""
    return bool((first[0] * second[1] - first[1] * second[0]).sign)
