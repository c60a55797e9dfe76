"""What OpenAPI says about each operation beyond its code: bodies, answers, headers, examples, links."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from service.api.problems import MEDIA_TYPE, ProblemType

WEB = Path(__file__).parent / "web"
Docs = dict[int | str, dict[str, Any]]

EXAMPLE_JOB_ID = "ct-0f343b0931126a20f133d67c2b018a3b5c1f6d3e"
EXAMPLE_GEOMETRY = {"a2x": 15.91, "a3x": 0, "a3y": 10, "d1": 17.04, "d2": 16.54, "d3": 20.84}
EXAMPLE_REQUEST: dict[str, Any] = {"geometry": EXAMPLE_GEOMETRY, "l1": 14.98}

EXAMPLE_TABLE: dict[str, Any] = json.loads((WEB / "example-table.json").read_text(encoding="utf-8"))
"""The answer for the article's first manipulator at L1 = 0.2 and 15 digits."""

_RANGE = {"start": "0.1", "stop": "50.1", "step": "0.1"}
_JOB = {
    "id": EXAMPLE_JOB_ID,
    "kind": "cusp-table",
    "status": "running",
    "progress": {"done": 120, "total": 501},
    "created_at": "2026-01-15T09:30:00.000Z",
    "started_at": "2026-01-15T09:30:00.012Z",
    "finished_at": None,
    "error": None,
    "links": {
        "self": f"/v1/jobs/{EXAMPLE_JOB_ID}",
        "result": f"/v1/jobs/{EXAMPLE_JOB_ID}/result",
        "events": f"/v1/jobs/{EXAMPLE_JOB_ID}/events",
    },
}
_RETRY_AFTER = {
    "Retry-After": {"description": "Seconds after which to ask again.", "schema": {"type": "integer"}}
}
_ETAG = {
    "ETag": {"description": "Strong validator of this representation.", "schema": {"type": "string"}},
    "Cache-Control": {
        "description": "Immutable, when every slice has an answer.",
        "schema": {"type": "string"},
    },
}


def ref(model: str) -> dict[str, str]:
    """A reference to a model's schema."""
    return {"$ref": f"#/components/schemas/{model}"}


