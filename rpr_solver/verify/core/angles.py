"""Angles in degrees: π, sine and cosine in intervals, by Machin's formula and Taylor's series."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import isqrt

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.work import spend

_SPARE = 32
_ULPS = 1 << 8


@lru_cache(maxsize=16)
def pi(bits: int) -> Interval:
    """π = 16 arctan(1/5) − 4 arctan(1/239)."""
    spend(bits, bits)
    unit = 1 << (bits + _SPARE)
    value = 16 * _arctan_of_inverse(5, unit) - 4 * _arctan_of_inverse(239, unit)
    middle = value >> _SPARE
    return Interval(middle - 1, middle + 2, bits)


def _arctan_of_inverse(n: int, unit: int) -> int:
    """arctan(1/n) times ``unit``; each term is off by less than 1, and there are fewer than 2^(spare − 8)."""
    power, total, k, square = unit // n, 0, 1, n * n
    while power:
        total += power // k if k % 4 == 1 else -(power // k)
        power //= square
        k += 2
    return total


def radians(degrees: Fraction, bits: int) -> Interval:
    """An angle in radians."""
    return pi(bits) * Interval.of(degrees / 180, bits)


def degrees(angle: Interval) -> Interval:
    """An angle in degrees."""
    return angle.scaled(180).over(pi(angle.bits))


def cos_sin(angle: Interval) -> tuple[Interval, Interval]:
    """Cosine and sine of all angles of an interval, in radians, of absolute value below 64."""
    bits = angle.bits
    middle = (angle.lower + angle.upper) // 2
    # both functions have slopes of at most 1
    radius = max(angle.upper - middle, middle - angle.lower) + 2
    one = 1 << bits
    cos, sin = _at(abs(middle), bits)
    if middle < 0:
        sin = -sin
    cosine, sine = (Interval(max(x - radius, -one), min(x + radius, one), bits) for x in (cos, sin))
    return cosine, sine


def angle_near(cos: Interval, sin: Interval, guess: Interval) -> Interval:
    """An angle in radians with about this cosine and sine, less than two radians from a guess.

    Each step leaves a sixth of the cube of the error: x + sin(a − x) is x + (a − x) to third order.
    """
    x = (guess.lower + guess.upper) // 2
    while True:
        at_cos, at_sin = cos_sin(Interval(x, x, guess.bits))
        error = sin * at_cos - cos * at_sin
        step = (error.lower + error.upper) // 2
        x += step
        if abs(step) < _ULPS:
            return Interval(x, x, guess.bits)


def _at(angle: int, bits: int) -> tuple[int, int]:
    """Cosine and sine of angle · 2^−bits ≥ 0 in units of 2^−bits, off by less than 2 units.

    Taylor's series is taken at x = angle / 2^h < 1/2, in units of 2^−scale: each of its terms, fewer than
    ``scale``, is off by at most 2 units, and so is the rest. Each of the h doublings makes an error e at
    most 3 e + 2 units. As 3^h (2 · scale + 4) < 2^(2 h + 64), less than 1 unit of 2^−bits remains.
    """
    spend(40 + 3 * isqrt(bits), bits)
    h = 8 + isqrt(bits) // 2
    scale = bits + 2 * h + 64
    x = angle << (scale - bits - h)
    sums, term, k = [0, 0], 1 << scale, 0
    while term:
        sums[k % 2] += term if k % 4 < 2 else -term
        k += 1
        term = (term * x // k) >> scale
    cos, sin = sums
    for _ in range(h):
        cos, sin = (cos * cos - sin * sin) >> scale, (cos * sin) >> (scale - 1)
    return cos >> (scale - bits), sin >> (scale - bits)
