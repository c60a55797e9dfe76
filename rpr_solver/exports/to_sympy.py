"""Scripts for Python with SymPy."""

from __future__ import annotations

from rpr_solver.exports.problem import Leg, Problem
from rpr_solver.exports.text import filled

_SCRIPT = r'''
from fractions import Fraction
from sys import exit

import mpmath as mp
from sympy import QQ, Poly
from sympy.polys.rings import ring

mp.mp.dps = @PRECISION@
ZERO = mp.mpf(10) ** (-@PRECISION@ // 4)

# c, s: cosine and sine of alpha; d, e: of theta. A moving leg, seen from the fixed one, has the base point
# (ax, ay) and the platform point (x, y h); h is the height of the platform.
R, c, s, d, e, L, h = ring("c s d e L h", QQ)
P, t, u, k = ring("t u k", QQ)
SQUARE, HEIGHT = QQ(*@SQUARE@), @HEIGHT@


def reduced(F):
    """With c^2 + s^2 = d^2 + e^2 = 1, and h^2 put in."""
    height = [h**2 - R(SQUARE)] if HEIGHT is None else [h - R(HEIGHT)]
    return F.rem([s**2 + c**2 - 1, e**2 + d**2 - 1, *height])


def square(ax, ay, x, y):
    F = (L * d + x * c - y * h * s - ax) ** 2 + (L * e + x * s + y * h * c - ay) ** 2
    return reduced(F)


def da(F):
    return reduced(c * F.diff(s) - s * F.diff(c))


def dt(F):
    return reduced(d * F.diff(e) - e * F.diff(d))


def along(F, G):
    return reduced(da(F) * dt(G) - dt(F) * da(G))


# J = 0: the pose is singular. E = 0 as well, along f or g: three poses coalesce. V = 0 as well: four.
f = square(@FIRST@)
g = square(@SECOND@)
J = along(f, g).exquo(L)
Ja, Jt, Ef, Eg = da(J), dt(J), along(f, J), along(g, J)
Vf, Vg = along(f, Ef), along(g, Eg)

# Half tangents t, u of alpha, theta are counted from these turns, given by cosine and sine.
TURNS = [@TURNS@]


def turned(x, turn):
    cosine, sine = turn
    return cosine * (1 - x**2) - 2 * sine * x, sine * (1 - x**2) + 2 * cosine * x


def halved(F, degree, length):
    """A form of this degree in (c, s) and in (d, e), in t, u and the height k."""
    (C, S), (D, E) = turned(t, TURNS[0]), turned(u, TURNS[1])
    result = P(0)
    for (i, j, m, n, power, r), x in F.terms():
        rest = (1 + t**2) ** (degree - i - j) * (1 + u**2) ** (degree - m - n)
        x *= QQ(length.numerator, length.denominator) ** power
        result += C**i * S**j * D**m * E**n * rest * k**r * x
    return result


def number(x):
    return mp.mpf(int(x.numerator)) / int(x.denominator)


ROOT = @SIGN@ * mp.sqrt(number(SQUARE))


def value(F, place):
    place = (*place, ROOT)
    return mp.fsum(number(x) * mp.fprod(p**n for p, n in zip(place, powers)) for powers, x in F.terms())


def small(x, degree, length):
    return abs(x) < (@SIZE@ + length) ** degree * ZERO


def near(x, y):
    return abs(x - y) <= mp.mpf(10) ** (2 - @DIGITS@) * max(1, abs(y))


def degrees(x, y):
    angle = mp.degrees(mp.atan2(y, x))
    return angle + 360 if angle < mp.mpf(10) ** (2 - @DIGITS@) - 180 else angle


def real_roots(F):
    """Of a polynomial over the rationals: isolated by SymPy, then refined."""
    found = []
    for part, _ in F.sqf_list()[1]:
        coefficients = [number(QQ(x.p, x.q)) for x in part.all_coeffs()]
        for (low, high), _ in part.intervals():
            low, high = (number(QQ(x.p, x.q)) for x in (low, high))
            found.append(low if low == high else bisected(coefficients, low, high))
    return found


def bisected(coefficients, low, high):
    """The root of a polynomial between two points at which it has different signs."""
    at_low = mp.polyval(coefficients, low)
    if at_low == 0:
        low -= (high - low) * mp.mpf(10) ** -8
        at_low = mp.polyval(coefficients, low)
    for _ in range(int(3.4 * mp.mp.dps) + 200):
        middle = (low + high) / 2
        if mp.polyval(coefficients, middle) * at_low > 0:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def cusps(length):
    j, E = halved(J, 2, length), halved(Ef, 3, length)
    r = j.resultant(E)
    v, height = r.ring.gens
    if HEIGHT is None:  # the norm is rational; roots of the conjugate are no common zeros of J and E
        r = r.rem([height**2 - SQUARE])
        r = (r * r.compose(height, -height)).rem([height**2 - SQUARE])
    if not r:
        exit("J and E share a curve of poses")
    found, l = [], mp.mpf(length.numerator) / length.denominator
    for b in real_roots(Poly(r.as_expr(), v.as_expr())):
        rows = [mp.mpf(0)] * 5
        for (i, m, n), x in j.terms():
            rows[4 - i] += number(x) * b**m * ROOT**n
        while abs(rows[0]) < ZERO * max(map(abs, rows)):
            rows.pop(0)
        for a in mp.polyroots(rows, maxsteps=500, extraprec=4 * mp.mp.prec):
            if abs(mp.im(a)) < ZERO * (1 + abs(a)):
                found += cusp(mp.re(a), b, l)
    return found


def cusp(a, b, l):
    """The pose with these half tangents, if exactly three poses coalesce there, where J = 0 is smooth."""
    turns = [[number(x) for x in turn] for turn in TURNS]
    (C, S), (D, E) = ([x / (1 + y**2) for x in turned(y, turn)] for y, turn in zip((a, b), turns))
    place = C, S, D, E, l
    by_g = all(small(value(F, place), 2, l) for F in (da(f), dt(f)))
    if by_g and all(small(value(F, place), 2, l) for F in (da(g), dt(g))):
        return []
    if all(small(value(F, place), 3, l) for F in (Ja, Jt)) or not small(value(J, place), 3, l):
        return []
    if not small(value(Eg if by_g else Ef, place), 5, l) or small(value(Vg if by_g else Vf, place), 7, l):
        return []
    return [[degrees(C, S), degrees(D, E), *(mp.sqrt(abs(value(F, place))) for F in (f, g))]]


def same(found, expected):
    return all(near(x, mp.mpf(y)) for x, y in zip(found, expected, strict=True))


def say(what, right):
    print(f"{what}: {'agrees' if right else 'differs'}", flush=True)
    return right


def check_slice(name, length, count, expected):
    found = cusps(Fraction(length))
    right = len(found) == count and all(sum(same(x, y) for x in found) == 1 for y in expected)
    return say(f"{name}: {len(found)} cusps, {count} expected", right)


def check_event(name, length, kind, expected):
    """Newton's method from the printed pose."""
    forms = (J, Ef, Vf) if kind == "swallowtail" else (J, Ja, Jt)
    x = mp.matrix([mp.radians(mp.mpf(expected[0])), mp.radians(mp.mpf(expected[1])), mp.mpf(length)])

    def place():
        return mp.cos(x[0]), mp.sin(x[0]), mp.cos(x[1]), mp.sin(x[1]), x[2]

    slopes = [[da(F), dt(F), F.diff(L)] for F in forms]
    for _ in range(12):
        at = place()
        matrix = mp.matrix([[value(F, at) for F in row] for row in slopes])
        x -= mp.lu_solve(matrix, mp.matrix([value(F, at) for F in forms]))
    at = place()
    zero = all(small(value(F, at), n, at[4]) for F, n in zip(forms, (3, 5, 7)))
    pose = [degrees(*at[:2]), degrees(*at[2:4]), *(mp.sqrt(abs(value(F, at))) for F in (f, g))]
    return say(f"{name}: {kind}", zero and near(at[4], mp.mpf(length)) and same(pose, expected))


right = [
@CHECKS@
]
print("agrees" if all(right) else "differs")
exit(0 if all(right) else 1)
'''


