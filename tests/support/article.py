"""The article's conditions as it prints them, for checking cusps by other formulas than the solver's.

Equations (6), (9), (10), (11) and (12), evaluated with mpmath at one pose. They know nothing of the
fixed leg's map, of half angles or of elimination.
"""

from dataclasses import dataclass

import mpmath as mp

from rpr_solver import Manipulator


@dataclass(frozen=True)
class Pose:
    """Leg lengths and leg angles."""

    lengths: tuple[mp.mpf, mp.mpf, mp.mpf]
    cosines: tuple[mp.mpf, mp.mpf, mp.mpf]
    sines: tuple[mp.mpf, mp.mpf, mp.mpf]


def number(text: object) -> mp.mpf:
    numerator, _, denominator = str(text).partition("/")
    return mp.mpf(numerator) / mp.mpf(denominator or 1)


def pose(manipulator: Manipulator, l1: str, alpha_deg: str, theta1_deg: str) -> Pose:
    """Equation (12): the legs from the pose (alpha, theta1)."""
    m = manipulator
    a2x, a3x, a3y, d1, d2, d3 = (number(getattr(m, k)) for k in ("a2x", "a3x", "a3y", "d1", "d2", "d3"))
    length, alpha, theta1 = number(l1), mp.radians(number(alpha_deg)), mp.radians(number(theta1_deg))
    beta = mp.acos((d1**2 + d3**2 - d2**2) / (2 * d1 * d3)) * (1 if m.orientation == "ccw" else -1)
    x1, y1 = length * mp.cos(theta1), length * mp.sin(theta1)
    legs = [
        (x1, y1),
        (x1 + d1 * mp.cos(alpha) - a2x, y1 + d1 * mp.sin(alpha)),
        (x1 + d3 * mp.cos(alpha + beta) - a3x, y1 + d3 * mp.sin(alpha + beta) - a3y),
    ]
    lengths = [mp.hypot(x, y) for x, y in legs]
    return Pose(
        tuple(lengths),
        tuple(x / r for (x, _), r in zip(legs, lengths, strict=True)),
        tuple(y / r for (_, y), r in zip(legs, lengths, strict=True)),
    )


def singularity(manipulator: Manipulator, p: Pose) -> mp.mpf:
    """The left side of equation (6)."""
    a2x, a3x, a3y = (number(getattr(manipulator, k)) for k in ("a2x", "a3x", "a3y"))
    (_, _, c3), (_, s2, s3) = p.cosines, p.sines
    return a2x * s2 * _s(p, 3, 1) + (a3x * s3 - a3y * c3) * _s(p, 1, 2)


def coalescence(manipulator: Manipulator, p: Pose) -> mp.mpf:
    """The left side of equation (10), divided by the size of its terms."""
    a2x, a3x, a3y = (number(getattr(manipulator, k)) for k in ("a2x", "a3x", "a3y"))
    (l1, l2, l3), (c1, c2, c3), (s1, s2, s3) = p.lengths, p.cosines, p.sines
    k1 = 2 * l2 * ((a3x - a2x) * s2 + l3 * _s(p, 2, 3) - a3y * c2)
    k2 = -2 * l3 * (l1 * _s(p, 1, 3) + a3x * s3 - a3y * c3)
    k3 = -2 * l3 * ((a3x - a2x) * s3 + l2 * _s(p, 2, 3) - a3y * c3)
    k4 = 2 * l1 * (l3 * _s(p, 1, 3) + a3x * s1 - a3y * c1)
    k5 = -2 * l2 * (l1 * _s(p, 1, 2) + a2x * s2)
    c12, c23, c31 = _c(p, 1, 2), _c(p, 2, 3), _c(p, 3, 1)
    h1 = mp.matrix([[l1 * (a2x * c1 + l2 * c12), -l1 * l2 * c12, 0],
                    [-l1 * l2 * c12, -l2 * (a2x * c2 - l1 * c12), 0],
                    [0, 0, 0]])  # fmt: skip
    h2 = mp.matrix([[0, 0, 0],
                    [0, -l2 * ((a2x - a3x) * c2 - l3 * c23 - a3y * s2), -l2 * l3 * c23],
                    [0, -l2 * l3 * c23, l3 * ((a2x - a3x) * c3 + l2 * c23 - a3y * s3)]])  # fmt: skip
    h3 = mp.matrix([[l1 * (a3x * c1 + l3 * c31 + a3y * s1), 0, -l1 * l3 * c31],
                    [0, 0, 0],
                    [-l1 * l3 * c31, 0, l3 * (l1 * c31 - a3x * c3 - a3y * s3)]])  # fmt: skip
    v = mp.matrix([k1 * k2, k3 * k4, -k1 * k4])
    form = k1 * k2 * h1 - k2 * k5 * h2 + k3 * k5 * h3
    terms = [v[i] * form[i, j] * v[j] for i in range(3) for j in range(3)]
    return mp.fsum(terms) / mp.fsum(abs(t) for t in terms)


def _s(p: Pose, i: int, j: int) -> mp.mpf:
    return p.sines[i - 1] * p.cosines[j - 1] - p.cosines[i - 1] * p.sines[j - 1]


def _c(p: Pose, i: int, j: int) -> mp.mpf:
    return p.cosines[i - 1] * p.cosines[j - 1] + p.sines[i - 1] * p.sines[j - 1]
