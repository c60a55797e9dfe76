"""A witness for censuses: the lengths at which two roots of Q(u, L) meet, from its discriminant in u.

For similar, congruent and flat triangles Q(u, L) splits into factors of low degree over ℚ. The number of
cusps above simple roots changes at these lengths only; those of a census must be among them.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, combinations

from flint import fmpz_mat, fmpz_mpoly, fmpz_poly

from rpr_solver.errors import SolverError
from rpr_solver.exact.biform import RING, BiForm, leading_coefficient, without_common_factors
from rpr_solver.exact.quadratic import univariate
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.slices.eliminant import DEGREE_U, Eliminant
from rpr_solver.transitions.event_systems import Landmark
from rpr_solver.transitions.isolated_events import positive_roots

_T, _U = range(2)
_UNSUPPORTED = "the census of this degenerate geometry is not supported: its eliminant has no small factors"


def candidate_lengths(eliminant: Eliminant) -> Iterator[Landmark]:
    """The positive scaled L at which two roots of Q(u, L) can meet, or one can be infinite.

    Raises:
        SolverError: the factors are too large, or J and E share an irrational curve at every L.
    """
    norm = _norm(eliminant) or _divided_norm(eliminant.slice_map)
    factors = [factor for factor, _ in norm.factor()[1]]
    in_u = [factor for factor in factors if factor.degrees()[_U] > 0]
    if any(factor.degrees()[_U] > DEGREE_U for factor in in_u):
        raise SolverError(_UNSUPPORTED)
    meetings = chain(
        (factor for factor in factors if factor.degrees()[_U] == 0),
        (leading_coefficient(factor, _U) for factor in in_u),
        (factor.discriminant("u") for factor in in_u if factor.degrees()[_U] > 1),
        (first.resultant(second, "u") for first, second in combinations(in_u, 2)),
    )
    different = {str(f): f for polynomial in meetings for f, _ in _in_length(polynomial).factor()[1]}
    for factor in different.values():
        yield from positive_roots(factor)


def _norm(eliminant: Eliminant) -> fmpz_mpoly:
    """Q Q̄, or Q itself where it is rational; 0 where J and E share a curve at every L."""

    def whole(part: fmpz_mat) -> fmpz_mpoly:
        rows = enumerate(part.tolist())
        return RING.from_dict({(0, i, k, 0): c for i, row in rows for k, c in enumerate(row) if c})

    return BiForm(whole(eliminant.a), whole(eliminant.b), eliminant.slice_map.radicand, 0, DEGREE_U).norm


def _divided_norm(slice_map: SliceMap) -> fmpz_mpoly:
    """The norm of Res_t(J, E), J and E divided by their common factors, times their leading coefficients."""
    j, e, _ = without_common_factors(slice_map.singular, slice_map.coalescence)
    first, second = j.joined, e.joined
    resultant = first.resultant(second, "t")
    resultant *= leading_coefficient(first, _T) * leading_coefficient(second, _T)
    norm = BiForm.of(resultant, slice_map.radicand, 0, 0).norm
    if not norm:
        raise SolverError(_UNSUPPORTED)
    return norm


def _in_length(p: fmpz_mpoly) -> fmpz_poly:
    return univariate({power: c for (_, _, power, _), c in p.to_dict().items()})
