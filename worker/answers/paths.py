"""Paths without a singularity: loops round cusps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rpr_solver.contract import Progress
from rpr_solver.paths.loops import loop_in_slice, slice_for_loops
from rpr_solver.paths.path import DEFAULT_SAMPLES, SamplingPlan
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore
from worker.answers.tables import eliminant_of

KIND = Kind("path", "pa-")

USUAL: Mapping[str, Any] = {
    "samples": DEFAULT_SAMPLES,
    "timing": "cosine",
    "duration": "1",
    "others": False,
}
"""What a loop is of which nothing more is said."""


def compute(request: JobRequest, store: ResultStore, _progress: Progress) -> dict[str, Any]:
    """Compute a loop; the eliminant is kept.

    Raises:
        InputError: the slice has no such cusp.
        SolverError: the slice or the loop could not be decided.
    """
    content = request.content
    plan = SamplingPlan.of(content["samples"], content["timing"], content["duration"])
    eliminant = eliminant_of(request, store)
    table = slice_for_loops(eliminant, content["length"])
    loop = loop_in_slice(eliminant, table, content["cusp"], plan, request.digits)
    return (loop.with_others() if content["others"] else loop).to_json()
