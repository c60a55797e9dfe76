"""Real numbers in which poses are sought: exact where angles allow it, else known by balls of any precision.

With one angle, or with several that are multiples of half a degree or of another such part of a turn, all
numbers lie in a tower over the cosine of one angle (workspaces/tower.py), in which equality is decided. Those
of other decimals have no small common field: whether two numbers differ is seen by balls, or stays open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import gcd, lcm
from typing import Any, TypeAlias

from flint import arb, ctx, fmpq_poly, fmpz_poly

from rpr_solver.errors import Unproved
from rpr_solver.exact.precision import precisions
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.triangles.surds import Surd
from rpr_solver.workspaces.tower import Number, Tower

_FIRST_BITS = 128
GREATEST_BITS = 1 << 12
"""Numbers that are equal so far differ by less than 10 to the power of −1,200, if at all."""
_MOST_PARTS = 720
"""Angles that are multiples of a turn by this number are exact: cosines are polynomials of small degree."""


@dataclass(frozen=True, eq=False)
class Lazy:
    """A number by its balls.

    Attributes:
        found: a ball round it, at the working precision.
    """

    found: Callable[[int], arb]
    _balls: dict[int, arb] = field(default_factory=dict, repr=False)

    def ball(self, bits: int) -> arb:
        """A ball round the number, at a precision."""
        if bits not in self._balls:
            with ctx.workprec(bits + 32):
                self._balls[bits] = self.found(bits)
        return self._balls[bits]

    def __add__(self, other: Real | int | Fraction) -> Lazy:
        return Lazy(lambda bits: self.ball(bits) + _ball(other, bits))

    __radd__ = __add__

    def __neg__(self) -> Lazy:
        return Lazy(lambda bits: -self.ball(bits))

    def __sub__(self, other: Real | int | Fraction) -> Lazy:
        return self + (-other)

    def __rsub__(self, other: int | Fraction) -> Lazy:
        return -self + other

    def __mul__(self, other: Real | int | Fraction) -> Lazy:
        return Lazy(lambda bits: self.ball(bits) * _ball(other, bits))

    __rmul__ = __mul__

    @property
    def sign(self) -> int:
        """Its sign.

        Raises:
            Unproved: it is 0, or too near to it.
        """
        for bits in precisions(_FIRST_BITS, GREATEST_BITS):
            x = self.ball(bits)
            if x > 0 or x < 0 or x.is_zero():
                return (x > 0) - (x < 0)
        raise Unproved("two numbers are equal, or differ by less than 1e-1200, which is undecided")

    @property
    def is_zero(self) -> bool:
        """Whether it is 0."""
        return self.sign == 0


Real: TypeAlias = Number | Lazy


@dataclass(frozen=True)
class Reals:
    """The numbers of a question.

    Attributes:
        tower: their field; None if they are known by balls alone.
        angles: angle in degrees → its cosine and sine.
    """

    tower: Tower | None
    angles: dict[Fraction, tuple[Any, Any]]

    @classmethod
    def of(cls, angles: Sequence[Fraction], surds: Sequence[Surd]) -> Reals:
        """Those with the cosines of angles in degrees, and with roots."""
        base = _common(angles)
        if base is None:
            return cls(None, {angle: _lazy_turn(angle) for angle in angles})
        tower = Tower(base)
        c = tower.cosine
        tower, s = tower.with_root(1 - c * c, -1 if base > Fraction(1, 2) else 1)
        for surd in surds:
            tower = tower.with_surd(surd)
        return cls(tower, {angle: _multiple(tower, s, angle, base) for angle in angles})

    def number(self, x: Fraction | int) -> Any:
        """A rational number."""
        return self.tower.number(x) if self.tower else Lazy(lambda _: ball_of(Fraction(x)))

    def surd(self, surd: Surd) -> Any:
        """A root."""
        return self.tower.surd(surd) if self.tower else Lazy(lambda _: surd.ball())


def _common(angles: Sequence[Fraction]) -> Fraction | None:
    """A part of a turn of which all angles are multiples, if it is no small one; of one angle itself."""
    if len(set(angles)) <= 1:
        return (angles[0] if angles else Fraction(0)) / 360 % 1
    below = lcm(*(angle.denominator for angle in angles))
    whole = gcd(360 * below, *(int(angle * below) for angle in angles))
    part = Fraction(whole, 360 * below)
    return part % 1 if part.denominator <= _MOST_PARTS else None


def _multiple(tower: Tower, s: Number, angle: Fraction, base: Fraction) -> tuple[Number, Number]:
    """cos(k δ) = T_k(c) and sin(k δ) = U_{k−1}(c) s."""
    turn = angle / 360 % 1
    k = 1 if turn == base else int(turn / base)
    if k == 0:
        return tower.number(1), tower.number(0)
    times = Number(tower, {0: fmpq_poly(fmpz_poly.chebyshev_t(k))}) * 1
    return times, Number(tower, {0: fmpq_poly(fmpz_poly.chebyshev_u(k - 1))}) * s


def _lazy_turn(angle: Fraction) -> tuple[Lazy, Lazy]:
    def radians() -> arb:
        return ball_of(angle) * arb.pi() / 180

    return Lazy(lambda _: radians().cos()), Lazy(lambda _: radians().sin())


def _ball(x: Real | int | Fraction, bits: int) -> arb:
    return ball_of(Fraction(x)) if isinstance(x, int | Fraction) else x.ball(bits)
