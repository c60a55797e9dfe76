"""OpenAPI descriptions of the operations: bodies, parameters, header fields, responses, examples, links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from inspect import cleandoc
from typing import Any

from service.api.job_events import EVENT_ID
from service.api.problems import MEDIA_TYPE
from service.schemas import all_questions
from service.schemas.answers import JSON, compact
from service.schemas.questions import EXAMPLE_GEOMETRY, Question

_TEXT = {"type": "string"}


def parameter(
    name: str,
    description: str,
    schema: Mapping[str, Any] = _TEXT,
    *,
    place: str = "header",
    required: bool = False,
    examples: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Returns a header field that a client may send, or a parameter in another place."""
    shown = {} if examples is None else {"examples": {key: {"value": x} for key, x in examples.items()}}
    needed = {"required": True} if required else {}
    return {"name": name, "in": place, **needed, "description": description, "schema": schema, **shown}


def _field(description: str, schema: Mapping[str, str] = _TEXT) -> dict[str, Any]:
    """Returns a header field of a response."""
    return {"description": description, "schema": schema}


IF_NONE_MATCH = parameter("If-None-Match", "The `ETag` of the client's copy: 304 if it is unchanged.")
LAST_EVENT_ID = parameter(
    "Last-Event-ID",
    "The id of the last event received; only later ones are sent.",
    {**_TEXT, "pattern": rf"^\s*({EVENT_ID})?\s*$"},
)
_PREFER = parameter(
    "Prefer",
    "RFC 7240. `wait=N` waits up to N seconds for the answer (see max_wait_seconds in /v1/limits), "
    "`respond-async` not at all; without either it is 0.25 seconds.",
    examples={"wait": "wait=10", "async": "respond-async"},
)
NEXT_PAGE = {"Link": _field('The next page, if there is one: `<URL>; rel="next"` (RFC 8288).')}
REPLAYED = {"Idempotent-Replayed": _field("`true` if an earlier request with this Idempotency-Key made it.")}
PREFERENCE_APPLIED = {"Preference-Applied": _field("The preferences that were honoured (RFC 7240).")}

WAIT, USUAL_WAIT = "wait", 10
"""The parameter of a query that says how long to wait for its answer, and the seconds if it is missing."""


def shared(kind: str, name: str) -> dict[str, str]:
    """Returns a reference to a component of the contract."""
    return {"$ref": f"#/components/{kind}/{name}"}


REF = "#/components/schemas/{model}"


def ref(model: str) -> dict[str, str]:
    """Returns a reference to a model's schema."""
    return shared("schemas", model)


_FORM = parameter(
    "format",
    "The form of the answer, for clients that cannot set Accept: one of those that 200 lists.",
    ref("Format"),
    place="query",
)
FORM = shared("parameters", "Format")


Docs = dict[int | str, dict[str, Any]]

EXAMPLE_JOB_ID = "ct-0f343b0931126a20f133d67c2b018a3b5c1f6d3e"

RETRY_AFTER = {"Retry-After": _field("Seconds to wait before asking again.", {"type": "integer"})}


