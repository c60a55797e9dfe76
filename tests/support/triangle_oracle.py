"""Poses and cusps of two triangles in numbers alone: a witness that knows no ρ, no frame and no field.

Base and platform are three complex numbers each. With leg 1 fixed at the length L, X = L e^{iθ} is B1, a is a
corner of the base and m one of the platform, both seen from corner 1, and f = |X + m z − a|² with z = e^{iα}.
Half of f, less what is constant, is

    Re (L m z ē − L a ē − m ā z),    e = e^{iθ},

a sum of three waves, so that all its derivatives are closed. Cusps are found by Newton's iteration on J = E =
0 from many starts in doubles, and refined in mpmath; a cusp may be missed, but none is invented.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath as mp
import numpy as np

from rpr_solver.triangles import Geometry

Corners = tuple[Any, Any, Any]
_BINOMIALS = ((1,), (1, 1), (1, 2, 1), (1, 3, 3, 1))


def corners_of(geometry: Geometry) -> tuple[Corners, Corners]:
    """The corners in the article's frame as complex numbers of mpmath, at its precision; no frame is used."""
    base, platform = geometry.base, geometry.platform
    results = []
    for triangle in (base, platform):
        a, b, c = triangle.squares
        if not a:
            # corners 1 and 2 are one
            results.append((mp.mpc(0), mp.mpc(0), mp.mpc(mp.sqrt(_number(c)))))
            continue
        along = a + c - b
        # exact below the roots: of a nearly flat triangle half the digits would be lost
        side, height = (mp.sqrt(_number(square)) for square in (a, 4 * a * c - along**2))
        y = height / (2 * side) * (1 if triangle.sense == "ccw" else -1)
        results.append((mp.mpc(0), mp.mpc(side), mp.mpc(_number(along) / (2 * side), y)))
    sign = -1 if geometry.half_turn else 1
    return tuple(sign * z for z in results[0]), results[1]  # type: ignore[return-value]


def _number(x: Fraction) -> Any:
    return mp.mpf(x.numerator) / x.denominator


