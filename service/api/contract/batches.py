"""OpenAPI descriptions of batches."""

from __future__ import annotations

from typing import Any

from service.api.batches.intake import KEY_PATTERN
from service.api.batches.rows import COLUMNS
from service.api.contract.responses import (
    PREFERENCE_APPLIED,
    RETRY_AFTER,
    TIMES,
    UNAVAILABLE,
    Docs,
    accepted,
    events_content,
    events_responses,
    format_parameter,
    json_response,
    parameter,
    problems,
    ref,
)
from service.api.job_views import state_json
from service.api.problems import ProblemType
from service.schemas.answers import CSV, JSON, NDJSON, compact
from service.schemas.questions import EXAMPLE_GEOMETRY
from service.schemas.tables import EXAMPLE_TABLE
from worker.jobs.view import JobView
from worker.settings import WorkerSettings

EXAMPLE_ID = "ba-5d41402abc4b2a76b9719d911017c592ae2f1b04"

_VIEW = JobView(EXAMPLE_ID, "running", 120, 500, *TIMES, error=None, run="", failed=2)
_BATCH = state_json(_VIEW, WorkerSettings())
_ITEMS = [
    {
        "id": "leg-27",
        "kind": "cusp-table",
        "request": {"geometry": EXAMPLE_GEOMETRY, "l1": 27, "digits": 30},
    },
    {"kind": "poses", "request": {"geometry": EXAMPLE_GEOMETRY, "l1": 14.98, "l2": 15, "l3": 30}},
]
_LINES = (
    '{"id":"leg-27","kind":"cusp-table","request":{"geometry":{"a2x":15.91,"a3x":0,"a3y":10,"d1":17.04,'
    '"d2":16.54,"d3":20.84},"l1":27}}\n'
)
_ROWS = "id,a2x,a3x,a3y,d1,d2,d3,l1,digits\nleg-27,15.91,0,10,17.04,16.54,20.84,27;28.1,30\n"
_REFUSED = {
    "type": "/problems/invalid-request",
    "title": ProblemType.INVALID_REQUEST.title,
    "status": 422,
    "detail": "items[1].request.l3: is missing; give a number > 0",
    "errors": [
        {
            "field": "items[1].request.l3",
            "pointer": "/items/1/request/l3",
            "message": "is missing; give a number > 0",
        }
    ],
}
_LINES_OF_RESULTS: list[dict[str, Any]] = [
    {"index": 0, "id": "leg-27", "kind": "cusp-table", "status": "succeeded", "result": EXAMPLE_TABLE},
    {"index": 1, "id": None, "kind": "poses", "status": "failed", "problem": _REFUSED},
]
_RESULTS = "".join(compact(line) + "\n" for line in _LINES_OF_RESULTS)


def _text(description: str, example: str) -> dict[str, Any]:
    return {"schema": {"type": "string", "description": description}, "example": example}


_LINKS = (
    ("batch", "get_batch", "The state of the batch."),
    ("results", "get_results", "The results so far, or as they are computed."),
    ("events", "get_batch_events", "The events of the batch."),
    ("cancel", "cancel_batch", "Cancels the batch."),
)

POST_BODY: dict[str, Any] = {
    "parameters": [
        parameter(
            "Idempotency-Key",
            "A name for this submission, such as a UUID: sent again by the same caller within 24 hours, it "
            "gives the batch that was made first instead of another one.",
            {"type": "string", "pattern": f"^{KEY_PATTERN}$"},
            examples={"uuid": "7f9c2ba4-e88f-4aa8-9a5c-1c3b8f4d2e60"},
        )
    ],
    "requestBody": {
        "required": True,
        "content": {
            JSON: {
                "schema": ref("BatchRequest"),
                "examples": {"two": {"summary": "Two questions", "value": {"items": _ITEMS}}},
            },
            NDJSON: _text("One item per line.", _LINES),
            CSV: _text(
                f"One geometry per row; the first line names its columns, some of {', '.join(COLUMNS)}. "
                "Several lengths in a cell are separated by semicolons. Columns may also be separated by "
                "semicolons or tabs; then numbers may have decimal commas.",
                _ROWS,
            ),
        },
    },
}
POST_RESPONSES: Docs = {
    202: accepted("Batch", "The batch is accepted.", "The batch.", _BATCH, _LINKS),
    **problems(
        ProblemType.INVALID_HEADER,
        ProblemType.INVALID_CSV,
        ProblemType.INVALID_JSON,
        ProblemType.NOT_ACCEPTABLE,
        ProblemType.SUBMISSION_IN_PROGRESS,
        ProblemType.BODY_TOO_LARGE,
        ProblemType.UNSUPPORTED_MEDIA_TYPE,
        ProblemType.INVALID_REQUEST,
        ProblemType.IDEMPOTENCY_KEY_REUSED,
        ProblemType.LIMIT_EXCEEDED,
        UNAVAILABLE,
        ProblemType.QUEUE_FULL,
    ),
}
STATE_RESPONSES: Docs = {
    200: json_response("The batch.", "Batch", example=_BATCH, headers=RETRY_AFTER),
    **problems(ProblemType.NOT_FOUND, ProblemType.INVALID_REQUEST, UNAVAILABLE),
}
CANCEL_RESPONSES: Docs = {
    200: json_response(
        "The batch: canceled, or unchanged if another caller submitted it or it had ended.",
        "Batch",
        example={**_BATCH, "status": "canceled", "canceled": 380},
    ),
    **problems(ProblemType.FORBIDDEN, ProblemType.NOT_FOUND, ProblemType.INVALID_REQUEST, UNAVAILABLE),
}
RESULT_FORMATS = ("ndjson", "json")
"""The values of `format` for results."""

RESULTS_PARAMETERS: dict[str, Any] = {
    "parameters": [
        format_parameter(
            RESULT_FORMATS,
            "The form of the answer, for clients that cannot set Accept: lines, or one array of them.",
        ),
        parameter(
            "Prefer",
            "RFC 7240. `wait=N` keeps the response open for up to N seconds; with `order=completion` the "
            "lines come as the items are done.",
            examples={"wait": "wait=60", "completion": "wait=60, order=completion"},
        ),
    ]
}
RESULTS_RESPONSES: Docs = {
    200: {
        "description": "A line for each item, as BatchResult describes it.",
        "headers": dict(PREFERENCE_APPLIED),
        "content": {
            NDJSON: {"schema": ref("BatchResult"), "example": _RESULTS},
            JSON: {
                "schema": {"type": "array", "items": ref("BatchResult")},
                "example": _LINES_OF_RESULTS,
            },
        },
    },
    **problems(
        ProblemType.NOT_FOUND,
        ProblemType.NOT_ACCEPTABLE,
        ProblemType.INVALID_REQUEST,
        UNAVAILABLE,
        ProblemType.BUSY,
    ),
}
EVENTS_RESPONSES = events_responses(
    "batch", events_content("item", {"index": 0, "status": "succeeded"}), ProblemType.INVALID_REQUEST
)
