"""The pose at which both free legs vanish at once, of a mechanism with |a − b| = |m − n|.

Both legs are stationary there, so J, E and W vanish to second order, and ∇J to first order. For each such
function F and each pose x of a box about the pose x₀, by Taylor's theorem,

    F(x) = Σ F_n(ξ) (x − x₀)ⁿ    over the monomials n of this order, for some pose ξ between both.

So if all forms with coefficients in the balls of F_n have no common zero but 0, x₀ is the only zero in the
box. As many cusps come to it from below as leave it above (mathematics.md#both-free-legs-close).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add, mul
from typing import Any

import numpy as np
from flint import arb, ctx

from rpr_solver.boxes import Balls, Box, Boxes, Functions, Jet, Undecided, Zero, bits_of, monomials, sieved
from rpr_solver.verify.equations import LENGTH, Jets, Lengths
from rpr_solver.verify.finding import OF_SIEVE
from rpr_solver.verify.numbers import angle
from rpr_solver.verify.systems import Coalescing, Critical
from rpr_solver.verify.work import Work

_RADII = (2.0**-8, 2.0**-10, 2.0**-12, 2.0**-14)
"""Of the box in radians and units."""
_MOST = 2000
"""So many boxes of a face of the cube are looked at, however narrow they are."""
_SPARE = (64, 256, 1024, 4096)
"""Bits of a computation more than those of its result."""

Form = Mapping[tuple[int, ...], arb]
"""The coefficients of a homogeneous polynomial, by the exponents of the monomials."""


@dataclass(frozen=True)
class Meeting(Zero):
    """The only pose of ``room`` at which more than three poses coalesce: both free legs have the length 0."""

    space: Lengths

    @classmethod
    def of(cls, space: Lengths, start: Boxes, work: Work) -> Meeting | None:
        """That with a length of some boxes, if four poses coalesce there, and it is proved to be alone.

        Raises:
            Open: there is no work left.
        """
        mechanism = space.mechanism
        (base, platform), (f, g) = mechanism.geometry.squared_sides, mechanism.free
        if base[f, g] != platform[f, g]:
            return None
        if all(x[mechanism.fixed, f] == x[mechanism.fixed, g] for x in (base, platform)):
            return None
        at = _pose(space)
        if not (at[LENGTH] > start.low[LENGTH].min() and at[LENGTH] < start.high[LENGTH].max()):
            return None
        for radius in _RADII:
            room = [arb(x.mid(), x.rad() + radius) for x in at]
            if all(have_no_zero(forms, work) for forms in _all_forms(space, room)):
                return cls(Coalescing(space, 2).stages[-1], room, at, space)
        return None

    def within(self, bits: int, about: Box | None = None) -> Box:
        """A box of it with radii of at most 2^−``bits``.

        Raises:
            Undecided: it is not reached.
        """
        del about
        for spare in _SPARE:
            with ctx.workprec(bits + spare):
                box = _pose(self.space)
            if bits_of(box) >= bits:
                return box
        raise Undecided


def _pose(space: Lengths) -> Box:
    """z = (a − b)/(m − n) and L e = a − m z, by α, θ and t."""
    mechanism = space.mechanism
    first, second = (leg - 1 for leg in mechanism.free)
    base, platform = mechanism.geometry.base, mechanism.geometry.platform
    a, m = mechanism.arms(mechanism.free[0])
    # not by a and m: so α is an exact 0 where it is 0
    z = (base[first] - base[second]) / (platform[first] - platform[second])
    leg, unit = a - m * z, arb(2) ** mechanism.geometry.size
    return [angle(z), angle(leg), unit / abs(leg) if space.beyond else abs(leg) / unit]


def _all_forms(space: Lengths, room: Box) -> Sequence[Sequence[Form]]:
    """The forms of J, E and W of both legs, and those of J and ∇J."""
    coalescing = [_form(x, 2) for x in Coalescing(space, 2).stages[-1](room, 2)]
    j, *slopes = Critical(space).stages[-1](room, 2)
    return coalescing, [_form(j, 2), *(_form(x, 1) for x in slopes)]


def _form(jet: Jets, degree: int) -> Form:
    pairs = zip(monomials(jet.variables, jet.order), jet.terms, strict=True)
    return {n: x for n, x in pairs if sum(n) == degree}


def have_no_zero(forms: Sequence[Form], work: Work) -> bool:
    """Whether it is proved that forms in three variables have no common zero but 0: none on half a cube."""
    square = Boxes(np.full((2, 1), -1.0), np.full((2, 1), 1.0))
    for face in range(3):
        sieve = sieved(_Face(forms, face), square, 0.0, _MOST)
        work.spend(sieve.looked // OF_SIEVE)
        if not sieve.ended or len(sieve.boxes):
            return False
    return True


@dataclass(frozen=True)
class _Face:
    """Forms where one of three variables is 1, as functions of the others."""

    forms: Sequence[Form]
    one: int

    @property
    def stages(self) -> Sequence[Functions]:
        """All of them."""
        return (self._functions,)

    def square(self, box: Box) -> Functions:
        """Nothing is asked of zeros."""
        raise Undecided(box)

    def _functions(self, box: Sequence[Any], order: int) -> Sequence[Jets]:
        """The values, and the slopes if the order is 1."""
        zero = box[0] * 0
        one = zero + Balls.of([arb(1)])
        rows = [[box[0], one, zero], [box[1], zero, one]]
        rows.insert(self.one, [one, zero, zero])
        point = [Jet(2, order, row if order else row[:1]) for row in rows]
        return [
            reduce(
                add,
                (
                    reduce(mul, [x for x, k in zip(point, n, strict=True) for _ in range(k)])
                    * Balls.of([coefficient])
                    for n, coefficient in form.items()
                ),
            )
            for form in self.forms
        ]
