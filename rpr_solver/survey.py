"""The axis of L in intervals of constant number of cusps: its events in order, and a slice in each interval.

Between two neighbouring events no pose of a slice is degenerate, so the cusps of one exact slice there stand
for those of the whole interval (events.py says why the events are complete). Where events are not isolated,
as for similar or flat triangles, the discriminant of Q(u, L) takes their place (discriminant.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor
from typing import Any

from flint import arb, ctx

from rpr_solver.cusps import MIN_DIGITS, SliceTable, solve_slice
from rpr_solver.discriminant import candidate_lengths
from rpr_solver.eliminant import Eliminant, eliminate
from rpr_solver.errors import SolverError
from rpr_solver.events import Event, events
from rpr_solver.geometry import Manipulator
from rpr_solver.roots import MAX_BITS
from rpr_solver.simultaneous import grouped
from rpr_solver.surface import Surface
from rpr_solver.transitions import ELIMINATION_STEPS, EventSystems, NotGeneric

Progress = Callable[[int, int], None]
"""Told the steps done and their number, which may grow."""

_GAP_BITS = 64


@dataclass(frozen=True)
class Survey:
    """Events by ascending L, those of equal L together, and a slice before, between and after them.

    ``slices`` has one entry more than ``groups``. ``method`` says how the events were found.
    """

    eliminant: Eliminant
    groups: tuple[tuple[Event, ...], ...]
    slices: tuple[SliceTable, ...]
    method: str


def survey(manipulator: Manipulator, fixed_leg: int, progress: Progress) -> Survey:
    """All events over L > 0, and the slices between.

    Raises:
        InputError: ``fixed_leg`` is not 1, 2 or 3.
        SolverError: an event could not be decided; nothing was guessed.
    """
    eliminant = eliminate(manipulator, fixed_leg)
    found, systems = all_events(eliminant, lambda done, _: progress(done, ELIMINATION_STEPS + 1))
    groups = tuple(map(tuple, grouped(eliminant.surface, found)))
    slices = []
    for length in sample_lengths(eliminant.surface, [group[0] for group in groups]):
        table = solve_slice(eliminant, length, MIN_DIGITS)
        # the discriminant governs simple roots of Q only
        if systems is None and _cusps_at_multiple_roots(table):
            raise SolverError(
                "the census of this degenerate geometry is not supported: cusps at multiple roots"
            )
        slices.append(table)
        progress(ELIMINATION_STEPS + len(slices), ELIMINATION_STEPS + len(groups) + 1)
    return Survey(eliminant, groups, tuple(slices), "discriminant" if systems is None else "events")


def all_events(eliminant: Eliminant, progress: Progress) -> tuple[list[Event], EventSystems | None]:
    """Every length at which the count can change; without systems where events are not isolated."""
    try:
        systems = EventSystems.of(eliminant.surface, progress)
        return list(events(systems)), systems
    except NotGeneric:
        return list(candidate_lengths(eliminant)), None


def _cusps_at_multiple_roots(table: SliceTable) -> bool:
    """Whether some cusp may lie above a multiple root: one was settled exactly, and there is such a root."""
    certificate: Any = table.certificate
    multiple = any(x["origin"] == "cusps" and x["multiplicity"] > 1 for x in certificate["factors"])
    return multiple and any("field_degree" in proof for proof in certificate["proofs"])


def sample_lengths(surface: Surface, places: Sequence[Event]) -> Iterator[Fraction]:
    """A short rational length (user's unit) in each interval between neighbouring events."""
    below = Fraction(0)
    for place, above in zip(places, [*places[1:], None], strict=True):
        low, high = _bounds(surface, place, above)
        yield _short_between(below, low)
        below = high
    yield below * 2 if places else Fraction(1)


def _bounds(surface: Surface, place: Event, above: Event | None) -> tuple[Fraction, Fraction]:
    """Rationals just below and above an event, the upper one below the next event."""
    bits = _GAP_BITS
    while bits <= MAX_BITS:
        ball = place.scaled_length(bits + 64)
        with ctx.workprec(bits + 64):
            low, high = _fraction(ball.lower()), _fraction(ball.upper())
            apart = above is None or ball.upper() < above.scaled_length(bits + 64).lower()
        margin = (high - low) or low / 2**bits
        if apart and low > margin:
            return (low - margin) / surface.scale, (high + margin) / surface.scale
        bits *= 2
    raise SolverError("two neighbouring transitions could not be separated")


def _short_between(low: Fraction, high: Fraction) -> Fraction:
    """A decimal with few digits strictly between."""
    step = Fraction(1)
    while step > (high - low) / 4:
        step /= 10
    middle = (low + high) / 2
    return floor(middle / step) * step if floor(middle / step) * step > low else ceil(middle / step) * step


def _fraction(x: arb) -> Fraction:
    mantissa, exponent = x.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def silent(_done: int, _total: int) -> None:
    """The progress of a caller who asked for none."""
