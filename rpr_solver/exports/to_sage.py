"""Scripts for SageMath; they count and compare the cusps of slices."""

from __future__ import annotations

from rpr_solver.exports.problem import Leg, Problem
from rpr_solver.exports.text import filled

_SCRIPT = r"""
from sage.all import AA, QQ, ComplexField, Integer, PolynomialRing, RealField, prod

REAL = RealField(4 * @PRECISION@)
COMPLEX = ComplexField(4 * @PRECISION@)
ZERO = REAL(10) ** -(Integer(@PRECISION@) // 4)

# c, s: cosine and sine of alpha; d, e: of theta. A moving leg, seen from the fixed one, has the base point
# (ax, ay) and the platform point (x, y*h); h is the height of the platform.
R = PolynomialRing(QQ, "c, s, d, e, h")
c, s, d, e, h = R.gens()
P = PolynomialRing(QQ, "t, u, k")
t, u, k = P.gens()
U = PolynomialRing(QQ, "u")
SQUARE = QQ("@SQUARE@")
ROOT = Integer(@SIGN@) * REAL(SQUARE).sqrt()
CIRCLES = R.ideal([c**2 + s**2 - 1, d**2 + e**2 - 1, h**2 - SQUARE])


def reduced(F):
    return CIRCLES.reduce(F)


def da(F):
    return reduced(c * F.derivative(s) - s * F.derivative(c))


def dt(F):
    return reduced(d * F.derivative(e) - e * F.derivative(d))


def along(F, G):
    return reduced(da(F) * dt(G) - dt(F) * da(G))


def square(L, ax, ay, x, y):
    ax, ay, x, y = QQ(ax), QQ(ay), QQ(x), QQ(y)
    return reduced((L * d + x * c - y * h * s - ax) ** 2 + (L * e + x * s + y * h * c - ay) ** 2)


# Half tangents t, u of alpha, theta are counted from these turns, given by cosine and sine.
TURNS = [@TURNS@]


def turned(x, turn):
    return turn[0] * (1 - x**2) - 2 * turn[1] * x, turn[1] * (1 - x**2) + 2 * turn[0] * x


def halved(F, degree):
    # a form of this degree in (c, s) and in (d, e), in t, u and the height k
    (C, S), (D, E) = turned(t, TURNS[0]), turned(u, TURNS[1])
    result = P(0)
    for (i, j, m, n, r), x in F.dict().items():
        rest = (1 + t**2) ** (degree - i - j) * (1 + u**2) ** (degree - m - n)
        result += x * C**i * S**j * D**m * E**n * rest * k**r
    return result


def small(x, degree, length):
    return abs(x) < (Integer(@SIZE@) + length) ** degree * ZERO


def near(x, y):
    return abs(x - y) <= REAL(10) ** (2 - Integer(@DIGITS@)) * max(1, abs(y))


def degrees(x, y):
    angle = COMPLEX(x, y).argument() * 180 / REAL.pi()
    return angle + 360 if angle < REAL(10) ** (2 - Integer(@DIGITS@)) - 180 else angle


def cusps(length):
    l = QQ(length)
    f, g = square(l, @FIRST@), square(l, @SECOND@)
    # J = 0: the pose is singular. E = 0 as well, along f or g: three poses coalesce. V = 0 as well: four.
    J = along(f, g)
    Ef, Eg = along(f, J), along(g, J)
    Vf, Vg = along(f, Ef), along(g, Eg)
    j, E = halved(J, 2), halved(Ef, 3)
    # the norm is rational; roots of the conjugate are no common zeros of J and E
    r = j.resultant(E, t)
    relation = k**2 - SQUARE
    r = (r * r.subs({k: -k})).reduce([relation])
    if r == 0:
        raise SystemExit("J and E share a curve of poses")
    found = []
    for b in U(r.univariate_polynomial()).roots(AA, multiplicities=False):
        b = REAL(b)
        line = PolynomialRing(REAL, "t")(0)
        x = line.parent().gen()
        for (i, m, n), value in j.dict().items():
            line += REAL(value) * b**m * ROOT**n * x**i
        for a in line.roots(COMPLEX, multiplicities=False):
            if abs(a.imag()) > ZERO * (1 + abs(a)):
                continue
            a = a.real()
            (C, S), (D, W) = ([z / (1 + y**2) for z in turned(y, turn)] for y, turn in zip((a, b), TURNS))

            place = (C, S, D, W, ROOT)

            def at(F):
                terms = F.dict().items()
                return REAL(0) + sum(REAL(v) * prod(p**n for p, n in zip(place, m)) for m, v in terms)

            by_g = all(small(at(F), 2, l) for F in (da(f), dt(f)))
            if by_g and all(small(at(F), 2, l) for F in (da(g), dt(g))):
                continue
            if all(small(at(F), 4, l) for F in (da(J), dt(J))) or not small(at(J), 4, l):
                continue
            if not small(at(Eg if by_g else Ef), 6, l) or small(at(Vg if by_g else Vf), 8, l):
                continue
            found.append([degrees(C, S), degrees(D, W), abs(at(f)).sqrt(), abs(at(g)).sqrt()])
    return found


def check_slice(name, length, count, expected):
    found = cusps(length)
    right = len(found) == count and all(
        sum(all(near(x, REAL(y)) for x, y in zip(pose, wanted)) for pose in found) == 1 for wanted in expected
    )
    print(f"{name}: {len(found)} cusps, {count} expected: {'agrees' if right else 'differs'}", flush=True)
    return right


right = [
@CHECKS@
]
print("agrees" if all(right) else "differs")
raise SystemExit(0 if all(right) else 1)
"""


def script(problem: Problem) -> str:
    """The script for ``sage -python``."""
    checks = [
        f'    check_slice("L{problem.fixed_leg} = {part.length}", "{part.exact}", {part.count}, '
        f"{list(part.cusps or ())}),"
        for part in problem.slices
    ]
    first, second = (_leg(leg) for leg in problem.legs)
    turns = ", ".join(f'(QQ("{c}"), QQ("{s}"))' for c, s in problem.turns)
    parts = {"TURNS": turns, "FIRST": first, "SECOND": second, "CHECKS": "\n".join(checks)}
    return filled(_SCRIPT, problem, parts, "# ")


def _leg(leg: Leg) -> str:
    return f'"{leg.ax}", "{leg.ay}", "{leg.x}", {leg.y}'
