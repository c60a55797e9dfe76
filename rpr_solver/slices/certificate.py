"""The certificate of a slice's table."""

from __future__ import annotations

from typing import TypedDict

from rpr_solver.exact.factors import FactorShape, shapes_json
from rpr_solver.model.joint_points import free_legs


class Factor(FactorShape):
    """A factor of the eliminant: its degree in u = tan(θ/2), its multiplicity and its origin."""

    origin: str


class RootCertificate(TypedDict):
    """The part of a :class:`SliceCertificate` on the eliminant and its roots."""

    eliminant_degree: int
    real_roots: int
    factors: list[Factor]
    method: str


class SliceCertificate(RootCertificate):
    """The proof of a slice's table.

    ``eliminant_degree`` and ``real_roots`` refer to the factors of origin ``"cusps"``. ``method`` is
    ``"balls"`` if all of their roots are simple, else ``"exact"``; for the article's algorithm it is
    ``"article"``. ``working_bits`` is the least precision of balls, of those tried, that
    decides every pose and digit. ``proofs`` has an object for each cusp: the
    balls ``rank_1``, ``grad_J`` and ``v_grad_E`` (for scaled lengths), which exclude zero, or the
    ``field_degree`` of the number field in which these conditions were decided.
    """

    working_bits: int
    proofs: list[dict[str, str]]


def root_certificate(
    leg: int, cusp_factors: list[tuple[int, int]], real_roots: int, method: str, *, shared: bool = False
) -> RootCertificate:
    """The certificate of an eliminant whose part Q has factors of these degrees and multiplicities.

    Args:
        leg: the fixed leg.
        cusp_factors: degree and multiplicity of each factor of Q.
        real_roots: the number of its real roots.
        method: how the slice was decided.
        shared: whether J and E share curves in the slice.
    """
    return {
        "eliminant_degree": sum(degree * multiplicity for degree, multiplicity in cusp_factors),
        "real_roots": real_roots,
        "factors": _factor_table(leg, cusp_factors, shared=shared),
        "method": method,
    }


def _factor_table(leg: int, cusp_factors: list[tuple[int, int]], *, shared: bool) -> list[Factor]:
    """The factors of Res_t(J, E), a form of degree 48 in u, with their origins."""
    cusps: list[Factor] = [{**shape, "origin": "cusps"} for shape in shapes_json(cusp_factors)]
    if shared:
        return cusps
    closed, _ = free_legs(leg)
    return [
        {"degree": 2, "multiplicity": 1, "origin": f"L{closed}=0"},
        {"degree": 2, "multiplicity": 2, "origin": f"leg {leg} along A{min(leg, closed)}A{max(leg, closed)}"},
        {"degree": 2, "multiplicity": 9, "origin": "circular"},
        *cusps,
    ]
