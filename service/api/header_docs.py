"""Parameters and header fields in the OpenAPI document that operations share."""

from __future__ import annotations

from typing import Any

from service.api.answers.forms import FORMATS, NUMBERS, format_names
from service.api.jobs.tail import EVENT_ID
from service.api.negotiation import Forms

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
        "schema": {"type": "string", "pattern": rf"^\s*({EVENT_ID})?\s*$"},
    },
    "Numbers": {
        "name": "numbers",
        "in": "query",
        "description": "`float`: numbers of a JSON document as JSON numbers, rounded to double precision, "
        "except in proofs; `text`, the default: strings with all digits.",
        "schema": {"type": "string", "enum": list(NUMBERS)},
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


def form_parameters(forms: Forms | None = None) -> list[dict[str, Any]]:
    """Returns the parameters that choose the form of an answer, one of these or of all that there are."""
    names = list(FORMATS if forms is None else format_names(forms))
    chosen = {
        "name": "format",
        "in": "query",
        "required": False,
        "description": "The form of the answer, if the document has it; instead of Accept.",
        "schema": {"type": "string", "enum": names},
    }
    return [chosen, _parameter("Numbers")]


def describe_headers(contract: dict[str, Any]) -> None:
    """Add the header fields that are not described with their operations."""
    components = contract["components"]
    components["parameters"] = {
        name: {"in": "header", "required": False, **parameter} for name, parameter in _PARAMETERS.items()
    }
    components["headers"] = _HEADERS
    for operations in contract["paths"].values():
        for operation in operations.values():
            sent = [_parameter(name) for name in _of(operation["responses"])]
            operation["parameters"] = [*operation.get("parameters", ()), *sent]
            for status, answer in operation["responses"].items():
                if int(status) < 400:
                    request_id = {"X-Request-ID": {"$ref": "#/components/headers/RequestId"}}
                    answer["headers"] = {**answer.get("headers", {}), **request_id}


def _of(responses: dict[str, Any]) -> list[str]:
    """Returns what can be sent for such responses."""
    revalidates = ["IfNoneMatch"] if "304" in responses else []
    resumes = ["LastEventId"] if "text/event-stream" in responses.get("200", {}).get("content", ()) else []
    return [*revalidates, *resumes, "RequestId"]


def _parameter(name: str) -> dict[str, Any]:
    return {"$ref": f"#/components/parameters/{name}"}
