"""Intervals of L with a constant number of cusps: the events in order, and a slice in each interval.

Between two neighbouring events no pose of a slice is degenerate, so the number of cusps of one exact slice is
that of the whole interval (mathematics.md#completeness-of-the-events). If events are not isolated, as
for similar or congruent triangles, the discriminant of Q(u, L) takes their place (discriminant.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import floor

from flint import ctx

from rpr_solver.contract import MIN_DIGITS, Progress
from rpr_solver.errors import SolverError
from rpr_solver.exact.number_field import Field
from rpr_solver.exact.precision import GREATEST_BITS, decided
from rpr_solver.exact.real_roots import fraction_of
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.cusp_table import solve_slice
from rpr_solver.slices.eliminant import Eliminant, eliminate
from rpr_solver.slices.slice_table import SliceTable
from rpr_solver.transitions.discriminant import candidate_lengths
from rpr_solver.transitions.event_systems import ELIMINATION_STEPS, EventSystems, NotGeneric
from rpr_solver.transitions.event_types import Event, Landmark
from rpr_solver.transitions.events import events
from rpr_solver.transitions.order import grouped

_FIRST_BITS = 128
_WIDE = 16


@dataclass(frozen=True)
class Survey:
    """Events by ascending L, those of equal L together, and a slice before, between and after them.

    ``slices`` has one entry more than ``groups``. ``method`` is ``"events"`` or ``"discriminant"``.
    """

    eliminant: Eliminant
    groups: tuple[tuple[Event, ...], ...]
    slices: tuple[SliceTable, ...]
    method: str


def survey(
    manipulator: Manipulator,
    fixed_leg: int,
    progress: Progress,
    *,
    start: Fraction = Fraction(0),
    stop: Fraction | None = None,
    digits: int = MIN_DIGITS,
    more: Callable[[SliceMap, EventSystems | None], Iterable[Event]] | None = None,
) -> Survey:
    """All events strictly within a range of lengths > 0, and the slices between.

    Args:
        manipulator: the geometry.
        fixed_leg: the leg of fixed length.
        progress: callback ``progress(done, total)``; ``total`` may grow.
        start, stop: the range in the user's unit; None is an open end.
        digits: the significant digits of the slices.
        more: gives further events from the slice map and the event systems, None if events are not isolated.

    Raises:
        InputError: ``fixed_leg`` is not 1, 2 or 3.
        SolverError: an event could not be decided.
    """
    eliminant = eliminate(manipulator, fixed_leg)
    slice_map = eliminant.slice_map
    isolated, systems = _events(eliminant, lambda done, _: progress(done, ELIMINATION_STEPS + 1))
    low, high = (Landmark(Field.rationals()(end * slice_map.scale)) if end else None for end in (start, stop))
    ends = [end for end in (low, high) if end is not None]
    groups = grouped([*isolated, *ends, *(more(slice_map, systems) if more else ())])
    first = 0 if low is None else _position(groups, low) + 1
    last = len(groups) if high is None else _position(groups, high)
    inside = tuple(map(tuple, groups[first:last]))
    slices = []
    for length in _sample_lengths(slice_map, low, [group[0] for group in inside], high):
        table = solve_slice(eliminant, length, digits)
        # the discriminant only shows where simple roots of Q meet
        if systems is None and _cusps_at_multiple_roots(table):
            raise SolverError(
                "the census of this degenerate geometry is not supported: cusps at multiple roots"
            )
        slices.append(table)
        progress(ELIMINATION_STEPS + len(slices), ELIMINATION_STEPS + len(inside) + 1)
    return Survey(eliminant, inside, tuple(slices), "discriminant" if systems is None else "events")


def _events(eliminant: Eliminant, progress: Progress) -> tuple[list[Event], EventSystems | None]:
    """All events with their systems, or those of the discriminant and None if events are not isolated."""
    try:
        systems = EventSystems.of(eliminant.slice_map, progress)
        return list(events(systems)), systems
    except NotGeneric:
        return list(candidate_lengths(eliminant)), None


def _cusps_at_multiple_roots(table: SliceTable) -> bool:
    """Whether some cusp may lie above a multiple root: Q has one, and a cusp was decided exactly."""
    certificate = table.certificate
    multiple = any(x["origin"] == "cusps" and x["multiplicity"] > 1 for x in certificate["factors"])
    return multiple and any("field_degree" in proof for proof in certificate["proofs"])


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
