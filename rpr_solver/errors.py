"""What can go wrong in the solver.

ValueError
└── InputError          the caller gave something that is no manipulator, slice or number
Exception
└── SolverError         the input is right, and this version has no answer
    └── Unproved        the answer, or a step to it, was still open at the highest precision

A plain SolverError is a case that is not supported (an eliminant that vanishes identically), or an identity
that failed and should be reported, such as ``DivisionError`` (exact/quadratic.py). ``NotGeneric``
(transitions) and ``LostError`` (curves) are signals between modules that no caller sees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class FieldProblem:
    """One thing wrong with one input field: its dotted name, and what would be right."""

    field: str
    message: str


class InputError(ValueError):
    """Bad input. ``problems`` names every field at fault; the text is one line."""

    def __init__(self, problems: Sequence[FieldProblem]) -> None:
        self.problems = tuple(problems)
        super().__init__("; ".join(f"{p.field}: {p.message}" for p in self.problems))

    @classmethod
    def of(cls, field: str, message: str) -> InputError:
        """The error of a single field."""
        return cls([FieldProblem(field, message)])


class SolverError(Exception):
    """An honest refusal: no answer could be proved for this slice. Nothing was guessed."""


class Unproved(SolverError):  # noqa: N818 - a verdict, not a fault
    """What the text names could not be proved at any precision up to the limit (exact/precision.py)."""
