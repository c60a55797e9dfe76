"""Lines θ = const of a slice: the proof that no pose in which three coalesce lies there unlisted.

Such poses are the common zeros of J and of E along either leg. A line is cut into pieces of α until one of
the three excludes 0 on each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from rpr_solver.verify.core.angles import cos_sin, pi
from rpr_solver.verify.core.boxes import Directions, Pair, direction
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.roots import refined
from rpr_solver.verify.core.system import System, Trig, derivative
from rpr_solver.verify.core.work import spend
from rpr_solver.verify.eliminant import Eliminant

_LINE_BITS = 128
_LEAST_APART = 32
_PIECES = 48
_DEPTH = 40
NEARBY = 20
"""Listed poses are cut out with 2^−20 radians on either side."""


def opposite(bits: int) -> Pair:
    """The line θ = 180°."""
    return Interval.of(-1, bits), Interval.of(0, bits)


def separation(eliminant: Eliminant) -> int:
    """Bits at which the directions of all real lines are separated."""
    bits, ring = _LEAST_APART, eliminant.ring
    forms = ((eliminant.single, eliminant.single_roots), (eliminant.special, eliminant.special_roots))
    roots = [(form, root) for form, roots in forms for root in roots]
    while True:
        roots = [(form, refined(ring, form, root, Fraction(1, 1 << bits))) for form, root in roots]
        lines = [direction(ring, form, root, bits) for form, root in roots]
        if eliminant.special_at_infinity:
            lines.append(opposite(bits))
        if not any(meet(x, y) for n, x in enumerate(lines) for y in lines[:n]):
            return bits
        bits *= 2


def meet(first: Pair, second: Pair) -> bool:
    """Whether two directions may be the same."""
    return all(x.meets(y) for x, y in zip(first, second, strict=True))


def special_lines(system: System, eliminant: Eliminant, apart: int = 0) -> Iterator[Pair]:
    """The real lines that may hold several poses with J = E = 0, or spurious ones.

    Args:
        system: the slice.
        eliminant: its lines.
        apart: bits to which they are needed besides.
    """
    sizes = (
        part.bit_length()
        for p in (system.singular, *(leg.kernel for leg in system.legs))
        for x in p.values()
        for part in x
    )
    bits = _LINE_BITS + max(sizes) + 2 * apart
    for root in eliminant.special_roots:
        yield direction(system.ring, eliminant.special, root, bits)
    if eliminant.special_at_infinity:
        yield opposite(bits)


@dataclass(frozen=True)
class _OnLine:
    """A trigonometric polynomial in α alone, with its derivative."""

    value: dict[tuple[int, int], Interval]
    slope: dict[tuple[int, int], Interval]

    @classmethod
    def of(cls, p: Trig, line: Pair, radicand: int) -> _OnLine:
        return cls(*(_collapsed(q, line, radicand) for q in (p, derivative(p, theta=False))))

    def excludes_zero(self, alpha: Interval, pair: Pair, middle: Pair, radius: Interval) -> bool:
        """Whether it has no zero for any α of an interval, by the mean value theorem if not at once."""
        del alpha
        if _sum(self.value, pair).sign:
            return True
        return bool((_sum(self.value, middle) + _sum(self.slope, pair) * radius).sign)


def unlisted(system: System, line: Pair, listed: Sequence[Interval], apart: int = 0) -> Fraction | None:
    """An α in radians near which a pose with J = E = 0 cannot be excluded on a line; None if there is none.

    Args:
        system: the slice.
        line: cosine and sine of θ.
        listed: intervals of α, in radians, that are left out.
        apart: the number of further bits of the line, and of further cuts.
    """
    functions = [system.singular, *(leg.kernel for leg in system.legs)]
    return common_zero(functions, system.ring.radicand, line, listed, apart)


def common_zero(
    functions: Sequence[Trig], radicand: int, line: Pair, listed: Sequence[Interval] = (), apart: int = 0
) -> Fraction | None:
    """An α in radians near which a common zero of functions cannot be excluded on a line; None if there is
    none.

    Args:
        functions: of α and θ.
        radicand: of their ω.
        line: cosine and sine of θ.
        listed: intervals of α, in radians, that are left out.
        apart: how many cuts are made beyond the usual number.
    """
    bits = line[0].bits
    on_line = [_OnLine.of(p, line, radicand) for p in functions]
    half = pi(bits).upper
    step = -(-2 * half // _PIECES)
    todo = [(-half + k * step, -half + (k + 1) * step, 0) for k in range(_PIECES)]
    holes = [hole for x in listed for hole in _turned(x, bits)]
    while todo:
        lower, upper, depth = todo.pop()
        if any(a <= lower and upper <= b for a, b in holes):
            continue
        alpha = Interval(lower, upper, bits)
        middle = (lower + upper) // 2
        pair, at_middle = cos_sin(alpha), cos_sin(Interval(middle, middle, bits))
        radius = Interval(lower - middle, upper - middle, bits)
        if any(f.excludes_zero(alpha, pair, at_middle, radius) for f in on_line):
            continue
        if depth == _DEPTH + apart:
            return alpha.middle
        todo += [(lower, middle, depth + 1), (middle, upper, depth + 1)]
    return None


def _turned(x: Interval, bits: int) -> list[tuple[int, int]]:
    """An interval of α, and the same a turn away, in units of 2^−bits."""
    turn = 2 * pi(bits).lower
    low, high = (Interval.of(Fraction(end, 1 << x.bits), bits) for end in (x.lower, x.upper))
    # rounded inwards, and 2π being known to two units only
    return [(low.upper + k * turn + 4, high.lower + k * turn - 4) for k in (-1, 0, 1)]


def nearby(x: Interval) -> Interval:
    """All angles within 2^−20 radians of an interval."""
    return Interval.of(x.middle, x.bits, x.radius + Fraction(1, 1 << NEARBY))


def _collapsed(p: Trig, line: Pair, radicand: int) -> dict[tuple[int, int], Interval]:
    bits = line[0].bits
    one = Interval.of(1, bits)
    at = Directions((one, one), line, radicand)
    rows: dict[tuple[int, int], dict[tuple[int, int, int, int], tuple[int, int]]] = {}
    for (i, j, k, m), x in p.items():
        rows.setdefault((i, j), {})[0, 0, k, m] = x
    return {key: at.value(row) for key, row in rows.items()}


def _sum(coefficients: dict[tuple[int, int], Interval], alpha: Pair) -> Interval:
    cos, sin = alpha
    spend(2 * len(coefficients), cos.bits)
    total = Interval(0, 0, cos.bits)
    powers = [Interval.of(1, cos.bits)]
    for (i, j), x in coefficients.items():
        while len(powers) <= i:
            powers.append(powers[-1] * cos)
        term = x * powers[i]
        total += term * sin if j else term
    return total
