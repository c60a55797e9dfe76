"""What the solver works out about poses, by the definitions alone: SymPy differentiates, mpmath evaluates.

f and g, the squares of the free legs, are written down anew from the geometry, and J, E and what follows are
their derivatives. Nothing here knows of jets, half tangents, forms or elimination. Lengths are divided by the
size of the manipulator, so that zeros can be told from other numbers.
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

Place = tuple[Any, Any, Any]
"""α and θ in radians, and L."""
Condition = Callable[..., Sequence[Any]]

ALPHA, THETA, LENGTH = sp.symbols("alpha theta L", real=True)
CONSTANTS = sp.symbols("m n ax ay M N Ax Ay", real=True)


def _square(m: sp.Expr, n: sp.Expr, ax: sp.Expr, ay: sp.Expr) -> sp.Expr:
    """|L e(θ) + R(α) m − a|²."""
    along = LENGTH * sp.cos(THETA) + m * sp.cos(ALPHA) - n * sp.sin(ALPHA) - ax
    across = LENGTH * sp.sin(THETA) + m * sp.sin(ALPHA) + n * sp.cos(ALPHA) - ay
    return along**2 + across**2


def _along(leg: sp.Expr, function: sp.Expr) -> sp.Expr:
    """v·∇function, v being tangent to leg = const."""
    d = sp.diff
    return d(leg, ALPHA) * d(function, THETA) - d(leg, THETA) * d(function, ALPHA)


@cache
def _expressions() -> dict[str, sp.Expr]:
    f, g = _square(*CONSTANTS[:4]), _square(*CONSTANTS[4:])
    j = _along(f, g)
    result = {"f": f, "g": g, "j": j, "j_length": sp.diff(j, LENGTH)}
    for name, function in (("f", f), ("g", g), ("j", j)):
        result |= {f"{name}_{x}": sp.diff(function, x) for x in (ALPHA, THETA)}
        result |= {
            f"{name}_{code}": sp.diff(function, *by)
            for code, by in (("aa", (ALPHA, ALPHA)), ("at", (ALPHA, THETA)), ("tt", (THETA, THETA)))
        }
    for name, leg in (("f", f), ("g", g)):
        along = j
        for order in ("e", "along_e", "fourth"):
            along = _along(leg, along)
            result[f"{order}_{name}"] = along
    return result


@cache
def _compiled(*names: str, module: str = "mpmath") -> Condition:
    expressions = [_expressions()[name] for name in names]
    arguments = (ALPHA, THETA, LENGTH, *CONSTANTS)
    return sp.lambdify(arguments, expressions, module, cse=True)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Slices:
    """All slices of one manipulator with one leg fixed."""

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
            return cls(size, tuple(c / real(size) for leg in legs for c in leg))

    def values(self, place: Place, *names: str) -> SimpleNamespace:
        """Quantities at a place: f, g, j, e_f, along_e_f, fourth_f …; derivatives as f_alpha, j_at …"""
        alpha, theta, length = place
        with mp.workdps(DIGITS):
            values = _compiled(*names)(alpha, theta, length / real(self.size), *self.constants)
        return SimpleNamespace(**dict(zip(names, values, strict=True)))

    def free_legs(self, place: Place) -> tuple[mp.mpf, mp.mpf]:
        """The lengths of the other two legs."""
        v = self.values(place, "f", "g")
        with mp.workdps(DIGITS):
            return mp.sqrt(v.f) * real(self.size), mp.sqrt(v.g) * real(self.size)

    def kind(self, place: Place) -> PoseKind:
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

    def _common_tangent(self, place: Place) -> bool:
        """Whether the Hessians of f and g have a common zero, as binary quadratic forms."""
        v = self.values(place, "f_aa", "f_at", "f_tt", "g_aa", "g_at", "g_tt")
        outer = v.f_aa * v.g_tt - v.f_tt * v.g_aa
        left, right = (2 * (v.f_aa * v.g_at - v.f_at * v.g_aa), 2 * (v.f_at * v.g_tt - v.f_tt * v.g_at))
        return _vanish(outer**2 - left * right)

    def by_newton(self, starts: int) -> list[Place]:
        """Poses with L > 0 that are swallowtails, or have ∇J = 0, as far as Newton's method comes upon them.

        An honest witness: it may miss some, but what it gives is there.
        """
        random = Random(1)
        places: list[Place] = []
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


def real(x: Fraction | int) -> mp.mpf:
    return mp.mpf(Fraction(x).numerator) / Fraction(x).denominator


def number(ball: arb | Fraction) -> mp.mpf:
    """The middle of a ball, which must be good for nearly all digits; a rational number is exact."""
    if isinstance(ball, Fraction):
        return real(ball)
    assert ball.is_zero() or ball.rel_accuracy_bits() > 160
    with mp.workdps(DIGITS):
        return mp.mpf(ball.mid().str(DIGITS + 5, radius=False))


def same_place(x: Place, y: Place) -> bool:
    """Whether two places agree to many digits; angles may differ by whole turns."""
    with mp.workdps(DIGITS):
        turns = [(a - b) / (2 * mp.pi) for a, b in zip(x[:2], y[:2], strict=True)]
        return all(abs(t - mp.nint(t)) < mp.mpf("1e-20") for t in turns) and abs(
            x[2] - y[2]
        ) < ZERO**0.5 * abs(y[2])


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
