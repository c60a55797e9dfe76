"""Answers to slices as the contract's objects: one slice, several in turn, and the whole cusp table document.

A slice without an answer says why in its own place and does not spoil its neighbours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Protocol

from rpr_solver.contract import DEFAULT_DIGITS, Progress, document_head, silent
from rpr_solver.errors import InputError, SolverError
from rpr_solver.exact.rationals import exact_str
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.slices.cusp_table import solve_slice
from rpr_solver.slices.eliminant import Eliminant, eliminate


class Answer(Protocol):
    """The table of one slice."""

    def to_json(self) -> dict[str, object]:
        """The contract's slice object."""
        ...


def table_document(
    manipulator: Manipulator,
    lengths: Sequence[Fraction],
    *,
    fixed_leg: int = 1,
    digits: int = DEFAULT_DIGITS,
    progress: Progress = silent,
) -> dict[str, object]:
    """Solves slices of one manipulator and returns the contract's cusp table document.

    Raises:
        InputError: ``fixed_leg`` is not 1, 2 or 3.
    """
    eliminant = eliminate(manipulator, fixed_leg)
    slices = slices_json(lambda x: solve_slice(eliminant, x, digits), lengths, fixed_leg, progress)
    return table_json(manipulator, fixed_leg, digits, slices)


def slice_json(eliminant: Eliminant, length: Fraction, digits: int = DEFAULT_DIGITS) -> dict[str, object]:
    """Solves one slice and returns the contract's slice object, with an ``error`` if there is no answer."""
    fixed_leg = eliminant.slice_map.fixed_leg
    return answer_json(lambda x: solve_slice(eliminant, x, digits), length, fixed_leg)


def slices_json(
    solve: Callable[[Fraction], Answer], lengths: Sequence[Fraction], fixed_leg: int, progress: Progress
) -> list[dict[str, object]]:
    """The slice objects of several lengths, solved in turn."""
    slices = []
    for done, length in enumerate(lengths):
        progress(done, len(lengths))
        slices.append(answer_json(solve, length, fixed_leg))
    progress(len(lengths), len(lengths))
    return slices


def answer_json(solve: Callable[[Fraction], Answer], length: Fraction, fixed_leg: int) -> dict[str, object]:
    """The slice object of one length, with an ``error`` if ``solve`` refuses."""
    try:
        return solve(length).to_json()
    except InputError as error:
        return slice_error_json(length, fixed_leg, "input-error", str(error))
    except SolverError as error:
        return slice_error_json(length, fixed_leg, "solver-error", str(error))


def slice_error_json(length: Fraction, fixed_leg: int, kind: str, detail: str) -> dict[str, object]:
    """The slice object of a slice that has no answer."""
    return {f"l{fixed_leg}": exact_str(length), "error": {"type": kind, "detail": detail}}


def table_json(
    manipulator: Manipulator, fixed_leg: int, digits: int, slices: Sequence[Mapping[str, object]]
) -> dict[str, object]:
    """The contract's cusp table document."""
    return {**document_head(manipulator, digits, fixed_leg), "slices": [dict(s) for s in slices]}
