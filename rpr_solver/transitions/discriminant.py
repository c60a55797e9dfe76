"""Candidate lengths from the discriminant of Q(u, L), for manipulators whose events are not isolated.

For similar, congruent and flat triangles Q(u, L) falls into factors of low degree over ℚ. Where no two of
their real roots meet and none goes to infinity, the roots move without collision, and the number of simple
ones, which are the cusps, stays.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, combinations

from flint import fmpz, fmpz_mpoly, fmpz_mpoly_ctx, fmpz_poly

from rpr_solver.errors import SolverError
from rpr_solver.exact.quadratic import univariate
from rpr_solver.model.slice_map import BiForm, SliceMap
from rpr_solver.slices.eliminant import DEGREE_U, Eliminant
from rpr_solver.transitions.events import Landmark, positive_roots

_PLANE = fmpz_mpoly_ctx.get(("u", "L"), "lex")
_SPACE = fmpz_mpoly_ctx.get(("t", "u", "L", "omega"), "lex")
_OMEGA = _SPACE.gen(3)
_UNSUPPORTED = "the census of this degenerate geometry is not supported: its eliminant has no small factors"


def candidate_lengths(eliminant: Eliminant) -> Iterator[Landmark]:
    """The positive scaled L at which roots of Q(u, L) can meet or leave for infinity.

    Raises:
        SolverError: the factors are too large, or J and E share an irrational curve at every L.
    """
    norm = _norm(eliminant) or _divided_norm(eliminant.slice_map)
    factors = [factor for factor, _ in norm.factor()[1]]
    in_u = [factor for factor in factors if factor.degrees()[0] > 0]
    if any(factor.degrees()[0] > DEGREE_U for factor in in_u):
        raise SolverError(_UNSUPPORTED)
    meetings = chain(
        (factor for factor in factors if factor.degrees()[0] == 0),
        (_leading(factor) for factor in in_u),
        (factor.discriminant("u") for factor in in_u if factor.degrees()[0] > 1),
        (first.resultant(second, "u") for first, second in combinations(in_u, 2)),
    )
    found = {str(f): f for polynomial in meetings for f, _ in _in_length(polynomial).factor()[1]}
    for factor in found.values():
        yield from positive_roots(factor)


def _norm(eliminant: Eliminant) -> fmpz_mpoly:
    """Q Q̄, or Q itself where it is rational; 0 where J and E share a curve at every L."""

    def whole(part: object) -> fmpz_mpoly:
        rows = enumerate(part.tolist())  # type: ignore[attr-defined]
        return _PLANE.from_dict({(i, k): c for i, row in rows for k, c in enumerate(row) if c})

    a, b = whole(eliminant.a), whole(eliminant.b)
    return a * a - eliminant.slice_map.radicand * b * b if b else a


def _divided_norm(slice_map: SliceMap) -> fmpz_mpoly:
    """The norm of Res_t(J, E) after J and E were divided by what they share, times their leading terms."""
    j, e = (_parts(form) for form in (slice_map.singular, slice_map.coalescence))
    while not (common := _common(*j, *e)).is_constant():
        j, e = ((a / common, b / common) for a, b in (j, e))
        while not (again := _common(*j, common)).is_constant():
            j = (j[0] / again, j[1] / again)
    j_whole, e_whole = (a + _OMEGA * b for a, b in (j, e))
    resultant = j_whole.resultant(e_whole, "t") * _leading(j_whole) * _leading(e_whole)
    a, b = _omega_parts(resultant, slice_map.radicand)
    norm = a * a - slice_map.radicand * b * b if b else a
    if not norm:
        raise SolverError(_UNSUPPORTED)
    return norm


def _parts(form: BiForm) -> tuple[fmpz_mpoly, fmpz_mpoly]:
    def whole(part: int) -> fmpz_mpoly:
        return _SPACE.from_dict(
            {
                (i, k, power, 0): c
                for i, row in enumerate(form.coefficients)
                for power, pair in enumerate(row)
                for k, c in enumerate(pair[part].coeffs())
                if c
            }
        )

    return whole(0), whole(1)


def _common(*polynomials: fmpz_mpoly) -> fmpz_mpoly:
    common = polynomials[0]
    for p in polynomials[1:]:
        common = common.gcd(p)
    return common


def _leading(p: fmpz_mpoly) -> fmpz_mpoly:
    """The coefficient of the highest power of the ring's first variable."""
    top = p.degrees()[0]
    return p.context().from_dict({(0, *rest): c for (i, *rest), c in p.to_dict().items() if i == top})


def _omega_parts(p: fmpz_mpoly, radicand: int) -> tuple[fmpz_mpoly, fmpz_mpoly]:
    parts: tuple[dict[tuple[int, ...], int | fmpz], dict[tuple[int, ...], int | fmpz]] = ({}, {})
    for (_, k, power, w), c in p.to_dict().items():
        part = parts[0 if radicand == 1 else w % 2]
        part[k, power] = part.get((k, power), 0) + c * fmpz(radicand) ** (w // 2)
    return _PLANE.from_dict(parts[0]), _PLANE.from_dict(parts[1])


def _in_length(p: fmpz_mpoly) -> fmpz_poly:
    return univariate({power: c for (_, power), c in p.to_dict().items()})
