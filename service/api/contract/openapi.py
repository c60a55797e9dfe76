"""The published contract: the OpenAPI 3.1 document of the application."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute, iter_route_contexts
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from rpr_solver.contract import LEGS
from service.api.caller import NEEDED
from service.api.contract.responses import (
    USUAL_WAIT,
    WAIT,
    describe_headers,
    form_parameters,
    parameter,
    problems,
    ref,
)
from service.api.forms import IN_FLOATS, NO_NUMBERS
from service.api.problems import ProblemType
from service.schemas import all_questions, queries, resources
from service.schemas.answers import JSON, ProblemDocument
from service.schemas.columns import COLUMNS as GEOMETRY
from service.schemas.columns import POINTS, SIDES, SIX
from service.schemas.geometry import SixNumbers
from service.schemas.lengths import SLICE_COLUMNS
from service.schemas.numbers import (
    EXACT_NUMBER,
    NUMBER_PATTERN,
    POSITIVE_NUMBER,
    POSITIVE_PATTERN,
    POSITIVE_ROOT,
    ROOT_NUMBER,
    list_pattern,
)
from service.schemas.questions import Question

_WEBHOOK_HEADERS = {
    "webhook-id": "The id of the event, the same at every attempt.",
    "webhook-timestamp": "The time of the attempt, in seconds since 1970.",
    "webhook-signature": "`v1,` and the HMAC-SHA256 of `id.timestamp.body` in base64; one for each secret, "
    "separated by spaces.",
}
_WEBHOOK_PARAMETERS = [parameter(name, text, required=True) for name, text in _WEBHOOK_HEADERS.items()]


def _event(what: str, model: str) -> dict[str, Any]:
    return {
        "post": {
            "operationId": f"{what}_ended",
            "summary": f"The end of a {what}",
            "description": f"Sent to every `callback_url` of a {what} when it has succeeded, failed or was "
            "canceled, signed after the Standard Webhooks specification.",
            "tags": ["webhooks"],
            "security": [],
            "parameters": _WEBHOOK_PARAMETERS,
            "requestBody": {"required": True, "content": {JSON: {"schema": ref(model)}}},
            "responses": {
                "2XX": {"description": "Received."},
                "410": {"description": "Stops further attempts."},
                "default": {"description": "Sent again later; `Retry-After` is honoured."},
            },
        }
    }


WEBHOOKS: dict[str, Any] = {
    "job-ended": _event("job", "JobEvent"),
    "batch-ended": _event("batch", "BatchEvent"),
}


_SCHEMAS_AT = "#/components/schemas/"
_NO_NUMBER = ("enum", "const", "pattern", "format")
"""Members of the schema of a text that is not a number."""


def in_floats(schemas: Mapping[str, Any], documents: Sequence[str]) -> dict[str, Any]:
    """Returns the schemas of these documents with numbers, and of their parts that have any."""
    found: dict[str, Any] = {}

    def named(name: str) -> str:
        """Returns the name of the schema with numbers, or the same one if there are none in it."""
        if name not in schemas:
            return name  # one of those that take numbers anyway
        other = name + IN_FLOATS
        if other not in found:
            found[other] = {}  # a schema that refers to itself is taken to have numbers
            changed = of(schemas[name])
            if changed == schemas[name] and name not in documents:
                del found[other]
                return name
            found[other] = {**changed, "title": other}
        return other

    def of(schema: Any) -> Any:
        if not isinstance(schema, dict):
            return schema
        changed = dict(schema)
        if isinstance(reference := schema.get("$ref"), str):
            changed["$ref"] = _SCHEMAS_AT + named(reference.removeprefix(_SCHEMAS_AT))
        if schema.get("type") == "string" and not any(key in schema for key in _NO_NUMBER):
            changed["type"] = ["number", "string"]
        for key in ("items", "additionalProperties"):
            if key in schema:
                changed[key] = of(schema[key])
        for key in ("anyOf", "oneOf", "allOf", "prefixItems"):
            if key in schema:
                changed[key] = [of(part) for part in schema[key]]
        if "properties" in schema:
            changed["properties"] = {
                name: part if name in NO_NUMBERS else of(part) for name, part in schema["properties"].items()
            }
        return changed

    for name in documents:
        named(name)
    return found


_SCHEME = {
    "type": "http",
    "scheme": "bearer",
    "bearerFormat": "rpr_ID_SECRET",
    "description": "An API key, made by `rpr-cusps keys create`. A service on a loopback address requires "
    "one as soon as a key exists.",
}


def describe_access(contract: dict[str, Any]) -> None:
    """Add to every operation the key that it needs, and the answers of the guard.

    That a key may be sent is declared once, for the whole contract: generators of clients take an operation
    that declares it for one that requires a key.
    """
    contract.setdefault("components", {})["securitySchemes"] = {"key": _SCHEME}
    contract["security"] = [{}, {"key": []}]
    for path, operations in contract["paths"].items():
        for method, operation in operations.items():
            needed = NEEDED[f"{method.upper()} {path}"]
            kinds = [ProblemType.UNKNOWN_HOST]
            if needed is not None:
                kinds += [ProblemType.UNAUTHORIZED, ProblemType.FORBIDDEN, ProblemType.TOO_MANY_REQUESTS]
                operation["description"] += f"\n\nIf the service requires keys: scope `{needed}`."
            else:
                operation["security"] = []
            answers: dict[str, Any] = {str(status): answer for status, answer in problems(*kinds).items()}
            operation["responses"] = dict(sorted({**answers, **operation["responses"]}.items()))


DESCRIPTION = (
    """\
