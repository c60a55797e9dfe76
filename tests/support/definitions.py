"""The conditions of a slice by their definitions: SymPy derives them, mpmath evaluates them at any precision.

No half angles, no elimination, no scaling: f and g are |X + R(α)m − a|², J = f_α g_θ − f_θ g_α, E = v·∇J.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import mpmath as mp
import sympy as sp

from rpr_solver import Manipulator

Point = tuple[mp.mpf, mp.mpf, mp.mpf]
"""(α, θ, L): angles in radians, the length in the user's unit."""


@cache
def _derived() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """(f, g, J, E along f, E along g), and the gradients of these five in (α, θ, L)."""
    alpha, theta, length = point = sp.symbols("alpha theta L", real=True)
    legs = [sp.symbols(f"m{i} n{i} x{i} y{i}", real=True) for i in (1, 2)]
    fixed = sp.Matrix([length * sp.cos(theta), length * sp.sin(theta)])
    turn = sp.Matrix([[sp.cos(alpha), -sp.sin(alpha)], [sp.sin(alpha), sp.cos(alpha)]])

    def square(m: sp.Expr, n: sp.Expr, x: sp.Expr, y: sp.Expr) -> sp.Expr:
        """|X + R(α)m − a|², multiplied out."""
        platform, base = turn * sp.Matrix([m, n]), sp.Matrix([x, y])
        products = fixed.dot(platform) - fixed.dot(base) - platform.dot(base)
        return length**2 + m**2 + n**2 + x**2 + y**2 + 2 * products

    f, g = (square(*leg) for leg in legs)
    j = f.diff(alpha) * g.diff(theta) - f.diff(theta) * g.diff(alpha)
    e_f, e_g = (w.diff(alpha) * j.diff(theta) - w.diff(theta) * j.diff(alpha) for w in (f, g))
    conditions = [f, g, j, e_f, e_g]
    symbols = [*point, *legs[0], *legs[1]]
    gradients = [c.diff(x) for c in conditions for x in point]
    values, slopes = (sp.lambdify(symbols, x, "mpmath", cse=True) for x in (conditions, gradients))
    return values, slopes


class Conditions:
    """f, g, J and E of the slices of one leg of a manipulator."""

    def __init__(self, manipulator: Manipulator, fixed_leg: int = 1) -> None:
        self.manipulator, self.fixed_leg = manipulator, fixed_leg

    def _legs(self) -> list[mp.mpf]:
        """(m, n, x, y) of both free legs, seen from the fixed one, at the working precision."""
        m = self.manipulator
        a2x, a3x, a3y, d1, d2, d3 = (
            mp.mpf(x.numerator) / x.denominator for x in (m.a2x, m.a3x, m.a3y, m.d1, m.d2, m.d3)
        )
        p = (d1**2 + d3**2 - d2**2) / (2 * d1)
        h = mp.sqrt(max(d3**2 - p**2, mp.mpf(0))) * (1 if m.orientation == "ccw" else -1)
        seen = [(0, 0, 0, 0), (d1, 0, a2x, 0), (p, h, a3x, a3y)]
        origin = seen.pop(self.fixed_leg - 1)
        return [x - o for leg in seen for x, o in zip(leg, origin, strict=True)]

    def values(self, *point: mp.mpf) -> list[mp.mpf]:
        """f, g, J, E along f, E along g."""
        return list(_derived()[0](*point, *self._legs()))

    def gradients(self, *point: mp.mpf) -> list[list[mp.mpf]]:
        """Of the same, each in α, θ and L."""
        flat = _derived()[1](*point, *self._legs())
        return [list(flat[i : i + 3]) for i in range(0, len(flat), 3)]

    def newton(self, point: Point, *, held: int = 2) -> Point | None:
        """The zero of J and E near a point, one of α, θ and L (0, 1, 2) held; None if there is none."""
        x = list(point)
        free = [i for i in range(3) if i != held]
        for _ in range(60):
            values, slopes = self.values(*x), self.gradients(*x)
            # E along the leg with the larger gradient: the other may be 0 where it means nothing
            e = max((0, 1), key=lambda leg: mp.hypot(*slopes[leg][:2])) + 3
            matrix = mp.matrix([[slopes[i][k] for k in free] for i in (2, e)])
            try:
                step = mp.lu_solve(matrix, mp.matrix([values[2], values[e]]))
            except ZeroDivisionError:
                return None
            for k, dx in zip(free, step, strict=True):
                x[k] -= dx
            if max(map(abs, step)) < mp.mpf(10) ** (4 - mp.mp.dps) * (1 + abs(x[2])):
                return x[0], x[1], x[2]
        return None

    def trace(
        self, point: Point, low: mp.mpf, high: mp.mpf, *, upwards: bool, step: float = 0.02
    ) -> tuple[mp.mpf, Point]:
        """The curve J = E = 0 followed from a cusp to the first of two lengths that it meets.

        By a predictor along the tangent ∇J × ∇E and Newton's corrector, through turns in L as well.
        """
        start, way, longest = point, self.tangent(point), step
        if (way[2] > 0) != upwards:
            way = [-x for x in way]
        while True:
            held = max(range(3), key=lambda i: abs(way[i]))
            guess = point[0] + step * way[0], point[1] + step * way[1], point[2] * (1 + step * way[2])
            following = self.newton(guess, held=held)
            onwards = self.tangent(following or point)
            turn = sum(x * y for x, y in zip(way, onwards, strict=True))
            onwards = [-x for x in onwards] if turn < 0 else onwards
            inside = following is not None and low < following[2] < high
            turns_back = way[2] * onwards[2] < 0 and step > 1e-4  # it may meet an end unseen
            if following is None or abs(turn) < 0.97 or turns_back or (point == start and not inside):
                step /= 2
                assert step > 1e-6
                continue
            for end in (low, high):
                if (point[2] - end) * (following[2] - end) < 0 or following[2] == end:
                    share = (end - point[2]) / (following[2] - point[2])
                    between = (p + share * (q - p) for p, q in zip(point[:2], following[:2], strict=True))
                    last = self.newton((*between, end))  # type: ignore[arg-type]
                    assert last is not None
                    return end, last
            way = onwards
            point, step = following, min(2 * step, longest)

    def tangent(self, point: Point) -> list[mp.mpf]:
        """∇J × ∇E in α, θ and log L, of length 1."""
        f, g, j, *e = self.gradients(*point)
        first, second = (
            (a, b, c * point[2]) for a, b, c in (j, e[0 if mp.hypot(*f[:2]) >= mp.hypot(*g[:2]) else 1])
        )
        cross = [first[i - 2] * second[i - 1] - first[i - 1] * second[i - 2] for i in range(3)]
        size = mp.sqrt(mp.fsum(x * x for x in cross))
        return [x / size for x in cross]


def distance(a: Point, b: Point) -> mp.mpf:
    """The larger difference of the two angles, on the circle."""
    return max(abs(mp.atan2(mp.sin(x - y), mp.cos(x - y))) for x, y in zip(a[:2], b[:2], strict=True))
