"""Two or three zeros of two functions that are very near to each other: where cutting boxes would take long.

Let G and H be functions of r and s on a box, with ∂G/∂s ≠ 0, and G of opposite signs on the two faces at the
ends of s. Then G = 0 is a curve s = s(r) through the box, for all its r. Let

    D = ∂G/∂s ∂H/∂r − ∂G/∂r ∂H/∂s,    K = ∂G/∂s ∂D/∂r − ∂G/∂r ∂D/∂s.

The derivatives of H and of D along the curve are D / (∂G/∂s) and K / (∂G/∂s). So if K ≠ 0 on the box, H has
at most one extremum on the curve, where D = 0; it is a minimum if K > 0, a maximum if K < 0. If H has the
sign of K there, G and H have no common zero in the box; if it has the other sign, they have at most two,
regular ones. Where K has a zero, but not its derivative along the curve, D takes the place of H, and H has
three zeros at most (mathematics.md#folds-of-two-functions).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np
from flint import arb, ctx

from rpr_solver.boxes.box import Empty, bits_of, contains
from rpr_solver.boxes.jets import Jet
from rpr_solver.boxes.krawczyk import newton
from rpr_solver.boxes.systems import Box, Functions, Undecided
from rpr_solver.boxes.zeros import Zero

_STEPS = 6
"""Of Newton's method: from a third of the way, say, to 64 bits."""
_SPARE = 64
"""Bits of a computation with numbers of the size of 1."""
_WIDTHS = (64, 16, 4, 1)
"""How much wider the fold may be than the given box is away from the extremum."""
_SHARES = (3, 8, 16, 32, 64, 128)
"""Shares of the way between two zeros, as powers of 1/2, in which each is alone."""
_MOST_BITS = 1024
"""The sign of H at the extremum is sought with so many bits."""


@dataclass(frozen=True)
class Fold:
    """A box in which two functions have the given zeros and no others, three at most; or it is open.

    Attributes:
        room: the box.
        zeros: all zeros in it; None if it is not decided how many there are.
    """

    room: Box
    zeros: Sequence[Zero] | None


def fold_at(functions: Functions, most: Box, box: Box) -> Fold:
    """The fold within a box that a small box is in, or three zeros, or one, where three nearly meet.

    Raises:
        Undecided: none is found.
    """
    for find in (_Curve.fold, _Curve.three):
        for first, run in product((0, 1), repeat=2):
            try:
                return find(_Curve(functions, first, run), box, most)
            except (Undecided, Empty):
                continue
    raise Undecided