def answer(
    description: str, model: str, *, example: object = None, headers: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """A JSON answer."""
    content: dict[str, Any] = {"schema": ref(model)}
    if example is not None:
        content["example"] = example
    found: dict[str, Any] = {"description": description, "content": {"application/json": content}}
    return {**found, "headers": dict(headers)} if headers else found


def with_csv(description: str, model: str, lines: str) -> dict[str, Any]:
    """An immutable answer in JSON or, with a header line and then ``lines``, in CSV."""
    found = answer(description, model, headers=_ETAG)
    text = {"type": "string", "description": f"A header line, then {lines}."}
    return {**found, "content": {**found["content"], "text/csv": {"schema": text}}}


def problems(*kinds: ProblemType) -> Docs:
    """The problems that an operation can answer with, by status. 500 belongs to all."""
    found: Docs = {}
    for kind in (*kinds, ProblemType.INTERNAL):
        info = kind.value
        known = found.setdefault(
            info.status, {"description": "", "content": {MEDIA_TYPE: {"schema": ref("Problem")}}}
        )
        known["description"] = f"{known['description']}; {info.title}".removeprefix("; ")
        if info.status in (429, 503) or kind is ProblemType.NOT_FINISHED:
            known["headers"] = _RETRY_AFTER
    return dict(sorted(found.items(), key=lambda item: int(item[0])))


def _table(description: str, *others: str) -> dict[str, Any]:
    """A cusp table, or one of some other documents."""
    schema = {"anyOf": [ref("CuspTable"), *map(ref, others)]} if others else ref("CuspTable")
    return {
        "description": description,
        "headers": _ETAG,
        "content": {
            "application/json": {"schema": schema, "example": EXAMPLE_TABLE},
            "text/csv": {
                "schema": {"type": "string", "description": "A header line, then one line for each cusp."}
            },
            "application/x-ndjson": {"schema": {"type": "string", "description": "One slice a line."}},
        },
    }


def _link(operation: str, description: str, job_id: str) -> dict[str, Any]:
    return {"operationId": operation, "parameters": {"job_id": job_id}, "description": description}


_JOB_LINKS = {
    "job": _link("get_job", "The state of the job.", "$response.body#/id"),
    "result": _link("get_result", "The result, when the job has succeeded.", "$response.body#/id"),
    "events": _link("get_events", "The job's events.", "$response.body#/id"),
    "cancel": _link("cancel_job", "Cancels the job.", "$response.body#/id"),
}

_UNAVAILABLE = ProblemType.UNAVAILABLE
_FAILED = (
    ProblemType.JOB_FAILED_INPUT,
    ProblemType.JOB_FAILED_SOLVER,
    ProblemType.JOB_FAILED,
    ProblemType.JOB_LOST,
    ProblemType.JOB_EXHAUSTED,
    ProblemType.JOB_TIMEOUT,
)


def question(known: dict[str, Any]) -> Docs:
    """The answers to a question: known, or computed by a job."""
    accepted = answer(
        "The answer is being computed.",
        "Job",
        example=_JOB,
        headers={
            "Location": {"description": "The job.", "schema": {"type": "string"}},
            **_RETRY_AFTER,
            "Preference-Applied": {"description": "What was done of Prefer.", "schema": {"type": "string"}},
        },
    )
    return {
        200: known,
        202: {**accepted, "links": _JOB_LINKS},
        **problems(
            ProblemType.INVALID_JSON,
            ProblemType.NOT_ACCEPTABLE,
            ProblemType.JOB_CANCELED,
            ProblemType.BODY_TOO_LARGE,
            ProblemType.UNSUPPORTED_MEDIA_TYPE,
            ProblemType.INVALID_REQUEST,
            ProblemType.LIMIT_EXCEEDED,
            _UNAVAILABLE,
            *_FAILED,
        ),
    }


def posted(model: str, examples: Mapping[str, tuple[str, Any]]) -> dict[str, Any]:
    """What is sent with a question; each example has a summary and a value."""
    shown = {name: {"summary": summary, "value": value} for name, (summary, value) in examples.items()}
    return {
        "parameters": [
            {
                "name": "Prefer",
                "in": "header",
                "required": False,
                "description": "RFC 7240. `wait=N` waits up to N seconds (see max_wait_seconds in "
                "/v1/limits) for the answer; `respond-async` asks for a job at once.",
                "schema": {"type": "string"},
                "examples": {"wait": {"value": "wait=10"}, "async": {"value": "respond-async"}},
            }
        ],
        "requestBody": {
            "required": True,
            "content": {"application/json": {"schema": ref(model), "examples": shown}},
        },
    }


CUSP_TABLES_RESPONSES = question(_table("Every slice is known: the table."))
CUSP_TABLES_EXTRA = posted(
    "CuspTableRequest",
    {
        "slice": ("The article's first manipulator, one slice", EXAMPLE_REQUEST),
        "scan": (
            "The same manipulator, 501 slices",
            {"geometry": EXAMPLE_GEOMETRY, "l1": _RANGE, "digits": 30},
        ),
        "exact": (
            "Quotients and many digits",
            {
                "geometry": {**EXAMPLE_GEOMETRY, "d1": "426/25", "orientation": "ccw"},
                "l1": ["14.98", 27],
                "digits": 200,
            },
        ),
        "article": (
            "By the article's own algorithm, with its audit",
            {**EXAMPLE_REQUEST, "digits": 30, "method": "article"},
        ),
    },
)
CENSUSES_RESPONSES = question(with_csv("The census is known.", "Census", "one line for each interval"))
CENSUSES_EXTRA = posted(
    "CensusRequest",
    {
        "whole": ("All of the article's first manipulator", {"geometry": EXAMPLE_GEOMETRY, "digits": 30}),
        "range": (
            "A range of leg 1",
            {"geometry": EXAMPLE_GEOMETRY, "digits": 30, "range": {"from": 28, "to": "31"}},
        ),
    },
)
CURVES_RESPONSES = question(with_csv("The curves are known.", "CuspCurves", "one line for each point"))
CURVES_EXTRA = posted(
    "CuspCurvesRequest",
    {
        "scan": (
            "Points of all curves with L1 between 27 and 29, a tenth apart",
            {
                "geometry": EXAMPLE_GEOMETRY,
                "digits": 15,
                "range": {"from": 27, "to": 29},
                "l1": {"start": 27, "stop": 29, "step": "0.1"},
            },
        ),
        "samples": (
            "Four points of every curve between any two transitions",
            {"geometry": EXAMPLE_GEOMETRY, "digits": 15, "samples": 4},
        ),
    },
)
CHECKS_RESPONSES = question(answer("The report is known.", "CheckReport", headers=_ETAG))
CHECKS_EXTRA = posted(
    "CheckRequest",
    {
        "at_most": (
            "At most eight cusps for L1 between 28 and 31",
            {
                "geometry": EXAMPLE_GEOMETRY,
                "requirement": {"range": {"from": 28, "to": 31}, "max_cusps": 8},
            },
        ),
    },
)
POSES_RESPONSES = question(answer("The poses.", "PoseTable", headers=_ETAG))
POSES_EXTRA = posted(
    "PosesRequest",
    {
        "legs": (
            "The article's first manipulator with three given legs",
            {"geometry": EXAMPLE_GEOMETRY, "l1": 14.98, "l2": 15, "l3": 30, "digits": 30},
        )
    },
)
JOB_RESPONSES: Docs = {
    200: answer("The job.", "Job", example=_JOB, headers=_RETRY_AFTER),
    **problems(ProblemType.NOT_FOUND, _UNAVAILABLE),
}
CANCEL_RESPONSES: Docs = {
    200: answer("The job, canceled or as it had ended.", "Job", example={**_JOB, "status": "canceled"}),
    **problems(ProblemType.NOT_FOUND, _UNAVAILABLE),
}
RESULTS = ("PoseTable", "Census", "CuspCurves", "CheckReport")
RESULT_RESPONSES: Docs = {
    200: _table("What the job was asked for.", *RESULTS),
    304: {"description": "The client has this representation already (If-None-Match)."},
    **problems(
        ProblemType.NOT_FOUND,
        ProblemType.NOT_ACCEPTABLE,
        ProblemType.NOT_FINISHED,
        ProblemType.JOB_CANCELED,
        ProblemType.RESULT_EXPIRED,
        _UNAVAILABLE,
        *_FAILED,
    ),
}
EVENTS_RESPONSES: Docs = {
    200: {
        "description": "The events, up to the end of the job.",
        "content": {
            "text/event-stream": {
                "schema": {"type": "string"},
                "example": 'id: 1768469400012-0\nevent: slice\ndata: {"l1":"14.98",'
                '"progress":{"done":1,"total":1},"slice":{…}}\n\n',
            }
        },
    },
    204: {"description": "The job has ended, and nothing came after Last-Event-ID."},
    **problems(ProblemType.INVALID_HEADER, ProblemType.NOT_FOUND, _UNAVAILABLE),
}
HEALTH_RESPONSES: Docs = {200: answer("The process runs.", "Health"), **problems()}
READY_RESPONSES: Docs = {200: answer("Requests can be served.", "Readiness"), **problems(_UNAVAILABLE)}
VERSION_RESPONSES: Docs = {200: answer("The versions.", "Version"), **problems()}
LIMITS_RESPONSES: Docs = {200: answer("The limits.", "Limits"), **problems()}
METRICS_RESPONSES: Docs = {
    200: {"description": "The metrics.", "content": {"text/plain": {"schema": {"type": "string"}}}},
    **problems(),
}
