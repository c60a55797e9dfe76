"""Events in the order of L, grouped by exactly equal L.

Events of a symmetric manipulator come in pairs of equal L. No precision shows that two numbers are equal:
equality is proved by minimal polynomials, or by the mirror symmetry of the manipulator
(mathematics.md#equal-lengths).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cmp_to_key

from flint import acb, ctx

from rpr_solver.exact.equal_numbers import same_number
from rpr_solver.exact.precision import LENGTH_BITS, decided
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.transitions.event_types import Event
from rpr_solver.transitions.events import BallEvent

_FIRST_BITS = 256


def grouped(events: Sequence[Event]) -> list[list[Event]]:
    """The events by ascending L, those of equal L together.

    Raises:
        Unproved: two lengths can be neither separated nor proved equal.
    """

    def compare(x: Event, y: Event) -> int:
        return _compare(x, y, events)

    groups: list[list[Event]] = []
    for event in sorted(events, key=cmp_to_key(compare)):
        if groups and compare(groups[-1][0], event) == 0:
            groups[-1].append(event)
        else:
            groups.append([event])
    return groups


def _compare(x: Event, y: Event, events: Sequence[Event]) -> int:
    if x is y:
        return 0

    def order(bits: int) -> int | None:
        a, b = x.scaled_length(bits), y.scaled_length(bits)
        if not a.overlaps(b):
            return -1 if a < b else 1
        return 0 if bits == _FIRST_BITS and _equal(x, y, events) else None

    message = "two transitions are nearer than 1e-2000 and could not be proved to be one"
    return decided(order, _FIRST_BITS, LENGTH_BITS, message)


def _equal(x: Event, y: Event, events: Sequence[Event]) -> bool:
    if x.exact_length is not None and y.exact_length is not None:
        return same_number(x.exact_length, y.exact_length)
    if isinstance(x, BallEvent) and isinstance(y, BallEvent):
        return _isosceles(x.system.slice_map) and _mirror_images(x, y, events)
    first, second = (e.exact().length if isinstance(e, BallEvent) else e.exact_length for e in (x, y))
    return first is not None and second is not None and same_number(first, second)


def _isosceles(slice_map: SliceMap) -> bool:
    """Whether base and platform are both symmetric with respect to the fixed leg's corner."""
    f, g = slice_map.f, slice_map.g
    return f.base2 == g.base2 and f.platform2 == g.platform2


def _mirror_images(x: BallEvent, y: BallEvent, events: Sequence[Event]) -> bool:
    """Whether the mirror image of x, which is an event of the same L, can only be y."""
    image = _mirrored(x, _FIRST_BITS)
    near = [
        other
        for other in events
        if isinstance(other, BallEvent)
        and other.system is x.system
        and all(a.overlaps(b) for a, b in zip(image, _directions(other, _FIRST_BITS), strict=True))
    ]
    return near == [y]


def _mirrored(event: BallEvent, bits: int) -> tuple[acb, acb]:
    """exp(iα) and exp(iθ) of the pose reflected in the base's axis, legs f and g renamed."""
    alpha, theta = _directions(event, bits)
    f, g = event.system.slice_map.f, event.system.slice_map.g
    with ctx.workprec(bits):
        omega = omega_ball(f.radicand, bits)
        base = acb(f.ax, f.ay) * acb(g.ax, g.ay) / f.base2
        platform = acb(f.m, -f.n * omega) * acb(g.m, -g.n * omega) / f.platform2
        return base * platform * alpha.conjugate(), base * theta.conjugate()


def _directions(event: BallEvent, bits: int) -> tuple[acb, acb]:
    """exp(iα) and exp(iθ)."""
    alpha, theta, _, _ = event.coordinates(bits)
    with ctx.workprec(bits):
        return acb(alpha / 180).exp_pi_i(), acb(theta / 180).exp_pi_i()
