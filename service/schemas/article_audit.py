"""The audit of a slice by the article's method."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from service.schemas.model import Model


class Couple(Model):
    """A couple (α, θ1): a real solution above a root of the article's eliminant."""

    alpha_deg: str
    theta1_deg: str
    verdict: Literal["kept", "degenerate", "rejected"]
    reason: str


class ArticleFactor(Model):
    """A factor of the article's eliminant, the couples (α, θ1) above its real roots, and their origin."""

    origin: str
    degree: int
    multiplicity: int
    irreducible: list[dict[str, int]]
    reason: str
    real_roots: int
    rejected_in_step_6: int | None
    couples: list[Couple]


class Audit(Model):
    """The article's algorithm, audited step by step."""

    equations: str
    eliminant_degree: int
    h: str
    factors: list[ArticleFactor]
    conjecture: dict[str, Any] = Field(
        description="Whether the factor Q alone yields all cusps, with the reason."
    )
