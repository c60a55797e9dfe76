"""Cusp tables by the article's own algorithm, each slice with the audit of its eliminant."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from rpr_solver import Manipulator, exact_str
from worker.jobs.requests import DocumentRequest


def article_request(manipulator: Manipulator, l1: Sequence[Fraction], digits: int) -> DocumentRequest:
    """The request for a table by the article's algorithm; a slice that is asked for twice is kept once."""
    slices = list(dict.fromkeys(exact_str(x) for x in l1))
    return DocumentRequest(
        "article-table", {"geometry": manipulator.to_json(), "l1": slices, "digits": digits}
    )
