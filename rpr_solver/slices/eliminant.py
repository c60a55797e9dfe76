"""The eliminant Q(u, L): every cusp of every slice, as one polynomial over ℤ[ω].

With t = tan(α/2), u = tan(θ/2) and all degrees formal, eliminating t from J and E gives

    Res_t(J, E) = c · w(u)² · (u²+1)⁹ · q(u, L) · Q(u, L),     48 = 4 + 18 + 2 + 24

- w: the fixed leg lies along the base line to leg f; ∇f = 0 at both such poses, so E = 0 is no condition;
- q: leg f has length 0; again ∇f = 0;
- u² + 1: the circular points. The Newton polygons of J and E, as Laurent polynomials in exp(iα) and exp(iθ),
  are so small that the resultant has the exponents −15…15 of exp(iθ) instead of −24…24, hence a factor
  (u²+1)⁹ for every geometry;
- Q: degree 24 in u, 10 in L.

The first three are factors for every geometry, and Q is integral (mathematics.md#the-eliminant). So Q is
determined by its values on a 25 × 11 grid, computed modulo primes; enough primes are taken to exceed a proved
bound on its coefficients.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count, islice
from typing import Any

from flint import fmpz, fmpz_mat, fmpz_poly, nmod_poly

from rpr_solver.contract import SOLVER_VERSION
from rpr_solver.errors import SolverError
from rpr_solver.exact.elimination import resultant_bound
from rpr_solver.exact.modular import interpolated, reconstruct, resultants
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap

DEGREE_U = 24
DEGREE_L = 10


@dataclass(frozen=True)
class Eliminant:
    """Q(u, L) of one manipulator and one fixed leg: every cusp of every slice is above one of its roots.

    u = tan(θ/2), θ the fixed leg's angle, L its *scaled* length: the length in the user's unit times
    ``slice_map.scale``. Q = A + ω B has integer coefficients, degree 24 in u and 10 in L; it is the factor
    that the article keeps (step 5), for symbolic L.

    Attributes:
        manipulator: the geometry.
        slice_map: the integer model of its slices, with the fixed leg, the scale and ω² (``radicand``).
        a, b: A and B without common content, matrices of 25 rows (powers of u) and 11 columns (powers of
            the scaled L).

    >>> from rpr_solver import EXAMPLES, eliminate
    >>> eliminate(EXAMPLES["zein-flat"])
    <Eliminant of leg 1: degree 24 in u, 10 in L1>
    """

    manipulator: Manipulator
    slice_map: SliceMap
    a: fmpz_mat
    b: fmpz_mat

    def __repr__(self) -> str:
        leg = self.slice_map.fixed_leg
        return f"<Eliminant of leg {leg}: degree {DEGREE_U} in u, {DEGREE_L} in L{leg}>"

    def at(self, length: Fraction) -> QuadraticPoly:
        """Q at one *scaled* L, primitive: A(u) + ω B(u); zero if J and E share a curve there."""
        n, d = fmpz(length.numerator), fmpz(length.denominator)
        powers = fmpz_mat(DEGREE_L + 1, 1, [n**k * d ** (DEGREE_L - k) for k in range(DEGREE_L + 1)])
        a, b = (fmpz_poly((part * powers).entries()) for part in (self.a, self.b))
        return QuadraticPoly(a, b, self.slice_map.radicand).primitive()

    def to_json(self) -> dict[str, Any]:
        """A JSON form for caches (about 100 kB); :meth:`from_json` is its inverse."""
        return {
            "solver_version": SOLVER_VERSION,
            "geometry": self.manipulator.to_json(),
            "fixed_leg": self.slice_map.fixed_leg,
            "a": " ".join(str(x) for x in self.a.entries()),
            "b": " ".join(str(x) for x in self.b.entries()),
        }

    @classmethod
    def from_json(cls, obj: Mapping[str, object]) -> Eliminant:
        """The inverse of :meth:`to_json`.

        Raises:
            ValueError: made by another version of the solver.
        """
        if obj["solver_version"] != SOLVER_VERSION:
            raise ValueError(f"eliminant of solver version {obj['solver_version']}, not {SOLVER_VERSION}")
        geometry, leg = obj["geometry"], obj["fixed_leg"]
        if not isinstance(geometry, Mapping) or not isinstance(leg, int):
            raise ValueError("not an eliminant")
        manipulator = Manipulator.from_json(geometry, max_digits=1 << 20)
        a, b = (
            fmpz_mat(DEGREE_U + 1, DEGREE_L + 1, [fmpz(x) for x in str(obj[part]).split()]) for part in "ab"
        )
        return cls(manipulator, SliceMap.of(manipulator, leg), a, b)


def eliminate(manipulator: Manipulator, fixed_leg: int = 1) -> Eliminant:
    """Computes Q(u, L) of a manipulator and one fixed leg, to be shared by all slices (0.1 s).

    Args:
        manipulator: the geometry.
        fixed_leg: the leg of fixed length, 1, 2 or 3.

    Raises:
        InputError: naming ``manipulator`` or ``fixed_leg``.
        SolverError: the resultant lacks one of its known factors.

    >>> from rpr_solver import EXAMPLES, solve_slice
    >>> eliminant = eliminate(EXAMPLES["zein-flat"], fixed_leg=3)
    >>> solve_slice(eliminant, 10, 15)
    <SliceTable L3=10: 4 cusps, 15 digits>
    """
    slice_map = SliceMap.of(manipulator, fixed_leg)
    grid = _Grid.of(slice_map)
    parts = reconstruct(slice_map.radicand, grid.image, _coefficient_bound(slice_map))
    a, b = (fmpz_mat(DEGREE_L + 1, DEGREE_U + 1, part).transpose() for part in parts)
    return Eliminant(manipulator, slice_map, a, b)


@dataclass(frozen=True)
class _Grid:
    """The points (u, L) at which the resultant is evaluated; no known factor vanishes at any of them."""

    slice_map: SliceMap
    us: tuple[int, ...]
    ls: tuple[int, ...]
    known: tuple[tuple[int, ...], ...]
    """The product of the known factors at each point, a row for each L."""

    @classmethod
    def of(cls, slice_map: SliceMap) -> _Grid:
        along = slice_map.f.collinear()
        # one spare point in each direction checks the interpolation
        us = tuple(islice((u for u in count(2) if along(u) != 0), DEGREE_U + 2))

        def known(length: int) -> tuple[int, ...]:
            closed = slice_map.f.closed(Fraction(length))
            return tuple(int(closed(u) * along(u) ** 2 * fmpz(u * u + 1) ** 9) for u in us)

        rows = ((length, row) for length in count(1) if all(row := known(length)))
        ls, table = zip(*islice(rows, DEGREE_L + 2), strict=True)
        return cls(slice_map, us, ls, table)

    def image(self, p: int, omega: int, check: bool) -> list[int] | None:
        """The coefficients of Q modulo p, powers of L first; None if p divides a known factor."""
        if any(x % p == 0 for row in self.known for x in row):
            return None
        j, e = (form.residue(p, omega) for form in (self.slice_map.singular, self.slice_map.coalescence))

        def values(length: int, row: Sequence[int], us: Sequence[int]) -> list[int]:
            whole = resultants(j.at(length), e.at(length), us)
            return [x * pow(k, -1, p) % p for x, k in zip(whole, row, strict=True)]

        *ls, spare_l = self.ls
        *us, spare_u = self.us
        samples = [values(length, row[:-1], us) for length, row in zip(ls, self.known[:-1], strict=True)]
        rows = interpolated(samples, us, ls, p)
        if check:
            at_u = [int(nmod_poly(row, p)(spare_u)) for row in rows]
            if [int(nmod_poly(at_u, p)(spare_l))] != values(spare_l, self.known[-1][-1:], [spare_u]):
                raise SolverError(
                    "the resultant does not have the known factors; please report this geometry"
                )
        return [x for row in rows for x in row]


def _coefficient_bound(slice_map: SliceMap) -> int:
    """A bound on the coefficients of A and B (mathematics.md#the-bound-of-the-coefficients).

    The Mahler measure is multiplicative, at most the 1-norm, and at least 1 for the known
    factors; a coefficient is at most 2^(degrees) times it. |A| ≤ max |A ± ωB|, and B likewise
    since ω ≥ 1.
    """
    return resultant_bound(slice_map.singular, slice_map.coalescence) << (DEGREE_U + DEGREE_L)
