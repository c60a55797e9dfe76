"""A polynomial over ℤ[ω] with what proves its real roots: the parts that full certificates share.

{"variable": "u = tan(theta1/2)", "degree": 24, "coefficients": ["…", …],
 "omega": "sqrt(…)", "omega_coefficients": ["…", …]}
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import Any

from rpr_solver.exact.factors import exact_roots, norm_factors
from rpr_solver.exact.modular import primes
from rpr_solver.exact.quadratic import Form
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import RealRoot, real_roots

_PRIMES = 4


@dataclass(frozen=True)
class Certified:
    """A form with its finite real roots.

    Attributes:
        form: the form, in one variable.
        place: a prime, and ω modulo it, by which the form keeps its degree and has no multiple root
            (mathematics.md#images-modulo-primes); None if it has one, or one at infinity, or is 0.
        roots: all finite real roots with their multiplicities.
    """

    form: Form
    place: tuple[int, int] | None
    roots: tuple[tuple[RealRoot, int], ...]

    @classmethod
    def of(cls, form: Form) -> Certified:
        """Finds the prime and the roots.

        Raises:
            Unproved: two roots could not be separated.
        """
        p = form.polynomial
        place = None if p.is_zero else _place(form)
        if place is not None:
            return cls(form, place, tuple((root, 1) for root in real_roots(p)))
        roots = () if p.is_zero else exact_roots(norm_factors(p))
        return cls(form, None, tuple((root.root, root.multiplicity) for root in roots))

    def to_json(self, variable: str, intervals: Iterable[tuple[Fraction, Fraction, int]]) -> dict[str, Any]:
        """The members of a certificate, with isolating intervals of the roots and their multiplicities."""
        return {
            "polynomial": self.polynomial_json(variable),
            "squarefree": self.squarefree_json(),
            "real_roots": [
                {"lower": exact_str(low), "upper": exact_str(high), "multiplicity": multiplicity}
                for low, high, multiplicity in intervals
            ],
        }

    def polynomial_json(self, variable: str) -> dict[str, Any]:
        """The exact coefficients, from the constant one on."""
        p, powers = self.form.polynomial, range(self.form.degree + 1)
        result: dict[str, Any] = {
            "variable": variable,
            "degree": self.form.degree,
            "coefficients": [str(p.a[k]) for k in powers],
        }
        if p.b:
            result["omega"] = f"sqrt({p.radicand})"
            result["omega_coefficients"] = [str(p.b[k]) for k in powers]
        return result

    def squarefree_json(self) -> dict[str, str] | None:
        """The prime, and ω modulo it."""
        return None if self.place is None else {"prime": str(self.place[0]), "omega": str(self.place[1])}


def _place(form: Form) -> tuple[int, int] | None:
    for p, omega in islice(primes(form.polynomial.radicand), _PRIMES):
        image = form.polynomial.residue(p, omega)
        if image.degree() == form.degree and image.gcd(image.derivative()).degree() == 0:
            return p, omega
    return None
