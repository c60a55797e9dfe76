"""The condition number of a pose: how far the legs are from measuring all its motions alike.

The rates of the legs are A (vx, vy, ω λ), where v is the velocity of the centroid C of the platform's joints,
ω its angular velocity, and λ the *length scale*. Row i of A is

    (uᵢ, (bᵢ × uᵢ) / λ),

uᵢ being the unit vector from Aᵢ to Bᵢ, and bᵢ the vector from C to Bᵢ. The condition number is σ₁ / σ₃, the
greatest singular value over the least one: 1 if the legs react alike to motions of one size, infinite at a
singular pose. It says by how much relative errors of the legs' rates are magnified in the twist, at most.

Rotations and translations have different units, so that the number depends on λ and on the reference point
(J.-P. Merlet, *Jacobian, manipulability, condition number, and accuracy of parallel robots*, J. Mech. Des.
128, 2006, pp. 199–206); so both are told. A rotation times a *characteristic length* is homogeneous with a
translation (J. Angeles, *Fundamentals of Robotic Mechanical Systems*, who takes the length with which the
best pose is best); C. Gosselin takes velocities of points of the platform instead (*Dexterity indices for
planar and spatial robotic manipulators*, ICRA 1990, pp. 650–655). Unless another λ is given, it is the radius
of gyration of the three joints: the root of the mean of |bᵢ|². Then |v|² + (ω λ)² is the mean square of the
velocities of the joints B1, B2, B3, and λ is a length of the platform alone.

The squares of the singular values are the zeros of x³ − T x² + S x − D (mathematics.md#condition-numbers)
with, for rows wᵢ of A,

    T = Σ |wᵢ|²,    S = Σ |wᵢ × wⱼ|²,    D = det(A)²,

the second by the formula of Cauchy and Binet. With m = T/3, p = m² − S/3 and cos 3φ = (2m³ − S m + D)/2p√p,
0 ≤ φ ≤ π/3, the greatest is m + 2√p cos φ. Nothing cancels in it; so the least is found as the reciprocal of
the greatest zero of the cubic of the reciprocals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any, TypeAlias

from flint import arb

from rpr_solver.exact.rationals import Exact, parse_positive
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.triangles import Surd

CENTROID = "centroid"
"""The reference point, as documents name it: that of the platform's joints."""

Pair: TypeAlias = tuple[Any, Any]
"""x and y of a vector."""


def scale_of(manipulator: Manipulator, given: Exact | None = None) -> Surd:
    """λ: the given number, exact, > 0, in the user's unit; else the radius of gyration of the three joints.

    The sum of |bᵢ|² is a third of that of the squared sides.

    Raises:
        InputError: naming ``length_scale``.

    >>> robot = Manipulator(10, 5, 8, 3, 3, 3)
    >>> scale_of(robot), scale_of(robot, "2.5")
    (Surd('sqrt(3)'), Surd('2.5'))
    """
    if given is None:
        return Surd.root(sum(manipulator.geometry.platform.squares, Fraction(0)) / 9)
    return Surd.of(read_scale(given))


def read_scale(given: Exact) -> Fraction:
    """A length scale, in the user's unit.

    Raises:
        InputError: naming ``length_scale``.
    """
    return parse_positive(given, "length_scale", "a length scale must be > 0")


def condition_json(scale: str) -> dict[str, str]:
    """What documents say of all their condition numbers."""
    return {"length_scale": scale, "reference": CENTROID}


def arms(first: Pair, second: Pair) -> tuple[Pair, Pair, Pair]:
    """The vectors from the centroid to three corners; from those that lead from the first to the others."""
    x, y = ((a + b) / 3 for a, b in zip(first, second, strict=True))
    return (-x, -y), (first[0] - x, first[1] - y), (second[0] - x, second[1] - y)


@dataclass(frozen=True)
class Invariants:
    """T, S and D of the matrix A at a pose; or, over a piece of a path, bounds of them."""

    trace: Any
    minors: Any
    determinant2: Any

    @classmethod
    def of(cls, directions: Sequence[Pair], arms: Sequence[Pair], scale: Any) -> Invariants:
        """Those of legs with these unit vectors, in any ring; ``arms`` are the vectors bᵢ, ``scale`` is λ."""
        rows = [(*u, (b[0] * u[1] - b[1] * u[0]) / scale) for u, b in zip(directions, arms, strict=True)]
        crosses = [_cross(p, q) for p, q in combinations(rows, 2)]
        minors = sum((_dot(x, x) for x in crosses[1:]), _dot(crosses[0], crosses[0]))
        # directions are unit vectors
        trace = sum((row[2] * row[2] for row in rows[1:]), rows[0][2] * rows[0][2]) + 3
        determinant = _dot(crosses[0], rows[2])
        return cls(trace, minors, determinant * determinant)

    def condition(self) -> arb:
        """The condition number as a ball; not finite if D may be 0."""
        t, s, d = self.trace, self.minors, self.determinant2
        # the reciprocals are the zeros of the same cubic with S/D, T/D and 1/D
        return _root(_greatest(t, s, d) * _greatest(s / d, t / d, 1 / d))


def _greatest(trace: arb, minors: arb, determinant: arb) -> arb:
    """The greatest zero of x³ − T x² + S x − D, whose zeros are known to be positive."""
    third = trace / 3
    p = third * third - minors / 3
    angle = _angle((2 * third**3 - minors * third + determinant) / (2 * p * p.sqrt()))
    return third + 2 * _root(p) * angle.cos()


def _angle(cosine: arb) -> arb:
    """φ, from the cosine of 3φ, of which it is known that it is one; all angles if it is not finite."""
    if not cosine.is_finite():
        return arb(0).union(arb.pi() / 3)
    least, most = (x.max(arb(-1)).min(arb(1)).acos() / 3 for x in (cosine.upper(), cosine.lower()))
    return least.union(most)


def _root(x: arb) -> arb:
    """The square root of a number of which it is known that it is not negative."""
    least, most = (end.max(arb(0)).sqrt() for end in (x.lower(), x.upper()))
    return least.union(most)


def _cross(p: Sequence[Any], q: Sequence[Any]) -> tuple[Any, Any, Any]:
    return p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]


def _dot(p: Sequence[Any], q: Sequence[Any]) -> Any:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
