"""The certificate of a slice's table."""

from __future__ import annotations

from typing import TypedDict

from rpr_solver.exact.factors import FactorShape


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
    ``"article"``. ``working_bits`` is the highest precision used. ``proofs`` has an object for each cusp: the
    balls ``rank_1``, ``grad_J`` and ``v_grad_E`` (for scaled lengths), which exclude zero, or the
    ``field_degree`` of the number field in which these conditions were decided.
    """

    working_bits: int
    proofs: list[dict[str, str]]