def script(problem: Problem) -> str:
    """The script for ``python``, with SymPy 1.12 or later."""
    name = f"L{problem.fixed_leg} ="
    checks = [
        f'    check_slice("{name} {part.length}", "{part.exact}", {part.count}, {list(part.cusps or ())}),'
        for part in problem.slices
    ]
    checks += [
        f'    check_event("{name} {event.length}", "{event.length}", "{event.system}", {event.numbers}),'
        for event in problem.events
    ]
    first, second = (_leg(leg) for leg in problem.legs)
    parts = {
        "SQUARE": _pair(problem.square),
        "HEIGHT": "None" if problem.height is None else _rational(problem.height),
        "TURNS": ", ".join(f"({_rational(c)}, {_rational(s)})" for c, s in problem.turns),
        "FIRST": first,
        "SECOND": second,
        "CHECKS": "\n".join(checks),
    }
    return filled(_SCRIPT, problem, {**parts}, "# ")


def _pair(number: str) -> str:
    top, _, bottom = number.partition("/")
    return f"({top}, {bottom or 1})"


def _rational(number: str) -> str:
    return f"QQ{_pair(number)}"


def _leg(leg: Leg) -> str:
    return f"{', '.join(map(_rational, (leg.ax, leg.ay, leg.x)))}, {leg.y}"
