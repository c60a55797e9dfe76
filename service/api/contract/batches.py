"""OpenAPI descriptions of batches."""

from __future__ import annotations

from typing import Any

from service.api.batches.intake import KEY_PATTERN
from service.api.batches.rows import COLUMNS
from service.api.contract.responses import (
    FORM,
    PREFERENCE_APPLIED,
    PROBLEMS,
    REPLAYED,
    RETRY_AFTER,
    Docs,
    accepted,
    events_content,
    events_responses,
    json_response,
    parameter,
    ref,
    shared,
)
from service.schemas.answers import CSV, JSON, NDJSON
from service.schemas.questions import EXAMPLE_GEOMETRY

EXAMPLE_ID = "ba-5d41402abc4b2a76b9719d911017c592ae2f1b04"

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
                "semicolons or tabs.",
                _ROWS,
            ),
        },
    },
}
ACCEPTED = accepted("Batch", "The batch is accepted.", "The batch.", _LINKS)
ACCEPTED["headers"] |= REPLAYED
POST_RESPONSES: Docs = {202: shared("responses", "Batch"), **PROBLEMS}
STATE_RESPONSES: Docs = {200: json_response("The batch.", "Batch", headers=RETRY_AFTER), **PROBLEMS}
CANCEL_RESPONSES: Docs = {
    200: json_response(
        "The batch: canceled, or unchanged if another caller submitted it or it had ended.", "Batch"
    ),
    **PROBLEMS,
}
RESULT_FORMATS = ("ndjson", "json")
"""The values of `format` for results."""

RESULTS_PARAMETERS: dict[str, Any] = {
    "parameters": [
        FORM,
        parameter(
            "Prefer",
            "RFC 7240. `wait=N` keeps the response open for up to N seconds.",
            examples={"wait": "wait=60"},
        ),
    ]
}
RESULTS_RESPONSES: Docs = {
    200: {
        "description": "A line for each item, as BatchResult describes it.",
        "headers": dict(PREFERENCE_APPLIED),
        "content": {
            NDJSON: {"schema": ref("BatchResult")},
            JSON: {"schema": {"type": "array", "items": ref("BatchResult")}},
        },
    },
    **PROBLEMS,
}
EVENTS_RESPONSES = events_responses("batch", events_content("item", {"index": 0, "status": "succeeded"}))
