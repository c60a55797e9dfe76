"""Curves on which J and E vanish together in a slice, as for congruent triangles (method.md section 6).

There a whole curve of poses is degenerate and the eliminant vanishes identically. The curves are
divided out; what remains has an eliminant of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq, fmpz, fmpz_mpoly, fmpz_mpoly_ctx

from rpr_solver.errors import SolverError
from rpr_solver.exact.number_field import Algebraic, evaluate
from rpr_solver.exact.quadratic import Pair, primitive_pair, univariate
from rpr_solver.model.slice_map import SliceMap

_RING = fmpz_mpoly_ctx.get(("t", "u", "omega"), "lex")
_T, _U, _OMEGA = _RING.gens()
_Parts = tuple[fmpz_mpoly, fmpz_mpoly]
"""A + ω B, polynomials in t and u."""


@dataclass(frozen=True)
class Curve:
    """A curve of degenerate poses: a polynomial in t = tan(α/2) and u = tan(θ/2); None is α = 180°."""

    polynomial: fmpz_mpoly | None

    def holds(self, t: Algebraic | None, u: Algebraic) -> bool:
        """Whether the pose (t, u) lies on the curve; t is None at α = 180°."""
        if self.polynomial is None or t is None:
            return self.polynomial is None and t is None
        field = u.field
        rows = _by_power((self.polynomial, _T * 0), int(self.polynomial.degrees()[0]))
        in_t = [evaluate([field(fmpq(c)) for c in row.coeffs()], u) for row, _ in rows]
        return evaluate(in_t, t).is_zero

    def equation(self, fixed_leg: int) -> str:
        """The curve in words that a reader can check."""
        if self.polynomial is None:
            return "alpha = 180 deg"
        if self.polynomial in (_T, -_T):
            return "alpha = 0 deg"
        return f"{self.polynomial} = 0 with t = tan(alpha/2), u = tan(theta{fixed_leg}/2)"


@dataclass(frozen=True)
class SliceForms:
    """J and E of one slice by coefficients of t (formal degrees), less the curves they share."""

    singular: tuple[Pair, ...]
    coalescence: tuple[Pair, ...]
    shared: tuple[Curve, ...] = ()

    @classmethod
    def of(cls, slice_map: SliceMap, length: Fraction) -> SliceForms:
        """The slice as it is."""
        return cls(slice_map.singular.at(length), slice_map.coalescence.at(length))


def without_shared_curves(slice_map: SliceMap, length: Fraction) -> tuple[SliceForms, Pair]:
    """Divide J and E by the curves they share in this slice; the rest, and its eliminant in u.

    Raises:
        SolverError: they share a curve that is not rational.
    """
    whole = SliceForms.of(slice_map, length)
    j, e = _Form.of(whole.singular), _Form.of(whole.coalescence)
    shared: list[Curve] = []
    if (drop := min(j.drop, e.drop)) > 0:
        shared.append(Curve(None))
        j, e = _Form(j.parts, j.degree - j.drop), _Form(e.parts, e.degree - drop)
    while (common := _common_factor(*j.parts, *e.parts)) is not None:
        shared += _real_curves(common)
        j, e = j.divided(common), e.divided(common)
        # a component that J holds more often than E must not come back as an isolated zero
        while (again := _common_factor(*j.parts, common)) is not None:
            j = j.divided(again)
    resultant = j.joined().resultant(e.joined(), "t")
    # formal degrees: where only one loses degree in t, its zeros at t = ∞ meet the other's leading term
    resultant *= e.leading() ** j.drop * j.leading() ** e.drop
    pair = _in_u(resultant, slice_map.radicand)
    if not (pair[0] or pair[1]):
        raise SolverError("J and E share a curve of poses that is not rational; this slice is not supported")
    return SliceForms(j.rows(), e.rows(), tuple(shared)), primitive_pair(*pair)


@dataclass(frozen=True)
class _Form:
    """A + ω B with its formal degree in t."""

    parts: _Parts
    degree: int

    @classmethod
    def of(cls, rows: Sequence[Pair]) -> _Form:
        def whole(part: int) -> fmpz_mpoly:
            terms: dict[tuple[int, ...], int | fmpz] = {
                (i, k, 0): c for i, row in enumerate(rows) for k, c in enumerate(row[part].coeffs()) if c
            }
            return _RING.from_dict(terms)

        return cls((whole(0), whole(1)), len(rows) - 1)

    @property
    def actual(self) -> int:
        return max(int(p.degrees()[0]) for p in self.parts)

    @property
    def drop(self) -> int:
        """The multiplicity of the zero at t = ∞."""
        return self.degree - self.actual

    def divided(self, factor: fmpz_mpoly) -> _Form:
        return _Form((self.parts[0] / factor, self.parts[1] / factor), self.degree - int(factor.degrees()[0]))

    def joined(self) -> fmpz_mpoly:
        return self.parts[0] + _OMEGA * self.parts[1]

    def leading(self) -> fmpz_mpoly:
        a, b = _by_power(self.parts, self.degree)[self.actual]
        terms: dict[tuple[int, ...], int | fmpz] = {
            (0, k, w): c for w, part in ((0, a), (1, b)) for k, c in enumerate(part.coeffs()) if c
        }
        return _RING.from_dict(terms)

    def rows(self) -> tuple[Pair, ...]:
        return _by_power(self.parts, self.degree)


def _common_factor(*polynomials: fmpz_mpoly) -> fmpz_mpoly | None:
    common = _T * 0
    for p in polynomials:
        common = common.gcd(p)
    return None if common.is_constant() else common


def _real_curves(common: fmpz_mpoly) -> list[Curve]:
    """The irreducible curves of a common factor, without t² + 1 and u² + 1, which are no poses."""
    imaginary = (_T**2 + 1, _U**2 + 1)
    return [Curve(factor) for factor, _ in common.factor()[1] if factor not in imaginary]


def _by_power(parts: _Parts, degree: int) -> tuple[Pair, ...]:
    """The coefficients of t⁰ … t^degree, polynomials in u."""
    rows: list[tuple[dict[int, fmpz], dict[int, fmpz]]] = [({}, {}) for _ in range(degree + 1)]
    for part, polynomial in enumerate(parts):
        for (i, k, _), c in polynomial.to_dict().items():
            rows[i][part][k] = c
    return tuple((univariate(a), univariate(b)) for a, b in rows)


def _in_u(polynomial: fmpz_mpoly, radicand: int) -> Pair:
    """A polynomial in u and ω as A(u) + ω B(u)."""
    parts: tuple[dict[int, fmpz], dict[int, fmpz]] = ({}, {})
    for (_, k, power), c in polynomial.to_dict().items():
        part = parts[0 if radicand == 1 else power % 2]
        part[k] = part.get(k, fmpz(0)) + c * fmpz(radicand) ** (power // 2)
    return univariate(parts[0]), univariate(parts[1])
