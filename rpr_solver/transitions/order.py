"""Events in the order of L, grouped by exactly equal L.

Events of a symmetric manipulator come in pairs of equal L. No precision shows that two numbers are equal:
equality is proved by minimal polynomials, or by a symmetry of the manipulator (mathematics.md#equal-lengths).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cmp_to_key

from flint import acb, ctx

from rpr_solver.exact.equal_numbers import same_number
from rpr_solver.exact.precision import LENGTH_BITS, decided
from rpr_solver.transitions.event_systems import System
from rpr_solver.transitions.event_types import Event
from rpr_solver.transitions.events import BallEvent
from rpr_solver.transitions.symmetries import Symmetry, symmetries

_FIRST_BITS = 256


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

    def order(bits: int) -> int | None:
        a, b = x.scaled_length(bits), y.scaled_length(bits)
        if not a.overlaps(b):
            return -1 if a < b else 1
        return 0 if bits == _FIRST_BITS and _equal(x, y) else None

    message = "two transitions are nearer than 1e-2000 and could not be proved to be one"
    return decided(order, _FIRST_BITS, LENGTH_BITS, message)


def _equal(x: Event, y: Event) -> bool:
    if x.exact_length is not None and y.exact_length is not None:
        return same_number(x.exact_length, y.exact_length)
    if isinstance(x, BallEvent) and isinstance(y, BallEvent):
        return any(_is_image(symmetry, x, y) for symmetry in symmetries(x.system.slice_map))
    first, second = (e.exact().length if isinstance(e, BallEvent) else e.exact_length for e in (x, y))
    return first is not None and second is not None and same_number(first, second)


def _is_image(symmetry: Symmetry, x: BallEvent, y: BallEvent) -> bool:
    """Proves that a symmetry maps x to y; False if there is no proof.

    The image is an event of the same system, so its tan θ is a root of the eliminant, as that of y is, which
    is simple. If the derivative is not 0 between the two, they are one root, above which is one event.
    """
    if x.kind is not y.kind or not _maps(symmetry, x, y.system):
        return False
    image = symmetry.image(*_directions(x, _FIRST_BITS), _FIRST_BITS)
    own = _directions(y, _FIRST_BITS)
    if not all(a.overlaps(b) for a, b in zip(image, own, strict=True)):
        return False
    with ctx.workprec(_FIRST_BITS):
        first, second = (theta.imag / theta.real for _, theta in (image, own))
        if not (first.is_finite() and second.is_finite()):
            return False
        slope = y.system.eliminant.polynomial.ball(_FIRST_BITS).derivative()(first.union(second))
        return not slope.contains(0)


def _maps(symmetry: Symmetry, x: BallEvent, system: System) -> bool:
    """Whether a symmetry maps an event to an event of a system."""
    if x.kind is not None:
        return x.system is system
    ours, theirs = x.system.limit, system.limit
    # where a free leg has length 0, C = 0 need not be a cusp
    open_legs = all(length > 0 for length in x.coordinates(_FIRST_BITS)[2:])
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
