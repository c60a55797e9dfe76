"""OpenAPI descriptions of the operations: bodies, parameters, header fields, responses, examples, links."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from service.api.answers.forms import FLOATS, FORMATS, IN_FLOATS, NUMBERS, format_names, media_type_of
from service.api.jobs.tail import EVENT_ID
from service.api.jobs.views import job_json
from service.api.problems import MEDIA_TYPE, ProblemType
from service.schemas.answers import JSON, Forms, compact
from service.schemas.catalog import questions
from service.schemas.questions import EXAMPLE_GEOMETRY, Question
from worker.jobs.views import JobView
from worker.settings import WorkerSettings

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


Docs = dict[int | str, dict[str, Any]]

EXAMPLE_JOB_ID = "ct-0f343b0931126a20f133d67c2b018a3b5c1f6d3e"

_TIMES = "2026-01-15T09:30:00.000Z", "2026-01-15T09:30:00.012Z", None
_JOB = job_json(
    JobView(EXAMPLE_JOB_ID, "running", 120, 501, *_TIMES, error=None, run="5f2c01ab"), WorkerSettings()
)
RETRY_AFTER = {
    "Retry-After": {"description": "Seconds to wait before asking again.", "schema": {"type": "integer"}}
}
_ETAG = {
    "ETag": {"description": "Strong validator of this representation.", "schema": {"type": "string"}},
    "Cache-Control": {
        "description": "Immutable if every slice has an answer.",
        "schema": {"type": "string"},
    },
}


def ref(model: str) -> dict[str, str]:
    """Returns a reference to a model's schema."""
    return {"$ref": f"#/components/schemas/{model}"}


def json_response(
    description: str, model: str, *, example: object = None, headers: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Returns the description of a JSON response."""
    content: dict[str, Any] = {"schema": ref(model)}
    if example is not None:
        content["example"] = example
    response: dict[str, Any] = {"description": description, "content": {JSON: content}}
    return {**response, "headers": dict(headers)} if headers else response


def document_in_all_forms(question: type[Question], description: str) -> dict[str, Any]:
    """Returns the response with the document that answers a question."""
    response = json_response(description, question.answer.__name__, example=question.example, headers=_ETAG)
    in_floats = {**ref(question.answer.__name__ + IN_FLOATS), "description": FLOATS.description}
    response["content"][media_type_of(JSON, FLOATS)] = {"schema": in_floats}
    for media_type, form in question.forms.items():
        if media_type != JSON:
            response["content"][media_type] = {"schema": {"type": "string", "description": form.description}}
    if JSON not in question.forms:
        del response["content"][JSON]
    return response


def problems(*kinds: ProblemType) -> Docs:
    """Returns an operation's problems by status; 500 belongs to all."""
    responses: Docs = {}
    for kind in (*kinds, ProblemType.INTERNAL_ERROR):
        response = responses.setdefault(
            kind.status, {"description": "", "content": {MEDIA_TYPE: {"schema": ref("Problem")}}}
        )
        response["description"] = f"{response['description']}; {kind.title}".removeprefix("; ")
        if kind.status in (429, 503) or kind is ProblemType.JOB_NOT_FINISHED:
            response["headers"] = RETRY_AFTER
    return dict(sorted(responses.items(), key=lambda item: int(item[0])))


def events_content(event: str, data: Mapping[str, object]) -> dict[str, Any]:
    """Returns the content of a stream of events, with examples: a status, and one of another event."""
    of_it = {**data, "progress": {"done": 1, "total": 501}}
    examples = {
        "status": ("1768469400000-0", {"run": "5f2c01ab", "status": "running"}),
        event: ("1768469400012-0", of_it),
    }
    described = {
        name: {"value": {"id": event_id, "event": name, "data": compact(value)}}
        for name, (event_id, value) in examples.items()
    }
    return {"text/event-stream": {"schema": ref("StreamEvent"), "examples": described}}


_JOB_LINKS = {
    name: {"operationId": operation, "parameters": {"job_id": "$response.body#/id"}, "description": text}
    for name, operation, text in (
        ("job", "get_job", "The state of the job."),
        ("result", "get_result", "The result, once the job has succeeded."),
        ("events", "get_events", "The job's events."),
        ("cancel", "cancel_job", "Cancels the job, unless others want it."),
    )
}

UNAVAILABLE = ProblemType.UNAVAILABLE
_FAILED = (
    ProblemType.JOB_INPUT_ERROR,
    ProblemType.JOB_SOLVER_ERROR,
    ProblemType.JOB_FAILED,
    ProblemType.JOB_WORKER_LOST,
    ProblemType.JOB_RESOURCE_EXHAUSTED,
    ProblemType.JOB_TIMEOUT,
)


def question_responses(question: type[Question]) -> Docs:
    """Returns the responses to a question: the document, a job, or a problem."""
    accepted = json_response(
        "The answer is being computed.",
        "Job",
        example=_JOB,
        headers={
            "Location": {"description": "The job.", "schema": {"type": "string"}},
            **RETRY_AFTER,
            **PREFERENCE_APPLIED,
        },
    )
    known = document_in_all_forms(question, question.known)
    known["headers"] |= {**CONTENT_LOCATION, **PREFERENCE_APPLIED}
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
            UNAVAILABLE,
            ProblemType.QUEUE_FULL,
            *_FAILED,
        ),
    }


