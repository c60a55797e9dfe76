"""The census: every L at which the number of cusps changes, and the proved number between.

Between two neighbouring events no pose of a slice is degenerate, so one exact count there holds for
the whole interval (events.py says why the events are complete). Where events are not isolated, as for
similar or flat triangles, the discriminant of the eliminant Q(u, L) takes their place (discriminant.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import ceil, floor
from typing import Any

from flint import arb, ctx

from rpr_solver.cusps import DEFAULT_DIGITS, MAX_DIGITS, MIN_DIGITS, SliceTable, solve_slice
from rpr_solver.decimals import round_ball, round_fraction
from rpr_solver.discriminant import candidate_lengths
from rpr_solver.eliminant import SOLVER_VERSION, Eliminant, eliminate
from rpr_solver.errors import InputError, SolverError
from rpr_solver.events import BallEvent, Event, events
from rpr_solver.geometry import Manipulator
from rpr_solver.points import JointPoint, digit_bits, in_half_open_range
from rpr_solver.roots import MAX_BITS
from rpr_solver.simultaneous import grouped
from rpr_solver.surface import Surface
from rpr_solver.transitions import ELIMINATION_STEPS, EventSystems, NotGeneric

Progress = Callable[[int, int], None]
"""Told the steps done and their number, which may grow."""

_GAP_BITS = 64


@dataclass(frozen=True)
class TransitionPoint:
    """One degenerate pose of a transition."""

    kind: str
    point: JointPoint


@dataclass(frozen=True)
class Transition:
    """A length of the fixed leg at which cusps are born or die, or a degenerate pose is passed.

    ``length`` is a correctly rounded decimal in the user's unit. ``kind`` is that of its points, or
    "several" where they differ.
    """

    length: str
    kind: str
    count_before: int
    count_after: int
    points: tuple[TransitionPoint, ...]


@dataclass(frozen=True)
class Census:
    """All transitions of a manipulator, ascending, and the number of cusps in each interval between.

    ``counts`` has one entry more than ``transitions``.
    """

    manipulator: Manipulator
    fixed_leg: int
    digits: int
    transitions: tuple[Transition, ...]
    counts: tuple[int, ...]
    certificate: dict[str, object] = field(repr=False)

    def to_json(self) -> dict[str, object]:
        """The contract's census document over the whole range."""
        leg = self.fixed_leg
        ends = ["0", *(t.length for t in self.transitions), None]
        return {
            "geometry": self.manipulator.to_json(),
            "geometry_hash": self.manipulator.geometry_hash,
            "fixed_leg": leg,
            "digits": self.digits,
            "solver_version": SOLVER_VERSION,
            "range": {"from": "0", "to": None},
            "transitions": [
                {
                    f"l{leg}": t.length,
                    "kind": t.kind,
                    "count_before": t.count_before,
                    "count_after": t.count_after,
                    "events": [{"kind": p.kind, **p.point.to_json(leg)} for p in t.points],
                }
                for t in self.transitions
            ],
            "intervals": [
                {"from": start, "to": stop, "count": count}
                for start, stop, count in zip(ends, ends[1:], self.counts, strict=False)
            ],
            "certificate": self.certificate,
        }


def census(
    manipulator: Manipulator,
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    progress: Progress | None = None,
) -> Census:
    """Every transition of the slices of one leg, over all lengths > 0 (method.md section 5).

    Args:
        manipulator: the geometry.
        fixed_leg: the leg that is held, 1, 2 or 3.
        digits: significant digits of every printed number.
        progress: told the steps done and their number.

    Raises:
        InputError: ``fixed_leg`` or ``digits`` is out of range.
        SolverError: a transition could not be decided; nothing was guessed.
    """
    if not MIN_DIGITS <= digits <= MAX_DIGITS:
        raise InputError.of("digits", f"is {digits}; give {MIN_DIGITS} to {MAX_DIGITS}")
    surface = Surface.of(manipulator, fixed_leg)
    report = progress or silent
    eliminant = eliminate(manipulator, fixed_leg)
    found, systems = all_events(eliminant, lambda done, _: report(done, ELIMINATION_STEPS + 1))
    method = "discriminant" if systems is None else "events"
    groups = grouped(surface, found)
    counts = _counts(eliminant, groups, report, simple_only=systems is None)
    kept = [
        (group, before, after)
        for group, before, after in zip(groups, counts, counts[1:], strict=False)
        if before != after or any(event.kind for event in group)
    ]
    transitions = tuple(_transition(surface, *item, digits) for item in kept)
    certificate: dict[str, object] = {
        "method": method,
        "lengths_examined": len(groups),
        "counts_by": "exact slices between neighbours",
    }
    return Census(
        manipulator,
        fixed_leg,
        digits,
        transitions,
        (counts[0], *(after for _, _, after in kept)),
        certificate,
    )