Certified cusp points in the joint space of planar 3-RPR parallel manipulators.

Post a question to its address:

"""
    + "".join(f"- `{question.path}`: {question.summary}\n" for question in all_questions())
    + """\

`/v1/batches` takes thousands of such questions at once. Known answers are returned immediately; all others
are computed by a job. Every number in an answer is a decimal string with proved digits, and every number in a
request is exact as written.

Errors are `application/problem+json` (RFC 9457); the `type` of a problem is a URL that documents it.
"""
)
TAGS = [
    *(question.tag for question in all_questions()),
    ("batches", "Many questions in one request, with results as they are computed."),
    ("jobs", "Follow, fetch and cancel computations."),
    ("webhooks", "Events that the service sends; see `callback_url`."),
    ("operations", "Health, versions, limits and metrics."),
]
MODELS: tuple[type[BaseModel], ...] = (
    *(model for question in all_questions() for model in (question, question.answer)),
    resources.BatchRequest,
    resources.Batch,
    resources.BatchResult,
    resources.Job,
    resources.StreamEvent,
    resources.JobEvent,
    resources.BatchEvent,
    resources.Deliveries,
    resources.JobList,
    ProblemDocument,
    resources.Health,
    resources.Readiness,
    resources.Version,
    resources.LimitsDocument,
)
"""All documents of the contract."""
NUMBERS = {
    "ExactNumber": EXACT_NUMBER,
    "PositiveNumber": POSITIVE_NUMBER,
    "ExactRoot": ROOT_NUMBER,
    "PositiveRoot": POSITIVE_ROOT,
}
"""The schemas of numbers in requests, by name."""


def describe(app: FastAPI) -> None:
    """Give the application its OpenAPI document, which is made at first use."""

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = document(app)
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


def document(app: FastAPI) -> dict[str, Any]:
    """Returns the OpenAPI document of the application."""
    contract: dict[str, Any] = get_openapi(
        title=app.title,
        version=app.version,
        openapi_version="3.1.0",
        description=DESCRIPTION,
        tags=[{"name": name, "description": text} for name, text in TAGS],
        license_info={"name": "MIT", "identifier": "MIT"},
        routes=app.routes,
    )
    schemas = contract.setdefault("components", {}).setdefault("schemas", {})
    schemas.update(_schemas())
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    for operations in contract["paths"].values():
        for operation in operations.values():
            responses = operation["responses"]
            if responses.get("422", {}).get("description") == "Validation Error":
                del responses["422"]  # the framework's own, which never occurs
    _show_nulls(contract, app)
    for query in queries():
        contract["paths"][query.path]["get"]["parameters"] = _query_parameters(query)
    describe_headers(contract)
    describe_access(contract)
    contract["webhooks"] = WEBHOOKS
    return contract


_NUMBER = {"type": "string", "pattern": NUMBER_PATTERN}
_POSITIVE = {"type": "string", "pattern": POSITIVE_PATTERN}
_ROOT = {"$ref": "#/components/schemas/ExactRoot"}
_POSITIVE_ROOT = {"$ref": "#/components/schemas/PositiveRoot"}
_OF_GEOMETRY = (
    "Of the geometry, as in the body of POST. Give the six numbers a2x, a3x, a3y, d1, d2 and d3, or two "
    "triangles by points or by sides."
)
_OF_POINTS = "Of a geometry by points, the corners of base and platform; give all twelve."
_OF_SIDES = "Of a geometry by the sides of base and platform; give all six."
_LENGTHS = "Lengths of the fixed leg, with semicolons between them."
_OTHERWISE: Mapping[str, tuple[str, dict[str, Any]]] = {
    **dict.fromkeys(POINTS, (_OF_POINTS, _ROOT)),
    **dict.fromkeys(SIDES, (_OF_SIDES, _POSITIVE_ROOT)),
    **dict.fromkeys(SIX[:3], (_OF_GEOMETRY, _ROOT)),
    **dict.fromkeys(SIX[3:], (_OF_GEOMETRY, _POSITIVE_ROOT)),
    **dict.fromkeys(LEGS, (_LENGTHS, {"type": "string", "pattern": list_pattern(POSITIVE_PATTERN)})),
    **dict.fromkeys(SLICE_COLUMNS, ("Of a range of lengths of the fixed leg.", _NUMBER)),
    "width_mm": ("For print: the width in millimetres, 80 to 400.", _POSITIVE),
    "cusp": (
        "Of a loop, or of the mechanism: the number or the letter of a cusp.",
        {"type": "string", "pattern": "^([A-Xa-x]|[1-9]|1[0-9]|2[0-4])$"},
    ),
    "tolerance": (
        "A change of all lengths of the geometry: the answer must hold for every geometry within it.",
        _POSITIVE,
    ),
    WAIT: (
        f"Seconds to wait for an answer that is not known yet; {USUAL_WAIT} if missing.",
        {"type": "integer", "minimum": 0},
    ),
}
"""Parameters of queries that are not as the members of the body: their descriptions and schemas."""
_OF_PARAMETER = ("type", "enum", "pattern", "minimum", "maximum")


def _query_parameters(question: type[Question]) -> list[dict[str, Any]]:
    """Returns the parameters of a question that is asked by GET."""
    members = {**SixNumbers.model_json_schema()["properties"], **question.model_json_schema()["properties"]}

    def described(name: str) -> tuple[str, dict[str, Any]]:
        member = members.get(name, {})
        as_member = {key: member[key] for key in _OF_PARAMETER if key in member}
        return _OTHERWISE.get(name) or (member["description"], as_member)

    own = [parameter(name, *described(name), place="query") for name in (*GEOMETRY, *question.columns, WAIT)]
    return [*own, *form_parameters(question.forms)]


def _show_nulls(contract: dict[str, Any], app: FastAPI) -> None:
    """Put the examples of answers in again, from which the framework drops every null."""
    routes = (context.original_route for context in iter_route_contexts(app.routes))
    for route in routes:
        if not isinstance(route, APIRoute) or not route.include_in_schema:
            continue
        for method in route.methods or ():
            described = contract["paths"][route.path_format][method.lower()]["responses"]
            for status, response in route.responses.items():
                for media_type, content in response.get("content", {}).items():
                    shown = {key: content[key] for key in ("example", "examples") if key in content}
                    described[str(status)]["content"][media_type].update(shown)


def operation_id(route: APIRoute) -> str:
    """Returns the name of the route's function."""
    return route.name


