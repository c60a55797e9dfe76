"""Whether two real algebraic numbers, perhaps of different fields, are one.

No precision shows that, but their minimal polynomials do (mathematics.md#equal-lengths): both numbers are
roots of one irreducible polynomial, and lie in the isolating interval of the same root.
"""

from __future__ import annotations

from flint import fmpq_mat, fmpq_poly

from rpr_solver.exact.number_field import Algebraic
from rpr_solver.exact.precision import LENGTH_BITS, decided_or_none
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.real_roots import real_roots

_FIRST_BITS = 256


def same_number(x: Algebraic, y: Algebraic) -> bool:
    """Whether two real algebraic numbers are equal: one minimal polynomial, and the same root of it."""
    if not x.ball(_FIRST_BITS).overlaps(y.ball(_FIRST_BITS)):
        return False
    minimal = minimal_polynomial(x)
    if minimal_polynomial(y) != minimal:
        return False
    roots = real_roots(QuadraticPoly.rational(minimal.numer()))

    def same(bits: int) -> bool | None:
        first, second = (
            [i for i, root in enumerate(roots) if root.refined(bits).overlaps(z.ball(bits))] for z in (x, y)
        )
        return first == second if len(first) == len(second) == 1 else None

    return bool(decided_or_none(same, _FIRST_BITS, LENGTH_BITS))


def minimal_polynomial(x: Algebraic) -> fmpq_poly:
    """The monic minimal polynomial over ℚ."""
    n = x.field.degree
    power, columns = x.field(1), []
    for _ in range(n):
        columns.append([(x * power).poly[i] for i in range(n)])
        power = power * x.field.generator
    characteristic = fmpq_poly(fmpq_mat(columns).charpoly())
    common = characteristic.gcd(characteristic.derivative())
    return characteristic / common
