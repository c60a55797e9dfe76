"""Workspaces: at one orientation with all vertices, or swept over orientations in numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

import rpr_solver
from rpr_solver.contract import Progress
from worker.answers.cost import Sizes
from worker.answers.kind import Content, Document, JobRequest, Kind, Store


def workspace(request: JobRequest, _store: Store, progress: Progress) -> Document:
    """Compute the workspace, a tenth of a second for each orientation.

    Raises:
        SolverError: regions or digits could not be decided.
    """
    content = request.content
    phi, limits = content["phi"], bounds_of(content)
    if not isinstance(phi, Mapping):
        return rpr_solver.workspace(request.as_given, phi, limits, digits=request.digits).to_json()
    ends = phi["from"], phi["to"], phi["step"]
    return rpr_solver.workspace_sweep(
        request.as_given, *ends, limits, digits=request.digits, progress=progress
    ).to_json()


def bounds_of(content: Content) -> dict[str, tuple[str | None, str | None]]:
    """The limits of a question, as the library takes them."""
    return {leg: (ends["min"], ends["max"]) for leg, ends in content["limits"].items()}


def _measure(content: Content, size: Sizes) -> Sizes:
    phi = content["phi"]
    if not isinstance(phi, Mapping):
        return replace(size, count=1)
    start, stop, step = (Fraction(phi[name]) for name in ("from", "to", "step"))
    return replace(size, count=int((stop - start) // step) + 1)


def _cost(size: Sizes) -> float:
    """Curves and regions of each orientation, whose equalities are decided by exact numbers, and digits."""
    return size.count * (0.1 + 5e-5 * size.digits + 4e-3 * size.geometry + 6e-4 * size.lengths)


def _fewer(_content: Content, size: Sizes) -> Mapping[str, tuple[Sizes, str]]:
    if size.count == 1:
        return {}
    return {"phi": (replace(size, count=1), f"ask for fewer than {size.count} orientations")}


WORKSPACE = Kind("workspace", "ws-", workspace, _cost, measure=_measure, fewer=_fewer, unit="orientations")
