"""Res_t of two forms in (t, u) over ℤ[ω], divided by known factors, from its values modulo primes.

All degrees are formal, so that zeros at t = ∞ and u = ∞ count. The quotient is interpolated from as many
points u as it has coefficients, and a spare point checks that the known factors divide. The product of the
primes exceeds a proved bound on the coefficients.
"""

from __future__ import annotations

from itertools import count, islice

from flint import fmpz, fmpz_poly, nmod_poly

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


def resultant(
    first: BiForm, second: BiForm, *, circular: int = 0, known: Form | None = None, exponent: int = 0
) -> Form:
    """Res_t(first, second) / ((u²+1)^circular · known^exponent), primitive; zero where it vanishes.

    Numerator and denominator are multiplied by the conjugate of ``known``, so that the divisor is a primitive
    rational polynomial and the coefficients stay in ℤ[ω].

    Raises:
        SolverError: a known factor does not divide.
    """
    radicand = first.radicand
    degree = first.degree_t * second.degree_u + second.degree_t * first.degree_u - 2 * circular
    conjugate, norm = QuadraticPoly.rational([1], radicand), fmpz_poly([1])
    if known is not None:
        degree -= exponent * known.degree
        norm = known.polynomial.norm
        norm = norm / norm.content()
        conjugate = known.polynomial.conjugate if known.polynomial.b else conjugate
    *us, spare = islice((u for u in count(2) if norm(u) != 0), degree + 2)
    divisors = [norm(u) ** exponent * fmpz(u * u + 1) ** circular for u in (*us, spare)]

    def image(p: int, omega: int, _first: bool) -> list[int] | None:
        known_values = [int(x % p) for x in divisors]
        if not all(known_values):
            return None
        factor = conjugate.residue(p, omega)
        whole = resultants(first.residue(p, omega).at(), second.residue(p, omega).at(), (*us, spare))
        *values, expected = (
            value * pow(int(factor(u)), exponent, p) * pow(divisor, -1, p) % p
            for u, value, divisor in zip((*us, spare), whole, known_values, strict=True)
        )
        [coefficients] = interpolated([values], us, [0], p)
        if int(nmod_poly(coefficients, p)(spare)) != expected:
            raise SolverError("an eliminant lacks its known factors; please report this geometry")
        return coefficients

    # a coefficient is at most 2^degree times the Mahler measure, which is multiplicative, at most the
    # 1-norm, and at least 1 for a primitive factor
    bound = resultant_bound(first, second) * conjugate.norm1() ** exponent << degree
    a, b = reconstruct(radicand, image, bound)
    return Form(QuadraticPoly(fmpz_poly(a), fmpz_poly(b), radicand), degree)
