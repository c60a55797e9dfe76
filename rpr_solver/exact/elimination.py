"""Res_t of two forms in (t, u) over ℤ[ω], divided by known factors, from its values modulo primes.

All degrees are formal, so that zeros at t = ∞ and u = ∞ count. The quotient is interpolated from as many
points u as it has coefficients, and a spare point checks that the known factors divide. The product of the
primes exceeds a proved bound on the coefficients (mathematics.md#the-bound-of-the-coefficients).
"""

from __future__ import annotations

from itertools import count, islice

from flint import fmpz_poly, nmod_poly

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import BiForm
from rpr_solver.exact.modular import interpolated, reconstruct, resultants
from rpr_solver.exact.quadratic import Form, QuadraticPoly


def resultant_bound(first: BiForm, second: BiForm) -> int:
    """A bound on the 1-norm of Res_t, which is at most ‖first‖ⁿ ‖second‖ᵐ for the degrees m and n in t.

    Every term of Sylvester's determinant holds n coefficients of the first form and m of the second, and
    1-norms are submultiplicative.
    """
    return int(first.norm1() ** second.degree_t * second.norm1() ** first.degree_t)


def resultant(first: BiForm, second: BiForm, known: Form | None = None) -> Form:
    """Res_t(first, second) / known, primitive; zero where it vanishes.

    The quotient is multiplied by the content of the norm of ``known``, so that its coefficients stay in ℤ[ω]:
    then it is Res_t times the conjugate of ``known``, divided by a primitive rational polynomial.

    Raises:
        SolverError: a known factor does not divide.
    """
    one = QuadraticPoly.rational([1], first.radicand)
    divisor, known_degree = (known.polynomial, known.degree) if known else (one, 0)
    degree = first.degree_t * second.degree_u + second.degree_t * first.degree_u - known_degree
    norm, conjugate = divisor.norm, divisor.conjugate if divisor.b else one
    content = int(norm.content())
    *us, spare = islice((u for u in count(2) if norm(u) != 0), degree + 2)

    def image(p: int, omega: int, _first: bool) -> list[int] | None:
        at = divisor.residue(p, omega)
        divisors = [int(at(u)) for u in (*us, spare)]
        if not all(divisors):
            return None
        whole = resultants(first.residue(p, omega).at(), second.residue(p, omega).at(), (*us, spare))
        *values, expected = (x * content * pow(k, -1, p) % p for x, k in zip(whole, divisors, strict=True))
        [coefficients] = interpolated([values], us, [0], p)
        if int(nmod_poly(coefficients, p)(spare)) != expected:
            raise SolverError("an eliminant lacks its known factors; please report this geometry")
        return coefficients

    # a coefficient is at most 2^degree times the Mahler measure, which is multiplicative, at most the
    # 1-norm, and at least 1 for a primitive factor
    bound = resultant_bound(first, second) * conjugate.norm1() << degree
    a, b = reconstruct(first.radicand, image, bound)
    return Form(QuadraticPoly(fmpz_poly(a), fmpz_poly(b), first.radicand), degree)
