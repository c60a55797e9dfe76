"""Intervals of L with a constant number of cusps: the events in order, and a slice in each interval.

Between two neighbouring events no pose of a slice is degenerate, so the number of cusps of one exact slice is
that of the whole interval (mathematics.md#completeness-of-the-events). If events are not isolated, as for
similar or congruent triangles, they are those of the curves on which all cusps lie (component_events.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import pairwise
from math import floor

from flint import ctx

from rpr_solver.contract import MIN_DIGITS, Progress
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.precision import GREATEST_BITS, decided
from rpr_solver.exact.real_roots import fraction_of
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import Leg, SliceMap
from rpr_solver.slices.cusp_table import solve_slice
from rpr_solver.slices.eliminant import Eliminant, eliminate
from rpr_solver.slices.slice_table import SliceTable
from rpr_solver.transitions.component_events import ComponentEvents, distinct
from rpr_solver.transitions.event_systems import ELIMINATION_STEPS, EventSystems, NotGeneric
from rpr_solver.transitions.event_types import Event, Landmark
from rpr_solver.transitions.events import events, limit_events
from rpr_solver.transitions.order import grouped

_FIRST_BITS = 128
_WIDE = 16

LimitEvents = Callable[[Leg, Fraction], Iterator[Event]]
"""The lengths at which a cusp has, or may have, a squared free leg (scaled); NotGeneric if not isolated."""


@dataclass(frozen=True)
class Survey:
    """Events by ascending L, those of equal L together, and a slice before, between and after them.

    ``slices`` has one entry more than ``groups``. ``method`` is ``"events"`` or ``"components"``. ``events``
    are those of all lengths, and ``systems`` the equations that they solve, where they are isolated.
    """

    eliminant: Eliminant
    groups: tuple[tuple[Event, ...], ...]
    slices: tuple[SliceTable, ...]
    method: str
    events: tuple[Event, ...]
    systems: EventSystems | None


def survey(
    manipulator: Manipulator,
    fixed_leg: int,
    progress: Progress,
    *,
    start: Fraction = Fraction(0),
    stop: Fraction | None = None,
    digits: int = MIN_DIGITS,
    more: Callable[[SliceMap, LimitEvents], Iterable[Event]] | None = None,
) -> Survey:
    """All events strictly within a range of lengths > 0, and the slices between.

    Args:
        manipulator: the geometry.
        fixed_leg: the leg of fixed length.
        progress: callback ``progress(done, total)``; ``total`` may grow.
        start, stop: the range in the user's unit; None is an open end.
        digits: the significant digits of the slices.
        more: gives further events, such as those of joint limits.

    Raises:
        InputError: ``fixed_leg`` is not 1, 2 or 3.
        SolverError: an event could not be decided.
    """
    eliminant = eliminate(manipulator, fixed_leg)
    slice_map = eliminant.slice_map
    found = _events(eliminant, lambda done, _: progress(done, ELIMINATION_STEPS + 1))
    low, high = (Landmark(Field.rationals()(end * slice_map.scale)) if end else None for end in (start, stop))
    ends = [end for end in (low, high) if end is not None]
    groups = grouped([*found.events, *ends, *(more(slice_map, found.limit_events) if more else ())])
    first = 0 if low is None else _position(groups, low) + 1
    last = len(groups) if high is None else _position(groups, high)
    inside = tuple(tuple(found.distinct(group)) for group in groups[first:last])
    slices = []
    for length in _sample_lengths(slice_map, low, [group[0] for group in inside], high):
        slices.append(solve_slice(eliminant, length, digits))
        progress(ELIMINATION_STEPS + len(slices), ELIMINATION_STEPS + len(inside) + 1)
    return Survey(eliminant, inside, tuple(slices), found.method, found.events, found.systems)


@dataclass(frozen=True)
class _Found:
    """All events of a manipulator, and how they were found."""

    method: str
    events: tuple[Event, ...]
    systems: EventSystems | None
    limit_events: LimitEvents
    distinct: Callable[[Sequence[Event]], Sequence[Event]]


def _events(eliminant: Eliminant, progress: Progress) -> _Found:
    try:
        systems = EventSystems.of(eliminant.slice_map, progress)
        limits = partial(limit_events, systems)
        return _Found("events", tuple(events(systems)), systems, limits, lambda group: group)
    except NotGeneric:
        components = ComponentEvents.of(eliminant.slice_map)
        return _Found("components", tuple(components.events()), None, components.limit_events, distinct)


def _position(groups: Sequence[Sequence[Event]], landmark: Landmark) -> int:
    return next(i for i, group in enumerate(groups) if any(event is landmark for event in group))


def _sample_lengths(
    slice_map: SliceMap, low: Event | None, places: Sequence[Event], high: Event | None
) -> Iterator[Fraction]:
    """A short decimal (user's unit) in each interval between neighbours; None stands for the ends 0 and ∞."""
    for below, above in pairwise([low, *places, high]):
        if above is not None:
            yield _short_between(*(x / slice_map.scale for x in _gap(below, above)))
        elif below is not None:
            last = _bounds(below, _FIRST_BITS)[1] / slice_map.scale
            yield _short_between(last, 3 * last)
        else:
            yield Fraction(1)


def _gap(below: Event | None, above: Event) -> tuple[Fraction, Fraction]:
    """Two rationals between neighbours, almost as far apart as these."""

    def gap(bits: int) -> tuple[Fraction, Fraction] | None:
        low, high = (Fraction(0), Fraction(0)) if below is None else _bounds(below, bits)
        next_low, next_high = _bounds(above, bits)
        wide = next_low - high > _WIDE * (high - low + next_high - next_low)
        return (high, next_low) if wide else None

    return decided(gap, _FIRST_BITS, GREATEST_BITS, "two neighbouring transitions could not be separated")


def _bounds(place: Event, bits: int) -> tuple[Fraction, Fraction]:
    ball = place.scaled_length(bits)
    with ctx.workprec(bits):
        return fraction_of(ball.lower()), fraction_of(ball.upper())


def _short_between(low: Fraction, high: Fraction) -> Fraction:
    """A decimal with few digits strictly between."""
    step = Fraction(1)
    while step > (high - low) / 4:
        step /= 10
    return floor((low + high) / 2 / step) * step
