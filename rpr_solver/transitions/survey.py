"""Intervals of L with a constant number of cusps: the events in order, and a slice in each interval.

Between two neighbouring events no pose of a slice is degenerate, so the number of cusps of one exact slice is
that of the whole interval (mathematics.md#completeness-of-the-events); the next follows where it is proved
what events change (mathematics.md#what-changes-at-an-event). If events are not isolated, as for similar or
congruent triangles, they are those of the curves on which all cusps lie (components.py).

Events of a symmetric manipulator come in pairs of equal L. No precision shows that two numbers are equal:
equality is proved by minimal polynomials, or by a symmetry of the manipulator (mathematics.md#equal-lengths).

So each interval has one number of aspects, too (mathematics.md#numbers-of-aspects); a swallowtail does not
change it. If events are not isolated, their lengths are not known, and no number is given."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, cmp_to_key, partial
from itertools import pairwise
from math import prod

from flint import acb, arb, ctx

from rpr_solver.contract import MIN_DIGITS, Progress, check_type
from rpr_solver.errors import SolverError, Unproved
from rpr_solver.exact import decided
from rpr_solver.exact.factors import minimal_polynomial, same_number
from rpr_solver.exact.number_field import Algebraic, Field
from rpr_solver.exact.precision import EVENT_BITS, GREATEST_BITS, LENGTH_BITS, decided_or_none
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.rationals import short_between
from rpr_solver.exact.real_roots import fraction_of, number_of_real_roots, real_roots
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.joint_points import PoseKind
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.singular.aspects import number_of_aspects
from rpr_solver.slices import Eliminant, eliminate
from rpr_solver.slices.reference import ReferenceSlice
from rpr_solver.slices.slice_table import SliceTable
from rpr_solver.transitions.components import Components, distinct, once
from rpr_solver.transitions.event_systems import (
    ELIMINATION_STEPS,
    Event,
    EventSystems,
    Landmark,
    NotGeneric,
    System,
    length_form,
)
from rpr_solver.transitions.isolated_events import BallEvent, events, limit_events, sums_of_lengths
from rpr_solver.transitions.symmetries import Symmetry, symmetries

_ORDER_BITS = 256
_MOST_SPREAD = 10**60
"""Of the longest and the shortest side: roots that are so far apart take six seconds, or more."""
_SMALL_DEGREE = 8
"""Of number fields of lengths with which those of events are compared by a form."""


def grouped(events: Sequence[Event]) -> list[list[Event]]:
    """The events by ascending L, those of equal L together.

    Raises:
        Unproved: two lengths can be neither separated nor proved equal.
    """

    groups: list[list[Event]] = []
    for event in sorted(events, key=cmp_to_key(_compare)):
        if groups and _compare(groups[-1][0], event) == 0:
            groups[-1].append(event)
        else:
            groups.append([event])
    return groups


def _compare(x: Event, y: Event) -> int:
    if x is y:
        return 0
    tested: list[int] = []

    def order(bits: int) -> int | None:
        a, b = x.scaled_length(bits), y.scaled_length(bits)
        if not a.overlaps(b):
            return -1 if a < b else 1
        if tested or bits < min(2 * _bits(a), LENGTH_BITS):  # long ones differ far behind the point
            return None
        tested.append(bits)
        return 0 if _equal(x, y) else None

    message = "two transitions are nearer than 1e-2000 and could not be proved to be one"
    return decided(order, _ORDER_BITS, LENGTH_BITS, message)


def _bits(x: arb) -> int:
    """About how many bits a length has before the point."""
    mantissa, exponent = x.mid().man_exp()
    return int(exponent) + int(mantissa).bit_length()


def _equal(x: Event, y: Event) -> bool:
    if x.exact_length is not None and y.exact_length is not None:
        return same_number(x.exact_length, y.exact_length)
    if isinstance(x, BallEvent) and isinstance(y, BallEvent):
        return any(_is_image(symmetry, x, y) for symmetry in symmetries(x.system.slice_map))
    ball, other = (x, y) if isinstance(x, BallEvent) else (y, x)
    if not isinstance(ball, BallEvent) or other.exact_length is None:
        return False
    if other.exact_length.field.degree <= _SMALL_DEGREE:
        return _has_length(ball, other.exact_length)
    return same_number(ball.exact().length, other.exact_length)


def _has_length(event: BallEvent, length: Algebraic) -> bool:
    """Proves that an event has a length: its square is a root of the same polynomial, and of the same one."""
    squares = minimal_polynomial(length * length).numer()
    if not event.is_zero(length_form(event.system.slice_map, squares)):
        return False
    roots = real_roots(QuadraticPoly.rational(squares))

    def same(bits: int) -> bool | None:
        with ctx.workprec(bits):
            own, other = event.scaled_length(bits) ** 2, length.ball(bits) ** 2
        near = [[root for root in roots if root.refined(bits).overlaps(x)] for x in (own, other)]
        return near[0][0] is near[1][0] if len(near[0]) == len(near[1]) == 1 else None

    return bool(decided_or_none(same, _ORDER_BITS, LENGTH_BITS))


def _is_image(symmetry: Symmetry, x: BallEvent, y: BallEvent) -> bool:
    """Proves that a symmetry maps x to y; False if there is no proof.

    The image is an event of the same system, so its v = tan θ/√ρ is a root of the eliminant, as that of y is,
    which is simple. If the derivative is not 0 between the two, they are one root, above which is one event.
    """
    if x.kind is not y.kind or not _maps(symmetry, x, y.system):
        return False
    system = y.system

    def proved(bits: int) -> bool | None:
        image, own = symmetry.image(*_directions(x, bits), bits), _directions(y, bits)
        if not all(a.overlaps(b) for a, b in zip(image, own, strict=True)):
            return False
        with ctx.workprec(bits):
            bridge = Bridge.of(system.slice_map)
            first, second = (bridge.whole_tangent(theta) for _, theta in (image, own))
            if not (first.is_finite() and second.is_finite()):
                return False
            slope = system.eliminant.polynomial.ball(bits).derivative()(first.union(second))
            # beside a special shape, roots are close to each other
            return None if slope.contains(0) else True

    return bool(decided_or_none(proved, _ORDER_BITS, EVENT_BITS))


def _maps(symmetry: Symmetry, x: BallEvent, system: System) -> bool:
    """Whether a symmetry maps an event to an event of a system."""
    if x.kind is not None:
        return x.system is system
    ours, theirs = x.system.limit, system.limit
    # where a free leg has length 0, C = 0 need not be a cusp
    open_legs = all(length > 0 for length in x.coordinates(_ORDER_BITS)[2:])
    return (
        ours is not None
        and theirs is not None
        and (ours.square, ours.leg, theirs.leg) == (theirs.square, symmetry.target, symmetry.source)
        and open_legs
    )


def _directions(event: BallEvent, bits: int) -> tuple[acb, acb]:
    """exp(iα) and exp(iθ)."""
    alpha, theta, _, _ = event.coordinates(bits)
    with ctx.workprec(bits):
        return acb(alpha / 180).exp_pi_i(), acb(theta / 180).exp_pi_i()


_GAP_BITS = 128
_WIDE = 16

LimitEvents = Callable[[Leg, Fraction], Iterator[Event]]
"""The lengths at which a cusp has, or may have, a squared free leg (scaled); NotGeneric if not isolated."""


class CountedSlice:
    """A slice whose cusps are counted at once, and computed when they are asked for.

    Args:
        eliminant: of the manipulator and its fixed leg.
        length: of the fixed leg, in the user's unit, > 0.
        digits: significant digits of every printed number.
        count: of its cusps, if it is known; then no other pose is degenerate.

    Raises:
        SolverError: the slice could not be decided.
    """

    def __init__(self, eliminant: Eliminant, length: Fraction, digits: int, count: int | None = None) -> None:
        self.length, self.digits = length, digits
        self._reference = ReferenceSlice(eliminant, length, digits)
        self._has_cusps_alone = count is not None or self._reference.is_generic
        self.count = self._counted() if count is None else count

    def _counted(self) -> int:
        return number_of_real_roots(self._reference.q) if self._has_cusps_alone else self.table.count

    @cached_property
    def table(self) -> SliceTable:
        """The cusps."""
        return self._reference.solve()

    @property
    def degenerate_points(self) -> Sequence[Mapping[str, str]]:
        """As in the table."""
        return () if self._has_cusps_alone else self.table.degenerate_points


@dataclass(frozen=True)
class Survey:
    """Events by ascending L, those of equal L together, and a slice before, between and after them.

    ``slices`` has one entry more than ``groups``. ``method`` is ``"events"`` or ``"components"``.
    """

    eliminant: Eliminant
    groups: tuple[tuple[Event, ...], ...]
    slices: tuple[CountedSlice, ...]
    method: str

    @property
    def tables(self) -> list[SliceTable]:
        """The slices with their cusps."""
        self.eliminant.expect(len(self.slices))
        return [part.table for part in self.slices]


def survey(
    manipulator: Manipulator,
    fixed_leg: int,
    progress: Progress,
    *,
    start: Fraction = Fraction(0),
    stop: Fraction | None = None,
    digits: int = MIN_DIGITS,
    extra_events: Callable[[SliceMap, LimitEvents], Iterable[Event]] | None = None,
) -> Survey:
    """All events strictly within a range of lengths > 0, and the slices between.

    Args:
        manipulator: the geometry.
        fixed_leg: the leg of fixed length.
        progress: callback ``progress(done, total)``; ``total`` may grow.
        start, stop: the range in the user's unit; None is an open end.
        digits: the significant digits of the slices.
        extra_events: gives further events, such as those of joint limits.

    Raises:
        InputError: naming ``manipulator`` or ``fixed_leg``.
        SolverError: an event could not be decided, or sides differ too much.
    """
    check_type(manipulator, Manipulator, "manipulator")
    _check_spread(manipulator)
    eliminant = eliminate(manipulator, fixed_leg)
    manipulator.geometry.apart_from_shared()
    slice_map = eliminant.slice_map
    known = _events(eliminant, lambda done, _: progress(done, ELIMINATION_STEPS + 1))
    low, high = (Landmark(Field.rationals()(end * slice_map.scale)) if end else None for end in (start, stop))
    ends = [end for end in (low, high) if end is not None]
    groups = grouped(
        [*known.events, *ends, *(extra_events(slice_map, known.limit_events) if extra_events else ())]
    )
    first = 0 if low is None else _position(groups, low) + 1
    last = len(groups) if high is None else _position(groups, high)
    inside = tuple(tuple(known.distinct(group)) for group in groups[first:last])
    changes = [None, *(_change(group) if known.is_generic else None for group in inside)]
    eliminant.expect(changes.count(None))
    slices: list[CountedSlice] = []
    lengths = _sample_lengths(slice_map, low, [group[0] for group in inside], high)
    for length, change in zip(lengths, changes, strict=True):
        count = None if change is None else slices[-1].count + change
        slices.append(CountedSlice(eliminant, length, digits, count))
        progress(ELIMINATION_STEPS + len(slices), ELIMINATION_STEPS + len(inside) + 1)
    return Survey(eliminant, inside, tuple(slices), known.method)


def _change(group: Sequence[Event]) -> int | None:
    """By how much the number of cusps changes at events of one L; None if that is not proved."""
    changes = [event.change for event in group]
    return None if None in changes else sum(filter(None, changes))


def _check_spread(manipulator: Manipulator) -> None:
    """Refuse sides of very different sizes."""
    base, platform = manipulator.geometry.base, manipulator.geometry.platform
    squares = [square for square in (*base.squares, *platform.squares) if square]
    if max(squares) > min(squares) * _MOST_SPREAD**2:
        raise Unproved(
            "the longest side of the geometry has more than 1e60 times the length of the shortest one: "
            "its transitions lie too far apart to be found"
        )


@dataclass(frozen=True)
class _Found:
    """All events of a manipulator, and how they were found.

    ``is_generic`` tells that between the events cusps are the only degenerate poses.
    """

    method: str
    events: tuple[Event, ...]
    limit_events: LimitEvents
    distinct: Callable[[Sequence[Event]], Sequence[Event]]
    is_generic: bool = False


def _events(eliminant: Eliminant, progress: Progress) -> _Found:
    geometry = eliminant.manipulator.geometry
    if geometry.is_similar and geometry.base.area16:
        return _Found("components", tuple(_of_similar(eliminant)), lambda _leg, _square: iter(()), once)
    try:
        systems = EventSystems.of(eliminant.slice_map, progress)
        limits = partial(limit_events, systems)
        return _Found("events", tuple(events(systems)), limits, once, not systems.near_shared_angles)
    except NotGeneric:
        components = Components.of(eliminant.slice_map)
        return _Found("components", tuple(components.events()), components.limit_events, distinct)


def _of_similar(eliminant: Eliminant) -> Iterator[Event]:
    """The lengths at which similar triangles lose two of their nodes: 2 R |κ ± 1|, R being the radius of the
    circle through the corners of the base, κ the ratio of platform and base (mathematics.md#special-shapes).
    They have no cusps.
    """
    base, platform = eliminant.manipulator.geometry.base, eliminant.manipulator.geometry.platform
    # R² = a b c / (16 times the squared area)
    square = 4 * prod(base.squares) / base.area16 * eliminant.slice_map.scale**2
    return sums_of_lengths(square, square * platform.squares[0] / base.squares[0])


def _position(groups: Sequence[Sequence[Event]], landmark: Landmark) -> int:
    return next(i for i, group in enumerate(groups) if any(event is landmark for event in group))


def _sample_lengths(
    slice_map: SliceMap, low: Event | None, places: Sequence[Event], high: Event | None
) -> Iterator[Fraction]:
    """A short decimal (user's unit) in each interval between neighbours; None stands for the ends 0 and ∞."""
    for below, above in pairwise([low, *places, high]):
        if above is not None:
            yield short_between(*(x / slice_map.scale for x in _gap(below, above)))
        elif below is not None:
            last = _bounds(below, _GAP_BITS)[1] / slice_map.scale
            yield short_between(last, 3 * last)
        else:
            yield Fraction(1)


def _gap(below: Event | None, above: Event) -> tuple[Fraction, Fraction]:
    """Two rationals between neighbours, almost as far apart as these."""

    def gap(bits: int) -> tuple[Fraction, Fraction] | None:
        low, high = (Fraction(0), Fraction(0)) if below is None else _bounds(below, bits)
        next_low, next_high = _bounds(above, bits)
        wide = next_low - high > _WIDE * (high - low + next_high - next_low)
        return (high, next_low) if wide else None

    return decided(gap, _GAP_BITS, GREATEST_BITS, "two neighbouring transitions could not be separated")


def _bounds(place: Event, bits: int) -> tuple[Fraction, Fraction]:
    ball = place.scaled_length(bits)
    with ctx.workprec(bits):
        return fraction_of(ball.lower()), fraction_of(ball.upper())


def numbers_of_aspects(result: Survey, transitions: Sequence[int]) -> tuple[int | None, ...]:
    """The number of aspects between the groups of events that are transitions; None where it is not known.

    Args:
        result: the survey.
        transitions: the numbers of the groups at which intervals end.
    """
    if result.method != "events":
        return (None,) * (len(transitions) + 1)
    slice_map = result.eliminant.slice_map
    numbers: list[int | None] = []
    for k, part in enumerate(result.slices):
        same = bool(k) and all(map(_keeps_the_curve, result.groups[k - 1]))
        numbers.append(numbers[-1] if same else _number(slice_map, part.length))
    ends = [0, *(k + 1 for k in transitions), len(numbers)]
    parts = (set(numbers[start:stop]) for start, stop in pairwise(ends))
    return tuple(part.pop() if len(part) == 1 else None for part in parts)


def _keeps_the_curve(event: Event) -> bool:
    return event.change == 0 or (event.pose is not None and event.pose.kind is PoseKind.SWALLOWTAIL)


def _number(slice_map: SliceMap, length: Fraction) -> int | None:
    """The number of aspects of the slice of a length in the user's unit."""
    try:
        return number_of_aspects(slice_map, length * slice_map.scale)
    except SolverError:
        return None
