"""The number of cusps of slices, from the exact eliminant alone; and slices that cannot be predicted."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from math import atan2, degrees
from secrets import randbelow

from rpr_solver.verify.claims import Claim, ClaimStatus
from rpr_solver.verify.core.boxes import Equations, Pair, zero_near
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.printed import Printed
from rpr_solver.verify.core.surds import Indivisible
from rpr_solver.verify.core.system import Leg, System
from rpr_solver.verify.eliminant import Eliminant
from rpr_solver.verify.lines import nearby, special_lines, unlisted

_BITS = 60
_MOST = 12
"""The most poses that are looked at on one line; J has degree 4 there."""
_DRAWN_BITS, _SPREAD = 64, 1 << 20
OPEN = "not for every length in it; a census with a full certificate is what proves that"
Count = Callable[[Fraction], tuple[int, bool] | None]
"""The number of cusps of the slice of a length, and whether it is proved; None if it is open."""
Bounds = tuple[Fraction, Fraction]


def count_of(system: System) -> tuple[int, bool] | None:
    """The number of cusps, and whether it is proved. None if the resultant does not decide it.

    It is where every root of Q is simple and apart from the spurious ones: one cusp is on each line. On other
    lines the cusps are those that a search finds.
    """
    try:
        eliminant = Eliminant.of(system)
    except Indivisible:
        return None
    if not eliminant.form:
        return None
    single = len(eliminant.single_roots)
    if eliminant.generic:
        return single, True
    return single + sum(_cusps_on(system, line) for line in special_lines(system, eliminant)), False


def _cusps_on(system: System, line: Pair) -> int:
    """The cusps that are found on a line: where J = E = 0 cannot be excluded, a regular zero is one."""
    return sum(any(_is_cusp(system, leg, *pose) for leg in system.legs) for pose in _poses_on(system, line))


def _poses_on(system: System, line: Pair) -> Iterator[tuple[Fraction, Fraction]]:
    """Where J = E = 0 cannot be excluded on a line: α and θ in degrees."""
    holes: list[Interval] = []
    theta = Fraction(degrees(atan2(float(line[1].middle), float(line[0].middle))))
    while (alpha := unlisted(system, line, holes)) is not None and len(holes) < _MOST:
        holes.append(nearby(Interval.of(alpha, line[0].bits)))
        yield Fraction(degrees(float(alpha))), theta


def _is_cusp(system: System, leg: Leg, alpha: Fraction, theta: Fraction) -> bool:
    equations = Equations.of(system.singular, leg.kernel, system.ring.radicand)
    box = zero_near(equations, alpha, theta, _BITS)
    return box is not None and any(box.directions.value(slope).sign for slope in (leg.alpha, leg.theta))


def simplest_between(low: Fraction, high: Fraction) -> Fraction:
    """The decimal of fewest places strictly between two numbers.

    >>> simplest_between(Fraction(1, 3), Fraction(1, 2))
    Fraction(2, 5)
    """
    unit = Fraction(1)
    while True:
        candidate = (low // unit + 1) * unit
        if low < candidate < high:
            middle = round((low + high) / 2 / unit) * unit
            return middle if low < middle < high else candidate
        unit /= 10


def drawn_within(bounds: Bounds) -> Fraction:
    """A length between two others, drawn at random by the operating system, rounded to few places."""
    low, high = bounds
    step = (high - low) / (_SPREAD + 2)
    place = low + (high - low - 2 * step) * Fraction(randbelow(1 << _DRAWN_BITS), 1 << _DRAWN_BITS)
    return simplest_between(place, place + 2 * step)


def sampled(at: str, number: int, bounds: Bounds | None, count: Count, samples: int) -> Claim:
    """The claim that all slices between two lengths have this number of cusps: refuted, or checked, by some
    of them."""
    claim = f"{number} cusps in every slice of this interval"
    if bounds is None:
        reason = "no number of so many digits lies between its ends"
        return Claim(at, claim, ClaimStatus.NOT_CHECKED, reason)
    for length in (drawn_within(bounds) for _ in range(samples)):
        found = count(length)
        if found is None:
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, "the cusps of a slice in it were not counted")
        if found[0] != number:
            return Claim(at, claim, ClaimStatus.REFUSED, f"the slice at {length} has {found[0]}")
    reason = f"{samples} slices at random lengths have as many; {OPEN}"
    return Claim(at, claim, ClaimStatus.CHECKED, reason)


def changed(
    at: str,
    cut: Printed,
    outer: tuple[Fraction | None, Fraction | None],
    numbers: tuple[int, int],
    count: Count,
) -> Claim:
    """That the number of cusps changes within half a unit of the last digit of a length.

    Args:
        at: the member with the length.
        cut: the length.
        outer: between which two lengths the slices beside it must lie.
        numbers: of cusps below and above.
        count: how they are counted.
    """
    claim = "the number of cusps changes here"
    if numbers[0] == numbers[1]:
        return Claim(at, claim, ClaimStatus.REFUSED, "it is the same below and above")
    low, high = outer
    if cut.is_zero or cut.lower <= (low or 0) or (high is not None and high <= cut.upper):
        reason = "its digits leave no room between it and its neighbour"
        return Claim(at, claim, ClaimStatus.NOT_CHECKED, reason)
    doubt = False
    for length, expected in zip((cut.lower, cut.upper), numbers, strict=True):
        found = count(length)
        if found is None:
            return Claim(at, claim, ClaimStatus.NOT_CHECKED, "the slices beside it were not counted")
        if found[0] != expected:
            return Claim(at, claim, ClaimStatus.REFUSED, f"{found[0]} cusps are counted beside it")
        doubt = doubt or not found[1]
    reason = "half a unit of the last digit below and above, as many are counted"
    return Claim(at, claim, ClaimStatus.CHECKED if doubt else ClaimStatus.PROVED, reason)
