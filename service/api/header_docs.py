"""Parameters and header fields in the OpenAPI document that operations share."""

from __future__ import annotations

from typing import Any

_TEXT = {"type": "string"}

_PARAMETERS: dict[str, dict[str, Any]] = {
    "RequestId": {
        "name": "X-Request-ID",
        "description": "A name for this request, which its answer and the log of the service repeat: up to "
        "64 letters, digits, dots, dashes and underscores; anything else is replaced.",
        "schema": _TEXT,
    },
    "IfNoneMatch": {
        "name": "If-None-Match",
        "description": "The `ETag` of what the client has: 304 if it is unchanged.",
        "schema": _TEXT,
    },
    "LastEventId": {
        "name": "Last-Event-ID",
        "description": "The id of the last event received; only later ones are sent.",
        "schema": {"type": "string", "pattern": r"^\s*(\d{1,20}(-\d{1,20})?)?\s*$"},
    },
    "Format": {
        "name": "format",
        "in": "query",
        "description": "The form of the answer, `json`, `csv` or `ndjson` if the document has it; instead of "
        "Accept.",
        "schema": _TEXT,
    },
    "Numbers": {
        "name": "numbers",
        "in": "query",
        "description": "`float`: numbers of a JSON document as JSON numbers, rounded to double precision, "
        "except in proofs; `text`, the default: strings with all digits.",
        "schema": {"type": "string", "enum": ["text", "float"]},
    },
}
_HEADERS: dict[str, dict[str, Any]] = {
    "RequestId": {"description": "The name of the request, as sent or made here.", "schema": _TEXT},
    "PreferenceApplied": {
        "description": "The preferences that were honoured (RFC 7240).",
        "schema": _TEXT,
    },
    "ContentLocation": {
        "description": "Where this answer can be had again: with GET, If-None-Match and any form in Accept.",
        "schema": _TEXT,
    },
}
PREFERENCE_APPLIED = {"Preference-Applied": {"$ref": "#/components/headers/PreferenceApplied"}}
CONTENT_LOCATION = {"Content-Location": {"$ref": "#/components/headers/ContentLocation"}}

RESULT_FORM = ("format", "numbers")
_OF_ANSWERS = ("IfNoneMatch", "Format", "Numbers")
_OF_OPERATIONS = {
    "get_result": _OF_ANSWERS,
    "get_cusp_table": _OF_ANSWERS,
    "get_census": _OF_ANSWERS,
    **dict.fromkeys(("get_events", "get_batch_events"), ("LastEventId",)),
    **dict.fromkeys(
        ("post_cusp_table", "post_census", "post_cusp_curves", "post_check", "post_poses"),
        ("Format", "Numbers"),
    ),
}


def describe_headers(contract: dict[str, Any]) -> None:
    """Add the header fields that are not described with their operations."""
    components = contract["components"]
    components["parameters"] = {
        name: {"in": "header", "required": False, **parameter} for name, parameter in _PARAMETERS.items()
    }
    components["headers"] = _HEADERS
    for operations in contract["paths"].values():
        for operation in operations.values():
            names = [*_OF_OPERATIONS.get(operation["operationId"], ()), "RequestId"]
            sent = [{"$ref": f"#/components/parameters/{name}"} for name in names]
            operation["parameters"] = [*operation.get("parameters", ()), *sent]
            for status, answer in operation["responses"].items():
                if int(status) < 400:
                    request_id = {"X-Request-ID": {"$ref": "#/components/headers/RequestId"}}
                    answer["headers"] = {**answer.get("headers", {}), **request_id}
