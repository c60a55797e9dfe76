"""An independent count of a slice's cusps: multi-start Newton in double precision.

It solves J = E = 0 on the torus from a grid of starts, with E from either leg, and keeps what
converges to a simple solution. It can miss cusps silently, so it serves only as a witness.
"""

from math import cos, hypot, pi, sin

from rpr_solver import Manipulator

Point = tuple[float, float]


class Slice:
    """The map (alpha, theta1) -> (L2², L3²) of one slice, in floats."""

    def __init__(self, manipulator: Manipulator, l1: float) -> None:
        m = manipulator
        a2x, a3x, a3y, d1, d2, d3 = (float(getattr(m, k)) for k in ("a2x", "a3x", "a3y", "d1", "d2", "d3"))
        self.l1 = l1
        p = (d1 * d1 + d3 * d3 - d2 * d2) / (2 * d1)
        h = max(d3 * d3 - p * p, 0.0) ** 0.5 * (1 if m.orientation == "ccw" else -1)
        self.legs = (((d1, 0.0), (a2x, 0.0)), ((p, h), (a3x, a3y)))
        self.size = max(l1, abs(a2x), abs(a3x), abs(a3y), d1, d2, d3)

    def derivatives(self, leg: int, x: Point) -> list[list[float]]:
        """Partial derivatives [i][j] of half the squared length, i + j ≤ 4, in units of size²."""
        (m, n), (ax, ay) = self.legs[leg]
        alpha, theta = x
        s2 = self.size**2
        rows = []
        for i in range(5):
            row = []
            for j in range(5 - i):
                ta, tt = alpha + i * pi / 2, theta + j * pi / 2
                rotated = (m * cos(ta) - n * sin(ta), m * sin(ta) + n * cos(ta))
                value = self.l1 * (cos(tt) * rotated[0] + sin(tt) * rotated[1])
                if i == 0:
                    value -= self.l1 * (ax * cos(tt) + ay * sin(tt))
                if j == 0:
                    value -= ax * rotated[0] + ay * rotated[1]
                row.append(value / s2)
            rows.append(row)
        return rows

    def system(self, leg: int, x: Point) -> tuple[Point, tuple[Point, Point]]:
        """(J, E) and their gradients, E along the curve on which ``leg`` is constant."""
        f, g = self.derivatives(0, x), self.derivatives(1, x)
        w = (f, g)[leg]

        def j(a: int, b: int) -> float:
            return product(f, (1, 0), g, (0, 1), a, b) - product(f, (0, 1), g, (1, 0), a, b)

        table = [[j(a, b) for b in range(3 - a)] for a in range(3)]

        def e(a: int, b: int) -> float:
            return product(w, (1, 0), table, (0, 1), a, b) - product(w, (0, 1), table, (1, 0), a, b)

        return (j(0, 0), e(0, 0)), ((j(1, 0), j(0, 1)), (e(1, 0), e(0, 1)))


def product(
    p: list[list[float]], dp: tuple[int, int], q: list[list[float]], dq: tuple[int, int], a: int, b: int
) -> float:
    """∂^a ∂^b of (∂^dp p)(∂^dq q), for a + b ≤ 2."""
    binomial = ((1,), (1, 1), (1, 2, 1))
    return sum(
        binomial[a][i] * binomial[b][j] * p[dp[0] + i][dp[1] + j] * q[dq[0] + a - i][dq[1] + b - j]
        for i in range(a + 1)
        for j in range(b + 1)
    )


def count_cusps(manipulator: Manipulator, l1: float, starts: int = 24) -> list[Point]:
    """The cusps (alpha, theta1) in radians that Newton finds from starts² points."""
    s = Slice(manipulator, l1)
    cusps: list[Point] = []
    for i in range(starts):
        for k in range(starts):
            x = (2 * pi * (i + 0.31) / starts, 2 * pi * (k + 0.17) / starts)
            for leg in (0, 1):
                if (
                    (y := newton(s, leg, x))
                    and is_cusp(s, y)
                    and not any(distance(y, z) < 1e-5 for z in cusps)
                ):
                    cusps.append(y)
    return cusps


def newton(s: Slice, leg: int, x: Point) -> Point | None:
    for _ in range(30):
        (j, e), ((ja, jt), (ea, et)) = s.system(leg, x)
        det = ja * et - jt * ea
        if det == 0:
            return None
        step = ((j * et - e * jt) / det, (ja * e - ea * j) / det)
        size = hypot(*step)
        if size > 0.5:
            step = (step[0] * 0.5 / size, step[1] * 0.5 / size)
        x = (x[0] - step[0], x[1] - step[1])
        if size < 1e-12:
            return x
    return None


def is_cusp(s: Slice, x: Point) -> bool:
    """Both forms of E vanish: neither ∇f = 0 nor ∇g = 0 fakes it."""
    return all(abs(s.system(leg, x)[0][1]) < 1e-11 for leg in (0, 1)) and all(
        hypot(s.derivatives(leg, x)[1][0], s.derivatives(leg, x)[0][1]) > 1e-7 for leg in (0, 1)
    )


def distance(x: Point, y: Point) -> float:
    return max(abs((a - b + pi) % (2 * pi) - pi) for a, b in zip(x, y, strict=True))
