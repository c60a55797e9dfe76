"""The published contract: the OpenAPI 3.1 document of the application."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from rpr_solver.contract import FIXED_LEGS
from service.api.caller import NEEDED
from service.api.contract import batches
from service.api.contract.queries import SHARED, query_parameters
from service.api.contract.responses import COMPONENTS, REF, parameter, ref
from service.schemas import all_questions, queries, resources
from service.schemas.answers import FORMATS, JSON, ProblemDocument
from service.schemas.numbers import (
    EXACT_NUMBER,
    POSITIVE_NUMBER,
    POSITIVE_ROOT,
    ROOT_NUMBER,
    SIDE,
)

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


_SCHEME = {
    "type": "http",
    "scheme": "bearer",
    "bearerFormat": "rpr_ID_SECRET",
    "description": "An API key, made by `rpr-cusps keys create`. A service on a loopback address requires "
    "one as soon as a key exists.",
}


def describe_access(contract: dict[str, Any]) -> None:
    """Add to every operation the key that it needs.

    That a key may be sent is declared once, for the whole contract: generators of clients take an operation
    that declares it for one that requires a key.
    """
    contract["components"]["securitySchemes"] = {"key": _SCHEME}
    contract["security"] = [{}, {"key": []}]
    for path, operations in contract["paths"].items():
        for method, operation in operations.items():
            needed = NEEDED[f"{method.upper()} {path}"]
            if needed is not None:
                operation["description"] += f" Scope of keys: `{needed}`."
            else:
                operation["security"] = []


DESCRIPTION = (
    """\
Certified cusp points in the joint space of planar 3-RPR parallel manipulators.

Send each kind of question to its own endpoint:

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
    ("questions", "Ask, and be answered with a document, or with the job that computes it."),
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
    resources.JobList,
    ProblemDocument,
    resources.Readiness,
    resources.Version,
)
"""All documents of the contract."""
SHARED_SCHEMAS: dict[str, dict[str, Any]] = {
    "ExactNumber": EXACT_NUMBER,
    "PositiveNumber": POSITIVE_NUMBER,
    "ExactRoot": ROOT_NUMBER,
    "PositiveRoot": POSITIVE_ROOT,
    "Side": SIDE,
    **{
        name: {"type": "string", "enum": [*values]}
        for name, values in (
            ("Format", FORMATS),
            ("Kind", resources.KIND_NAMES),
            ("Orientation", ("ccw", "cw")),
            ("RequiredOrExcluded", ("required", "excluded")),
        )
    },
    "FixedLeg": {"type": "integer", "enum": [*FIXED_LEGS]},
    "AnyObject": {"type": "object", "additionalProperties": True},
    "Texts": {"type": "object", "additionalProperties": {"type": "string"}},
}
"""Schemas that many others refer to."""


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
    for query in queries():
        contract["paths"][query.path]["get"]["parameters"] = query_parameters(query)
    contract["components"] = {
        "schemas": _schemas(),
        "parameters": {**COMPONENTS["parameters"], **SHARED},
        "responses": {**COMPONENTS["responses"], "Batch": batches.ACCEPTED},
    }
    describe_access(contract)
    contract["webhooks"] = WEBHOOKS
    return contract


def operation_id(route: APIRoute) -> str:
    """Returns the name of the route's function."""
    return route.name


def _schemas() -> dict[str, Any]:
    _, schema = models_json_schema([(model, "validation") for model in MODELS], ref_template=REF)
    tidy = _Tidy(schema["$defs"])
    wanted = [model.__name__ for model in MODELS if model.__name__ in tidy.found]
    made: dict[str, Any] = {}
    for name in wanted:  # it grows by what these refer to
        title = tidy.title(name)
        if title not in made:
            made[title] = tidy.of(tidy.found[name], is_asked=name in tidy.asked)
            wanted += tidy.met
            tidy.met.clear()
    return {**SHARED_SCHEMAS, **made}


class _Tidy:
    """Names schemas by their titles, and refers to shared ones.

    The values of a member of an answer are a part of its description, since there may be more in a later
    version, which a generated client would refuse.

    Attributes:
        found: the schemas of models, by the names of these.
        asked: the names of those that are sent to the service.
        met: the names of those that were referred to.
    """

    def __init__(self, found: dict[str, Any]) -> None:
        self.found = found
        self.asked = {name for name, value in found.items() if value.get("additionalProperties") is False}
        self.met: list[str] = []

    def title(self, name: str) -> str:
        """Returns the name of a model in the contract."""
        return str(self.found[name].get("title", name))

    def of(self, value: Any, *, is_asked: bool) -> Any:
        """Returns a schema as it is in the contract."""
        if isinstance(value, list):
            return [self.of(item, is_asked=is_asked) for item in value]
        if not isinstance(value, dict):
            return value
        if "$ref" in value:
            return self._referred(value)
        schema = {key: self.of(item, is_asked=is_asked) for key, item in value.items()}
        if "properties" in schema:
            schema.pop("title", None)  # its name says it
        if not is_asked and "enum" in schema and "properties" not in schema:
            values = ", ".join(f"`{x}`" for x in schema.pop("enum") if x is not None)
            schema["description"] = f"{schema.get('description', '')} One of {values}.".strip()
        return _shared(schema)

    def _referred(self, value: dict[str, Any]) -> dict[str, Any]:
        name = value["$ref"].rpartition("/")[2]
        if name not in self.found:
            return value
        target = self.found[name]
        if "properties" not in target and target.get("type") == "object":  # it is described in words
            return _shared({**target, **{key: item for key, item in value.items() if key != "$ref"}})
        self.met.append(name)
        return {**value, **ref(self.title(name))}


def _shared(schema: dict[str, Any]) -> dict[str, Any]:
    """Returns a reference to a schema that many have, or the schema itself."""
    for name, other in SHARED_SCHEMAS.items():
        own = {key: item for key, item in other.items() if key not in ("description", "examples")}
        if own == {key: schema.get(key) for key in own} and "properties" not in schema:
            kept = {key: schema[key] for key in ("description", "default") if key in schema}
            is_same = kept.get("description") == other.get("description")
            return {
                **ref(name),
                **{key: item for key, item in kept.items() if not (is_same and key == "description")},
            }
    return schema
