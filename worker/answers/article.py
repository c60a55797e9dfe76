"""Cusp tables by the article's own algorithm, with an audit of each slice's eliminant."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from rpr_solver.contract import Progress
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore

KIND = Kind("article-table", "at-", unit="slices")


def compute(request: JobRequest, _store: ResultStore, progress: Progress) -> dict[str, Any]:
    """Compute a table in one piece."""
    from rpr_solver.article.audit import article_document  # by those who compute: a service starts sooner

    slices = [Fraction(x) for x in request.content["l1"]]
    return article_document(request.manipulator, slices, request.digits, progress)
