"""What the solver works out about poses, by the definitions alone: SymPy differentiates, mpmath evaluates.

f and g, the squares of the free legs, are written down anew from the geometry; J = f_α g_θ − f_θ g_α,
E = v·∇J and what follows are their derivatives. Nothing here knows of jets, half tangents, forms or
elimination. Lengths of points are in the user's unit; values are those of lengths divided by the size of the
manipulator, so that zeros can be told from other numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import pi
from random import Random
from types import SimpleNamespace
from typing import Any

import mpmath as mp
import sympy as sp
from flint import arb

from rpr_solver import Manipulator, PoseKind

DIGITS = 60
ZERO, NOT_ZERO = mp.mpf("1e-30"), mp.mpf("1e-12")

Point = tuple[Any, Any, Any]
"""α and θ in radians, and L."""
Condition = Callable[..., Sequence[Any]]

ALPHA, THETA, LENGTH = sp.symbols("alpha theta L", real=True)
CONSTANTS = sp.symbols("m n ax ay M N Ax Ay", real=True)


def _square(m: sp.Expr, n: sp.Expr, ax: sp.Expr, ay: sp.Expr) -> sp.Expr:
    """|X + R(α)m − a|² with X = L e(θ), multiplied out."""
    cos, sin = sp.cos(ALPHA), sp.sin(ALPHA)
    fixed = sp.Matrix([LENGTH * sp.cos(THETA), LENGTH * sp.sin(THETA)])
    platform, base = sp.Matrix([m * cos - n * sin, m * sin + n * cos]), sp.Matrix([ax, ay])
    products = fixed.dot(platform) - fixed.dot(base) - platform.dot(base)
    return LENGTH**2 + m**2 + n**2 + ax**2 + ay**2 + 2 * products


def _along(leg: sp.Expr, function: sp.Expr) -> sp.Expr:
    """v·∇function, v being tangent to leg = const."""
    d = sp.diff
    return d(leg, ALPHA) * d(function, THETA) - d(leg, THETA) * d(function, ALPHA)


@cache
def _expressions() -> dict[str, sp.Expr]:
    f, g = _square(*CONSTANTS[:4]), _square(*CONSTANTS[4:])
    j = _along(f, g)
    result = {"f": f, "g": g, "j": j}
    for name, function in (("f", f), ("g", g), ("j", j)):
        result |= {
            f"{name}_{code}": sp.diff(function, *by)
            for code, by in (("aa", (ALPHA, ALPHA)), ("at", (ALPHA, THETA)), ("tt", (THETA, THETA)))
        }
    for name, leg in (("f", f), ("g", g)):
        along = j
        for order in ("e", "along_e", "fourth"):
            along = _along(leg, along)
            result[f"{order}_{name}"] = along
    for name in ("f", "g", "j", "e_f", "e_g"):
        result |= {
            f"{name}_{x}": sp.diff(result[name], by)
            for x, by in (("alpha", ALPHA), ("theta", THETA), ("length", LENGTH))
        }
    return result


@cache
def _compiled(*names: str, module: str = "mpmath") -> Condition:
    expressions = [_expressions()[name] for name in names]
    arguments = (ALPHA, THETA, LENGTH, *CONSTANTS)
    return sp.lambdify(arguments, expressions, module, cse=True)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Slices:
    """All slices of one manipulator with one leg fixed."""

    manipulator: Manipulator
    fixed_leg: int
    size: Fraction
    constants: tuple[mp.mpf, ...]

    @classmethod
    def of(cls, m: Manipulator, fixed_leg: int = 1) -> Slices:
        with mp.workdps(DIGITS):
            p = (m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1)
            height = mp.sqrt(real(m.d3**2 - p**2)) * (1 if m.orientation == "ccw" else -1)
            platform = [(mp.mpf(0), mp.mpf(0)), (real(m.d1), mp.mpf(0)), (real(p), height)]
            base = [(0, 0), (m.a2x, 0), (m.a3x, m.a3y)]
            size = max(abs(m.a2x), abs(m.a3x), abs(m.a3y), m.d1, m.d2, m.d3)
            (x0, y0), (ax0, ay0) = platform.pop(fixed_leg - 1), base.pop(fixed_leg - 1)
            legs = [
                (x - x0, y - y0, real(ax - ax0), real(ay - ay0))
                for (x, y), (ax, ay) in zip(platform, base, strict=True)
            ]
            return cls(m, fixed_leg, size, tuple(c / real(size) for leg in legs for c in leg))

    def values(self, place: Point, *names: str) -> SimpleNamespace:
        """Quantities at a place: f, g, j, e_f, along_e_f, fourth_f …; derivatives as f_alpha, j_at …"""
        alpha, theta, length = place
        with mp.workdps(DIGITS):
            values = _compiled(*names)(alpha, theta, length / real(self.size), *self.constants)
        return SimpleNamespace(**dict(zip(names, values, strict=True)))

    def gradients(self, point: Point, *names: str) -> list[list[mp.mpf]]:
        """Of f, g, j, e_f or e_g, each in α, θ and L."""
        slopes = self.values(point, *(f"{name}_{x}" for name in names for x in ("alpha", "theta", "length")))
        flat, size = list(vars(slopes).values()), real(self.size)
        return [[*flat[i : i + 2], flat[i + 2] / size] for i in range(0, len(flat), 3)]

    def free_legs(self, place: Point) -> tuple[mp.mpf, mp.mpf]:
        """The lengths of the other two legs."""
        v = self.values(place, "f", "g")
        with mp.workdps(DIGITS):
            return mp.sqrt(v.f) * real(self.size), mp.sqrt(v.g) * real(self.size)

    def kind(self, place: Point) -> PoseKind:
        """What a pose is, by the definitions in :class:`PoseKind`."""
        legs = [
            name
            for name in "fg"
            if not _vanish(*vars(self.values(place, f"{name}_alpha", f"{name}_theta")).values())
        ]
        if not legs:
            return PoseKind.HIGHER if self._common_tangent(place) else PoseKind.QUADRUPLE
        along = [f"{order}_{legs[0]}" for order in ("e", "along_e", "fourth")]
        e, along_e, fourth = vars(self.values(place, *along)).values()
        j = self.values(place, "j", "j_alpha", "j_theta", "j_aa", "j_at", "j_tt", "j_length")
        if not _vanish(j.j) or not _vanish(e):
            return PoseKind.ORDINARY
        if _vanish(j.j_alpha, j.j_theta):
            hessian = j.j_aa * j.j_tt - j.j_at**2
            if _vanish(hessian):
                return PoseKind.HIGHER
            if _vanish(j.j_length) or _vanish(along_e):
                return PoseKind.ISOLATED_POINT if hessian > 0 else PoseKind.NODE
            return PoseKind.LIPS if hessian > 0 else PoseKind.BEAK_TO_BEAK
        if not _vanish(along_e):
            return PoseKind.CUSP
        return PoseKind.HIGHER if _vanish(fourth) else PoseKind.SWALLOWTAIL

    def _common_tangent(self, place: Point) -> bool:
        """Whether the Hessians of f and g have a common zero, as binary quadratic forms."""
        v = self.values(place, "f_aa", "f_at", "f_tt", "g_aa", "g_at", "g_tt")
        outer = v.f_aa * v.g_tt - v.f_tt * v.g_aa
        left, right = (2 * (v.f_aa * v.g_at - v.f_at * v.g_aa), 2 * (v.f_at * v.g_tt - v.f_tt * v.g_at))
        return _vanish(outer**2 - left * right)

    def by_newton(self, starts: int) -> list[Point]:
        """Poses with L > 0 that are swallowtails, or have ∇J = 0, as far as Newton's method comes upon them.

        An honest witness: it may miss some, but what it gives is there.
        """
        random = Random(1)
        places: list[Point] = []
        for names in (("j", "e_f", "along_e_f"), ("j", "j_alpha", "j_theta")):
            floats, exact = (self._system(*names, module=module) for module in ("math", "mpmath"))
            rough: list[Sequence[float]] = []
            for _ in range(starts):
                x = [random.uniform(-pi, pi), random.uniform(-pi, pi), random.uniform(0, 3)]
                y = _newton(floats, x, 1e-6, 1e-9)
                if y and y[2] > 1e-3 and not any(_near(y, z) for z in rough):
                    rough.append(y)
            with mp.workdps(DIGITS):
                for y in rough:
                    z = _newton(exact, [mp.mpf(c) for c in y], mp.mpf("1e-25"), mp.mpf("1e-40"))
                    if z:
                        places.append((z[0], z[1], z[2] * real(self.size)))
        return [p for p in places if self.kind(p) not in (PoseKind.ORDINARY, PoseKind.CUSP)]

    def _system(self, *names: str, module: str) -> Condition:
        compiled = _compiled(*names, module=module)
        constants = [float(c) for c in self.constants] if module == "math" else self.constants
        return lambda *place: compiled(*place, *constants)

    def newton(self, point: Point, *, held: int = 2) -> Point | None:
        """The zero of J and E near a point, one of α, θ and L (0, 1, 2) held; None if there is none."""
        x = list(point)
        free = [i for i in range(3) if i != held]
        for _ in range(60):
            values, slopes = self._steeper((x[0], x[1], x[2]))
            matrix = mp.matrix([[row[k] for k in free] for row in slopes])
            try:
                step = mp.lu_solve(matrix, mp.matrix(values))
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
        first, second = ((a, b, c * point[2]) for a, b, c in self._steeper(point)[1])
        cross = [first[i - 2] * second[i - 1] - first[i - 1] * second[i - 2] for i in range(3)]
        size = mp.sqrt(mp.fsum(x * x for x in cross))
        return [x / size for x in cross]

    def _steeper(self, point: Point) -> tuple[list[mp.mpf], list[list[mp.mpf]]]:
        """J and E with their gradients, E along the leg that is steeper: the other may be level."""
        slopes = self.gradients(point, "f", "g", "j", "e_f", "e_g")
        f, g = (mp.hypot(*slope[:2]) for slope in slopes[:2])
        e = "e_f" if f >= g else "e_g"
        return list(vars(self.values(point, "j", e)).values()), [slopes[2], slopes[3 if f >= g else 4]]


def real(x: Fraction | int) -> mp.mpf:
    return mp.mpf(Fraction(x).numerator) / Fraction(x).denominator


def number(ball: arb | Fraction) -> mp.mpf:
    """The middle of a ball, which must be good for nearly all digits; a rational number is exact."""
    if isinstance(ball, Fraction):
        return real(ball)
    assert ball.is_zero() or ball.rel_accuracy_bits() > 160
    with mp.workdps(DIGITS):
        return mp.mpf(ball.mid().str(DIGITS + 5, radius=False))


def distance(a: Point, b: Point) -> mp.mpf:
    """The larger difference of the two angles, on the circle."""
    return max(abs(mp.atan2(mp.sin(x - y), mp.cos(x - y))) for x, y in zip(a[:2], b[:2], strict=True))


def same_place(x: Point, y: Point) -> bool:
    """Whether two places agree to many digits; angles may differ by whole turns."""
    with mp.workdps(DIGITS):
        return bool(distance(x, y) < mp.mpf("1e-19") and abs(x[2] - y[2]) < ZERO**0.5 * abs(y[2]))


def _vanish(*values: mp.mpf) -> bool:
    largest = max(map(abs, values))
    assert not ZERO < largest < NOT_ZERO, f"{largest} is neither zero nor certainly not"
    return bool(largest <= ZERO)


def _newton(system: Condition, x: Sequence[Any], step: Any, accuracy: Any) -> Sequence[Any] | None:
    """A simple solution of three equations, its derivatives taken as differences; or None."""
    for _ in range(40):
        columns = []
        for k in range(3):
            after, before = (
                system(*(c + sign * step * (i == k) for i, c in enumerate(x))) for sign in (1, -1)
            )
            columns.append([(p - q) / (2 * step) for p, q in zip(after, before, strict=True)])
        values, (a, b, c) = system(*x), columns
        whole = _determinant(a, b, c)
        if whole == 0:
            return None
        steps = [_determinant(*m) / whole for m in ((values, b, c), (a, values, c), (a, b, values))]
        longest = max(map(abs, steps))
        factor = 1 if longest < 0.5 else 0.5 / longest
        x = [place - factor * move for place, move in zip(x, steps, strict=True)]
        if longest < accuracy:
            return x
    return None


def _determinant(a: Sequence[Any], b: Sequence[Any], c: Sequence[Any]) -> Any:
    cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return sum(x * y for x, y in zip(cross, c, strict=True))


def _near(x: Sequence[float], y: Sequence[float]) -> bool:
    return all(abs((a - b + pi) % (2 * pi) - pi) < 1e-7 for a, b in zip(x[:2], y[:2], strict=True)) and (
        abs(x[2] - y[2]) < 1e-7
    )