def poses(base: Corners, platform: Corners, legs: Sequence[Any]) -> list[tuple[Any, Any]]:
    """All real poses (α, θ1) of a joint vector, in radians, from a sextic in e^{iα}; mpmath at its
    precision."""
    s1, *others = (mp.mpf(leg) ** 2 for leg in legs)

    def system(z: Any) -> list[Any]:
        """v₂, v₃, c₂ and c₃ with 2 v·X = c."""
        vectors = [platform[k] * z - base[k] for k in (1, 2)]
        return [*vectors, *(s - s1 - abs(v) ** 2 for v, s in zip(vectors, others, strict=True))]

    def value(z: Any) -> Any:
        v, w, c, d = system(z)
        # −i (c w − d v) / (2 Im(v̄ w)) is X
        return abs(c * w - d * v) ** 2 - 4 * s1 * (mp.conj(v) * w).imag ** 2

    count = 8
    points = [mp.expjpi(mp.mpf(2 * k) / count) for k in range(count)]
    values = [value(z) for z in points]
    coefficients = [
        mp.fsum(x * z ** (-k) for x, z in zip(values, points, strict=True)) / count for k in range(-3, 4)
    ]
    size = max(map(abs, coefficients))
    guesses = np.roots([complex(c / size) for c in reversed(coefficients)])
    found = []
    for root in (
        _newton(coefficients, mp.mpc(guess)) for guess in guesses if abs(abs(guess) - 1) < _NEAR_CIRCLE
    ):
        if abs(abs(root) - 1) < mp.mpf(10) ** (-mp.mp.dps // 3):
            v, w, c, d = system(root)
            x = -1j * (c * w - d * v) / (2 * (mp.conj(v) * w).imag)
            found.append((mp.arg(root), mp.arg(x)))
    return sorted(found)


_NEAR_CIRCLE = 1e-3
"""Double precision puts simple roots nearer than this to the unit circle, and double ones, too."""


def _newton(coefficients: Sequence[Any], root: Any) -> Any:
    for _ in range(mp.mp.prec.bit_length() + 20):
        value = slope = mp.mpf(0)
        for c in reversed(coefficients):
            slope, value = slope * root + value, value * root + c
        if not slope:
            break
        root -= value / slope
    return root


@dataclass(frozen=True)
class Waves:
    """f/2 and g/2 of a slice: the three complex amplitudes of each free leg, in doubles or in mpmath."""

    amplitudes: tuple[tuple[Any, Any, Any], tuple[Any, Any, Any]]

    @classmethod
    def of(cls, base: Corners, platform: Corners, length: Any) -> "Waves":
        first, second = (
            (length * m, -length * a, -m * a.conjugate()) for m, a in zip(platform[1:], base[1:], strict=True)
        )
        return cls((first, second))

    def derivatives(self, leg: int, alpha: Any, theta: Any, exp: Any) -> list[list[Any]]:
        """[i][j] is ∂α^i ∂θ^j of f/2, i + j ≤ 4."""
        both, base, platform = self.amplitudes[leg]
        z, e = exp(1j * alpha), exp(1j * theta)
        waves = both * z / e, base / e, platform * z
        return [
            [
                (1j ** (i % 4) * (-1j) ** (j % 4) * waves[0]).real
                + ((-1j) ** (j % 4) * waves[1] if i == 0 else 0 * waves[1]).real
                + (1j ** (i % 4) * waves[2] if j == 0 else 0 * waves[2]).real
                for j in range(5 - i)
            ]
            for i in range(5)
        ]

    def system(self, alpha: Any, theta: Any, exp: Any) -> tuple[Any, ...]:
        """J and E with their gradients, and v·∇E, E along leg 2."""
        f, g = (self.derivatives(leg, alpha, theta, exp) for leg in (0, 1))

        def product(p: Any, q: Any, i: int, j: int, k: int, l: int, a: int, b: int) -> Any:  # noqa: E741
            return sum(
                _BINOMIALS[a][m] * _BINOMIALS[b][n] * p[i + m][j + n] * q[k + a - m][l + b - n]
                for m in range(a + 1)
                for n in range(b + 1)
            )

        j = [
            [product(f, g, 1, 0, 0, 1, a, b) - product(f, g, 0, 1, 1, 0, a, b) for b in range(3 - a)]
            for a in range(3)
        ]
        e = [
            [product(f, j, 1, 0, 0, 1, a, b) - product(f, j, 0, 1, 1, 0, a, b) for b in range(2 - a)]
            for a in range(2)
        ]
        along = f[1][0] * e[0][1] - f[0][1] * e[1][0]
        return j[0][0], e[0][0], j[1][0], j[0][1], e[1][0], e[0][1], along, f[1][0], f[0][1]


def cusps(base: Corners, platform: Corners, length: Any, starts: int = 60) -> list[tuple[Any, Any]]:
    """The cusps (α, θ1) of a slice that Newton's iteration finds from starts² points, in radians, by α."""
    size = float(max(abs(z) for z in (*base, *platform, length)))
    small = [tuple(complex(z) / size for z in corners) for corners in (base, platform)]
    waves = Waves.of(small[0], small[1], float(length) / size)  # type: ignore[arg-type]
    turn = 2 * np.pi * (np.arange(starts) + 0.37) / starts
    alpha, theta = (x.ravel() for x in np.meshgrid(turn, turn))
    with np.errstate(all="ignore"):
        for _ in range(40):
            j, e, ja, jt, ea, et, *_ = waves.system(alpha, theta, np.exp)
            det = ja * et - jt * ea
            steps = (j * et - e * jt) / det, (e * ja - j * ea) / det
            reach = np.minimum(1, 0.5 / np.hypot(*steps))
            alpha, theta = alpha - reach * steps[0], theta - reach * steps[1]
        last = np.hypot(*steps)
    found: list[tuple[Any, Any]] = []
    exact = Waves.of(base, platform, mp.mpf(length))
    for x, y in {
        (round(a % (2 * np.pi), 6), round(t % (2 * np.pi), 6))
        for a, t in zip(alpha[last < 1e-9], theta[last < 1e-9], strict=True)
    }:
        pose = refined(exact, mp.mpf(x), mp.mpf(y), size)
        if pose is not None and not any(same(pose, other) for other in found):
            found.append(pose)
    return sorted(found)


def refined(waves: Waves, alpha: Any, theta: Any, size: float) -> tuple[Any, Any] | None:
    """A simple zero of J and E near a pose, at mpmath's precision, if ∇f, ∇J and v·∇E are not 0: a cusp."""
    for _ in range(mp.mp.prec.bit_length() + 6):
        j, e, ja, jt, ea, et, along, fa, ft = waves.system(alpha, theta, mp.exp)
        det = ja * et - jt * ea
        if not det:
            return None
        step = (j * et - e * jt) / det, (e * ja - j * ea) / det
        alpha, theta = alpha - step[0], theta - step[1]
    small = mp.mpf(10) ** (-mp.mp.dps // 2) * size**2
    if abs(step[0]) + abs(step[1]) > mp.mpf(10) ** (-mp.mp.dps // 2):
        return None
    if (
        max(abs(fa), abs(ft)) < small
        or max(abs(ja), abs(jt)) < small * size**2
        or abs(along) < small * size**6
    ):
        return None
    return wrapped(alpha), wrapped(theta)


def wrapped(angle: Any) -> Any:
    """The angle in (−π, π]."""
    return angle - 2 * mp.pi * mp.ceil((angle - mp.pi) / (2 * mp.pi))


def same(first: tuple[Any, Any], second: tuple[Any, Any]) -> bool:
    return all(abs(wrapped(x - y)) < 1e-7 for x, y in zip(first, second, strict=True))
