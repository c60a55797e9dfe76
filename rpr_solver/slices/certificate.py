"""How the table of a slice is proved."""

from __future__ import annotations

from typing import TypedDict


class Factor(TypedDict):
    """A factor of the eliminant: its degree in u = tan(θ/2), its multiplicity, and why it is there."""

    degree: int
    multiplicity: int
    origin: str


class SliceCertificate(TypedDict):
    """The proof of a slice's table.

    ``eliminant_degree`` and ``real_roots`` belong to the factors whose origin is ``"cusps"``. ``method`` is
    ``"balls"`` where all of their roots are simple, else ``"exact"``; by the article's algorithm it is
    ``"article"``. ``working_bits`` is the largest precision that was needed. ``proofs`` has an object for
    each cusp: balls that exclude zero, ``rank_1``, ``grad_J`` and ``v_grad_E`` (of scaled lengths), or the
    degree of the number field in which the same was decided, ``field_degree``.
    """

    eliminant_degree: int
    real_roots: int
    factors: list[Factor]
    method: str
    working_bits: int
    proofs: list[dict[str, str]]