def _schemas() -> dict[str, Any]:
    _, schema = models_json_schema(
        [(model, "validation") for model in MODELS], ref_template="#/components/schemas/{model}"
    )
    titles = {name: value["title"] for name, value in schema["$defs"].items()}
    tidy = {titles[name]: _tidy(value, titles) for name, value in schema["$defs"].items()}
    return {
        **{name: {"title": name, **number} for name, number in NUMBERS.items()},
        **{title: {"title": title, **value} for title, value in tidy.items()},
        **in_floats(tidy, [question.answer.__name__ for question in all_questions()]),
    }


def _tidy(value: Any, titles: Mapping[str, str]) -> Any:
    """Name every schema by its title, refer to shared ones, and drop derived titles."""
    if isinstance(value, list):
        return [_tidy(item, titles) for item in value]
    if not isinstance(value, dict):
        return value
    schema = {key: _tidy(item, titles) for key, item in value.items()}
    for name, number in NUMBERS.items():
        if schema.get("oneOf") == number["oneOf"]:
            text = schema["description"]
            described = {} if text == number["description"] else {"description": text}
            return {"$ref": f"#/components/schemas/{name}", **described}
    if isinstance(schema.get("title"), str) and "properties" not in schema:
        del schema["title"]  # derived from the name of the field
    if isinstance(ref := schema.get("$ref"), str):
        prefix, _, name = ref.rpartition("/")
        schema["$ref"] = f"{prefix}/{titles.get(name, name)}"
    if isinstance(text := schema.get("description"), str):
        schema["description"] = re.sub(r"\s*\n\s*", " ", text)
    return schema