@dataclass(frozen=True)
class _Curve:
    """The curve G = 0: which of the functions is G, and which of the variables is r."""

    functions: Functions
    first: int
    run: int

    def _all(self, box: Sequence[Any], order: int) -> Sequence[Jet[Any]]:
        """G, D and H."""
        found = self.functions(box, order + 1)
        g, h = found[self.first], found[1 - self.first]
        r, s = self.run, 1 - self.run
        return g, g.d(s) * h.d(r) - g.d(r) * h.d(s), h

    def _extremum(self, box: Sequence[Any], order: int) -> Sequence[Jet[Any]]:
        """G and D, which are 0 where H has an extremum on the curve."""
        return self._all(box, order)[:2]

    @property
    def slope(self) -> _Curve:
        """The same curve, and in place of H its derivative, D."""
        return _Curve(self._extremum, 0, self.run)

    def fold(self, box: Box, most: Box) -> Fold:
        """The fold about a box.

        Raises:
            Undecided, Empty: there is none of this kind.
        """
        room, extremum, curvature = self._about(box, most)
        height = self._height(extremum)
        if height is None:
            return Fold(room, None)
        return Fold(room, () if height * curvature > 0 else self._pair(room, extremum, height))

    def three(self, box: Box, most: Box) -> Fold:
        """Where three zeros nearly meet about a box: three of them, or one.

        Raises:
            Undecided, Empty: there is none of this kind.
        """
        room, inflection, third = self.slope._about(box, most)
        steepness, count = self.slope._height(inflection), 1
        if steepness is None:
            return Fold(room, None)
        if not steepness * third > 0:
            first, second = (self._height(x) for x in self.slope._pair(room, inflection, steepness))
            if first is None or second is None:
                return Fold(room, None)
            count = 3 if first * second < 0 else 1
        return Fold(room, self._triple(room, inflection, count))

    def _about(self, box: Box, most: Box) -> tuple[Box, Zero, arb]:
        """A room about a box, the extremum of H in it, and K on it.

        Raises:
            Undecided, Empty: there is none.
        """
        size = max(x.rad() for x in box)
        near = newton(self._extremum, [x.mid() for x in box], _STEPS)
        reach = size + max(abs(x.mid() - y).upper() for x, y in zip(box, near, strict=True))
        for width in _WIDTHS:
            radii = [width * reach * (1 if k == self.run else 2) for k in (0, 1)]
            room = [arb(x, radius) for x, radius in zip(near, radii, strict=True)]
            if not (contains(room, box) and contains(most, room)):
                continue
            if (curvature := self._curvature(room)) is not None:
                return room, Zero.alone(self._extremum, [arb(x, size / 4) for x in near]), curvature
        raise Undecided

    def _bend(self, box: Sequence[Any]) -> Jet[Any]:
        """K, to first order."""
        r, s = self.run, 1 - self.run
        g, d, _ = self._all(box, 2)
        return g.d(s) * d.d(r) - g.d(r) * d.d(s)

    def _curvature(self, room: Box) -> arb | None:
        """K on a box, if it is not 0 and G = 0 leads through the box as a graph; else None."""
        r, s = self.run, 1 - self.run
        middle = [x.mid() for x in room]
        steps = [x - m for x, m in zip(room, middle, strict=True)]
        # by the mean value theorem from the middle to the faces at the ends of s, and to each point
        slopes = self.functions(room, 1)[self.first].gradient
        rest = self.functions(middle, 0)[self.first].value + slopes[r] * steps[r]
        if not abs(slopes[s]) * room[s].rad() > abs(rest):
            return None
        bend = self._bend(room).gradient
        curvature: arb = self._bend(middle).value + bend[0] * steps[0] + bend[1] * steps[1]
        return curvature if not curvature.contains(0) else None

    def _height(self, extremum: Zero) -> arb | None:
        """H at the extremum, if its sign is decided."""
        bits = 64
        while bits <= _MOST_BITS:
            with ctx.workprec(bits + 64):
                height: arb = self._all(extremum.within(bits), 0)[2].value
                if not height.contains(0):
                    return height
            bits *= 2
        return None

    def _pair(self, room: Box, extremum: Zero, height: arb) -> Sequence[Zero]:
        """The zeros on both sides of an extremum.

        Raises:
            Undecided, Empty: they are not found in the box.
        """
        r, s = self.run, 1 - self.run
        with ctx.workprec(_SPARE):
            at = [x.mid() for x in extremum.at]
            slopes = self.functions(at, 1)[self.first].gradient
            # h(r) is about height + K (r − r₀)² / (2 (∂G/∂s)²)
            step = (-2 * height / self._bend(at).value).sqrt().mid() * abs(slopes[s]).mid()
            sides = [step if k == r else (-step * slopes[r] / slopes[s]).mid() for k in (0, 1)]
        if not step.is_finite():
            raise Undecided
        bits = max(bits_of([arb(0, step)]), 0)
        zeros = []
        with ctx.workprec(_SPARE + 4 * bits):
            middle = [x.mid() for x in extremum.within(2 * bits + _SPARE)]
            for sign in (-1, 1):
                start = [(x + sign * side).mid() for x, side in zip(middle, sides, strict=True)]
                near = newton(self.functions, start, _STEPS)
                zeros.append(_alone(self.functions, near, step))
        if all(x.overlaps(y) for x, y in zip(zeros[0].at, zeros[1].at, strict=True)):
            raise Undecided
        if not all(contains(room, zero.at) for zero in zeros):
            raise Undecided
        return zeros

    def _triple(self, room: Box, inflection: Zero, count: int) -> Sequence[Zero]:
        """So many zeros about an inflection, 1 or 3.

        Raises:
            Undecided, Empty: they are not found in the box.
        """
        r, s = self.run, 1 - self.run
        at = [x.mid() for x in inflection.within(_MOST_BITS // 4)]
        with ctx.workprec(_MOST_BITS):
            _, d, h = self._all(at, 0)
            slopes = self.functions(at, 1)[self.first].gradient
            # h(r) is about H + D x / (∂G/∂s) + M x³ / (6 (∂G/∂s)³) for x = r − r₀
            cubic = self.slope._bend(at).value / (6 * slopes[s] ** 3)
            height, steepness = h.value / cubic, d.value / (slopes[s] * cubic)
            scale = abs(height).root(3) + abs(steepness).sqrt()
            rest = [float((x / scale**n).mid()) for x, n in ((steepness, 2), (height, 3))]
            if not np.isfinite(rest).all():
                raise Undecided
            roots = sorted(np.roots([1, 0, *rest]), key=lambda x: abs(x.imag))
            zeros = []
            for root in roots[:count]:
                step = (scale * float(root.real)).mid()
                start = [at[k] + (step if k == r else (-step * slopes[r] / slopes[s]).mid()) for k in (0, 1)]
                for _ in range(_STEPS):
                    own = self.functions(start, 1)[self.first]
                    start[s] = (start[s] - own.value / own.gradient[s]).mid()
                zeros.append(_alone(self.functions, newton(self.functions, start, 2 * _STEPS), scale.mid()))
        if any(
            all(x.overlaps(y) for x, y in zip(a.at, b.at, strict=True)) for a, b in combinations(zeros, 2)
        ):
            raise Undecided
        if not all(contains(room, zero.at) for zero in zeros):
            raise Undecided
        return zeros


def _alone(functions: Functions, near: Box, step: arb) -> Zero:
    """The zero near a point, in a box that is not as wide as a step from one zero to the other.

    Raises:
        Undecided, Empty: there is none, or it is not proved.
    """
    for shift in _SHARES:
        try:
            return Zero.alone(functions, [arb(x, step * arb(2) ** -shift) for x in near])
        except Undecided:
            continue
    raise Undecided
