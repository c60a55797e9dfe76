"""The report of the article's algorithm on a slice, beside its cusps."""

from __future__ import annotations

from typing import TypedDict

from rpr_solver.exact.factors import FactorShape


class CoupleReport(TypedDict):
    """A couple (α, θ1) above a real root; its verdict is ``"kept"``, ``"degenerate"`` or ``"rejected"``."""

    alpha_deg: str
    theta1_deg: str
    verdict: str
    reason: str


class FactorReport(TypedDict):
    """A factor of the eliminant: its origin, the reason for it, and the couples above its real roots.

    ``irreducible`` are its own factors over the field of coefficients.
    ``rejected_in_step_6`` counts the real solutions of (13) that violate (14); None if they were not counted.
    """

    origin: str
    degree: int
    multiplicity: int
    irreducible: list[FactorShape]
    reason: str
    real_roots: int
    rejected_in_step_6: int | None
    couples: list[CoupleReport]


class Conjecture(TypedDict):
    """Whether all cusps of the slice belong to the factor of degree 24, as the article conjectures."""

    holds: bool
    answer: str


class AuditReport(TypedDict):
    """The article's steps 1 to 7: the equations, the eliminant's factors, and the conjecture."""

    equations: str
    eliminant_degree: int
    h: str
    factors: list[FactorReport]
    conjecture: Conjecture
