"""Systems of polynomial equations for msolve; their real solutions are the cusps of a slice."""

from __future__ import annotations

from math import gcd, lcm

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from rpr_solver.errors import InputError
from rpr_solver.exports.problem import Leg, Problem

_RING = fmpq_mpoly_ctx.get(("s", "e", "h", "c", "d", "u", "v"), Ordering.lex)
"""c, s: cosine and sine of α; d, e: of θ; h: the height of the platform; (u, v): ∇J / |∇J|²."""
_S, _E, _H, _C, _D, _U, _V = _RING.gens()
_CIRCLES = (_S**2 + _C**2 - 1, _E**2 + _D**2 - 1)


def equations(problem: Problem) -> str:
    """The input of ``msolve -f``.

    Raises:
        InputError: the document is not a table of one slice.
    """
    tables = [part for part in problem.slices if part.cusps is not None]
    if len(problem.slices) != 1 or not tables:
        what = f"has {len(tables)} slices" if tables else "is a census"
        words = f"{what}, but msolve solves one system of equations; give a cusp table of one slice"
        raise InputError.of("document", words)
    names = ("c", "s", "d", "e", *(() if problem.height else ("h",)), "u", "v")
    polynomials = ",\n".join(map(_text, _system(problem)))
    return f"{','.join(names)}\n0\n{polynomials}\n"


def _system(problem: Problem) -> list[fmpq_mpoly]:
    """J = 0 where ∇J ≠ 0, and E = 0 along f and along g: one of them is 0 where ∇f = 0 or ∇g = 0."""
    height = _H if problem.height is None else _RING.constant(_rational(problem.height))
    relations = (*_CIRCLES, *((_H**2 - _rational(problem.square),) if problem.height is None else ()))

    def reduced(p: fmpq_mpoly) -> fmpq_mpoly:
        for relation in relations:
            p %= relation
        return p

    def slopes(p: fmpq_mpoly) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        alpha = _C * p.derivative("s") - _S * p.derivative("c")
        theta = _D * p.derivative("e") - _E * p.derivative("d")
        return reduced(alpha), reduced(theta)

    def along(p: fmpq_mpoly, q: fmpq_mpoly) -> fmpq_mpoly:
        (p_alpha, p_theta), (q_alpha, q_theta) = slopes(p), slopes(q)
        return reduced(p_alpha * q_theta - p_theta * q_alpha)

    def square(leg: Leg) -> fmpq_mpoly:
        x, y, length = _rational(leg.x), leg.y * height, _rational(problem.slices[0].exact)
        across = length * _D + x * _C - y * _S - _rational(leg.ax)
        up = length * _E + x * _S + y * _C - _rational(leg.ay)
        return reduced(across**2 + up**2)

    f, g = map(square, problem.legs)
    j = along(f, g)
    j_alpha, j_theta = slopes(j)
    smooth = (_U * j_alpha + _V * j_theta - 1, _U * j_theta - _V * j_alpha)
    return [j, along(f, j), along(g, j), *smooth, *relations]


def _rational(number: str) -> fmpq:
    top, _, bottom = number.partition("/")
    return fmpq(int(top), int(bottom or 1))


def _text(p: fmpq_mpoly) -> str:
    """A polynomial with integral coefficients that have no common factor."""
    numbers = p.coeffs()
    factor = fmpq(lcm(*(int(x.q) for x in numbers)), gcd(*(int(x.p) for x in numbers)))
    return str(p * factor).replace(" ", "")
