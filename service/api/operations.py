"""The operations that answer questions; routes and documentation are made from these entries."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel

import rpr_solver
from service.api.answers.forms import (
    CSV,
    JSON,
    JSON_FORM,
    NDJSON,
    SVG,
    Form,
    Forms,
    csv_pieces,
    ndjson_bytes,
    ndjson_pieces,
    ndjson_size,
)
from service.schemas.aspects import RangeAspects, RangeAspectsRequest
from service.schemas.census import Census, CensusRequest
from service.schemas.checks import CheckReport, CheckRequest
from service.schemas.curves import CuspCurves, CuspCurvesRequest
from service.schemas.paths import Path as PathDocument
from service.schemas.paths import PathRequest
from service.schemas.plots import Plot, PlotRequest
from service.schemas.poses import PosesRequest, PoseTable
from service.schemas.questions import Question
from service.schemas.singular import SingularCurves, SingularCurvesRequest
from service.schemas.tables import CuspTable, CuspTableRequest
from service.schemas.verifications import Verification, VerificationRequest
from worker.answers.kinds import kind_of_job

WEB = Path(__file__).parent / "web"

EXAMPLE_TABLE: dict[str, Any] = json.loads((WEB / "example-table.json").read_text(encoding="utf-8"))
"""The table of the article's first manipulator at L1 = 0.2 with 15 digits."""


@dataclass(frozen=True)
class Operation:
    """A question as an HTTP operation; its method is POST.

    Attributes:
        path, name, summary, description: of the operation in OpenAPI.
        tag: the name and the description of its group.
        question: the model of the body.
        answer: the model of the document.
        known: the description of the response 200.
        example: an answer, for the documentation.
        forms: media type → form of the document.
        implied_wait: seconds to wait for a job if the client states no preference; None: do not wait.
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


def _csv(writer: str, line: str) -> Form:
    """The form that a function of the solver writes; it is loaded when it is first used."""

    def written(document: Any) -> bytes:
        text: str = getattr(rpr_solver, writer)(document)
        return text.encode()

    return Form(written, f"A header line, then one line per {line}.")


CUSP_TABLES = Operation(
    path="/v1/cusp-tables",
    name="post_cusp_table",
    tag=("cusp tables", "Ask for the cusps of a manipulator."),
    summary="The cusps of a manipulator in one or more slices",
    description="""\
Answers 200 with the table if every slice is already known. Otherwise answers 202 with a job that computes
the missing slices; follow its `Location`. With `Prefer: wait=N` the response waits up to N seconds for the
job and is 200 if the job succeeds in that time.

The answer's `Content-Location` is an address that works with GET: with `If-None-Match`, and in other forms.
`If-None-Match` has no meaning for POST and is ignored.

Equal requests share one job, and slices that requests have in common are computed once. Numbers are exact:
`17.04` is 426/25, never a binary float.
""",
    question=CuspTableRequest,
    answer=CuspTable,
    known="The table, with every slice known.",
    example=EXAMPLE_TABLE,
    forms={
        JSON: JSON_FORM,
        CSV: replace(_csv("table_csv", "cusp and degenerate point"), pieces=csv_pieces),
        NDJSON: Form(ndjson_bytes, "One slice per line.", ndjson_pieces, ndjson_size),
    },
)
CENSUSES = Operation(
    path="/v1/censuses",
    name="post_census",
    tag=("censuses", "Where the number of cusps changes."),
    summary="Every length at which the number of cusps changes",
    description="""\
The census of a manipulator: all transitions of its slices, proved complete rather than sampled, each with
its kind and its degenerate poses, and the numbers of cusps and of aspects in every interval between.

The whole census is computed once, by a job of a few seconds, and kept; ranges of it, or fewer digits, are
then answered immediately. `Prefer: wait=N` waits for the job.
""",
    question=CensusRequest,
    answer=Census,
    known="The census.",
    forms={JSON: JSON_FORM, CSV: _csv("census_csv", "interval")},
)
CUSP_CURVES = Operation(
    path="/v1/cusp-curves",
    name="post_cusp_curves",
    tag=("cusp curves", "How cusps move as the length of the fixed leg varies."),
    summary="Each cusp followed from the transition where it appears to the one where it vanishes",
    description="""\
