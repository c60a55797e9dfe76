"""Random manipulators of the degenerate families, and the lengths of legs at which they are most special."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from math import isqrt
from random import Random

from rpr_solver import InputError, Manipulator

Point = tuple[Fraction, Fraction]
Sides = tuple[Fraction, Fraction, Fraction]
"""|A1A2|, |A2A3| and |A3A1|, or d1, d2 and d3: of a triangle with its first corner at 0."""

_PYTHAGOREAN = ((3, 4), (4, 3), (5, 12), (12, 5), (8, 15), (-3, 4), (-5, 12), (9, 12), (7, 24))


def _number(rng: Random, low: int = 1, high: int = 24) -> Fraction:
    return Fraction(rng.randint(low * 10, high * 10), rng.choice((10, 10, 5, 1, 3)))


def _rational_base(rng: Random) -> tuple[Fraction, Point]:
    """A base with rational sides: A2x and A3."""
    (x, y), (p, q) = rng.sample(_PYTHAGOREAN, 2)
    scale = _number(rng, 1, 4)
    third = Fraction(p, abs(q)) * abs(y)  # the same height, from the other side
    return (x + third) * scale, (x * scale, y * scale)


def _sides(a2x: Fraction, a3: Point) -> Sides:
    (x, y) = a3
    return abs(a2x), _root((x - a2x) ** 2 + y * y), _root(x * x + y * y)


def _root(square: Fraction) -> Fraction:
    root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    if root * root != square:
        raise InputError.of("sides", "are irrational")
    return root


def _on_base(
    rng: Random, change: Callable[[Random, Sides], Sides], orientation: str | None = None
) -> Manipulator:
    """A platform made of the sides of a rational base."""
    a2x, a3 = _rational_base(rng)
    if rng.random() < 0.3:
        a2x, a3 = -a2x, (-a3[0], -a3[1])  # the base turned round
    if rng.random() < 0.3:
        a3 = a3[0], -a3[1]
    own = "ccw" if a2x * a3[1] > 0 else "cw"
    other = {"ccw": "cw", "cw": "ccw"}[own]
    side = {"same": own, "mirrored": other}.get(orientation or "", rng.choice(("ccw", "cw")))
    return Manipulator(a2x, *a3, *change(rng, _sides(a2x, a3)), orientation=side)


def _times(rng: Random, sides: Sides) -> Sides:
    factor = _number(rng, 1, 9) / _number(rng, 1, 9)
    return sides[0] * factor, sides[1] * factor, sides[2] * factor


def _permuted(rng: Random, sides: Sides) -> Sides:
    a, b, c = rng.sample(sides, 3)
    return a, b, c


def _flat(rng: Random) -> Sides:
    a, b = _number(rng), _number(rng)
    return rng.choice(((a, b, a + b), (a + b, a, b), (a, a + b, b)))


def _flat_base(rng: Random) -> tuple[Fraction, Fraction, Fraction]:
    a, b = (rng.choice((1, -1)) * _number(rng) for _ in range(2))
    return a, b, Fraction(0)


def _side(rng: Random) -> str:
    return rng.choice(("ccw", "cw"))


def _both_flat(rng: Random) -> Manipulator:
    return Manipulator(*_flat_base(rng), *_flat(rng), orientation=_side(rng))


def _doubly_flat(rng: Random) -> Manipulator:
    """Flat base and platform that are congruent, similar, or the same in another order."""
    a, b, _ = _flat_base(rng)
    factor = rng.choice((Fraction(1), Fraction(1), _number(rng, 1, 6)))
    sides = [abs(a) * factor, abs(b - a) * factor, abs(b) * factor]
    if rng.random() < 0.3:
        rng.shuffle(sides)
    return Manipulator(a, b, 0, *sides, orientation=_side(rng))


def _isosceles(rng: Random) -> Manipulator:
    half, height = _number(rng), _number(rng)
    base = (2 * half, half, height) if rng.random() < 0.7 else (half, _number(rng), height)
    a, b = _number(rng), _number(rng)
    return Manipulator(*base, *rng.choice(((a, b, b), (b, a, b), (b, b, a))), orientation=_side(rng))


def _equilateral(rng: Random) -> Manipulator:
    side = _number(rng)
    base = rng.choice(((side, side / 2, _number(rng)), (side, Fraction(0), side), (side, 2 * side, side)))
    return Manipulator(*base, *[rng.choice((side, _number(rng)))] * 3, orientation=_side(rng))


def _right(rng: Random) -> Manipulator:
    a, b, c = rng.choice(((3, 4, 5), (4, 5, 3), (5, 3, 4), (12, 13, 5), (8, 17, 15)))
    factor = _number(rng, 1, 5)
    base = _number(rng), Fraction(0), rng.choice((1, -1)) * _number(rng)
    return Manipulator(*base, *(factor * x for x in (a, b, c)), orientation=_side(rng))


def _equal_lengths(rng: Random) -> Manipulator:
    a, b = _number(rng), _number(rng)
    base = rng.choice(((a, b, a), (a, Fraction(0), a), (a, -a, b), (a, a, b), (-a, b, b)))
    sides = rng.choice(((a, a, b), (a, b, a), (a, b, b), (b, a, a), (a, a, a), (a, _number(rng), b)))
    return Manipulator(*base, *sides, orientation=_side(rng))


MAKERS: dict[str, Callable[[Random], Manipulator]] = {
    "similar": lambda rng: _on_base(rng, _times, "same"),
    "similar, mirrored": lambda rng: _on_base(rng, _times, "mirrored"),
    "congruent": lambda rng: _on_base(rng, lambda _, sides: sides, "same"),
    "congruent, mirrored": lambda rng: _on_base(rng, lambda _, sides: sides, "mirrored"),
    "sides permuted": lambda rng: _on_base(rng, _permuted),
    "flat platform": lambda rng: Manipulator(
        _number(rng), _number(rng), _number(rng), *_flat(rng), orientation=_side(rng)
    ),
    "flat base": lambda rng: Manipulator(
        *_flat_base(rng), *(_number(rng) for _ in range(3)), orientation=_side(rng)
    ),
    "both flat": _both_flat,
    "flat, congruent or similar": _doubly_flat,
    "isosceles": _isosceles,
    "equilateral": _equilateral,
    "right angle": _right,
    "equal lengths": _equal_lengths,
}
"""A random manipulator of each family; some draws are no manipulator (:class:`InputError`)."""


def draws(rng: Random) -> Iterator[tuple[str, Manipulator]]:
    """Manipulators of the families in turn, without end."""
    while True:
        for name, maker in MAKERS.items():
            while True:
                try:
                    found = maker(rng)
                except InputError:
                    continue
                yield name, found
                break


def beside(rng: Random, name: str, exponent: int) -> Manipulator:
    """A manipulator of a family, one length changed by 10^-exponent of itself, or of ``a2x`` if it is 0."""
    while True:
        try:
            m = MAKERS[name](rng)
            member = rng.choice(("a2x", "a3x", "a3y", "d1", "d2", "d3"))
            size = abs(getattr(m, member)) or abs(m.a2x)
            change = rng.choice((1, -1)) * size / 10**exponent
            return replace(m, **{member: getattr(m, member) + change})
        except InputError:
            continue


def special_lengths(m: Manipulator) -> list[Fraction]:
    """Sides and heights of both triangles, with their sums, differences and halves; positive, ascending."""
    base = [abs(m.a2x), abs(m.a3x), abs(m.a3y), abs(m.a3x - m.a2x)]
    squares = m.a3x**2 + m.a3y**2, (m.a3x - m.a2x) ** 2 + m.a3y**2
    for square in squares:
        try:
            base.append(_root(square))
        except InputError:
            continue
    platform = [m.d1, m.d2, m.d3]
    found = {*base, *platform, *(x / 2 for x in (*base, *platform))}
    found |= {x + sign * y for x in base for y in platform for sign in (1, -1)}
    return sorted(x for x in found if x > 0)
