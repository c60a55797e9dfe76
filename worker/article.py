"""Cusp tables by the article's own algorithm, each slice with the audit of its eliminant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import rpr_solver
from rpr_solver import Manipulator, exact_str
from rpr_solver.errors import InputError, SolverError
from worker.requests import DocumentRequest


def article_request(manipulator: Manipulator, l1: Sequence[Fraction], digits: int) -> DocumentRequest:
    """The request for a table by the article's algorithm; a slice that is asked for twice is kept once."""
    slices = list(dict.fromkeys(exact_str(x) for x in l1))
    return DocumentRequest(
        "article-table", {"geometry": manipulator.to_json(), "l1": slices, "digits": digits}
    )


def article_document(
    manipulator: Manipulator, l1: Sequence[Fraction], digits: int, progress: Callable[[int, int], None]
) -> dict[str, Any]:
    """The table. A slice that the algorithm cannot answer says so in its place."""
    solved: list[dict[str, Any]] = []
    for value in l1:
        progress(len(solved), len(l1))
        try:
            found = rpr_solver.article_table(manipulator, value, digits=digits).to_json()
        except InputError as error:
            found = rpr_solver.slice_error_json(value, 1, "input-error", str(error))
        except SolverError as error:
            found = rpr_solver.slice_error_json(value, 1, "solver-error", str(error))
        solved.append(found)
    progress(len(l1), len(l1))
    return {**rpr_solver.table_json(manipulator, 1, digits, solved), "method": "article"}
