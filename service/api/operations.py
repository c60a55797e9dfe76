"""The questions that can be posted: one entry for each, from which its route and its documentation follow."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import BaseModel

import rpr_solver
from service.api.negotiation import CSV, JSON, JSON_FORM, NDJSON, Form, Forms, ndjson_bytes
from service.schemas.census import Census, CensusRequest
from service.schemas.checks import CheckReport, CheckRequest
from service.schemas.curves import CuspCurves, CuspCurvesRequest
from service.schemas.poses import PosesRequest, PoseTable
from service.schemas.questions import Question
from service.schemas.tables import CuspTable, CuspTableRequest
from worker.answers.kinds import kind_of_job

WEB = Path(__file__).parent / "web"

EXAMPLE_TABLE: dict[str, Any] = json.loads((WEB / "example-table.json").read_text(encoding="utf-8"))
"""The answer for the article's first manipulator at L1 = 0.2 and 15 digits."""


@dataclass(frozen=True)
class Operation:
    """A question, and all that HTTP adds to it.

    Attributes:
        path, name, summary, description: of the operation in OpenAPI; its method is POST.
        tag: the name of its group, and what is said of the group.
        question: reads the body.
        answer: describes the document.
        known: says when the document is answered at once.
        example: of an answer.
        forms: in which the document can be had, by media type.
        implied_wait: seconds to wait for a job when the client does not say; None for not at all.
    """

    path: str
    name: str
    tag: tuple[str, str]
    summary: str
    description: str
    question: type[Question]
    answer: type[BaseModel]
    known: str
    example: object = None
    forms: Forms = field(default_factory=lambda: {JSON: JSON_FORM})
    implied_wait: int | None = None


def _csv(text: Any, line: str) -> Form:
    return Form(lambda document: text(document).encode(), f"A header line, then one line for each {line}.")


CUSP_TABLES = Operation(
    path="/v1/cusp-tables",
    name="post_cusp_table",
    tag=("cusp tables", "Ask for the cusps of a manipulator."),
    summary="The cusps of one manipulator in one or many slices",
    description="""\
Answers 200 with the table when every slice is known already. Otherwise answers 202 with a job that
computes the missing slices; follow its `Location`. With `Prefer: wait=N` the answer waits up to N seconds
for the job and is 200 when it ends in that time.

The same request twice is one job, at the same time or later, and slices that other requests have in
common with this one are computed once. Numbers are exact: `17.04` is 426/25, never a binary float.
""",
    question=CuspTableRequest,
    answer=CuspTable,
    known="Every slice is known: the table.",
    example=EXAMPLE_TABLE,
    forms={
        JSON: JSON_FORM,
        CSV: _csv(rpr_solver.table_csv, "cusp"),
        NDJSON: Form(ndjson_bytes, "One slice a line."),
    },
)
CENSUSES = Operation(
    path="/v1/censuses",
    name="post_census",
    tag=("censuses", "Where the number of cusps changes."),
    summary="Every length at which the number of cusps changes",
    description="""\
The census of a manipulator: all transitions of its slices, by proof and not by scan, each with its
kind and its degenerate poses, and the number of cusps in every interval between.

The whole census is computed once, by a job of some seconds, and kept; a range of it, or fewer digits, are
answered at once from then on. `Prefer: wait=N` waits for the job.
""",
    question=CensusRequest,
    answer=Census,
    known="The census is known.",
    forms={JSON: JSON_FORM, CSV: _csv(rpr_solver.census_csv, "interval")},
)
CUSP_CURVES = Operation(
    path="/v1/cusp-curves",
    name="post_cusp_curves",
    tag=("cusp curves", "How cusps move while the fixed leg changes its length."),
    summary="Each cusp from the transition where it is born to the one where it dies",
    description="""\
The curves that cusps run along while the fixed leg changes its length, each followed by proof and
named: α, the fixed leg's angle and the other two legs as functions of the fixed length.

A name belongs to the manipulator and its fixed leg, whatever range or points are asked for. Points are
given at the lengths `l1`, and with `samples` at so many lengths in every interval between transitions,
however narrow it is; without either, in one slice of each interval. The whole curves are computed once,
by a job of some seconds, and kept.
""",
    question=CuspCurvesRequest,
    answer=CuspCurves,
    known="The curves are known.",
    forms={JSON: JSON_FORM, CSV: _csv(rpr_solver.curves_csv, "point")},
)
CHECKS = Operation(
    path="/v1/checks",
    name="post_check",
    tag=("checks", "Requirements on the number of cusps."),
    summary="Whether a manipulator satisfies a requirement on its cusps",
    description="""\
Proves or refutes a requirement: at most, or at least, so many cusps in every slice of a range, counted
strictly within the joint limits of the other legs.

The report lists the intervals of the range with their numbers of cusps, and for each that violates the
requirement a slice with its cusps. A requirement that is not met is an answer too: 200, `passed` false.
""",
    question=CheckRequest,
    answer=CheckReport,
    known="The report is known.",
)
POSES = Operation(
    path="/v1/poses",
    name="post_poses",
    tag=("poses", "Direct kinematics."),
    summary="All poses of one manipulator with given leg lengths",
    description="""\
Direct kinematics: every real pose of the joint vector (L1, L2, L3), proved to be all of them, each
with its multiplicity: 1 regular, 2 on a singular curve, 3 at a cusp.

A worker computes this in some milliseconds, so the answer waits for it, up to 10 seconds unless `Prefer`
says otherwise; then it is 202 with a job.
""",
    question=PosesRequest,
    answer=PoseTable,
    known="The poses.",
    implied_wait=10,
)

OPERATIONS = (CUSP_TABLES, CENSUSES, CUSP_CURVES, CHECKS, POSES)

_BY_KIND: Mapping[str, Operation] = {
    kind.name: operation for operation in OPERATIONS for kind in operation.question.kinds
}


def forms_of(job_id: str) -> Forms:
    """The forms in which the result of a job can be had; all that there are if it is no id of a job."""
    kind = kind_of_job(job_id)
    return (CUSP_TABLES if kind is None else _BY_KIND[kind.name]).forms
