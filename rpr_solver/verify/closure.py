"""The closure equations of a joint vector, eliminated to one form in the angle α of the platform.

With B1 = X, v₂ = R(α) b₂ − A2 and v₃ likewise, the legs are |X|² = s₁, |X + v₂|² = s₂, |X + v₃|² = s₃. The
differences are linear in X, so X = n / det; then |n|² = s₁ det², of degree 3 in cos α and sin α, holds at
every pose. SymPy expands the squares. Lengths are multiplied by ``unit``, squares by its square.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from rpr_solver.verify.core.manipulator import Geometry
from rpr_solver.verify.core.surds import Poly, Ring, Surd, primitive
from rpr_solver.verify.core.system import Trig, in_half_tangent, normal_form, variables
from rpr_solver.verify.core.work import spend

DEGREE = 6


@dataclass(frozen=True)
class Closure:
    """The closure equations, as trigonometric polynomials in α.

    Attributes:
        vectors: v₂ and v₃, by their components.
        right: the right hand sides of 2 vᵢ · X = rightᵢ.
        determinant: det = 4 v₂ × v₃.
        numerators: n = det · X.
        whole: |n|² − s₁ det².
        upright: the y-components of the legs, times det.
    """

    geometry: Geometry
    squares: tuple[Fraction, Fraction, Fraction]
    unit: int
    ring: Ring
    vectors: tuple[tuple[Trig, Trig], tuple[Trig, Trig]]
    right: tuple[Trig, Trig]
    determinant: Trig
    numerators: tuple[Trig, Trig]
    whole: Trig
    upright: tuple[Trig, Trig, Trig]

    @classmethod
    def of(cls, geometry: Geometry, squares: tuple[Fraction, Fraction, Fraction]) -> Closure:
        """Derives the equations from squared lengths in the user's unit."""
        spend(10_000, 4 * geometry.bits)
        symbols = variables(geometry, (), squares)
        (ca, sa), unit = symbols.alpha, symbols.unit
        x, y = symbols.theta  # used as the unknown B1
        scaled = [int(square * unit**2) for square in squares]
        vectors, lines = [], []
        for leg in (2, 3):
            (mx, my), (ax, ay) = symbols.platform[leg - 1], symbols.base[leg - 1]
            v = ca * mx - sa * my - ax, sa * mx + ca * my - ay
            difference = (x + v[0]) ** 2 + (y + v[1]) ** 2 - x**2 - y**2
            constant = difference.subs([(x, 0), (y, 0)]) - (scaled[leg - 1] - scaled[0])
            lines.append((difference.diff(x), difference.diff(y), -constant))
            vectors.append(v)
        (a, b, e), (c, d, f) = lines
        determinant, n = a * d - b * c, (e * d - f * b, f * a - e * c)
        whole = n[0] ** 2 + n[1] ** 2 - scaled[0] * determinant**2

        def trig(p: Any) -> Trig:
            return normal_form(symbols, p)

        return cls(
            geometry,
            squares,
            unit,
            Ring(symbols.radicand),
            ((trig(vectors[0][0]), trig(vectors[0][1])), (trig(vectors[1][0]), trig(vectors[1][1]))),
            (trig(e), trig(f)),
            trig(determinant),
            (trig(n[0]), trig(n[1])),
            trig(whole),
            (trig(n[1]), *(trig(n[1] + v[1] * determinant) for v in vectors)),  # type: ignore[arg-type]
        )

    @cached_property
    def sextic(self) -> tuple[Surd, ...]:
        """The form of degree 6 in t = tan(α/2), primitive: seven coefficients."""
        row = in_half_tangent(self.whole, DEGREE // 2, lambda _k, _m: 1)
        short = primitive(row)
        return short + ((0, 0),) * (DEGREE + 1 - len(short))

    @cached_property
    def parts(self) -> dict[int, Poly]:
        """Multiplicity → the form of the roots with it, a root at α = 180° as a leading zero."""
        finite = primitive(self.sextic)
        parts = dict(self.ring.squarefree_parts(finite))
        if missing := len(self.sextic) - len(finite):
            parts[missing] = (*parts.get(missing, ((1, 0),)), (0, 0))
        return parts