The curves of cusps over the length of the fixed leg, each named and followed by proof: α, the fixed leg's
angle and the lengths of the other two legs as functions of the fixed length.

A name depends on the manipulator and the fixed leg alone, not on the requested range or points. Points are
given at the lengths `l1`, and with `samples` at that many lengths in every interval between transitions,
however narrow; without either, in one slice of each interval. The whole curves are computed once, by a job
of a few seconds, and kept.
""",
    question=CuspCurvesRequest,
    answer=CuspCurves,
    known="The curves.",
    forms={JSON: JSON_FORM, CSV: _csv("curves_csv", "point")},
)
CHECKS = Operation(
    path="/v1/checks",
    name="post_check",
    tag=("checks", "Requirements on the number of cusps."),
    summary="Whether a manipulator satisfies a requirement on its cusps",
    description="""\
Proves or refutes a requirement: a maximum or minimum number of cusps in every slice of a range, counted
strictly within the joint limits of the other legs.

The report lists the intervals of the range with their numbers of cusps and, for each interval that violates
the requirement, a slice with its cusps. A violated requirement is an answer too: 200 with `passed` false.
""",
    question=CheckRequest,
    answer=CheckReport,
    known="The report.",
)
POSES = Operation(
    path="/v1/poses",
    name="post_poses",
    tag=("poses", "Direct kinematics."),
    summary="All poses of a manipulator with given leg lengths",
    description="""\
Direct kinematics: every real pose of the joint vector (L1, L2, L3), proved complete, each with its
multiplicity: 1 regular, 2 on a singular curve, 3 at a cusp.

A worker computes the poses in milliseconds, so the response waits for them, up to 10 seconds unless
`Prefer` says otherwise; after that it is 202 with a job.
""",
    question=PosesRequest,
    answer=PoseTable,
    known="The poses.",
    implied_wait=10,
)

PATHS = Operation(
    path="/v1/paths",
    name="post_path",
    tag=("paths", "Motions without a singularity."),
    summary="A motion from one pose to another of the same leg lengths, without a singularity",
    description="""\
A loop begins and ends at one joint vector, where the manipulator has two poses of one sign of J. The platform
follows the legs continuously, is nowhere singular, and yet arrives at the other pose. Proved along the whole
path, not only at the samples: J keeps its sign, and the loop turns once round the cusp, counter-clockwise,
and round no other cusp of the slice. This is one way to change the assembly mode, not the only one.

From pose to pose, the answer is a path in the slice or, with `between`, with the fixed leg free to move; or
the reason why there is none: J has different signs at both poses, or they lie in different aspects of the
slice or of the range. For the latter the answer names a range of the fixed leg within which they are joined.

With `limits` the path or the loop keeps joint limits, proved as well. There may be no path that does, which
is proved by subdivision, or left undecided at a `resolution` that is told.

Samples are points of that path at equal intervals of time, with the legs, the pose, the determinant and a
bound of the distance to the nearest singular pose. A worker finds a path in a fraction of a second, so the
response waits for it, up to 10 seconds unless `Prefer` says otherwise; after that it is 202 with a job.
""",
    question=PathRequest,
    answer=PathDocument,
    known="The path.",
    forms={JSON: JSON_FORM, CSV: _csv("path_csv", "sample")},
    implied_wait=10,
)

SINGULAR_CURVES = Operation(
    path="/v1/singular-curves",
    name="post_singular_curves",
    tag=("singular curves", "The curves J = 0 of a slice, its assembly modes and aspects."),
    summary="The singular curves of a slice, the number of poses in each region, and the aspects",
    description="""\
All components of the curve J = 0, in the plane of α and the fixed leg's angle and in that of the free legs.
How they run between their special points (cusps, turning points, nodes, …) is proved, and these have proved
digits. Samples between them are for drawing; they are as near to the true curve as `tolerance` says.

