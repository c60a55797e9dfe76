"""The real roots of a slice's eliminant and the poses above them, in balls, from guesses of any origin.

Of a guess nothing is taken but a place to look: that a root is there is proved by an interval Newton step
(mathematics.md#real-roots), and the pose above it is the one common zero of J and E.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise

from flint import arb, arb_mat, arb_poly, ctx

from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.quadratic import omega_ball
from rpr_solver.exact.real_roots import ball_of
from rpr_solver.model.half_tangent import HalfTangent
from rpr_solver.slices.eliminant import DEGREE_L, Eliminant
from rpr_solver.slices.grid import GRID_GUARD

Guesses = Iterable[tuple[float, float]]
"""Numerators and denominators of tan(θ/2)."""

_REACHES = (2.0**-40, 2.0**-47, 2.0**-28)
"""Radii about a guess in which its root is looked for."""
_SPARE = 64
"""The bits to which u is found beyond those of the grid."""
_FIRST_TARGET = 80
_ABOVE_TARGET = 64
"""Precision of a Newton step beyond the bits that it is to find."""
_STEPS = 4
_NEAR = 8
"""Roots beyond are found as 1/u."""
_POWERS_OF_L = 3
_J, _E = 5, 7
"""The coefficients of J and of E in t, and in u."""


class PoseFinder:
    """J, E and Q of a manipulator with one leg fixed, at one working precision, for all slices."""

    def __init__(self, eliminant: Eliminant, bits: int) -> None:
        self.bits = bits
        slice_map, omega = eliminant.slice_map, omega_ball(eliminant.slice_map.radicand, bits)
        with ctx.workprec(bits):
            self._q = arb_mat(eliminant.a) + arb_mat(eliminant.b) * omega
            rows = (*_rows(slice_map.singular, bits), *_rows(slice_map.coalescence, bits))
            self._forms = arb_mat([entry for row in rows for entry in row])
        targets = [bits - GRID_GUARD + _SPARE]
        while targets[-1] > _FIRST_TARGET:
            targets.append(targets[-1] // 2 + 12)
        self._targets = targets[::-1]
        self._goals = [arb(2) ** -target for target in self._targets]

    def at(self, length: Fraction) -> SliceBalls:
        """The slice of a *scaled* length."""
        with ctx.workprec(self.bits):
            ball, powers = ball_of(length), [arb(1)]
            for _ in range(DEGREE_L):
                powers.append(powers[-1] * ball)
            q = (self._q * arb_mat(DEGREE_L + 1, 1, powers)).entries()
            forms = (self._forms * arb_mat(_POWERS_OF_L, 1, powers[:_POWERS_OF_L])).entries()
        return SliceBalls(self.bits, self._targets, self._goals, q, forms)


def _rows(form: BiForm, bits: int) -> Iterator[list[list[arb]]]:
    """For each power of t: for each of seven powers of u the coefficients of three powers of L."""
    for row in form.coefficients:
        parts = [c.ball(bits) for c in row]
        yield [
            [parts[k][power] if k < len(parts) else arb(0) for k in range(_POWERS_OF_L)]
            for power in range(_E)
        ]


class SliceBalls:
    """Q, J and E of one slice at one working precision."""

    def __init__(
        self, bits: int, targets: Sequence[int], goals: Sequence[arb], q: list[arb], forms: list[arb]
    ) -> None:
        self._bits, self._targets, self._goals, self._q, self._forms = bits, targets, goals, q, forms

    def poses(self, guesses: Guesses) -> list[tuple[HalfTangent, HalfTangent]] | None:
        """The poses (α, θ) above different real roots of Q, one for each guess; None if a guess misleads."""
        near: list[tuple[float, float]] = []
        far: list[tuple[float, float]] = []
        for n, d in guesses:
            (near if abs(n) <= _NEAR * abs(d) else far).append((n, d))
        with ctx.workprec(self._bits):
            us = [(x, False) for x in self._roots([n / d for n, d in near], self._q)]
            if far:
                us += [(x, True) for x in self._roots([d / n for n, d in far], self._q[::-1])]
            if len(us) < len(near) + len(far) or not _are_different(us):
                return None
            poses = [*self._above([x for x, far in us if not far], reverse=False)]
            if far:
                poses += self._above([x for x, far in us if far], reverse=True)
        return poses if len(poses) == len(us) else None

    def _roots(self, guesses: list[float], coefficients: list[arb]) -> list[arb]:
        """Balls of the roots about some guesses, without those that are not proved."""
        if not guesses:
            return []
        whole = arb_poly(coefficients)
        roots: list[arb] = []
        for place, target in enumerate(self._targets):
            ctx.prec = min(target + _ABOVE_TARGET, self._bits)
            p = whole * 1  # rounded
            slope, goal = p.derivative(), self._goals[place]
            found = [_first_ball(p, slope, x) for x in guesses] if place == 0 else roots
            sharpened = (_sharpened(p, slope, x, goal) for x in found if x is not None)
            roots = [x for x in sharpened if x is not None]
        ctx.prec = self._bits
        return roots

    def _above(self, roots: list[arb], *, reverse: bool) -> list[tuple[HalfTangent, HalfTangent]]:
        """The poses above roots u, or 1/u, without those that this precision does not decide."""
        one, poses = arb(1), []
        matrix = arb_mat(_J + _E, _E, self._reversed_forms() if reverse else self._forms)
        for x in roots:
            square = x * x
            cube, fourth = square * x, square * square
            powers = [one, x, square, cube, fourth, fourth * x, cube * cube]
            column = (matrix * arb_mat(_E, 1, powers)).entries()
            alpha = _common_root(column[:_J], column[_J:])
            if alpha is not None:
                poses.append((alpha, HalfTangent(one, x) if reverse else HalfTangent(x, one)))
        return poses

    def _reversed_forms(self) -> list[arb]:
        """The coefficients in 1/u: J has degree 4 in u, E degree 6."""
        forms, split = self._forms, _E * _J
        rows = [forms[k : k + _J][::-1] + forms[k + _J : k + _E] for k in range(0, split, _E)]
        rows += [forms[k : k + _E][::-1] for k in range(split, len(forms), _E)]
        return [x for row in rows for x in row]


def _first_ball(p: arb_poly, slope: arb_poly, guess: float) -> arb | None:
    """A ball about a guess that holds one root, by proof."""
    middle = arb(guess)
    value = p(middle)
    for reach in _REACHES:
        x = arb(guess, reach)
        y = middle - value / slope(x)
        if y.is_finite() and x.contains(y):
            return y
    return None


def _sharpened(p: arb_poly, slope: arb_poly, x: arb, goal: arb) -> arb | None:
    """The ball of a root, made as small as a goal by interval Newton steps."""
    for _ in range(_STEPS):
        if x.rad() < goal:
            return x
        middle = x.mid()
        x = middle - p(middle) / slope(x)
        if not x.is_finite():
            return None
    return x if x.rad() < goal else None


def _are_different(us: list[tuple[arb, bool]]) -> bool:
    """Whether roots u, some given as 1/u, are different by proof, and none may be 0 or ∞."""
    if any(x.contains(0) for x, _ in us):
        return False
    values = sorted((1 / x if far else x for x, far in us), key=float)
    return all(x < y for x, y in pairwise(values))


def _common_root(j: list[arb], e: list[arb]) -> HalfTangent | None:
    """The common root t of two forms that share exactly one, by Euclid's algorithm; None if undecided."""
    for inverse in (False, True):
        try:
            a, b = (arb_poly(x[::-1] if inverse else x) for x in (j, e))
            while a.degree() > 1:
                a, b = b % a, a
        except ZeroDivisionError:
            continue
        if a.degree() == 1 and not a[1].contains(0):
            n, d = -a[0], a[1]
            return HalfTangent(d, n) if inverse else HalfTangent(n, d)
    return None