def all_events(eliminant: Eliminant, progress: Progress) -> tuple[list[Event], EventSystems | None]:
    """Every length at which the count can change; without systems where events are not isolated."""
    try:
        systems = EventSystems.of(eliminant.surface, progress)
        return list(events(systems)), systems
    except NotGeneric:
        return list(candidate_lengths(eliminant)), None


def _counts(
    eliminant: Eliminant,
    groups: Sequence[Sequence[Event]],
    report: Callable[[int, int], None],
    *,
    simple_only: bool,
) -> list[int]:
    """The exact number of cusps in each interval between neighbouring lengths, from 0 to ∞.

    With ``simple_only``, every cusp must be a simple root of Q, whose count the discriminant governs.
    """
    total = ELIMINATION_STEPS + len(groups) + 1
    counts = []
    for done, length in enumerate(sample_lengths(eliminant.surface, [group[0] for group in groups]), 1):
        table = solve_slice(eliminant, length, MIN_DIGITS)
        if simple_only and _cusps_at_multiple_roots(table):
            raise SolverError(
                "the census of this degenerate geometry is not supported: cusps at multiple roots"
            )
        counts.append(table.count)
        report(ELIMINATION_STEPS + done, total)
    return counts


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


def _transition(surface: Surface, group: Sequence[Event], before: int, after: int, digits: int) -> Transition:
    named = [event for event in group if event.kind]
    points = tuple(TransitionPoint(event.kind, _point(event, digits)) for event in named)
    kinds = {event.kind for event in named}
    kind = "unclassified" if not kinds else kinds.pop() if len(kinds) == 1 else "several"
    return Transition(length_text(surface, group, digits), kind, before, after, points)


def length_text(surface: Surface, group: Sequence[Event], digits: int) -> str:
    """The length of simultaneous events as a correctly rounded decimal in the user's unit."""
    for event in group:
        if event.exact_length is not None and event.exact_length.rational is not None:
            return round_fraction(event.exact_length.rational / surface.scale, digits)

    def length(bits: int) -> list[arb]:
        ball = group[0].scaled_length(bits)
        with ctx.workprec(bits):
            return [ball / surface.scale_ball()]

    return _rounded(length, digits, MAX_BITS)[0]


def _point(event: Event, digits: int) -> JointPoint:
    limit = MAX_BITS
    if isinstance(event, BallEvent):
        limit = 8 * digit_bits(digits)
    try:
        texts = _rounded(lambda bits: list(event.coordinates(bits)), digits, limit)
    except SolverError:
        if not isinstance(event, BallEvent):
            raise
        return _point(event.exact(), digits)
    alpha, theta, first, second = texts
    return JointPoint(in_half_open_range(alpha), in_half_open_range(theta), first, second)


def _rounded(balls: Callable[[int], list[arb]], digits: int, limit: int) -> list[str]:
    bits = digit_bits(digits) + 128
    while bits <= limit:
        values = balls(bits)
        with ctx.workprec(bits):
            texts = [round_ball(x, digits) for x in values]
        if None not in texts:
            return [text or "" for text in texts]
        bits *= 2
    raise SolverError("the digits of a transition could not be decided")


def silent(_done: int, _total: int) -> None:
    """The progress of a caller who asked for none."""