`regions` are the faces into which the curves cut the plane of the free legs, each with its number of poses,
proved at a point of it; `aspects` are the connected regions of poses in which J has one sign.

A worker draws a slice in a fraction of a second, so the response waits for it, up to 10 seconds unless
`Prefer` says otherwise; after that it is 202 with a job.
""",
    question=SingularCurvesRequest,
    answer=SingularCurves,
    known="The curves.",
    forms={JSON: JSON_FORM, CSV: _csv("singular_csv", "sample")},
    implied_wait=10,
)

ASPECTS = Operation(
    path="/v1/aspects",
    name="post_aspects",
    tag=("aspects", "Connected sets of poses without a singularity."),
    summary="The aspects of a manipulator while the length of one leg varies within a range",
    description="""\
Aspects of different slices join if the fixed leg may vary, too. The answer has those of a range of lengths,
each with its sign of J and the number of aspects of the slices at both ends that belong to it. An open end is
the limit of slices, of length 0 or without bound.

Their number is exact, and so two poses in different aspects are not joined by any motion without a
singularity within the range. The response waits for a worker, which takes a fraction of a second, up to 10
seconds unless `Prefer` says otherwise; after that it is 202 with a job.
""",
    question=RangeAspectsRequest,
    answer=RangeAspects,
    known="The aspects.",
    implied_wait=10,
)

PLOTS = Operation(
    path="/v1/plots",
    name="post_plot",
    tag=("plots", "Pictures."),
    summary="A picture of a slice, a census, the curves of cusps, a loop, or the mechanism",
    description="""\
Draws what other calls compute. The answer is JSON with the picture as SVG text, its title and a description
in words, or the SVG alone with `Accept: image/svg+xml`; `/v1/plot.svg` gives the same by an address.

Equal questions give the same bytes. In the theme `auto` a picture follows its reader's setting, light or
dark; a moving one stands still for readers who prefer less motion. A census or the curves of all cusps take a
few seconds, anything else less than one; the response waits for it, up to 10 seconds unless `Prefer` says
otherwise.
""",
    question=PlotRequest,
    answer=Plot,
    known="The picture.",
    forms={JSON: JSON_FORM, SVG: Form(lambda document: document["svg"].encode(), "The picture.")},
    implied_wait=10,
)

VERIFICATIONS = Operation(
    path="/v1/verifications",
    name="post_verification",
    tag=("verifications", "Documents checked by independent means."),
    summary="Whether a document is right, claim by claim",
    description="""\
Checks a document of this service, or of the command line, without the solver and its libraries: the equations
are derived from the legs by SymPy, and digits and counts are proved by exact integers and intervals.

Every claim of the document is listed with its place and its status: `proved`, `checked` (short of a proof;
the reason says how far), `not checked`, or `refused`. A refused document is an answer too: 200 with `verdict`
`refused`. The response waits for it, up to 10 seconds unless `Prefer` says otherwise; after that it is 202
with a job.
""",
    question=VerificationRequest,
    answer=Verification,
    known="The verdict and its claims.",
    implied_wait=10,
)

OPERATIONS = (
    CUSP_TABLES,
    CENSUSES,
    CUSP_CURVES,
    CHECKS,
    POSES,
    PATHS,
    SINGULAR_CURVES,
    ASPECTS,
    PLOTS,
    VERIFICATIONS,
)

PICTURES = replace(PLOTS, path="/v1/plot.svg", forms={SVG: PLOTS.forms[SVG]})
"""Pictures as addresses, for pages that show them."""

QUERIES = (CUSP_TABLES, CENSUSES, PICTURES)
"""Those that are asked by GET too. They compute, and so need what POST needs."""

_BY_KIND: Mapping[str, Operation] = {
    kind.name: operation for operation in OPERATIONS for kind in operation.question.kinds
}


def forms_of(job_id: str) -> Forms:
    """Returns the forms of a job's result, or all forms if the id is not a job's."""
    kind = kind_of_job(job_id)
    return (CUSP_TABLES if kind is None else _BY_KIND.get(kind.name, CUSP_TABLES)).forms