def request_body(question: type[Question]) -> dict[str, Any]:
    """Returns the parameters and the body of a question."""
    geometry = {"geometry": EXAMPLE_GEOMETRY} if question.names_geometry else {}
    examples = {
        name: {"summary": summary, "value": {**geometry, **value}}
        for name, (summary, value) in question.examples.items()
    }
    return {
        "parameters": [
            {
                "name": "Prefer",
                "in": "header",
                "required": False,
                "description": "RFC 7240. `wait=N` waits up to N seconds for the answer (see "
                "max_wait_seconds in /v1/limits); `respond-async` requests a job without waiting.",
                "schema": {"type": "string"},
                "examples": {"wait": {"value": "wait=10"}, "async": {"value": "respond-async"}},
            },
            *form_parameters(question.forms),
        ],
        "requestBody": {
            "required": True,
            "content": {JSON: {"schema": ref(question.__name__), "examples": examples}},
        },
    }


def any_result() -> dict[str, Any]:
    """Returns the response with a job's result: a cusp table, or another document, the quickest first."""
    first, *others = questions()
    response = document_in_all_forms(first, "The document that the job computed.")
    others.sort(key=lambda question: question.implied_wait is None)
    models = [question.answer.__name__ for question in (first, *others)]
    for media_type, end in ((JSON, ""), (media_type_of(JSON, FLOATS), IN_FLOATS)):
        response["content"][media_type]["schema"] = {"anyOf": [ref(model + end) for model in models]}
    return response


JOB_RESPONSES: Docs = {
    200: json_response("The job.", "Job", example=_JOB, headers=RETRY_AFTER),
    **problems(ProblemType.NOT_FOUND, UNAVAILABLE),
}
CANCEL_RESPONSES: Docs = {
    200: json_response(
        "The job: canceled, or unchanged if others want it or it had ended.",
        "Job",
        example={**_JOB, "status": "canceled"},
    ),
    **problems(ProblemType.NOT_FOUND, ProblemType.INVALID_REQUEST, UNAVAILABLE),
}
RESULT_PARAMETERS: dict[str, Any] = {"parameters": form_parameters()}
RESULT_RESPONSES: Docs = {
    200: any_result(),
    304: {"description": "Not modified: the client has this representation (If-None-Match)."},
    **problems(
        ProblemType.NOT_FOUND,
        ProblemType.NOT_ACCEPTABLE,
        ProblemType.JOB_NOT_FINISHED,
        ProblemType.JOB_CANCELED,
        ProblemType.RESULT_EXPIRED,
        UNAVAILABLE,
        *_FAILED,
    ),
}
EVENTS_RESPONSES: Docs = {
    200: {
        "description": "The events, up to the end of the job.",
        "content": events_content("slice", {"l1": "14.98", "slice": {"count": 6}}),
    },
    204: {"description": "The job has ended, and no event follows Last-Event-ID."},
    **problems(ProblemType.INVALID_HEADER, ProblemType.NOT_FOUND, ProblemType.INVALID_REQUEST, UNAVAILABLE),
}
DELIVERIES_RESPONSES: Docs = {
    200: json_response("The deliveries.", "Deliveries"),
    **problems(ProblemType.NOT_FOUND, UNAVAILABLE),
}
HEALTH_RESPONSES: Docs = {200: json_response("The process is running.", "Health"), **problems()}
READY_RESPONSES: Docs = {
    200: json_response("Requests can be served.", "Readiness"),
    **problems(UNAVAILABLE, ProblemType.NO_WORKER),
}
VERSION_RESPONSES: Docs = {200: json_response("The versions.", "Version"), **problems()}
LIMITS_RESPONSES: Docs = {200: json_response("The limits.", "Limits"), **problems()}
METRICS_RESPONSES: Docs = {
    200: {"description": "The metrics.", "content": {"text/plain": {"schema": {"type": "string"}}}},
    **problems(),
}
