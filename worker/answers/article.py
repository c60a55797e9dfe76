"""Cusp tables by the article's own algorithm, each slice with the audit of its eliminant."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from rpr_solver import Manipulator
from rpr_solver.article.audit import article_document
from worker.answers.requests import JobRequest, Kind, Progress
from worker.answers.store import ResultStore
from worker.answers.tables import canonical_slices

KIND = Kind("article-table", "at-", unit="slices")


def article_request(manipulator: Manipulator, slices: Iterable[Fraction], digits: int) -> JobRequest:
    """The request for a table by the article's algorithm; duplicate slices are removed."""
    content = {"geometry": manipulator.to_json(), "l1": canonical_slices(slices), "digits": digits}
    return JobRequest(KIND, content)


def compute_article_table(request: JobRequest, _store: ResultStore, progress: Progress) -> dict[str, Any]:
    """Compute a table, in one piece."""
    slices = [Fraction(x) for x in request.content["l1"]]
    return article_document(request.manipulator, slices, request.digits, progress)