def json_response(
    description: str, model: str, *, example: object = None, headers: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Returns the description of a JSON response."""
    content: dict[str, Any] = {"schema": ref(model)}
    if example is not None:
        content["example"] = example
    response: dict[str, Any] = {"description": description, "content": {JSON: content}}
    return {**response, "headers": dict(headers)} if headers else response


def document_in_all_forms(
    question: type[Question], description: str, example: object = None
) -> dict[str, Any]:
    """Returns the response with the document that answers a question."""
    response = json_response(description, question.answer.__name__, example=example)
    for media_type, form in question.forms.items():
        if media_type != JSON:
            response["content"][media_type] = {"schema": {"type": "string", "description": form.description}}
    if JSON not in question.forms:
        del response["content"][JSON]
    return response


PROBLEMS: Docs = {"default": shared("responses", "Problem")}
"""What every operation may answer in place of what was asked for."""
PROBLEM = {
    "description": "A problem: `type` identifies it; GET /problems lists all, with their statuses.",
    "headers": RETRY_AFTER,
    "content": {MEDIA_TYPE: {"schema": ref("Problem")}},
}


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


def accepted(
    model: str, description: str, location: str, links: Sequence[tuple[str, str, str]]
) -> dict[str, Any]:
    """Returns the response 202 with a job or a batch.

    Args:
        model: its schema.
        description: of the response.
        location: the description of the header field.
        links: the names of links, the operations that they lead to, and their descriptions.
    """
    headers = {"Location": _field(location), **RETRY_AFTER}
    target = {"parameters": {f"{model.lower()}_id": "$response.body#/id"}}
    return {
        **json_response(description, model, headers=headers),
        "links": {
            name: {"operationId": operation, **target, "description": text} for name, operation, text in links
        },
    }


def events_responses(what: str, content: Mapping[str, Any]) -> Docs:
    """Returns the responses with the events of a job or a batch."""
    return {
        200: {"description": f"The events, up to the end of the {what}.", "content": content},
        204: {"description": f"The {what} has ended, and no event follows Last-Event-ID."},
        **PROBLEMS,
    }


_JOB_LINKS = (
    ("job", "get_job", "The state of the job."),
    ("result", "get_result", "The result, once the job has succeeded."),
    ("events", "get_events", "The job's events."),
    ("cancel", "cancel_job", "Cancels the job, unless it has other subscribers."),
)

JOB_ACCEPTED = accepted("Job", "The answer is being computed.", "The job.", _JOB_LINKS)
JOB_ACCEPTED["headers"] |= PREFERENCE_APPLIED


def question_responses(question: type[Question], example: object = None) -> Docs:
    """Returns the responses to a question: the document, a job, or a problem."""
    about, _, _ = cleandoc(question.answer.__doc__ or "").partition("\n\n")
    known = document_in_all_forms(question, " ".join(about.split()), example)
    return {200: known, 202: shared("responses", "Job"), **PROBLEMS}


def request_body(question: type[Question]) -> dict[str, Any]:
    """Returns the parameters and the body of a question."""
    geometry = {"geometry": EXAMPLE_GEOMETRY} if question.names_geometry else {}
    examples = {
        name: {"summary": summary, "value": {**geometry, **value}}
        for name, (summary, value) in question.examples.items()
    }
    return {
        "parameters": [shared("parameters", "Prefer"), FORM],
        "requestBody": {
            "required": True,
            "content": {JSON: {"schema": ref(question.__name__), "examples": examples}},
        },
    }


def any_result() -> dict[str, Any]:
    """Returns the response with a job's result: a cusp table, or another document."""
    first, *others = all_questions()
    response = document_in_all_forms(first, "The document that the job computed.")
    models = [question.answer.__name__ for question in (first, *others)]
    response["content"][JSON] = {"schema": {"anyOf": [ref(model) for model in models]}}
    return response


COMPONENTS: dict[str, dict[str, Any]] = {
    "parameters": {"Prefer": _PREFER, "Format": _FORM, "If-None-Match": IF_NONE_MATCH},
    "responses": {"Problem": PROBLEM, "Job": JOB_ACCEPTED},
}
"""What operations refer to."""

JOB_RESPONSES: Docs = {200: json_response("The job.", "Job", headers=RETRY_AFTER), **PROBLEMS}
CANCEL_RESPONSES: Docs = {
    200: json_response("The job: canceled, or unchanged if it had ended or another key wants it.", "Job"),
    **PROBLEMS,
}
CONDITIONAL: Docs = {
    304: {"description": "Not modified: the client has this representation (If-None-Match)."},
}
"""What a client may get if it has the answer already."""
RESULT_PARAMETERS: dict[str, Any] = {"parameters": [FORM, shared("parameters", "If-None-Match")]}
RESULT_RESPONSES: Docs = {200: any_result(), **CONDITIONAL, **PROBLEMS}
EVENTS_PARAMETERS: dict[str, Any] = {"parameters": [LAST_EVENT_ID]}
EVENTS_RESPONSES = events_responses("job", events_content("slice", {"l1": "14.98", "slice": {"count": 6}}))
HEALTH_RESPONSES: Docs = {200: json_response("The process is running.", "AnyObject"), **PROBLEMS}
READY_RESPONSES: Docs = {200: json_response("Requests can be served.", "Readiness"), **PROBLEMS}
VERSION_RESPONSES: Docs = {200: json_response("The versions.", "Version"), **PROBLEMS}
LIMITS_RESPONSES: Docs = {
    200: json_response("The limits by name, each with its value and its description.", "AnyObject"),
    **PROBLEMS,
}
METRICS_RESPONSES: Docs = {
    200: {"description": "The metrics.", "content": {"text/plain": {"schema": _TEXT}}},
    **PROBLEMS,
}
