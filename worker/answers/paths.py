"""Paths without a singularity: loops round cusps, and paths from pose to pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import rpr_solver
from rpr_solver.contract import DEFAULT_SAMPLES, Progress
from rpr_solver.errors import FieldProblem, InputError
from rpr_solver.model.lengths import read_limits
from worker.answers.requests import JobRequest, Kind
from worker.answers.store import ResultStore
from worker.answers.tables import eliminant_of

KIND = Kind("path", "pa-")

_NAMES = {"start": "from", "stop": "to"}

USUAL: Mapping[str, Any] = {
    "samples": DEFAULT_SAMPLES,
    "timing": "cosine",
    "duration": "1",
    "others": False,
}
"""What a loop is of which nothing more is said."""


def compute(request: JobRequest, store: ResultStore, _progress: Progress) -> dict[str, Any]:
    """Compute a path; the eliminant is kept.

    Raises:
        InputError: the slice has no such cusp, or the joint vector no such pose.
        SolverError: the path could not be decided.
    """
    return document(request.manipulator, request.content, lambda: eliminant_of(request, store))


def document(
    manipulator: rpr_solver.Manipulator,
    content: Mapping[str, Any],
    eliminant: Callable[[], rpr_solver.Eliminant],
) -> dict[str, Any]:
    """Returns the document that answers a question in canonical form.

    Raises:
        InputError: naming the member of the question at fault.
        SolverError: the path could not be decided.
    """
    from rpr_solver.paths.loops import loop_in_slice, slice_for_loops  # by those who compute
    from rpr_solver.paths.path import SamplingPlan

    digits, others = content["digits"], content["others"]
    sampling = {name: content[name] for name in ("samples", "timing", "duration")}
    limits = {leg: (ends["min"], ends["max"]) for leg, ends in (content.get("limits") or {}).items()}
    if "cusp" in content:
        own = eliminant()
        table = slice_for_loops(own, content["length"])
        plan = SamplingPlan.of(**sampling)
        path = loop_in_slice(own, table, content["cusp"], plan, digits, read_limits(limits, "limits"))
        return (path.with_others() if others else path).to_json()
    ends = content["between"]
    try:
        answer = rpr_solver.joint_path(
            manipulator,
            content["l1"],
            content["l2"],
            content["l3"],
            content["from"],
            content["to"],
            between=ends and (ends["from"], ends["to"]),
            limits=limits,
            fixed_leg=content["fixed_leg"],
            digits=digits,
            **sampling,
        )
    except InputError as error:
        raise InputError(
            [FieldProblem(_NAMES.get(p.field, p.field), p.message) for p in error.problems]
        ) from None
    return (answer.with_others() if others and isinstance(answer, rpr_solver.Path) else answer).to_json()
