"""What OpenAPI says about each operation beyond its code: bodies, answers, headers, examples, links."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from service.api.negotiation import JSON
from service.api.operations import CUSP_TABLES, OPERATIONS, Operation
from service.api.problems import MEDIA_TYPE, ProblemType
from service.schemas.questions import EXAMPLE_GEOMETRY

Docs = dict[int | str, dict[str, Any]]

EXAMPLE_JOB_ID = "ct-0f343b0931126a20f133d67c2b018a3b5c1f6d3e"

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


def json_response(
    description: str, model: str, *, example: object = None, headers: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """A JSON answer."""
    content: dict[str, Any] = {"schema": ref(model)}
    if example is not None:
        content["example"] = example
    response: dict[str, Any] = {"description": description, "content": {JSON: content}}
    return {**response, "headers": dict(headers)} if headers else response


def document_in_all_forms(operation: Operation, description: str) -> dict[str, Any]:
    """The document that answers a question, which never changes."""
    response = json_response(description, operation.answer.__name__, example=operation.example, headers=_ETAG)
    for media_type, form in operation.forms.items():
        if media_type != JSON:
            response["content"][media_type] = {"schema": {"type": "string", "description": form.description}}
    return response


def problems(*kinds: ProblemType) -> Docs:
    """The problems that an operation can answer with, by status. 500 belongs to all."""
    responses: Docs = {}
    for kind in (*kinds, ProblemType.INTERNAL):
        info = kind.value
        response = responses.setdefault(
            info.status, {"description": "", "content": {MEDIA_TYPE: {"schema": ref("Problem")}}}
        )
        response["description"] = f"{response['description']}; {info.title}".removeprefix("; ")
        if info.status in (429, 503) or kind is ProblemType.NOT_FINISHED:
            response["headers"] = _RETRY_AFTER
    return dict(sorted(responses.items(), key=lambda item: int(item[0])))


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


def question_responses(operation: Operation) -> Docs:
    """The answers to a question: known, or computed by a job."""
    accepted = json_response(
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
        200: document_in_all_forms(operation, operation.known),
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


def request_body(operation: Operation) -> dict[str, Any]:
    """What is sent with a question."""
    examples = {
        name: {"summary": summary, "value": {"geometry": EXAMPLE_GEOMETRY, **value}}
        for name, (summary, value) in operation.question.examples.items()
    }
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
            "content": {JSON: {"schema": ref(operation.question.__name__), "examples": examples}},
        },
    }


def any_result() -> dict[str, Any]:
    """The result of a job: a cusp table, or one of the other documents, the quickest first."""
    response = document_in_all_forms(CUSP_TABLES, "What the job was asked for.")
    others = sorted(
        (operation for operation in OPERATIONS if operation is not CUSP_TABLES),
        key=lambda operation: operation.implied_wait is None,
    )
    models = [operation.answer.__name__ for operation in (CUSP_TABLES, *others)]
    response["content"][JSON]["schema"] = {"anyOf": [ref(model) for model in models]}
    return response


JOB_RESPONSES: Docs = {
    200: json_response("The job.", "Job", example=_JOB, headers=_RETRY_AFTER),
    **problems(ProblemType.NOT_FOUND, _UNAVAILABLE),
}
CANCEL_RESPONSES: Docs = {
    200: json_response(
        "The job, canceled or as it had ended.", "Job", example={**_JOB, "status": "canceled"}
    ),
    **problems(ProblemType.NOT_FOUND, _UNAVAILABLE),
}
RESULT_RESPONSES: Docs = {
    200: any_result(),
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
HEALTH_RESPONSES: Docs = {200: json_response("The process runs.", "Health"), **problems()}
READY_RESPONSES: Docs = {200: json_response("Requests can be served.", "Readiness"), **problems(_UNAVAILABLE)}
VERSION_RESPONSES: Docs = {200: json_response("The versions.", "Version"), **problems()}
LIMITS_RESPONSES: Docs = {200: json_response("The limits.", "Limits"), **problems()}
METRICS_RESPONSES: Docs = {
    200: {"description": "The metrics.", "content": {"text/plain": {"schema": {"type": "string"}}}},
    **problems(),
}
